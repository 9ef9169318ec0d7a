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

const Table& block(const Table& scenario, const std::string& key) {
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

void read_vehicle(const Table& scenario, Assembly& a, VecN<double>& wheel_inertia) {
  Table table = block(scenario, "vehicle");
  if (table.empty()) refuse("vehicle is missing: J_B and D_B at least");
  // The number of actuators is known once the axes are.
  VehicleBlock axes;
  Place place{"vehicle"};
  const Value* D = table.find("D_B");
  if (D == nullptr) place.refuse("D_B is missing: actuator axes in columns, body frame");
  read(*D, Key{place, "D_B", -1e6, 1e6}, axes.D_B);
  const int n = static_cast<int>(axes.D_B.cols());
  place.actuators = n;
  const VehicleBlock v = read_params(VehicleBlock{}, table, place);
  check_inertia(v.J_B, "vehicle: J_B");
  check_rank(v.D_B, "vehicle: D_B");

  Vehicle<double>& vehicle = a.setup.vehicle;
  vehicle.D_B = v.D_B;
  vehicle.u_up = VecN<double>::Constant(n, detail::infinite);
  vehicle.u_lo = -vehicle.u_up;
  limits(v.u_max, v.u_min, vehicle.u_lo, vehicle.u_up, "vehicle");
  vehicle.u_rate = or_constant(v.u_rate, n, detail::infinite);
  vehicle.h_max = or_constant(v.momentum_max, n, detail::infinite);
  vehicle.spare = v.spare;
  vehicle.orbit_rate = v.orbit_rate;
  vehicle.coordinates = v.coordinates;
  wheel_inertia = or_constant(v.wheel_inertia, n, 0.0);
  for (int i = 0; i < n; ++i) {
    if (wheel_inertia[i] == 0.0) {
      if (std::isfinite(vehicle.h_max[i]))
        refuse("vehicle: momentum_max of actuator " + std::to_string(i) + " needs a wheel_inertia");
      continue;
    }
    vehicle.wheels.set(i);
    if (std::abs(v.D_B.col(i).norm() - 1.0) > 1e-6) {
      refuse("vehicle: D_B column " + std::to_string(i) + " is a wheel axis of length " +
             number_text(v.D_B.col(i).norm()) + "; a unit vector belongs here");
    }
  }
  vehicle.J_B = v.J_B - wheel_inertia_sum(v.D_B, wheel_inertia);
  if (!(eigenvalues(vehicle.J_B)[0] > 0)) {
    refuse(
        "vehicle: J_B (of the whole vehicle) less the wheels' axial inertia is not positive definite; is J_B without "
        "the wheels?");
  }
}

void read_truth(const Table& scenario, Assembly& a, const VecN<double>& wheel_inertia) {
  const Vehicle<double>& nominal = a.setup.vehicle;
  const int n = nominal.actuators();
  const TruthBlock t = read_params(TruthBlock{}, block(scenario, "truth"), Place{"truth", n});
  truth::PlantModel& plant = a.plant;
  plant.D_B = nominal.D_B;
  if (t.dD_B.cols() != 0) {
    if (t.dD_B.cols() != n)
      refuse("truth: dD_B has " + std::to_string(t.dD_B.cols()) + " columns; the vehicle has " + std::to_string(n) +
             " actuators");
    plant.D_B += t.dD_B;
  }
  const Mat3<double> total = nominal.J_B + wheel_inertia_sum(nominal.D_B, wheel_inertia) + t.dJ_B;
  check_inertia(total, "truth: J_B + dJ_B");
  plant.J_B = nominal.J_B + t.dJ_B;
  plant.orbit_rate = nominal.orbit_rate;
  truth::Actuators& actuators = plant.actuators;
  actuators.u_lo = nominal.u_lo;
  actuators.u_up = nominal.u_up;
  limits(t.u_max, t.u_min, actuators.u_lo, actuators.u_up, "truth");
  actuators.limit_on = t.limit_on == TruthBlock::LimitOn::command ? truth::LimitOn::command : truth::LimitOn::output;
  actuators.wheel_inertia = wheel_inertia;
  actuators.viscous_friction = or_constant(t.viscous_friction, n, 0.0);
  actuators.coulomb_friction = or_constant(t.coulomb_friction, n, 0.0);
  actuators.momentum_max = t.momentum_max.size() != 0 ? t.momentum_max : nominal.h_max;
  a.vehicles.D_true_B = plant.D_B;
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
        },
        a.plant.faults[i]);
  }
  if (const std::string clash = truth::contradiction(a.plant.faults); !clash.empty()) refuse(clash);
}

void read_initial(const Table& scenario, Assembly& a, const VecN<double>& wheel_inertia) {
  const int n = a.setup.vehicle.actuators();
  const InitialBlock i = read_params(InitialBlock{}, block(scenario, "initial"), Place{"initial", n});
  const bool has_q = block(scenario, "initial").find("q_NB") != nullptr;
  const bool has_mrp = !i.mrp.hasNaN(), has_euler = !i.euler.hasNaN();
  if (int{has_q} + int{has_mrp} + int{has_euler} > 1) refuse("initial: give one of q_NB, mrp and euler");
  a.initial.q_NB = has_mrp ? quat_from_mrp(i.mrp) : has_euler ? quat_from_euler(i.euler) : i.q_NB;
  a.initial.euler = has_euler ? i.euler : euler(a.initial.q_NB);
  a.initial.omega_BN_B = i.omega_BN_B;
  const VecN<double> speed = or_constant(i.wheel_speed, n, 0.0);
  a.initial.h_w = VecN<double>::Zero(n);
  for (int w = 0; w < n; ++w) {
    if (speed[w] != 0.0 && wheel_inertia[w] == 0.0) {
      refuse("initial: wheel_speed = " + number_text(speed[w]) + " rad/s for actuator " + std::to_string(w) +
             ", which has no wheel_inertia");
    }
    a.initial.h_w[w] = wheel_inertia[w] * (speed[w] + a.plant.D_B.col(w).dot(i.omega_BN_B));
  }
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
      "name",           "description",    "duration",  "dt",         "seed",      "run_number",
      "noise_versions", "allow_unstable", "vehicle",   "truth",      "flexible",  "initial",
      "navigator",      "observer",       "detector",  "controller", "allocator", "faults",
      "shadows",        "disturbances",   "reference", "sensors",    "record",    "integrator"};
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

/// Data sheets of the sensors, of which a navigator is told what it was not given. Never bias, scale factor, misalignment or outliers:
/// those nobody knows in flight.
void fill_from_sensors(Assembly& a) {
  if (a.navigator.type == "python") return;
  std::vector<ParamInfo> taken;  // asked only where a sensor has something to say
  const auto takes = [&](const char* key) {
    if (taken.empty()) taken = catalogue().navigators.find(a.navigator.type, a.navigator.where).describe(a.setup);
    return std::any_of(taken.begin(), taken.end(), [key](const ParamInfo& p) { return p.name == key; });
  };
  const auto tell = [&](const char* key, bool known, auto&& value) {
    if (known && a.navigator.params.find(key) == nullptr && takes(key)) a.navigator.params.set(key, value());
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
  }
}

/// Refuses sensors that cannot be, before anything flies.
void check_sensors(const Assembly& a) {
  (void)truth::Sensors(a.sensors, a.run.seed, a.run.run_number, false, a.setup.dt, a.setup.vehicle.wheels,
                       a.run.noise_versions);
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
  a.reference = read_typed<ReferenceSpec>("reference", block(scenario, "reference"), "reference", n, "hold");
  a.navigator = component(block(scenario, "navigator"), "navigator", "none");
  fill_from_sensors(a);
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
  admit(a, a.observer.where + ", " + a.allocator.where, check_pair(a));
  return Stack(unchecked, a.setup, AnyObserver(make_one(c.observers, a, a.observer, external.observer)),
               AnyDetector(make_one(c.detectors, a, a.detector, external.detector)),
               AnyController(make_one(c.controllers, a, a.controller, external.controller)),
               AnyAllocator(make_one(c.allocators, a, a.allocator, external.allocator)),
               AnyNavigator(make_one(c.navigators, a, a.navigator, external.navigator)));
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
