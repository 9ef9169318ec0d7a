// SPDX-License-Identifier: MIT
#include "python_component.hpp"

#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>

#include <pybind11/eigen.h>

#include "numbers.hpp"

namespace gyrostat::bindings {
namespace {

namespace py = pybind11;

/// Owns the object; takes the GIL to let go of it.
struct Release {
  template <class Object>
  void operator()(Object* object) const {
    const py::gil_scoped_acquire gil;
    delete object;
  }
};
using Held = std::unique_ptr<py::object, Release>;

Held hold(const py::object& object) { return Held(new py::object(object)); }

/// A role that is no flight component: the object with one function, and what it says of a mistake.
struct PythonFunction {
  PythonFunction(const py::object& object, const Setup<double>& setup, const char* role, const char* name, Use use)
      : who(std::string(role) + " " + class_name(object)), function(nullptr) {
    if (!py::hasattr(object, name)) throw std::invalid_argument(who + " has no " + name + "(...)");
    if (use == Use::fly && py::hasattr(object, "setup")) object.attr("setup")(setup);
    function = hold(object.attr(name));
    returned = who + "." + name + " returned";
  }
  std::string who, returned;
  Held function;
};

/// Of a reference: `at(t)` gives q_NR, or (q_NR, omega_RN_R, omegadot_RN_R), or a Reference.
class PythonReference {
 public:
  PythonReference(const py::object& object, const Setup<double>& setup, Use use)
      : model_(std::make_shared<PythonFunction>(object, setup, "reference", "at", use)) {}

  Reference<double> operator()(Tick, double t) const {
    const py::gil_scoped_acquire gil;
    const py::object out = (*model_->function)(t);
    if (py::isinstance<Reference<double>>(out)) return py::cast<Reference<double>>(out);
    Reference<double> r;
    if (py::isinstance<py::tuple>(out) && py::len(out) == 3) {
      const py::tuple parts(out);
      attitude(parts[0], r);
      copy_numbers(parts[1], 3, r.omega_RN_R, model_->returned);
      copy_numbers(parts[2], 3, r.omegadot_RN_R, model_->returned);
    } else {
      attitude(out, r);
    }
    return r;
  }

 private:
  void attitude(const py::object& out, Reference<double>& r) const {
    Eigen::Vector4d q;
    copy_numbers(out, 4, q, model_->returned);
    r.q_NR = Quat<double>(q[0], q[1], q[2], q[3]);
  }
  std::shared_ptr<PythonFunction> model_;
};

/// Common half: the object with its functions, and what it says of a mistake.
template <class Base>
class PythonModel : public Base {
 public:
  PythonModel(const py::object& object, const Setup<double>& setup, const char* role, Use use)
      : setup_(setup), who_(std::string(role) + " " + class_name(object)), object_(hold(object)) {
    if (!py::hasattr(object, "step"))
      throw std::invalid_argument(std::string(role) + ": " + class_name(object) + " has no step(...)");
    if (use == Use::fly && py::hasattr(object, "setup")) object.attr("setup")(setup);
    step_ = function("step");
    start_ = function("start");
  }
  void entries(std::vector<host::TelemetryEntry>&) const final {}
  double* values(double* row) const final { return row; }

 protected:
  int actuators() const { return setup_.vehicle.actuators(); }
  Allocation<double> idle() const { return Allocation<double>::idle(actuators()); }

  /// Null where the object has none.
  Held function(const char* name) const { return py::hasattr(*object_, name) ? hold(object_->attr(name)) : nullptr; }

  std::string returned(const char* from) const { return who_ + "." + from + " returned"; }

  /// What a function gave, when it is a signal of this kind.
  template <class Signal>
  Signal signal(const py::object& out, const char* from, const char* wanted) const {
    if (py::isinstance<Signal>(out)) return py::cast<Signal>(out);
    throw std::invalid_argument(returned(from) + (out.is_none() ? " nothing (None)" : " a " + class_name(out)) + "; " +
                                wanted + " belongs there");
  }

  void check_size(const VecN<double>& v, const char* from, const char* name, bool may_be_empty = false) const {
    if (v.size() == actuators() || (may_be_empty && v.size() == 0)) return;
    throw std::invalid_argument(returned(from) + " " + std::to_string(v.size()) + " numbers as " + name + "; " +
                                std::to_string(actuators()) + " belong there, one an actuator" +
                                (may_be_empty ? ", or none" : ""));
  }

  void check_members(Mask mask, const char* from, const char* name) const {
    for (int i = actuators(); i < max_actuators; ++i) {
      if (mask.test(i))
        throw std::invalid_argument(returned(from) + " actuator " + std::to_string(i) + " as " + name +
                                    "; the vehicle has 0 to " + std::to_string(actuators() - 1));
    }
  }

  Setup<double> setup_;
  std::string who_;
  Held object_, step_, start_;
};

class PythonNavigator final : public PythonModel<host::NavigatorBase> {
 public:
  using PythonModel::PythonModel;
  Measurement<double> start(const Vehicle<double>&, const Measurement<double>& y) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result((*start_)(y), "start", y) : result((*step_)(y), "step", y);
  }
  Measurement<double> step(const Vehicle<double>&, const Measurement<double>& y) final {
    const py::gil_scoped_acquire gil;
    return result((*step_)(y), "step", y);
  }

 private:
  Measurement<double> result(const py::object& out, const char* from, const Measurement<double>& sensed) const {
    Measurement<double> y = signal<Measurement<double>>(out, from, "a Measurement (the one it was given, changed)");
    check_size(y.h_w, from, "h_w");
    y.tick = sensed.tick;
    return y;
  }
};

class PythonObserver final : public PythonModel<host::ObserverBase> {
 public:
  PythonObserver(const py::object& object, const Setup<double>& setup, const char* role, Use use)
      : PythonModel(object, setup, role, use), skip_(function("skip")), shift_rate_(function("shift_rate")) {}
  Estimate<double> start(const Vehicle<double>&, const Measurement<double>& y) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result((*start_)(y), "start", y) : result((*step_)(y, idle()), "step", y);
  }
  Estimate<double> step(const Vehicle<double>&, const Measurement<double>& y, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return result((*step_)(y, last), "step", y);
  }
  Estimate<double> skip(const Vehicle<double>&, const Measurement<double>& y, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return skip_ ? result((*skip_)(y, last), "skip", y) : result((*step_)(y, last), "step", y);
  }
  void shift_rate(const Vec3<double>& step) final {
    if (!shift_rate_) return;
    const py::gil_scoped_acquire gil;
    (*shift_rate_)(Eigen::Vector3d(step));
  }

 private:
  Estimate<double> result(const py::object& out, const char* from, const Measurement<double>& y) const {
    Estimate<double> x = signal<Estimate<double>>(out, from, "an Estimate (Estimate.healthy(y) makes one)");
    check_size(x.h_w, from, "h_w");
    check_size(x.effectiveness, from, "effectiveness");
    check_size(x.effectiveness_bound, from, "effectiveness_bound");
    x.tick = y.tick;
    return x;
  }

  Held skip_, shift_rate_;
};

class PythonDetector final : public PythonModel<host::DetectorBase> {
 public:
  using PythonModel::PythonModel;
  Detection<double> start(const Vehicle<double>&, const Estimate<double>& x) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result((*start_)(x), "start") : result((*step_)(x, idle()), "step");
  }
  Detection<double> step(const Vehicle<double>&, const Estimate<double>& x, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return result((*step_)(x, last), "step");
  }

 private:
  Detection<double> result(const py::object& out, const char* from) const {
    const auto det = signal<Detection<double>>(out, from, "a Detection (Detection.none(vehicle) makes one)");
    check_size(det.u_probe, from, "u_probe", true);
    check_size(det.gain, from, "gain", true);
    check_size(det.bias, from, "bias", true);
    check_members(det.changed, from, "changed");
    check_members(det.failed, from, "failed");
    check_members(det.enabled, from, "enabled");
    return det;
  }
};

class PythonController final : public PythonModel<host::ControllerBase> {
 public:
  using PythonModel::PythonModel;
  Demand<double> start(const Vehicle<double>&, const Estimate<double>& x, const Detection<double>& det,
                       const Reference<double>& ref) final {
    const py::gil_scoped_acquire gil;
    return start_ ? result((*start_)(x, det, ref), "start") : result((*step_)(x, det, ref, idle()), "step");
  }
  Demand<double> step(const Vehicle<double>&, const Estimate<double>& x, const Detection<double>& det,
                      const Reference<double>& ref, const Allocation<double>& last) final {
    const py::gil_scoped_acquire gil;
    return result((*step_)(x, det, ref, last), "step");
  }

 private:
  Demand<double> result(const py::object& out, const char* from) const {
    Demand<double> demand;
    if (py::isinstance<Demand<double>>(out)) {
      demand = py::cast<Demand<double>>(out);
      check_size(demand.u_pref, from, "u_pref", true);
    } else {
      copy_numbers(out, 3, demand.tau_B, returned(from));
    }
    return demand;
  }
};

class PythonAllocator final : public PythonModel<host::AllocatorBase> {
 public:
  PythonAllocator(const py::object& object, const Setup<double>& setup, const char* role, Use use)
      : PythonModel(object, setup, role, use), reset_(function("reset")) {}
  void reset(const Vehicle<double>&) final {
    if (!reset_) return;
    const py::gil_scoped_acquire gil;
    (*reset_)();
  }
  Allocation<double> step(const Vehicle<double>&, const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) final {
    const py::gil_scoped_acquire gil;
    const py::object out = (*step_)(demand, x, det);
    if (py::isinstance<Allocation<double>>(out)) {
      const Allocation<double> a = py::cast<Allocation<double>>(out);
      check_size(a.u, "step", "u");
      check_members(a.saturated, "step", "saturated");
      return a;
    }
    Allocation<double> a;
    copy_numbers(out, actuators(), a.u, returned("step"));
    a.demand_B = demand.tau_B;
    a.achieved_B = torque<double>(x.axes.of(setup_.vehicle.D_B), x.effectiveness.cwiseProduct(a.u));
    return a;
  }

 private:
  Held reset_;
};

template <class Model, class Base>
std::function<std::unique_ptr<Base>(const Setup<double>&)> factory(const py::dict& objects, const char* role, Use use) {
  if (!objects.contains(role)) return {};
  const std::shared_ptr<py::object> object(new py::object(objects[role]), Release{});
  return [object, role, use](const Setup<double>& setup) -> std::unique_ptr<Base> {
    const py::gil_scoped_acquire gil;
    return std::make_unique<Model>(*object, setup, role, use);
  };
}

std::function<host::ReferencePath::Function(const Setup<double>&)> reference(const py::dict& objects, Use use) {
  if (!objects.contains("reference")) return {};
  const std::shared_ptr<py::object> object(new py::object(objects["reference"]), Release{});
  return [object, use](const Setup<double>& setup) -> host::ReferencePath::Function {
    const py::gil_scoped_acquire gil;
    return PythonReference(*object, setup, use);
  };
}

using Functions = std::vector<std::shared_ptr<PythonFunction>>;

Functions functions(const py::dict& objects, const char* list, const char* role, const char* name,
                    const Setup<double>& setup, Use use) {
  Functions all;
  if (!objects.contains(list)) return all;
  for (const py::handle& object : py::cast<py::sequence>(objects[list])) {
    all.push_back(std::make_shared<PythonFunction>(py::reinterpret_borrow<py::object>(object), setup, role, name, use));
  }
  return all;
}

/// Sensors, faults and disturbances, one after the other as they are listed.
host::Outside outside_of(const py::dict& objects, const Setup<double>& setup, Use use) {
  host::Outside outside;
  if (const Functions all = functions(objects, "sensors", "sensor", "measure", setup, use); !all.empty()) {
    outside.sensor = [all, n = setup.vehicle.actuators()](Measurement<double>& y) {
      const py::gil_scoped_acquire gil;
      const Tick tick = y.tick;
      for (const auto& sensor : all) {
        const py::object out = (*sensor->function)(y);
        if (!py::isinstance<Measurement<double>>(out)) {
          throw std::invalid_argument(sensor->returned + (out.is_none() ? " nothing (None)" : " a " + class_name(out)) +
                                      "; a Measurement (the one it was given, changed) belongs there");
        }
        y = py::cast<Measurement<double>>(out);
        y.tick = tick;
        if (y.h_w.size() == n) continue;
        throw std::invalid_argument(sensor->returned + " " + std::to_string(y.h_w.size()) + " numbers as h_w; " +
                                    std::to_string(n) + " belong there, one an actuator");
      }
    };
  }
  if (const Functions all = functions(objects, "faults", "fault", "apply", setup, use); !all.empty()) {
    outside.fault = [all](double t, VecN<double>& u) {
      const py::gil_scoped_acquire gil;
      for (const auto& fault : all) {
        const Eigen::VectorXd given = u;
        copy_numbers((*fault->function)(t, given), given.size(), u, fault->returned);
        if (!u.allFinite()) throw std::invalid_argument(fault->returned + " a number that is not finite");
      }
    };
  }
  if (const Functions all = functions(objects, "disturbances", "disturbance", "torque_B", setup, use); !all.empty()) {
    outside.torque_B = [all](double t, const Quat<double>& q, const Vec3<double>& omega_BN_B) {
      const py::gil_scoped_acquire gil;
      const Eigen::Vector4d q_NB(q.w(), q.x(), q.y(), q.z());
      Vec3<double> sum = Vec3<double>::Zero();
      for (const auto& disturbance : all) {
        Vec3<double> torque_B;
        copy_numbers((*disturbance->function)(t, q_NB, Eigen::Vector3d(omega_BN_B)), 3, torque_B,
                     disturbance->returned);
        sum += torque_B;
      }
      if (!sum.allFinite()) throw std::invalid_argument("disturbances: a torque that is not finite");
      return sum;
    };
  }
  return outside;
}

std::function<host::Outside(const Setup<double>&)> outside(const py::dict& objects, Use use) {
  if (!objects.contains("sensors") && !objects.contains("faults") && !objects.contains("disturbances")) return {};
  const std::shared_ptr<py::dict> held(new py::dict(objects), Release{});
  return [held, use](const Setup<double>& setup) {
    const py::gil_scoped_acquire gil;
    return outside_of(*held, setup, use);
  };
}

}  // namespace

host::ExternalComponents python_components(const py::dict& objects, Use use) {
  for (const auto& [key, value] : objects) {
    const std::string role = py::cast<std::string>(key);
    static const std::set<std::string> roles = {"navigator", "observer", "detector", "controller",  "allocator",
                                                "reference", "sensors",  "faults",   "disturbances"};
    if (!roles.contains(role)) {
      throw std::invalid_argument("components: no role '" + role +
                                  "'; there are: navigator, observer, detector, controller, allocator, reference, "
                                  "sensors, faults, disturbances");
    }
  }
  return {factory<PythonNavigator, host::NavigatorBase>(objects, "navigator", use),
          factory<PythonObserver, host::ObserverBase>(objects, "observer", use),
          factory<PythonDetector, host::DetectorBase>(objects, "detector", use),
          factory<PythonController, host::ControllerBase>(objects, "controller", use),
          factory<PythonAllocator, host::AllocatorBase>(objects, "allocator", use),
          reference(objects, use),
          outside(objects, use)};
}

}  // namespace gyrostat::bindings
