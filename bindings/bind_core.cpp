// SPDX-License-Identifier: MIT
// Signals as Python components see them, and attitude mathematics on arrays.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <optional>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/params.hpp"
#include "numbers.hpp"

namespace gyrostat::bindings {
namespace {

namespace py = pybind11;
using namespace py::literals;

using V3 = Vec3<double>;
using VN = VecN<double>;
using Q = Quat<double>;

Eigen::Vector4d coefficients(const Q& q) { return {q.w(), q.x(), q.y(), q.z()}; }

/// The numbers that something is given.
template <class Vector>
Vector given(const ArrayLike& from, const char* name) {
  Vector out;
  copy_numbers(from, Vector::SizeAtCompileTime, out, std::string(name) + " was given");
  return out;
}
/// One an actuator; of how many, is known where it is used.
VN given_per_actuator(const ArrayLike& from, const char* name) {
  const std::string who = std::string(name) + " was given", most = "at most " + std::to_string(max_actuators);
  const Numbers array = numbers(from, who, most + " numbers");
  if (array.size() > max_actuators)
    throw std::invalid_argument(who + " " + std::to_string(array.size()) + " numbers; " + most +
                                " belong there, one an actuator");
  return Eigen::Map<const Eigen::VectorXd>(array.data(), array.size());
}

/// A property that holds a quaternion, scalar first.
template <class T, class C>
void def_quat(py::class_<C>& c, const char* name, T C::* member, const char* doc) {
  c.def_property(
      name, [member](const C& s) { return coefficients(s.*member); },
      [member, name](C& s, const ArrayLike& from) {
        const auto q = given<Eigen::Vector4d>(from, name);
        s.*member = Q(q[0], q[1], q[2], q[3]);
      },
      doc);
}

/// A property that holds one number an actuator (copied out, so that numpy never outlives the sample).
template <class C>
void def_per_actuator(py::class_<C>& c, const char* name, VN C::* member, const char* doc) {
  c.def_property(
      name, [member](const C& s) { return Eigen::VectorXd(s.*member); },
      [member, name](C& s, const ArrayLike& from) { s.*member = given_per_actuator(from, name); }, doc);
}

template <class C>
void def_vector(py::class_<C>& c, const char* name, V3 C::* member, const char* doc) {
  c.def_property(
      name, [member](const C& s) { return V3(s.*member); },
      [member, name](C& s, const ArrayLike& from) { s.*member = given<V3>(from, name); }, doc);
}

template <class C>
void def_mask(py::class_<C>& c, const char* name, Mask C::* member, const char* doc) {
  c.def_property(
      name,
      [member](const C& s) {
        py::list members;
        for (int i = 0; i < max_actuators; ++i) {
          if ((s.*member).test(i)) members.append(i);
        }
        return members;
      },
      [member](C& s, const std::vector<int>& members) {
        Mask mask;
        for (int i : members) {
          if (i < 0 || i >= max_actuators)
            throw std::invalid_argument("actuator " + std::to_string(i) + " is not in 0 to 15");
          mask.set(i);
        }
        s.*member = mask;
      },
      doc);
}

/// Fewer names than actuators: the others are healthy.
std::array<FaultClass, max_actuators> fault_classes(const std::vector<std::string>& names) {
  if (names.size() > max_actuators)
    throw std::invalid_argument("classes was given " + std::to_string(names.size()) + " names; at most " +
                                std::to_string(max_actuators) + " belong there, one an actuator");
  std::array<FaultClass, max_actuators> out{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = std::find(fault_class_names.begin(), fault_class_names.end(), names[i]);
    if (at == fault_class_names.end()) {
      std::string all;
      for (const char* name : fault_class_names) all += std::string(all.empty() ? "" : ", ") + name;
      throw std::invalid_argument("classes: no class of faults '" + names[i] + "'; there are: " + all);
    }
    out[i] = static_cast<FaultClass>(at - fault_class_names.begin());
  }
  return out;
}

void bind_signals(py::module_& m) {
  py::class_<EulerState<double>> euler_state(m, "EulerState", "Roll, pitch, yaw (rad) and their rates (rad/s).");
  def_vector(euler_state, "angles", &EulerState<double>::angles, "(3,) rad");
  def_vector(euler_state, "rates", &EulerState<double>::rates, "(3,) rad/s");

  py::class_<Vehicle<double>> vehicle(m, "NominalVehicle", "The nominal vehicle: all that flight knows of it.");
  vehicle.def_property_readonly(
      "J_B", [](const Vehicle<double>& v) { return v.J_B; }, "(3, 3) kg m^2; with wheels: total less sum Js g g'");
  vehicle.def_property_readonly(
      "D_B", [](const Vehicle<double>& v) { return Eigen::MatrixXd(v.D_B); }, "(3, n) actuator axes in columns");
  def_per_actuator(vehicle, "u_lo", &Vehicle<double>::u_lo, "(n,) N m");
  def_per_actuator(vehicle, "u_up", &Vehicle<double>::u_up, "(n,) N m");
  def_per_actuator(vehicle, "u_rate", &Vehicle<double>::u_rate, "(n,) N m/s");
  def_per_actuator(vehicle, "h_max", &Vehicle<double>::h_max,
                   "(n,) N m s, momentum at which a wheel gives no more; infinite: not known");
  def_per_actuator(
      vehicle, "u_quantum", &Vehicle<double>::u_quantum,
      "(n,) N m, of on/off actuators one tick of the valve as a mean over the period; 0, or empty: continuous");
  def_per_actuator(vehicle, "u_dead", &Vehicle<double>::u_dead, "(n,) N m, smallest command of these that acts");
  def_per_actuator(vehicle, "u_gap", &Vehicle<double>::u_gap,
                   "(n,) N m, smallest distance from u_up that they keep; what is nearer is u_up");
  def_mask(vehicle, "spare", &Vehicle<double>::spare, "actuators that are off until a detector enables them");
  def_mask(vehicle, "magnetorquers", &Vehicle<double>::magnetorquers,
           "actuators that are a dipole (A m^2); their D_B is zero but in the axes of a sample");
  def_mask(vehicle, "wheels", &Vehicle<double>::wheels, "actuators that store momentum");
  vehicle.def_readonly("orbit_rate", &Vehicle<double>::orbit_rate, "rad/s");
  vehicle.def_readonly("moving_axes", &Vehicle<double>::moving_axes, "D_B is where they start; signals have `axes`");

  py::class_<Setup<double>>(m, "Setup", "What a component is built for: the nominal vehicle and the period dt (s).")
      .def_readonly("vehicle", &Setup<double>::vehicle)
      .def_readonly("dt", &Setup<double>::dt);

  using Rows3 = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  py::class_<Axes<double>> axes(m, "Axes", "Where actuators point at one sample; empty: as the vehicle says.");
  axes.def_property_readonly(
      "D_B", [](const Axes<double>& a) { return Rows3(a.D_B); }, "(3, n) axes in columns; (3, 0)");
  axes.def_property_readonly("h_B", [](const Axes<double>& a) { return V3(a.h_B); }, "(3,) N m s, stored momentum");
  axes.def_readonly("revision", &Axes<double>::revision, "another one wherever D_B is another one");

  py::class_<Measurement<double>> y(m, "Measurement", "Sensors to navigator and observer.");
  y.def_readonly("tick", &Measurement<double>::tick);
  def_quat(y, "q_NB", &Measurement<double>::q_NB, "(4,) scalar first; sign continuous from the start");
  def_vector(y, "omega_BN_B", &Measurement<double>::omega_BN_B, "(3,) rad/s");
  def_per_actuator(y, "h_w", &Measurement<double>::h_w, "(n,) N m s");
  def_per_actuator(y, "gimbal", &Measurement<double>::gimbal, "(n,) rad; (0,) without control moment gyros");
  y.def_readonly("euler", &Measurement<double>::euler);
  def_vector(y, "field_B", &Measurement<double>::field_B, "(3,) T, magnetic field");
  y.def_readwrite("field_valid", &Measurement<double>::field_valid, "False: field_B was not measured at this sample");
  def_vector(y, "field_N", &Measurement<double>::field_N,
             "(3,) T, the field as flight's model has it; zero: not known");
  def_vector(y, "sun_B", &Measurement<double>::sun_B, "(3,) unit, direction to the sun");
  y.def_readwrite("sun_valid", &Measurement<double>::sun_valid, "False: sun_B was not measured at this sample");
  def_vector(y, "sun_N", &Measurement<double>::sun_N, "(3,) unit, the sun as the almanac has it; zero: not known");
  y.def_readwrite("attitude_valid", &Measurement<double>::attitude_valid,
                  "False: q_NB was not measured at this sample but carried on by the model");
  y.def_readwrite("rate_valid", &Measurement<double>::rate_valid,
                  "False: omega_BN_B was not measured at this sample but carried on by the model");
  y.def_readwrite("momentum_valid", &Measurement<double>::momentum_valid,
                  "False: h_w was not measured at this sample but carried on by the model");
  def_vector(y, "rate_step", &Measurement<double>::rate_step,
             "(3,) rad/s, share of the change of omega_BN_B that is a navigator's knowledge, not motion");
  y.def_readonly("axes", &Measurement<double>::axes);
  y.def_readonly("event", &Measurement<double>::event, "counts jumps that no motion explains");

  py::class_<Reference<double>> ref(m, "Reference", "What the vehicle should do.");
  def_quat(ref, "q_NR", &Reference<double>::q_NR, "(4,) scalar first");
  def_vector(ref, "omega_RN_R", &Reference<double>::omega_RN_R, "(3,) rad/s");
  def_vector(ref, "omegadot_RN_R", &Reference<double>::omegadot_RN_R, "(3,) rad/s^2");
  ref.def_readonly("euler", &Reference<double>::euler);
  def_vector(ref, "euler_accelerations", &Reference<double>::euler_accelerations, "(3,) rad/s^2");
  ref.def_readonly("event", &Reference<double>::event, "counts jumps");

  py::class_<Estimate<double>> x(m, "Estimate", "Observer to detector, controller and allocator.");
  x.def_static("healthy", &Estimate<double>::healthy, "y"_a,
               "The measured state, healthy actuators of unknown certainty, no disturbance.");
  x.def_readonly("tick", &Estimate<double>::tick);
  def_quat(x, "q_NB", &Estimate<double>::q_NB, "(4,) scalar first");
  def_vector(x, "omega_BN_B", &Estimate<double>::omega_BN_B, "(3,) rad/s");
  def_per_actuator(x, "h_w", &Estimate<double>::h_w, "(n,) N m s");
  x.def_readwrite("euler", &Estimate<double>::euler);
  def_per_actuator(x, "effectiveness", &Estimate<double>::effectiveness, "(n,) delivered / commanded");
  def_per_actuator(x, "effectiveness_bound", &Estimate<double>::effectiveness_bound,
                   "(n,) relative half-width; inf: never excited");
  def_vector(x, "d_B", &Estimate<double>::d_B, "(3,) N m, what effectiveness does not explain");
  x.def_readonly("axes", &Estimate<double>::axes);
  def_vector(x, "field_B", &Estimate<double>::field_B, "(3,) T, magnetic field of the measurement");
  x.def_readonly("momentum_valid", &Estimate<double>::momentum_valid,
                 "False: h_w was not measured at this sample; the stack sets it");
  x.def_readonly("event", &Estimate<double>::event, "of the measurement: counts jumps that no motion explains");

  py::class_<Detection<double>> det(m, "Detection", "Detector to controller and allocator.");
  det.def_static("none", &Detection<double>::none, "vehicle"_a,
                 "Nothing detected; everything but the spares is enabled.");
  def_mask(det, "changed", &Detection<double>::changed, "actuators declared changed");
  def_mask(det, "failed", &Detection<double>::failed, "actuators declared useless");
  def_mask(det, "enabled", &Detection<double>::enabled, "actuators that may be used");
  def_per_actuator(det, "u_probe", &Detection<double>::u_probe, "(n,) N m, dither; empty: none");
  det.def_property(
      "classes",
      [](const Detection<double>& d) {
        py::list names;
        for (const FaultClass fault : d.classes) names.append(fault_class_names[static_cast<std::size_t>(fault)]);
        return names;
      },
      [](Detection<double>& d, const std::vector<std::string>& names) { d.classes = fault_classes(names); },
      "of each of 16 actuators: healthy, gain, additive, stuck, intermittent or unclear");
  def_per_actuator(det, "gain", &Detection<double>::gain, "(n,) delivered = gain u + bias as far as is known");
  def_per_actuator(det, "bias", &Detection<double>::bias, "(n,) N m");
  det.def_readwrite("event", &Detection<double>::event, "counts declarations and recoveries");

  py::class_<Demand<double>> demand(m, "Demand", "Controller to allocator.");
  demand.def(py::init([](const ArrayLike& tau_B, const std::optional<ArrayLike>& u_pref) {
               Demand<double> d;
               d.tau_B = given<V3>(tau_B, "tau_B");
               if (u_pref) d.u_pref = given_per_actuator(*u_pref, "u_pref");
               return d;
             }),
             "tau_B"_a, "u_pref"_a = py::none());
  def_vector(demand, "tau_B", &Demand<double>::tau_B, "(3,) N m");
  def_per_actuator(demand, "u_pref", &Demand<double>::u_pref, "(n,) N m; empty: zero");

  py::class_<Allocation<double>> a(m, "Allocation",
                                   "Allocator to actuators, and to everyone as `last` at the next sample.");
  a.def(py::init<>());
  def_per_actuator(a, "u", &Allocation<double>::u, "(n,) N m, issued command");
  def_vector(a, "demand_B", &Allocation<double>::demand_B, "(3,) N m, what was asked");
  def_vector(a, "achieved_B", &Allocation<double>::achieved_B, "(3,) N m, D diag(effectiveness) u");
  def_mask(a, "saturated", &Allocation<double>::saturated, "actuators at a limit, and not at rest");
  a.def_readwrite("gap", &Allocation<double>::gap);
  a.def_readwrite("worst_case", &Allocation<double>::worst_case, "N m");
  a.def_readwrite("iterations", &Allocation<double>::iterations);
}

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Applies f to every row of an array (..., In); returns (..., Out), or (...) for one number.
template <int In, int Out, class F>
py::array_t<double> rowwise(const Rows& in, const char* what, F f) {
  if (in.ndim() == 0 || in.shape(in.ndim() - 1) != In) {
    throw std::invalid_argument(std::string(what) + ": the last axis must hold " + std::to_string(In) + " numbers");
  }
  std::vector<py::ssize_t> shape(in.shape(), in.shape() + in.ndim());
  if (Out == 1) {
    shape.pop_back();
  } else {
    shape.back() = Out;
  }
  py::array_t<double> out(shape);
  const py::ssize_t rows = in.size() / In;
  const double* from = in.data();
  double* to = out.mutable_data();
  for (py::ssize_t r = 0; r < rows; ++r) f(from + r * In, to + r * Out);
  return out;
}

Q q_at(const double* p) { return {p[0], p[1], p[2], p[3]}; }
V3 v_at(const double* p) { return {p[0], p[1], p[2]}; }
void put(const V3& v, double* to) { V3::Map(to) = v; }
void put(const Q& q, double* to) { Eigen::Vector4d::Map(to) = coefficients(q); }

void bind_attitude(py::module_& m) {
  m.def(
      "mrp_from_quat",
      [](const Rows& q) { return rowwise<4, 3>(q, "q", [](auto* i, auto* o) { put(mrp(q_at(i)), o); }); }, "q"_a,
      "MRP of quaternions (..., 4), scalar first -> (..., 3). The sign of q decides which of the two sets comes out; a "
      "full turn, "
      "infinite in its set, gives zero.");
  m.def(
      "quat_from_mrp",
      [](const Rows& s) { return rowwise<3, 4>(s, "sigma", [](auto* i, auto* o) { put(quat_from_mrp(v_at(i)), o); }); },
      "sigma"_a, "Quaternions (..., 4), scalar first, of MRP (..., 3).");
  m.def(
      "mrp_shadow",
      [](const Rows& s) { return rowwise<3, 3>(s, "sigma", [](auto* i, auto* o) { put(mrp_shadow(v_at(i)), o); }); },
      "sigma"_a, "The other MRP (..., 3) of the same attitude; zero, whose other one is infinite, stays.");
  m.def(
      "euler_from_quat",
      [](const Rows& q) { return rowwise<4, 3>(q, "q", [](auto* i, auto* o) { put(euler(q_at(i)), o); }); }, "q"_a,
      "Roll, pitch, yaw (..., 3) in rad of quaternions (..., 4), scalar first; 3-2-1 sequence. Yaw is zero at pitch "
      "+-pi/2.");
  m.def(
      "quat_from_euler",
      [](const Rows& a) {
        return rowwise<3, 4>(a, "angles", [](auto* i, auto* o) { put(quat_from_euler(v_at(i)), o); });
      },
      "angles"_a, "Quaternions (..., 4), scalar first, of roll, pitch, yaw (..., 3) in rad.");
  m.def(
      "quat_from_rotation_vector",
      [](const Rows& a) { return rowwise<3, 4>(a, "phi", [](auto* i, auto* o) { put(quat_exp(v_at(i)), o); }); },
      "phi"_a, "Quaternions (..., 4) of rotation vectors (..., 3) in rad.");
  m.def(
      "rotation_vector_from_quat",
      [](const Rows& q) { return rowwise<4, 3>(q, "q", [](auto* i, auto* o) { put(quat_log(q_at(i)), o); }); }, "q"_a,
      "Rotation vectors (..., 3) in rad, of length at most pi, of quaternions (..., 4).");
  m.def(
      "rotation_angle",
      [](const Rows& q) { return rowwise<4, 1>(q, "q", [](auto* i, auto* o) { *o = rotation_angle(q_at(i)); }); },
      "q"_a, "Rotation angles (...) in rad, 0 to pi, of quaternions (..., 4).");
  m.def(
      "dcm_from_quat",
      [](const Rows& q) {
        py::array_t<double> flat = rowwise<4, 9>(q, "q", [](auto* i, auto* o) {
          Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> C(o);
          C = dcm(q_at(i));
        });
        std::vector<py::ssize_t> shape(q.shape(), q.shape() + q.ndim());
        shape.back() = 3;
        shape.push_back(3);
        return py::array_t<double>(flat.reshape(shape));
      },
      "q"_a, "Direction cosines C_BN (..., 3, 3) of quaternions q_NB (..., 4): v_B = C_BN v_N.");
}

}  // namespace

void bind_core(py::module_& m) {
  bind_signals(m);
  bind_attitude(m);
}

}  // namespace gyrostat::bindings
