// SPDX-License-Identifier: MIT
#include "gyrostat/host/channels.hpp"

#include <algorithm>
#include <stdexcept>
#include <variant>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/flight/parts/euler_model.hpp"
#include "gyrostat/host/value.hpp"

namespace gyrostat::host {

namespace {

constexpr int per_actuator = -1, per_mode = -2, per_gimbal = -3, gimballed = -4, of_thrusters = -5, of_thrusters3 = -6,
              once_an_orbit = -7, three_an_orbit = -8;  // one number, or three, where there are such

void put(const Vec3<double>& v, double* out) { std::copy_n(v.data(), 3, out); }
void put(const VecN<double>& v, double* out) { std::copy_n(v.data(), v.size(), out); }
void put(const Quat<double>& q, double* out) {
  out[0] = q.w();
  out[1] = q.x();
  out[2] = q.y();
  out[3] = q.z();
}
void put(double x, double* out) { *out = x; }
/// `otherwise` for each where nothing is said.
void put_or(const VecN<double>& v, double otherwise, int n, double* out) {
  for (int i = 0; i < n; ++i) out[i] = v.size() == n ? v[i] : otherwise;
}
void put_classes(const PairView& p, double* out) {
  for (int i = 0; i < p.actuators; ++i) out[i] = static_cast<double>(p.det->classes[static_cast<std::size_t>(i)]);
}

truth::Orbit::Point orbit_of(const Moment& m) { return m.vehicles.orbit->at(m.now.t); }

Vec3<double> field_of(const Moment& m, const truth::TruthState& s) {
  return s.q_NB.conjugate() * m.vehicles.orbit->field(s.t).B_N;
}

/// Where gyros point, of a vehicle that has some.
Axes<double> gimballed_axes(const Moment& m, const truth::TruthState& s) {
  return m.vehicles.gyros.at(m.vehicles.nominal, s.gimbal, s.h_w);
}

/// Axes of torque at s: of gyros where their gimbals point, of magnetorquers across the field, of all others `D_B`.
Mat3N<double> axes_of(const Moment& m, const truth::TruthState& s, Mat3N<double> D_B) {
  const Mask gyros = m.vehicles.gyros.gyros(), magnetorquers = m.vehicles.nominal.magnetorquers;
  if (!gyros.any() && !magnetorquers.any()) return D_B;
  const Axes<double> turned = gyros.any() ? gimballed_axes(m, s) : Axes<double>{};
  for (int i = 0; i < D_B.cols(); ++i) {
    if (gyros.test(i)) D_B.col(i) = turned.D_B.col(i);
    if (magnetorquers.test(i)) D_B.col(i) = Vec3<double>(D_B.col(i)).cross(field_of(m, s));
  }
  return D_B;
}

/// What the nominal model knows of the motion without commands.
Vec3<double> known_of(const Moment& m, const truth::TruthState& s) {
  const bool gyros = m.vehicles.gyros.any();
  const Vec3<double> h_B = gyros ? gimballed_axes(m, s).h_B : torque<double>(m.vehicles.nominal.D_B, s.h_w);
  return known_torque<double>(m.vehicles.nominal, s.angles, s.omega_BN_B, h_B);
}

/// N m, of the nominal axes that held at s.
Vec3<double> nominal_torque(const Moment& m, const truth::TruthState& s, const VecN<double>& u) {
  return torque<double>(axes_of(m, s, m.vehicles.D_B), u);
}

Vec3<double> fault_torque(const Moment& m) {
  return torque<double>(axes_of(m, m.now, m.vehicles.D_true_B), m.truth().delivered - m.u_held);
}

/// sqrt det(B B'), B the axes of the gyros.
double singularity(const Moment& m) {
  const Mat3N<double> D_B = gimballed_axes(m, m.now).D_B;
  Mat3<double> squares = Mat3<double>::Zero();
  for (int i = 0; i < D_B.cols(); ++i) {
    if (m.vehicles.gyros.gyros().test(i)) squares += D_B.col(i) * D_B.col(i).transpose();
  }
  return std::sqrt(std::max(squares.determinant(), 0.0));
}

Vec3<double> lumped(const Moment& m) {
  const Vehicle<double>& v = m.vehicles.nominal;
  return v.J_B * m.truth().omegadot_BN_B - known_of(m, m.now) - nominal_torque(m, m.now, m.u_held);
}

/// Interval mean; what is known by the trapezoid, axes as they were when the command was made.
Vec3<double> lumped_mean(const Moment& m) {
  const Vehicle<double>& v = m.vehicles.nominal;
  const Vec3<double> mean = 0.5 * (known_of(m, m.now) + known_of(m, m.before));
  return v.J_B * (m.now.omega_BN_B - m.before.omega_BN_B) / m.vehicles.dt - mean -
         nominal_torque(m, m.before, m.u_held);
}

AttitudeError<double> error_of(const Moment& m) {
  return attitude_error(m.now.q_NB, m.now.omega_BN_B, m.ref->q_NR, m.ref->omega_RN_R);
}

/// What most runs measure at every sample: of unit quaternions, without the rest of attitude_error.
double pointing_error(const Moment& m) {
  const Quat<double> q_RB = m.ref->q_NR.conjugate() * m.now.q_NB;
  return 2 * std::atan2(q_RB.vec().norm(), std::abs(q_RB.w()));
}

struct Known {
  const char* name;
  int size;  // per_actuator, per_mode, ...: one each; .._an_orbit: where there is one
  const char* unit;
  const char* meaning;
  std::variant<void (*)(const Moment&, double*), void (*)(const PairView&, double*)> fill;  // of a pair: of shadows too
  bool usual = false;
  bool previous = false;
};

using M = const Moment&;
using P = const PairView&;
const Known known[] = {
    {"truth.q_NB", 4, "", "attitude, scalar first", [](M m, double* o) { put(m.now.q_NB, o); }, true},
    {"truth.omega_BN_B", 3, "rad/s", "body rate", [](M m, double* o) { put(m.now.omega_BN_B, o); }, true},
    {"truth.mrp", 3, "", "attitude as MRP of the short way, |sigma| <= 1",
     [](M m, double* o) { put(mrp(short_way(m.now.q_NB)), o); }},
    {"truth.euler", 3, "rad", "roll, pitch, yaw", [](M m, double* o) { put(m.euler().angles, o); }},
    {"truth.euler_rates", 3, "rad/s", "rates of roll, pitch, yaw", [](M m, double* o) { put(m.euler().rates, o); }},
    {"truth.h_w", per_actuator, "N m s", "axial wheel momentum in inertial space",
     [](M m, double* o) { put(m.now.h_w, o); }},
    {"truth.eta", per_mode, "kg^1/2 m", "displacement of each mode of the appendages",
     [](M m, double* o) { put(m.now.eta, o); }},
    {"truth.eta_rate", per_mode, "kg^1/2 m/s", "its rate", [](M m, double* o) { put(m.now.eta_rate, o); }},
    {"truth.r_N", three_an_orbit, "m", "position on the orbit", [](M m, double* o) { put(orbit_of(m).r_N, o); }},
    {"truth.v_N", three_an_orbit, "m/s", "velocity on the orbit", [](M m, double* o) { put(orbit_of(m).v_N, o); }},
    {"truth.field_B", three_an_orbit, "T", "magnetic field", [](M m, double* o) { put(field_of(m, m.now), o); }},
    {"truth.eclipse", once_an_orbit, "", "1: in the Earth's shadow",
     [](M m, double* o) { put(m.vehicles.orbit->dark(m.now.t), o); }},
    {"truth.propellant", of_thrusters, "kg", "propellant that the thrusters have used",
     [](M m, double* o) { put(m.now.propellant, o); }},
    {"truth.thruster_impulse_B", of_thrusters3, "N s", "integral of the thrusters' force in body axes",
     [](M m, double* o) { put(m.now.thruster_impulse_B, o); }},
    {"truth.thruster_force_B", of_thrusters3, "N", "force of the thrusters, mean over the interval",
     [](M m, double* o) { put(m.truth().thruster_force_B, o); }},
    {"truth.gimbal", per_gimbal, "rad", "angle of each gimbal; 0 of an actuator that has none",
     [](M m, double* o) { put(m.now.gimbal, o); }},
    {"truth.rotor_momentum", per_gimbal, "N m s", "of the rotor in each gimbal",
     [](M m, double* o) { put(m.now.rotor_momentum, o); }},
    {"truth.singularity", gimballed, "",
     "sqrt det(D D') of the control moment gyros: 0 where their axes lie in a plane",
     [](M m, double* o) { put(singularity(m), o); }},
    {"truth.delivered", per_actuator, "N m",
     "torque on the body that the actuators gave; thrusters: mean over the interval",
     [](M m, double* o) { put(m.truth().delivered, o); }, true},
    {"truth.effectiveness", per_actuator, "", "true effectiveness",
     [](M m, double* o) { put(m.truth().effectiveness, o); }, true},
    {"truth.bias", per_actuator, "N m", "true additive fault", [](M m, double* o) { put(m.truth().bias, o); }},
    {"truth.external_B", 3, "N m", "disturbance torque", [](M m, double* o) { put(m.truth().external_B, o); }},
    {"truth.omegadot_BN_B", 3, "rad/s^2", "body acceleration", [](M m, double* o) { put(m.truth().omegadot_BN_B, o); }},
    {"truth.fault_B", 3, "N m", "D_true (delivered - u)", [](M m, double* o) { put(fault_torque(m), o); }, false, true},
    {"truth.lumped_B", 3, "N m", "J w' + w x (J w + D h_w) - D u, nominal J and D",
     [](M m, double* o) { put(lumped(m), o); }, false, true},
    {"truth.lumped_mean_B", 3, "N m", "mean of lumped_B over the interval",
     [](M m, double* o) { put(lumped_mean(m), o); }, false, true},
    {"error.angle", 1, "rad", "angle between body and reference", [](M m, double* o) { put(pointing_error(m), o); },
     true},
    {"error.mrp", 3, "", "MRP of the body relative to the reference, short way",
     [](M m, double* o) { put(mrp(short_way(error_of(m).q_RB)), o); }},
    {"error.omega_BR_B", 3, "rad/s", "body rate relative to the reference",
     [](M m, double* o) { put(error_of(m).omega_BR_B, o); }},
    {"error.euler", 3, "rad", "roll, pitch, yaw less those of the reference",
     [](M m, double* o) { put(m.angle_difference(m.euler().angles, m.ref->euler.angles), o); }},
    {"error.euler_rates", 3, "rad/s", "rates of roll, pitch, yaw less those of the reference",
     [](M m, double* o) { put(Vec3<double>(m.euler().rates - m.ref->euler.rates), o); }},
    {"measurement.q_NB", 4, "", "measured attitude", [](M m, double* o) { put(m.y->q_NB, o); }},
    {"measurement.omega_BN_B", 3, "rad/s", "measured rate", [](M m, double* o) { put(m.y->omega_BN_B, o); }},
    {"measurement.h_w", per_actuator, "N m s", "measured wheel momentum", [](M m, double* o) { put(m.y->h_w, o); }},
    {"measurement.gimbal", per_gimbal, "rad", "measured angle of each gimbal",
     [](M m, double* o) { put(m.y->gimbal, o); }},
    {"measurement.attitude_valid", 1, "", "1: attitude measured at this sample, 0: not",
     [](M m, double* o) { put(m.y->attitude_valid, o); }},
    {"measurement.rate_valid", 1, "", "1: rate measured at this sample, 0: not",
     [](M m, double* o) { put(m.y->rate_valid, o); }},
    {"measurement.momentum_valid", 1, "", "1: wheel momentum measured at this sample, 0: not",
     [](M m, double* o) { put(m.y->momentum_valid, o); }},
    {"measurement.field_B", three_an_orbit, "T", "measured magnetic field",
     [](M m, double* o) { put(m.y->field_B, o); }},
    {"measurement.field_valid", once_an_orbit, "", "1: field measured at this sample, 0: not",
     [](M m, double* o) { put(m.y->field_valid, o); }},
    {"measurement.field_N", three_an_orbit, "T", "the field as flight's model has it",
     [](M m, double* o) { put(m.y->field_N, o); }},
    {"measurement.sun_B", three_an_orbit, "", "measured direction to the sun; zero: never seen",
     [](M m, double* o) { put(m.y->sun_B, o); }},
    {"measurement.sun_valid", once_an_orbit, "", "1: sun seen at this sample, 0: not",
     [](M m, double* o) { put(m.y->sun_valid, o); }},
    {"measurement.sun_N", three_an_orbit, "", "direction to the sun as flight's almanac has it",
     [](M m, double* o) { put(m.y->sun_N, o); }},
    {"measurement.euler", 3, "rad", "measured roll, pitch, yaw", [](M m, double* o) { put(m.y->euler.angles, o); }},
    {"measurement.euler_rates", 3, "rad/s", "measured Euler rates", [](M m, double* o) { put(m.y->euler.rates, o); }},
    {"reference.q_NR", 4, "", "reference attitude", [](M m, double* o) { put(m.ref->q_NR, o); }},
    {"reference.omega_RN_R", 3, "rad/s", "reference rate", [](M m, double* o) { put(m.ref->omega_RN_R, o); }},
    {"reference.omegadot_RN_R", 3, "rad/s^2", "reference acceleration",
     [](M m, double* o) { put(m.ref->omegadot_RN_R, o); }},
    {"reference.euler", 3, "rad", "reference roll, pitch, yaw", [](M m, double* o) { put(m.ref->euler.angles, o); }},
    {"reference.event", 1, "", "count of jumps", [](M m, double* o) { put(m.ref->event, o); }},
    {"estimate.q_NB", 4, "", "estimated attitude", [](M m, double* o) { put(m.pair.x->q_NB, o); }},
    {"estimate.omega_BN_B", 3, "rad/s", "estimated rate", [](P p, double* o) { put(p.x->omega_BN_B, o); }},
    {"estimate.effectiveness", per_actuator, "", "estimated effectiveness",
     [](P p, double* o) { put(p.x->effectiveness, o); }, true},
    {"estimate.effectiveness_bound", per_actuator, "", "relative half-width; infinite: never excited",
     [](P p, double* o) { put(p.x->effectiveness_bound, o); }},
    {"estimate.d_B", 3, "N m", "estimated lumped torque", [](P p, double* o) { put(p.x->d_B, o); }, true},
    {"detection.changed", 1, "", "bit mask of actuators", [](P p, double* o) { put(p.det->changed.bits(), o); }},
    {"detection.failed", 1, "", "bit mask of actuators", [](P p, double* o) { put(p.det->failed.bits(), o); }},
    {"detection.enabled", 1, "", "bit mask of actuators", [](M m, double* o) { put(m.pair.det->enabled.bits(), o); }},
    {"detection.class", per_actuator, "", "0 healthy, 1 gain, 2 additive, 3 stuck, 4 intermittent, 5 unclear",
     [](P p, double* o) { put_classes(p, o); }},
    {"detection.gain", per_actuator, "", "delivered = gain u + bias, as far as is known",
     [](P p, double* o) { put_or(p.det->gain, 1, p.actuators, o); }},
    {"detection.bias", per_actuator, "N m", "delivered = gain u + bias, as far as is known",
     [](P p, double* o) { put_or(p.det->bias, 0, p.actuators, o); }},
    {"detection.event", 1, "", "count of declarations and recoveries", [](P p, double* o) { put(p.det->event, o); }},
    {"demand.tau_B", 3, "N m", "torque that the controller asks for", [](M m, double* o) { put(m.demand->tau_B, o); },
     true},
    {"demand.u_pref", per_actuator, "N m", "preferred command, probe included",
     [](M m, double* o) { put(m.demand->u_pref, o); }},
    {"allocation.u", per_actuator, "N m", "issued command, held to the next sample",
     [](M m, double* o) { put(m.last->u, o); }, true},
    {"allocation.achieved_B", 3, "N m", "torque that flight believes it gets",
     [](M m, double* o) { put(m.last->achieved_B, o); }},
    {"allocation.saturated", 1, "", "bit mask of actuators at a limit and not at rest",
     [](M m, double* o) { put(m.last->saturated.bits(), o); }, true},
    {"allocation.gap", 1, "", "certified distance to the optimum", [](M m, double* o) { put(m.last->gap, o); }},
    {"allocation.worst_case", 1, "N m", "worst residual under the effectiveness bound",
     [](M m, double* o) { put(m.last->worst_case, o); }},
    {"allocation.iterations", 1, "", "of the allocator", [](M m, double* o) { put(m.last->iterations, o); }},
    {"allocation.status", 1, "", "flags of the sample (core/signals.hpp)",
     [](M m, double* o) { put(m.last->status.bits(), o); }},
};

/// Whether it is a channel of each shadow as well.
bool of_pair(const Known& k) { return k.fill.index() == 1; }

int width_of(int size, const Counts& counts) {
  switch (size) {
    case per_actuator:
      return counts.actuators;
    case per_mode:
      return counts.modes;
    case per_gimbal:
      return counts.gimbals;
    case gimballed:
      return counts.gimbals > 0 ? 1 : 0;
    case of_thrusters:
      return counts.thrusters ? 1 : 0;
    case of_thrusters3:
      return counts.thrusters ? 3 : 0;
    case once_an_orbit:
      return counts.orbit ? 1 : 0;
    case three_an_orbit:
      return counts.orbit ? 3 : 0;
    default:
      return size;
  }
}

ChannelInfo info_of(const std::string& name, const Known& k, const Counts& counts) {
  const bool actuator = k.size == per_actuator || k.size == per_gimbal;
  const bool axis = k.size == 3 || k.size == of_thrusters3 || k.size == three_an_orbit;
  const char* dimension = actuator ? "actuator" : axis ? "axis" : k.size == 4 ? "quaternion" : "";
  return {name, width_of(k.size, counts), k.unit, k.meaning, dimension};
}

ChannelInfo info_of(const std::string& name, const TelemetryEntry& e) {
  return {name, e.width, "", e.counter ? "counter" : "inner signal", e.dimension};
}

std::vector<TelemetryEntry> entries_of(const Reported& r) {
  std::vector<TelemetryEntry> entries;
  r.component->entries(entries);
  return entries;
}

/// Whether `name` is meant by `pattern`, which may end in ".*".
bool meant(const std::string& pattern, const std::string& name) {
  if (pattern.ends_with(".*")) return name.starts_with(pattern.substr(0, pattern.size() - 1));
  return pattern == name;
}

}  // namespace

std::vector<ChannelInfo> ChannelReader::offered(const Counts& counts, const std::vector<Reported>& components,
                                                const std::vector<ShadowView>& shadows) {
  std::vector<ChannelInfo> out;
  for (const Known& k : known) {
    if (width_of(k.size, counts) > 0) out.push_back(info_of(k.name, k, counts));
  }
  for (const ShadowView& s : shadows) {
    for (const Known& k : known) {
      if (of_pair(k)) out.push_back(info_of(s.role + "." + k.name, k, counts));
    }
  }
  for (const Reported& r : components) {
    for (const TelemetryEntry& e : entries_of(r)) out.push_back(info_of(r.role + "." + e.name, e));
  }
  return out;
}

std::vector<std::string> ChannelReader::usual(const std::vector<Reported>& components,
                                              const std::vector<ShadowView>& shadows) {
  std::vector<std::string> names;
  for (const Known& k : known) {
    if (k.usual) names.emplace_back(k.name);
  }
  for (const Reported& r : components) {
    for (const TelemetryEntry& e : entries_of(r)) names.push_back(r.role + "." + e.name);
  }
  for (const ShadowView& s : shadows) names.push_back(s.role + ".estimate.*");
  return names;
}

ChannelReader::ChannelReader(const std::vector<std::string>& names, const Counts& counts,
                             const std::vector<Reported>& components, std::vector<ShadowView> shadows,
                             const std::string& where)
    : shadows_(std::move(shadows)) {
  for (const std::string& pattern : names) choose(pattern, counts, components, where);
}

void ChannelReader::add(ChannelInfo info, Source source) {
  const auto same = [&](const ChannelInfo& c) { return c.name == info.name; };
  if (std::any_of(channels_.begin(), channels_.end(), same)) return;
  source.offset = row_.size();
  row_.resize(row_.size() + static_cast<std::size_t>(info.size));
  channels_.push_back(std::move(info));
  sources_.push_back(source);
}

int ChannelReader::telemetry_of(const Reported& r) {
  for (std::size_t i = 0; i < telemetry_.size(); ++i) {
    if (telemetry_[i].component == r.component) return static_cast<int>(i);
  }
  std::size_t width = 0;
  for (const TelemetryEntry& e : entries_of(r)) width += static_cast<std::size_t>(e.width);
  telemetry_.push_back({r.component, std::vector<double>(width)});
  return static_cast<int>(telemetry_.size()) - 1;
}

void ChannelReader::choose(const std::string& pattern, const Counts& counts, const std::vector<Reported>& components,
                           const std::string& where) {
  bool found = false;
  for (const Known& k : known) {
    if (!meant(pattern, k.name) || width_of(k.size, counts) == 0) continue;
    found = true;
    needs_previous_ = needs_previous_ || k.previous;
    add(info_of(k.name, k, counts),
        of_pair(k) ? Source{.fill_pair = std::get<1>(k.fill)} : Source{.fill = std::get<0>(k.fill)});
  }
  for (std::size_t i = 0; i < shadows_.size(); ++i) {
    for (const Known& k : known) {
      const std::string name = shadows_[i].role + "." + k.name;
      if (!of_pair(k) || !meant(pattern, name)) continue;
      found = needs_shadows_ = true;
      add(info_of(name, k, counts), {.fill_pair = std::get<1>(k.fill), .part = i + 1});
    }
  }
  for (const Reported& r : components) {
    std::size_t part = 0;
    for (const TelemetryEntry& e : entries_of(r)) {
      const std::string name = r.role + "." + e.name;
      if (meant(pattern, name)) {
        found = true;
        needs_shadows_ = needs_shadows_ || r.role.starts_with("shadow");
        add(info_of(name, e), {.component = telemetry_of(r), .part = part});
      }
      part += static_cast<std::size_t>(e.width);
    }
  }
  if (found) return;
  std::vector<std::string> all;
  for (const ChannelInfo& c : offered(counts, components, shadows_)) all.push_back(c.name);
  const std::string near = nearest(pattern, all);
  throw std::invalid_argument(where + ": no channel '" + pattern + "'" +
                              (near.empty() ? "" : ", did you mean '" + near + "'?"));
}

void ChannelReader::read(const Moment& now) {
  for (Telemetry& t : telemetry_) t.component->values(t.row.data());
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Source& s = sources_[i];
    double* out = row_.data() + s.offset;
    if (s.fill != nullptr) {
      s.fill(now, out);
    } else if (s.fill_pair != nullptr) {
      s.fill_pair(s.part == 0 ? now.pair : shadows_[s.part - 1].pair, out);
    } else {
      std::copy_n(telemetry_[static_cast<std::size_t>(s.component)].row.data() + s.part, channels_[i].size, out);
    }
  }
}

}  // namespace gyrostat::host
