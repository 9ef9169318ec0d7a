// SPDX-License-Identifier: MIT
#include "gyrostat/host/assembly.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>

#include "gyrostat/host/alternatives.hpp"

namespace gyrostat::host {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

const Table& table_of(const Value& value, const std::string& where) {
  const Table* table = value.as<Table>();
  if (table == nullptr) refuse(where + " = " + value.text() + " is " + value.kind() + "; a table belongs here");
  return *table;
}

const Table& block(const Table& scenario, const char* key) {
  static const Table empty;
  const Value* value = scenario.find(key);
  return value == nullptr || value->is_none() ? empty : table_of(*value, key);
}

const List& list_of(const Table& scenario, const std::string& key) {
  static const List empty;
  const Value* value = scenario.find(key);
  if (value == nullptr || value->is_none()) return empty;
  const List* list = value->as<List>();
  if (list == nullptr) refuse(key + " = " + value->text() + " is " + value->kind() + "; a list of tables belongs here");
  return *list;
}

std::string type_of(const Table& table, const std::string& where) {
  const Value* type = table.find("type");
  if (type == nullptr) refuse(where + ": type is missing");
  const std::string* name = type->as<std::string>();
  if (name == nullptr) refuse(where + ": type = " + type->text() + " is " + type->kind() + "; a name belongs here");
  return *name;
}

/// A table with a type from a closed set; `fallback` is the type when the whole table is absent.
template <class Variant>
Variant read_typed(const std::string& family, const Table& table, const std::string& where, int actuators,
                   const std::string& fallback = "") {
  const std::string type = table.empty() && !fallback.empty() ? fallback : type_of(table, where);
  return Alternatives<Variant>::read(family, type, table, Place{where + " '" + type + "'", actuators});
}

template <class Variant>
std::vector<Variant> read_list(const std::string& family, const Table& scenario, const std::string& key,
                               int actuators) {
  std::vector<Variant> out;
  const List& list = list_of(scenario, key);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string where = key + "[" + std::to_string(i) + "]";
    out.push_back(read_typed<Variant>(family, table_of(list[i], where), where, actuators));
  }
  return out;
}

ComponentSpec component(const Table& table, const std::string& where, const std::string& fallback) {
  if (table.empty()) return {where + " '" + fallback + "'", fallback, {}};
  const std::string type = type_of(table, where);
  return {where + " '" + type + "'", type, table};
}

/// Of a symmetric matrix, ascending.
Vec3<double> eigenvalues(const Mat3<double>& m) {
  return Eigen::SelfAdjointEigenSolver<Mat3<double>>(m, Eigen::EigenvaluesOnly).eigenvalues();
}

void check_inertia(const Mat3<double>& J, const std::string& where) {
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < r; ++c) {
      if (std::abs(J(r, c) - J(c, r)) > 1e-9 * J.norm()) {
        refuse(where + " is not symmetric: entry [" + std::to_string(c) + "][" + std::to_string(r) +
               "] = " + number_text(J(c, r)) + " and [" + std::to_string(r) + "][" + std::to_string(c) +
               "] = " + number_text(J(r, c)));
      }
    }
  }
  const Vec3<double> I = eigenvalues(J);
  if (!(I[0] > 0))
    refuse(where + " is not positive definite: smallest principal moment " + number_text(I[0]) +
           " kg m^2, must be > 0");
  if (I[0] + I[1] < I[2] * (1 - 1e-9)) {
    refuse(where + " is no inertia of a body: principal moments " + number_text(I[0]) + " + " + number_text(I[1]) +
           " < " + number_text(I[2]) + " kg m^2 (triangle inequality)");
  }
}

void check_rank(const Mat3N<double>& D, const std::string& where) {
  Mat3<double> squares = Mat3<double>::Zero();
  for (Eigen::Index i = 0; i < D.cols(); ++i) squares += D.col(i) * D.col(i).transpose();
  const Vec3<double> s = eigenvalues(squares).cwiseMax(0.0).cwiseSqrt();
  if (!(s[0] > 1e-6 * s[2])) {
    refuse(where + " is rank-deficient: singular values " + number_text(s[2]) + " ... " + number_text(s[0]) +
           "; at least three independent actuator axes are needed");
  }
}

/// Lower and upper limits from a largest and an optional smallest; `lo`, `up` hold the fallback.
void limits(const VecN<double>& u_max, const VecN<double>& u_min, VecN<double>& lo, VecN<double>& up,
            const std::string& where) {
  if (u_max.size() != 0) {
    up = u_max;
    lo = -u_max;
  }
  if (u_min.size() != 0) lo = u_min;
  for (Eigen::Index i = 0; i < up.size(); ++i) {
    if (lo[i] > up[i])
      refuse(where + ": u_min = " + number_text(lo[i]) + " is above u_max = " + number_text(up[i]) + " N m, actuator " +
             std::to_string(i));
  }
}

VecN<double> or_constant(const VecN<double>& v, int n, double value) {
  return v.size() != 0 ? v : VecN<double>(VecN<double>::Constant(n, value));
}

Mat3<double> wheel_inertia_sum(const Mat3N<double>& axes, const VecN<double>& Js) {
  Mat3<double> sum = Mat3<double>::Zero();
  for (Eigen::Index i = 0; i < axes.cols(); ++i) sum += Js[i] * axes.col(i) * axes.col(i).transpose();
  return sum;
}

/// Thrusters with what follows from where they sit: the axis of the torque of each, and how much it makes when open.
struct ThrusterAxes {
  truth::Thrusters thrusters;
  Mat3N<double> D_B{3, 0};
  VecN<double> torque;  // N m
};

Vec3<double> row_of_three(const std::vector<std::vector<double>>& rows, std::size_t i, const char* name) {
  if (rows[i].size() != 3)
    refuse("thrusters: " + std::string(name) + "[" + std::to_string(i) + "] has " + std::to_string(rows[i].size()) +
           " numbers; three belong there");
  return {rows[i][0], rows[i][1], rows[i][2]};
}

ThrusterAxes read_thrusters(const Table& scenario, double dt, int others) {
  ThrusterAxes out;
  const Table& table = block(scenario, "thrusters");
  if (table.empty()) return out;
  const Value* given = table.find("positions");
  const List* rows = given == nullptr ? nullptr : given->as<List>();
  const std::size_t k = rows == nullptr ? 0 : rows->size();
  if (k == 0) refuse("thrusters: positions are missing: a row of three numbers a thruster");
  if (static_cast<int>(k) + others > max_actuators)
    refuse("thrusters: " + std::to_string(k) + " beside " + std::to_string(others) + " other actuators; at most " +
           std::to_string(max_actuators) + " in all");
  const ThrustersBlock t = read_params(ThrustersBlock{}, table, Place{"thrusters", static_cast<int>(k)});
  if (t.directions.size() != k)
    refuse("thrusters: directions has " + std::to_string(t.directions.size()) + " rows, positions " +
           std::to_string(k) + "; one each belongs there");
  if (t.thrust.size() == 0) refuse("thrusters: thrust is missing, N");
  const VecN<double> Isp = or_constant(t.Isp, static_cast<int>(k), 220.0);
  out.D_B.resize(3, static_cast<Eigen::Index>(k));
  out.torque.resize(static_cast<Eigen::Index>(k));
  for (std::size_t i = 0; i < k; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const std::string who = "thrusters: thruster " + std::to_string(i);
    const Vec3<double> n = row_of_three(t.directions, i, "directions");
    if (!(n.norm() > 1e-9)) refuse(who + ": its direction is no direction, all zero");
    const Vec3<double> n_B = n.normalized(),
                       arm = (row_of_three(t.positions, i, "positions") - t.centre_of_mass).cross(n_B);
    const double lever = arm.norm();
    if (lever < 1e-6)
      refuse(who + " makes no torque about the centre of mass: its lever is " + number_text(lever) + " m");
    if (!(t.thrust[at] > 0)) refuse(who + ": thrust must be positive");
    if (!(Isp[at] > 0)) refuse(who + ": Isp must be positive");
    out.D_B.col(at) = arm / lever;
    out.torque[at] = t.thrust[at] * lever;
    out.thrusters.each.push_back({n_B, lever, Isp[at]});
  }
  out.thrusters.first = others;
  out.thrusters.period = dt;
  out.thrusters.tick = t.tick;
  out.thrusters.min_on = t.min_on;
  out.thrusters.min_off = t.min_off;
  out.thrusters.align = static_cast<truth::Thrusters::Align>(t.align);
  out.thrusters.modulator = static_cast<truth::Thrusters::Modulator>(t.modulator);
  out.thrusters.pwpf = {t.pwpf_gain, t.pwpf_time_constant, t.pwpf_on, t.pwpf_off};
  out.thrusters.propellant_mass = t.propellant_mass;
  if (const std::string error = out.thrusters.check(); !error.empty()) refuse(error);
  return out;
}

/// `v` and behind it `more`.
VecN<double> joined(const VecN<double>& v, const VecN<double>& more) {
  VecN<double> out(v.size() + more.size());
  out << v, more;
  return out;
}

/// Behind the other actuators.
void add_thrusters(const ThrusterAxes& more, Assembly& a, VecN<double>& wheel_inertia) {
  Vehicle<double>& vehicle = a.setup.vehicle;
  if (vehicle.coordinates != Coordinates::body) refuse("thrusters: they fly on body coordinates");
  const int n = vehicle.actuators();
  const auto k = more.D_B.cols();
  const VecN<double> zero = VecN<double>::Zero(k), infinite = VecN<double>::Constant(k, detail::infinite);
  Mat3N<double> D_B(3, n + k);
  D_B << vehicle.D_B, more.D_B;
  vehicle.D_B = D_B;
  vehicle.u_lo = joined(vehicle.u_lo, zero);
  vehicle.u_up = joined(vehicle.u_up, more.torque);
  vehicle.u_rate = joined(vehicle.u_rate, infinite);
  vehicle.h_max = joined(vehicle.h_max, infinite);
  wheel_inertia = joined(wheel_inertia, zero);
  a.plant.actuators.thrusters = more.thrusters;
  if (more.thrusters.modulator != truth::Thrusters::Modulator::pwm) return;
  const VecN<double> tick = more.torque / more.thrusters.ticks(), others = VecN<double>::Zero(n);
  vehicle.u_quantum = joined(others, tick);
  vehicle.u_dead = joined(others, tick * more.thrusters.min_on);
  vehicle.u_gap = joined(others, tick * more.thrusters.min_off);
}

/// Control moment gyros, in the order of their rows; channels are counted from `first` on.
std::vector<truth::ControlMomentGyro> read_gyros(const Table& table, int first, VecN<double>& u_max) {
  const Value* axes = table.find("gimbal_axes");
  const List* rows = axes == nullptr ? nullptr : axes->as<List>();
  if (rows == nullptr || rows->empty()) refuse("cmg: gimbal_axes is missing: a row of three numbers a gyro");
  const int n = static_cast<int>(rows->size());
  if (first + n > max_actuators)
    refuse("cmg: " + std::to_string(first + n) + " actuators in all; at most " + std::to_string(max_actuators));
  const CmgBlock c = read_params(CmgBlock{}, table, Place{"cmg", n});
  const auto axis = [&](const std::vector<std::vector<double>>& list, int i, const char* key) -> Vec3<double> {
    const std::string where = "cmg: gyro " + std::to_string(i) + ": " + key;
    if (static_cast<int>(list.size()) != n)
      refuse(std::string("cmg: ") + key + " has " + std::to_string(list.size()) + " rows; one a gyro belongs here, " +
             std::to_string(n));
    const std::vector<double>& row = list[static_cast<std::size_t>(i)];
    if (row.size() != 3) refuse(where + " has " + std::to_string(row.size()) + " numbers; a row is an axis, of three");
    const Vec3<double> v{row[0], row[1], row[2]};
    if (std::abs(v.norm() - 1.0) > 1e-6)
      refuse(where + " has length " + number_text(v.norm()) + "; a unit vector belongs here");
    return v.normalized();
  };
  if (c.rotor_momentum.size() == 0) refuse("cmg: rotor_momentum is missing, N m s");
  if (c.rate_max.size() == 0) refuse("cmg: rate_max is missing, rad/s");
  std::vector<truth::ControlMomentGyro> gyros;
  u_max = c.rotor_momentum.cwiseProduct(c.rate_max);
  for (int i = 0; i < n; ++i) {
    const std::string gyro = "cmg: gyro " + std::to_string(i) + ": ";
    const Vec3<double> g = axis(c.gimbal_axes, i, "gimbal_axes"), s = axis(c.spin_axes, i, "spin_axes");
    if (std::abs(g.dot(s)) > 1e-6)
      refuse(gyro + "the spin axis must be perpendicular to the gimbal axis; the cosine between them is " +
             number_text(g.dot(s)));
    if (!(c.rotor_momentum[i] > 0)) refuse(gyro + "rotor_momentum must be positive");
    if (!(c.rate_max[i] > 0)) refuse(gyro + "rate_max must be positive");
    const double angle = c.angles.size() == 0 ? 0.0 : c.angles[i];
    const double most = c.angle_max.size() == 0 ? detail::infinite : c.angle_max[i];
    if (std::abs(angle) > most)
      refuse(gyro + "angles = " + number_text(angle) + " rad is beyond angle_max = " + number_text(most) + " rad");
    gyros.push_back({first + i, g, (s - g.dot(s) * g).normalized(), c.rotor_momentum[i], angle, most, {}});
  }
  return gyros;
}

/// What flight knows of them: the axes at the start stand behind those of the other actuators.
void place_gyros(Assembly& a, const std::vector<truth::ControlMomentGyro>& gyros) {
  Vehicle<double>& vehicle = a.setup.vehicle;
  vehicle.moving_axes = !gyros.empty();
  for (const truth::ControlMomentGyro& gyro : gyros) {
    a.vehicles.gyros.add(gyro.channel, gyro.gimbal_axis_B, gyro.spin_axis_B, gyro.rotor_momentum);
    const double c = std::cos(gyro.angle), s = std::sin(gyro.angle);
    vehicle.D_B.col(gyro.channel) = s * gyro.spin_axis_B - c * gyro.transverse_B();
  }
}

/// It makes no torque of its own: what it makes depends on the field, which only a sample knows.
void add_magnetorquer(Vehicle<double>& vehicle, int i, double wheel_inertia) {
  const std::string actuator = "vehicle: actuator " + std::to_string(i);
  if (wheel_inertia != 0) refuse(actuator + " cannot be a wheel and a magnetorquer");
  const double length = vehicle.D_B.col(i).norm();
  if (std::abs(length - 1) > 1e-6) {
    refuse("vehicle: D_B column " + std::to_string(i) + " is a dipole axis of length " + number_text(length) +
           "; a unit vector belongs here");
  }
  vehicle.D_B.col(i).setZero();
}

void read_vehicle(const Table& scenario, Assembly& a, VecN<double>& wheel_inertia) {
  Table table = block(scenario, "vehicle");
  if (table.empty()) refuse("vehicle is missing: J_B and D_B at least");
  // The number of actuators is known once the axes are.
  VehicleBlock axes;
  Place place{"vehicle"};
  const Table& cmg = block(scenario, "cmg");
  const Value* D = table.find("D_B");
  if (D != nullptr && D->is_none()) D = nullptr;
  if (D != nullptr) {
    read(*D, Key{place, "D_B", -1e6, 1e6}, axes.D_B);
  } else if (cmg.empty() && block(scenario, "thrusters").empty()) {
    place.refuse("D_B is missing: actuator axes in columns, body frame");
  } else {
    axes.D_B.resize(3, 0);
  }
  const int others = static_cast<int>(axes.D_B.cols());
  VecN<double> gyro_max;
  std::vector<truth::ControlMomentGyro> gyros;
  if (!cmg.empty()) gyros = read_gyros(cmg, others, gyro_max);
  const int n = others + static_cast<int>(gyros.size());
  place.actuators = n;
  const ThrusterAxes more = read_thrusters(scenario, a.run.dt, n);
  const auto k = more.D_B.cols();
  VehicleBlock given;
  if (D == nullptr) given.D_B = axes.D_B;
  if (const Value* spare = table.find("spare"); k > 0 && spare != nullptr && !spare->is_none()) {  // of all actuators
    const Place all{"vehicle", n + static_cast<int>(k)};
    read(*spare, Key{all, "spare"}, a.setup.vehicle.spare);
    table.set("spare", List{});
  }
  const VehicleBlock v = read_params(given, table, place);
  check_inertia(v.J_B, "vehicle: J_B");

  Vehicle<double>& vehicle = a.setup.vehicle;
  vehicle.D_B.resize(3, n);
  vehicle.D_B.leftCols(others) = v.D_B;
  place_gyros(a, gyros);
  a.plant.gyros = gyros;
  if (gyros.empty()) {  // gimbals may start where they are singular
    Mat3N<double> all_axes(3, n + k);
    all_axes << vehicle.D_B, more.D_B;
    check_rank(all_axes, k == 0 ? "vehicle: D_B" : "vehicle: D_B, with the thrusters' axes,");
  }
  vehicle.u_up = VecN<double>::Constant(n, detail::infinite);
  vehicle.u_lo = -vehicle.u_up;
  limits(v.u_max, v.u_min, vehicle.u_lo, vehicle.u_up, "vehicle");
  for (const truth::ControlMomentGyro& gyro : gyros) {
    const double most = gyro_max[gyro.channel - others];
    vehicle.u_up[gyro.channel] = std::min(vehicle.u_up[gyro.channel], most);
    vehicle.u_lo[gyro.channel] = std::max(vehicle.u_lo[gyro.channel], -most);
  }
  vehicle.u_rate = or_constant(v.u_rate, n, detail::infinite);
  vehicle.h_max = or_constant(v.momentum_max, n, detail::infinite);
  vehicle.spare = vehicle.spare | v.spare;
  vehicle.magnetorquers = v.magnetorquers;
  vehicle.orbit_rate = v.orbit_rate;
  vehicle.coordinates = v.coordinates;
  if (!gyros.empty() && v.coordinates != Coordinates::body) refuse("cmg: gyros fly on body coordinates");
  wheel_inertia = or_constant(v.wheel_inertia, n, 0.0);
  for (int i = 0; i < n; ++i) {
    if (v.magnetorquers.test(i)) {
      if (i >= others) refuse("vehicle: magnetorquers: actuator " + std::to_string(i) + " is a control moment gyro");
      add_magnetorquer(vehicle, i, wheel_inertia[i]);
    }
    if (wheel_inertia[i] == 0.0) {
      if (std::isfinite(vehicle.h_max[i]))
        refuse("vehicle: momentum_max of actuator " + std::to_string(i) + " needs a wheel_inertia");
      continue;
    }
    if (i >= others)
      refuse("vehicle: wheel_inertia of actuator " + std::to_string(i) + ", a control moment gyro, must be 0");
    vehicle.wheels.set(i);
    if (std::abs(v.D_B.col(i).norm() - 1.0) > 1e-6) {
      refuse("vehicle: D_B column " + std::to_string(i) + " is a wheel axis of length " +
             number_text(v.D_B.col(i).norm()) + "; a unit vector belongs here");
    }
  }
  vehicle.J_B = v.J_B - wheel_inertia_sum(vehicle.D_B, wheel_inertia);
  if (k > 0) add_thrusters(more, a, wheel_inertia);
  a.vehicles.D_B = vehicle.D_B;
  for (int i = 0; i < others; ++i) {
    if (v.magnetorquers.test(i)) a.vehicles.D_B.col(i) = v.D_B.col(i);
  }
  if (!(eigenvalues(vehicle.J_B)[0] > 0)) {
    refuse(
        "vehicle: J_B (of the whole vehicle) less the wheels' axial inertia is not positive definite; is J_B without "
        "the wheels?");
  }
}

void read_truth(const Table& scenario, Assembly& a, const VecN<double>& wheel_inertia) {
  const Vehicle<double>& nominal = a.setup.vehicle;
  const int n = nominal.actuators();
  truth::PlantModel& plant = a.plant;
  const int k = static_cast<int>(plant.actuators.thrusters.each.size());  // what follows is of the others, but for dD_B
  const TruthBlock t = read_params(TruthBlock{}, block(scenario, "truth"), Place{"truth", n - k});
  plant.D_B = a.vehicles.D_B;
  plant.magnetorquers = nominal.magnetorquers;
  if (t.dD_B.cols() != 0) {
    if (t.dD_B.cols() != n)
      refuse("truth: dD_B has " + std::to_string(t.dD_B.cols()) + " columns; the vehicle has " + std::to_string(n) +
             " actuators");
    for (const truth::ControlMomentGyro& gyro : plant.gyros) {
      if (t.dD_B.col(gyro.channel).isZero(0)) continue;
      refuse("truth: dD_B of actuator " + std::to_string(gyro.channel) +
             ", a control moment gyro, must be 0: its axis moves");
    }
    plant.D_B += t.dD_B;
  }
  const Mat3<double> total = nominal.J_B + wheel_inertia_sum(nominal.D_B, wheel_inertia) + t.dJ_B;
  check_inertia(total, "truth: J_B + dJ_B");
  plant.J_B = nominal.J_B + t.dJ_B;
  plant.orbit_rate = nominal.orbit_rate;
  truth::Actuators& actuators = plant.actuators;
  actuators.u_lo = nominal.u_lo.head(n - k);
  actuators.u_up = nominal.u_up.head(n - k);
  limits(t.u_max, t.u_min, actuators.u_lo, actuators.u_up, "truth");
  const VecN<double> zero = VecN<double>::Zero(k), infinite = VecN<double>::Constant(k, detail::infinite);
  actuators.u_lo = joined(actuators.u_lo, nominal.u_lo.tail(k));
  actuators.u_up = joined(actuators.u_up, nominal.u_up.tail(k));
  actuators.limit_on = t.limit_on == TruthBlock::LimitOn::command ? truth::LimitOn::command : truth::LimitOn::output;
  actuators.wheel_inertia = wheel_inertia;
  actuators.viscous_friction = joined(or_constant(t.viscous_friction, n - k, 0.0), zero);
  actuators.coulomb_friction = joined(or_constant(t.coulomb_friction, n - k, 0.0), zero);
  actuators.momentum_max = t.momentum_max.size() != 0 ? joined(t.momentum_max, infinite) : nominal.h_max;
  a.vehicles.D_true_B = plant.D_B;
}

/// Where it flies. The orbit's rate is the vehicle's, unless that says another one.
void read_orbit(const Table& scenario, Assembly& a) {
  const Table& table = block(scenario, "orbit");
  if (table.empty()) {
    if (a.setup.vehicle.magnetorquers.any()) refuse("vehicle: magnetorquers need an orbit, for its field");
    return;
  }
  const Place place{"orbit"};
  const truth::OrbitElements elements = read_params(truth::OrbitElements{}, table, place);
  if (table.find("sun_N") != nullptr && table.find("sun_longitude") != nullptr)
    place.refuse("give one of sun_N and sun_longitude");
  if (const std::string error = elements.check(); !error.empty()) place.refuse(error);
  Vehicle<double>& vehicle = a.setup.vehicle;
  if (vehicle.coordinates != Coordinates::body) place.refuse("flies on body coordinates");
  a.plant.orbit.emplace(elements);
  const double n = a.plant.orbit->mean_motion();
  if (vehicle.orbit_rate != 0 && std::abs(vehicle.orbit_rate - n) > 1e-6 * n) {
    refuse("vehicle: orbit_rate = " + number_text(vehicle.orbit_rate) + " rad/s; that of the orbit is " +
           number_text(n) + ": leave it out");
  }
  vehicle.orbit_rate = a.plant.orbit_rate = n;
  a.vehicles.orbit = a.plant.orbit;
}

/// What the stack does about momentum.
void read_desaturation(const Table& scenario, Assembly& a) {
  const Value* value = scenario.find("desaturation");
  if (value == nullptr || value->is_none()) return;
  const Place place{"desaturation"};
  if (!a.setup.vehicle.magnetorquers.any()) place.refuse("the vehicle has no magnetorquers to do it with");
  a.desaturation = read_params(DesaturationBlock{}, table_of(*value, "desaturation"), place);
}

/// Modes of appendages, whose inertia the true body has.
void read_flexible(const Table& scenario, Assembly& a) {
  const Table& table = block(scenario, "flexible");
  if (table.empty()) return;
  const FlexibleBlock f = read_params(FlexibleBlock{}, table, Place{"flexible", a.setup.vehicle.actuators()});
  const std::size_t m = f.delta.size();
  if (m == 0) refuse("flexible: delta is missing: a row of three numbers a mode");
  if (m > FlexibleBlock::most_modes) refuse("flexible: delta has " + std::to_string(m) + " rows; at most 8 modes");
  if (a.setup.vehicle.coordinates != Coordinates::body) refuse("flexible: appendages fly on body coordinates");
  const auto one_a_mode = [&](const std::vector<double>& v, const char* name, bool may_be_absent) {
    if (v.size() == m || (may_be_absent && v.empty())) return;
    refuse(std::string("flexible: ") + name + " has " + std::to_string(v.size()) +
           " numbers; one a mode belongs here, " + std::to_string(m));
  };
  for (std::size_t k = 0; k < m; ++k) {
    if (f.delta[k].size() == 3) continue;
    refuse("flexible: mode " + std::to_string(k) + ": delta has " + std::to_string(f.delta[k].size()) +
           " numbers; a row is a mode, of three numbers");
  }
  one_a_mode(f.omega, "omega", false);
  one_a_mode(f.xi, "xi", true);
  one_a_mode(f.eta, "eta", true);
  one_a_mode(f.eta_rate, "eta_rate", true);
  const auto of = [](const std::vector<double>& v, std::size_t k, double absent) { return v.empty() ? absent : v[k]; };
  for (std::size_t k = 0; k < m; ++k) {
    const std::string mode = "flexible: mode " + std::to_string(k);
    if (!(f.omega[k] > 0)) refuse(mode + ": frequency must be positive");
    const Vec3<double> delta_B{f.delta[k][0], f.delta[k][1], f.delta[k][2]};
    a.plant.modes.push_back({delta_B, f.omega[k], of(f.xi, k, 0.005), of(f.eta, k, 0), of(f.eta_rate, k, 0)});
  }
  (void)truth::free_frequencies(a.plant.J_B, a.plant.modes);  // refuses more inertia than there is
  for (const truth::FlexibleMode& mode : a.plant.modes) a.plant.J_B -= mode.inertia_B();
}

void read_faults(const Table& scenario, Assembly& a) {
  const int n = a.setup.vehicle.actuators();
  a.plant.faults = read_list<truth::Fault>("fault", scenario, "faults", n);
  for (std::size_t i = 0; i < a.plant.faults.size(); ++i) {
    std::visit(
        [&](const auto& fault) {
          const std::string where = "faults[" + std::to_string(i) + "] '" + fault.name + "': ";
          const truth::Window& window = fault.window;
          if (window.actuator >= n) {
            refuse(where + "actuator = " + std::to_string(window.actuator) + " is not there; the vehicle has " +
                   std::to_string(n) + " (0 to " + std::to_string(n - 1) + ")");
          }
          if (!window.ordered())
            refuse(where + "t_off = " + number_text(window.t_off) +
                   " must be after t_on = " + number_text(window.t_on) + " s");
          if constexpr (std::same_as<std::decay_t<decltype(fault)>, truth::RotorSlowDown>) {
            if (!a.vehicles.gyros.gyros().test(window.actuator))
              refuse(where + "actuator " + std::to_string(window.actuator) + " is no control moment gyro");
          }
        },
        a.plant.faults[i]);
  }
  if (const std::string clash = truth::contradiction(a.plant.faults); !clash.empty()) refuse(clash);
}

void read_initial(const Table& scenario, Assembly& a, const VecN<double>& wheel_inertia) {
  const int n = a.setup.vehicle.actuators();
  const int k = static_cast<int>(a.plant.actuators.thrusters.each.size());
  const InitialBlock i = read_params(InitialBlock{}, block(scenario, "initial"), Place{"initial", n - k});
  const bool has_q = block(scenario, "initial").find("q_NB") != nullptr;
  const bool has_mrp = !i.mrp.hasNaN(), has_euler = !i.euler.hasNaN();
  if (int{has_q} + int{has_mrp} + int{has_euler} > 1) refuse("initial: give one of q_NB, mrp and euler");
  a.initial.q_NB = has_mrp ? quat_from_mrp(i.mrp) : has_euler ? quat_from_euler(i.euler) : i.q_NB;
  a.initial.euler = has_euler ? i.euler : euler(a.initial.q_NB);
  a.initial.omega_BN_B = i.omega_BN_B;
  const VecN<double> speed = joined(or_constant(i.wheel_speed, n - k, 0.0), VecN<double>::Zero(k));
  a.initial.h_w = VecN<double>::Zero(n);
  for (int w = 0; w < n; ++w) {
    if (speed[w] != 0.0 && wheel_inertia[w] == 0.0) {
      refuse("initial: wheel_speed = " + number_text(speed[w]) + " rad/s for actuator " + std::to_string(w) +
             ", which has no wheel_inertia");
    }
    a.initial.h_w[w] = wheel_inertia[w] * (speed[w] + a.plant.D_B.col(w).dot(i.omega_BN_B));
  }
}

Surroundings surroundings_of(const Assembly& a) { return {a.plant.orbit, a.plant.orbit_rate}; }

void read_reference(const Table& scenario, Assembly& a) {
  const Table& table = block(scenario, "reference");
  a.reference_outside = !table.empty() && type_of(table, "reference") == "python";
  if (a.reference_outside) return;
  a.reference = read_typed<ReferenceSpec>("reference", table, "reference", a.setup.vehicle.actuators(), "hold");
  const std::string name = std::visit([](const auto& r) { return std::string(r.name); }, a.reference);
  if (name != Nadir::name && name != Target::name && name != SunPointing::name && name != TwoVector::name) return;
  ReferencePath(a.reference, a.setup.dt, surroundings_of(a), "reference '" + name + "'").survey(a.ticks);
}

void read_run(const Table& scenario, Assembly& a) {
  Table run;
  for (const char* key : {"duration", "dt", "seed", "run_number", "noise_versions", "allow_unstable"}) {
    if (const Value* value = scenario.find(key)) run.set(key, *value);
  }
  a.run = read_params(RunBlock{}, run, Place{"scenario"});
  const double dt = a.run.dt, duration = a.run.duration;
  const double ticks = std::round(duration / dt);
  if (std::abs(ticks * dt - duration) > 1e-9 * std::max(1.0, duration)) {
    const double below = std::floor(duration / dt);
    refuse("scenario: duration = " + number_text(duration) +
           " s is not a whole number of periods dt = " + number_text(dt) + " s; nearest are " +
           number_text(below * dt) + " and " + number_text((below + 1) * dt) + " s");
  }
  a.ticks = static_cast<Tick>(ticks);
  a.setup.dt = dt;
}

void refuse_unknown_keys(const Table& scenario) {
  static const std::vector<std::string> known = {
      "name",           "description", "duration",     "dt",        "seed",         "run_number", "noise_versions",
      "allow_unstable", "vehicle",     "truth",        "orbit",     "desaturation", "flexible",   "cmg",
      "thrusters",      "initial",     "navigator",    "observer",  "detector",     "controller", "allocator",
      "faults",         "shadows",     "disturbances", "reference", "sensors",      "record",     "integrator"};
  detail::refuse_unknown(scenario, Place{"scenario"}, known);
}

template <class Base>
Status<double> check_one(const Family<Base>& family, const Setup<double>& setup, const ComponentSpec& spec) {
  return family.find(spec.type, spec.where).check(setup, spec.params, Place{spec.where, setup.vehicle.actuators()});
}

template <class Base>
Coupling coupling_of(const Family<Base>& family, const Assembly& a, const ComponentSpec& spec) {
  if (spec.type == "python") return {};
  return family.find(spec.type, spec.where)
      .coupling(a.setup, spec.params, Place{spec.where, a.setup.vehicle.actuators()});
}

/// What observer and allocator must agree on.
Status<double> check_pair(const Assembly& a) {
  const Catalogue& c = catalogue();
  return actuators_can_recover(coupling_of(c.observers, a, a.observer).effectiveness_floor,
                               coupling_of(c.allocators, a, a.allocator).effectiveness_floor);
}

/// Data sheets of the sensors, of which a component is told what it was not given. Never bias, scale factor, misalignment or
/// outliers: those nobody knows in flight.
template <class Base>
void fill_from_sensors(const Assembly& a, const Family<Base>& family, ComponentSpec& spec) {
  if (spec.type == "python") return;
  std::vector<ParamInfo> taken;  // asked only where a sensor has something to say
  const auto takes = [&](const char* key) {
    if (taken.empty()) taken = family.find(spec.type, spec.where).describe(a.setup);
    return std::any_of(taken.begin(), taken.end(), [key](const ParamInfo& p) { return p.name == key; });
  };
  const auto tell = [&](const char* key, bool known, auto&& value) {
    if (known && spec.params.find(key) == nullptr && takes(key)) spec.params.set(key, value());
  };
  const auto square = [](double x) { return x * x; };
  for (const truth::Sensor& sensor : a.sensors) {
    if (const auto* gyro = std::get_if<truth::Gyro>(&sensor)) {
      const double walk = square(gyro->angle_random_walk) +
                          (square(gyro->noise) + square(gyro->quantisation) / 12) * gyro->every * a.setup.dt;
      tell("angle_random_walk", walk > 0, [&] { return std::sqrt(walk); });
      tell("rate_random_walk", gyro->rate_random_walk > 0, [&] { return gyro->rate_random_walk; });
      tell("gyro_every", gyro->every > 1, [&] { return gyro->every; });
    }
    if (const auto* attitude = std::get_if<truth::AttitudeSensor>(&sensor)) {
      const double noise = std::sqrt(square(attitude->noise) + square(attitude->quantisation) / 12);
      tell("attitude_noise", noise > 0, [&] { return write(Vec3<double>(Vec3<double>::Constant(noise))); });
      tell("latency", attitude->delay > 0, [&] { return attitude->delay; });
    }
    if (const auto* tracker = std::get_if<truth::StarTracker>(&sensor)) {
      tell("attitude_noise", tracker->noise.minCoeff() > 0, [&] { return write(tracker->noise); });
      tell("q_BS", tracker->q_BS.w() != 1, [&] { return write(tracker->q_BS); });
      tell("latency", tracker->latency > 0, [&] { return tracker->latency; });
    }
    if (const auto* sun = std::get_if<truth::SunSensor>(&sensor))
      tell("sun_noise", sun->noise > 0, [&] { return sun->noise; });
    if (const auto* field = std::get_if<truth::Magnetometer>(&sensor))
      tell("field_noise", field->noise > 0, [&] { return field->noise; });
    if (const auto* tachometer = std::get_if<truth::Tachometer>(&sensor))
      tell("momentum_delay", tachometer->delay > 0, [&] { return tachometer->delay; });
  }
}

void fill_from_sensors(Assembly& a) {
  const Catalogue& c = catalogue();
  fill_from_sensors(a, c.navigators, a.navigator);
  fill_from_sensors(a, c.observers, a.observer);
  fill_from_sensors(a, c.detectors, a.detector);
  for (auto& [observer, detector] : a.shadows) {
    fill_from_sensors(a, c.observers, observer);
    fill_from_sensors(a, c.detectors, detector);
  }
}

/// Refuses sensors that cannot be, before anything flies.
void check_sensors(const Assembly& a) {
  (void)truth::Sensors(a.sensors, a.run.seed, a.run.run_number, false, a.setup.dt, a.setup.vehicle.wheels,
                       a.plant.orbit, a.run.noise_versions);
  if (a.setup.vehicle.coordinates == Coordinates::body) return;
  for (const truth::Sensor& sensor : a.sensors) {
    if (std::holds_alternative<truth::StarTracker>(sensor)) refuse("sensor star_tracker: flies on body coordinates");
  }
}

std::string text_of(const Status<double>& s) {
  return std::string(s.quantity) + " = " + number_text(s.value) + ", must be " + s.relation + " " +
         number_text(s.limit);
}

/// Lets pass what works, and what is unstable where the scenario wants it so.
void admit(const Assembly& a, const std::string& where, const Status<double>& status) {
  if (status.ok(a.run.allow_unstable)) return;
  const bool unstable = status.code == Status<double>::Code::unstable;
  refuse(where + ": " + text_of(status) + (unstable ? " (unstable; allow_unstable = true runs it anyway)" : ""));
}

/// Checked, then made: from outside when the type says so.
template <class Base>
std::unique_ptr<Base> make_one(const Family<Base>& family, const Assembly& a, const ComponentSpec& spec,
                               const std::function<std::unique_ptr<Base>(const Setup<double>&)>& external) {
  if (spec.type == "python") {
    if (!external) refuse(spec.where + ": type 'python' needs a Python object for this role");
    return external(a.setup);
  }
  admit(a, spec.where, check_one(family, a.setup, spec));
  return family.find(spec.type, spec.where).make(a.setup, spec.params, Place{spec.where, a.setup.vehicle.actuators()});
}

}  // namespace

Assembly assemble(const Table& scenario) {
  refuse_unknown_keys(scenario);
  Assembly a;
  VecN<double> wheel_inertia;
  read_run(scenario, a);
  read_vehicle(scenario, a, wheel_inertia);
  read_truth(scenario, a, wheel_inertia);
  read_orbit(scenario, a);
  read_desaturation(scenario, a);
  read_flexible(scenario, a);
  read_faults(scenario, a);
  read_initial(scenario, a, wheel_inertia);
  a.vehicles.nominal = a.setup.vehicle;
  a.vehicles.dt = a.setup.dt;
  const int n = a.setup.vehicle.actuators();
  a.plant.disturbances = read_list<truth::Disturbance>("disturbance", scenario, "disturbances", n);
  a.sensors = read_list<truth::Sensor>("sensor", scenario, "sensors", n);
  check_sensors(a);
  a.plant.integrator =
      read_typed<truth::Integrator>("integrator", block(scenario, "integrator"), "integrator", n, "cvode");
  read_reference(scenario, a);
  a.navigator = component(block(scenario, "navigator"), "navigator", "none");
  a.observer = component(block(scenario, "observer"), "observer", "passthrough");
  a.detector = component(block(scenario, "detector"), "detector", "none");
  a.controller = component(block(scenario, "controller"), "controller", "mrp_feedback");
  a.allocator = component(block(scenario, "allocator"), "allocator", "pseudo_inverse");
  const List& shadows = list_of(scenario, "shadows");
  for (std::size_t i = 0; i < shadows.size(); ++i) {
    const std::string where = "shadows[" + std::to_string(i) + "]";
    const Table& pair = table_of(shadows[i], where);
    detail::refuse_unknown(pair, Place{where}, {"observer", "detector"});
    a.shadows.emplace_back(component(block(pair, "observer"), where + ".observer", "passthrough"),
                           component(block(pair, "detector"), where + ".detector", "none"));
  }
  fill_from_sensors(a);
  a.record = block(scenario, "record");
  return a;
}

std::vector<CheckRow> check_components(const Assembly& a, const ExternalComponents&) {
  std::vector<CheckRow> rows;
  const auto add = [&](const auto& family, const ComponentSpec& spec) {
    if (spec.type == "python") return;
    rows.push_back({spec.where.substr(0, spec.where.find(' ')), spec.type, check_one(family, a.setup, spec)});
  };
  const Catalogue& c = catalogue();
  add(c.navigators, a.navigator);
  add(c.observers, a.observer);
  add(c.detectors, a.detector);
  add(c.controllers, a.controller);
  add(c.allocators, a.allocator);
  if (a.desaturation) {
    rows.push_back(
        {"desaturation", "cross_product", CrossProductDesaturation<double>::check(a.setup, *a.desaturation)});
  }
  if (const Status<double> pair = check_pair(a); !pair.ok())
    rows.push_back({"observer and allocator", a.observer.type + ", " + a.allocator.type, pair});
  for (const auto& [observer, detector] : a.shadows) {
    add(c.observers, observer);
    add(c.detectors, detector);
  }
  return rows;
}

AnyPlant make_plant(const Assembly& a) {
  if (a.setup.vehicle.coordinates == Coordinates::euler_angles) {
    return AnyPlant(std::in_place_type<truth::EulerPlant>, a.plant, a.initial, a.setup.dt);
  }
  return AnyPlant(std::in_place_type<truth::RigidPlant>, a.plant, a.initial, a.setup.dt);
}

Outside make_outside(const Assembly& a, const ExternalComponents& external) {
  Outside outside = external.outside ? external.outside(a.setup) : Outside{};
  if (a.reference_outside && !outside.reference) refuse("reference: type 'python' needs a Python object for this role");
  for (const Drive& drive : outside.drives) {
    if (!a.plant.actuators.thrusters.has(drive.actuator)) continue;
    refuse("drives: actuator " + std::to_string(drive.actuator) +
           " is a thruster, whose valve says what it gives; a column of the vehicle's D_B can be driven");
  }
  return outside;
}

ReferencePath make_reference(const Assembly& a, const Outside& outside) {
  if (a.reference_outside) return ReferencePath(outside.reference, a.setup.dt);
  return ReferencePath(a.reference, a.setup.dt, surroundings_of(a));
}

std::vector<std::pair<std::string, Estimates>> estimate_flow(const Assembly& a) {
  const Catalogue& c = catalogue();
  std::vector<std::pair<std::string, Estimates>> flow;
  if (a.observer.type != "python")
    flow.emplace_back("observer", c.observers.find(a.observer.type, a.observer.where).traits.estimates);
  const auto add = [&](const auto& family, const ComponentSpec& spec) {
    if (spec.type != "python") flow.emplace_back(family.role(), coupling_of(family, a, spec).uses);
  };
  add(c.detectors, a.detector);
  add(c.controllers, a.controller);
  add(c.allocators, a.allocator);
  return flow;
}

Stack make_stack(const Assembly& a, const ExternalComponents& external) {
  const Catalogue& c = catalogue();
  using Law = CrossProductDesaturation<double>;
  admit(a, a.observer.where + ", " + a.allocator.where, check_pair(a));
  AnyManagement management;
  if (a.desaturation) {
    admit(a, "desaturation", Law::check(a.setup, *a.desaturation));
    management.law.emplace(unchecked, a.setup, *a.desaturation);
  }
  return Stack(unchecked, a.setup, AnyObserver(make_one(c.observers, a, a.observer, external.observer)),
               AnyDetector(make_one(c.detectors, a, a.detector, external.detector)),
               AnyController(make_one(c.controllers, a, a.controller, external.controller)),
               AnyAllocator(make_one(c.allocators, a, a.allocator, external.allocator)),
               AnyNavigator(make_one(c.navigators, a, a.navigator, external.navigator)),
               MovingAxes<double>{a.vehicles.gyros, {a.vehicles.D_B}}, management);
}

std::vector<Shadow> make_shadows(const Assembly& a, const ExternalComponents&) {
  const Catalogue& c = catalogue();
  std::vector<Shadow> out;
  for (const auto& [observer, detector] : a.shadows) {
    out.emplace_back(a.setup, AnyObserver(make_one(c.observers, a, observer, {})),
                     AnyDetector(make_one(c.detectors, a, detector, {})));
  }
  return out;
}

}  // namespace gyrostat::host
