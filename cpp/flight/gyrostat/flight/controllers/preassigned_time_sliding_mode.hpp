// SPDX-License-Identifier: MIT
/// @file  Sliding mode in Euler angles whose error follows a quintic that is zero from a preassigned time T on.
///
///   z = chi_a - chi_r,   s = c (z - p) + (z' - p')
///   chi_a'' asked for = p'' + chi_r'' - c (z' - p') - b s - eta sat(s / layer)
///
/// p starts with the error's own value and rate, so that s = 0 from the first sample on: there is no reaching phase and
/// no singularity. The known dynamics and the observer's d_B are taken away.
///
/// Source: Cao, Gong, Xue, Wen 2023, eq. (17)-(18), with a boundary layer; on a body chi_a'' is turned into a torque by
/// tau = J (E chi_a'' + E' chi_a') + w x (J w + D h_w) - d_B. Page: docs/components/preassigned_time_sliding_mode.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/controllers/parts/preassigned_path.hpp"
#include "gyrostat/flight/parts/euler_model.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// A body's angles are taken from its quaternion and rate. Near pitch +-90 deg they do not exist: Flag::singular.
template <class S>
class PreassignedTimeSlidingMode {
 public:
  using Scalar = S;
  static constexpr const char* name = "preassigned_time_sliding_mode";
  static constexpr bool switching = true;  ///< plans anew when it saturates
  static constexpr bool regulates = true;

  enum class StartAcceleration : std::uint8_t { smooth, zero };

  struct Params {
    S T;
    S c;
    S b;
    S eta;
    S layer;
    StartAcceleration start_acceleration = StartAcceleration::smooth;
    S stretch = S(10);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.T, Field{"T", "s", 1e-6, 1e9, "preassigned time: the error is zero from there on"});
      field(p.c, Field{"c", "1/s", 1e-9, 1e9, "slope of the sliding surface"});
      field(p.b, Field{"b", "1/s", 0, 1e9, "linear gain of s"});
      field(p.eta, Field{"eta", "rad/s^2", 0, 1e9, "switching gain"});
      field(p.layer, Field{"layer", "rad/s", 0, 1e9, "boundary layer of s; 0: sign(s)"});
      field(p.start_acceleration,
            Choice{"start_acceleration", "smooth|zero",
                   "p''(0): that of the motion without torque, so that the first demand is zero, or 0"});
      field(p.stretch,
            Field{"stretch", "s/s", 0, 1e6,
                  "time that T moves away while the command falls 1 % short of the demand, per time; 0: T is kept"});
    }

    /// With a = usable acceleration: T is that of a turn by 45 deg whose quintic peaks at a / 2; the surface and the
    /// correction have five times the default natural frequency, with a / 4 at the edge of the layer.
    explicit Params(const Setup<S>& setup) noexcept {
      const S a = usable_acceleration(setup.vehicle);
      const S rate = std::min(fastest_law(setup), S(5) * default_stiffness(setup).frequency);
      T = std::max(std::sqrt(S(5.7735) * S(0.7854) / (S(0.5) * a)), S(50) * setup.dt);
      c = rate;
      b = rate;
      eta = S(0.25) * a;
      layer = eta / rate;
    }
  };

  static constexpr Estimates uses(const Params&) noexcept { return {.d_B = true}; }

  /// The command is held: s' = -(b + eta / layer) s and (z - p)' = -c (z - p) must be stable when sampled.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S slope = p.b + (p.layer > S(0) ? p.eta / p.layer : S(0));
    return fits_euler_model(setup) && Status<S>::require(p.T > S(2) * setup.dt, "T", p.T, S(2) * setup.dt, ">") &&
           Status<S>::require(slope * setup.dt < S(2), "(b + eta / layer) * dt", slope * setup.dt, S(2), "<",
                              unstable) &&
           Status<S>::require(p.c * setup.dt < S(2), "c * dt", p.c * setup.dt, S(2), "<", unstable);
  }

  PreassignedTimeSlidingMode(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt), params_(params), torque_(usable_torque(setup.vehicle)) {}

  /// First sample: the path starts where the error is.
  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& given) noexcept {
    const Reference<S> ref = in_angles(vehicle, given);
    const Error now = error(vehicle, x, ref);
    plan(now, free_acceleration(vehicle, now, x, ref), params_.T);
    event_ = event(x, ref);
    tumbling_ = false;
    return demand(vehicle, now, x, ref);
  }

  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& given, const Allocation<S>& last) noexcept {
    ++ticks_;
    const Reference<S> ref = in_angles(vehicle, given);
    const Error now = error(vehicle, x, ref);
    if (tumbles(vehicle, now, x, last)) {
      event_ = ~event(x, ref);  // plan when it is over
      return damping(vehicle, now, x);
    }
    if (event(x, ref) != event_) {  // a new target, or the state is elsewhere: all of T again
      event_ = event(x, ref);
      plan(now, free_acceleration(vehicle, now, x, ref), params_.T);
    } else if (params_.stretch > S(0) && falls_short(last)) {  // after T too: a fault may come at any time
      plan(now, achieved_acceleration(vehicle, now, x, ref, last), left() + params_.stretch * dt_);
    }
    return demand(vehicle, now, x, ref);
  }

  void telemetry(auto&& log) const {
    log("s", s_);
    log("p", point_.p);
    log("T_left", left());
  }

 private:
  /// The error and the chart it is written in.
  struct Error {
    EulerState<S> chi;
    Vec3<S> z, zd;
    bool singular = false;
  };

  /// Changes where a new path is wanted. A kept T is kept whatever happens to the state.
  std::uint32_t event(const Estimate<S>& x, const Reference<S>& ref) const noexcept {
    return params_.stretch > S(0) ? ref.event + x.event : ref.event;
  }

  /// An actuator at its limit is no reason as long as the others make up for it, nor is rounding about zero.
  bool falls_short(const Allocation<S>& last) const noexcept {
    return (last.achieved_B - last.demand_B).norm() > S(0.01) * last.demand_B.norm() + S(1e-3) * torque_;
  }

  /// Once the command falls short, or is beyond sense where it has no limit: stopping takes more than a radian, or the gyroscopic
  /// torque is beyond the actuators. Until both are down to a tenth.
  bool tumbles(const Vehicle<S>& vehicle, const Error& now, const Estimate<S>& x, const Allocation<S>& last) noexcept {
    if (!on_body(vehicle) || !(params_.stretch > S(0))) return false;
    const S stopping = x.omega_BN_B.squaredNorm() * largest_inertia(vehicle.J_B) / (S(2) * torque_);
    const S excess = std::max(stopping, known(vehicle, now, x).norm() / torque_);
    const bool lost = falls_short(last) || last.demand_B.norm() > S(100) * torque_;
    tumbling_ = tumbling_ ? excess > S(0.1) : excess > S(1) && lost;
    return tumbling_;
  }

  /// No path in these angles is fit for a tumble. Torque against the rate takes energy out even where it saturates.
  Demand<S> damping(const Vehicle<S>& vehicle, const Error& now, const Estimate<S>& x) const noexcept {
    Demand<S> out;
    out.tau_B = -params_.c * (vehicle.J_B * x.omega_BN_B);
    if (now.singular) out.status.set(Flag::singular);
    return out;
  }

  static bool on_body(const Vehicle<S>& vehicle) noexcept { return vehicle.coordinates == Coordinates::body; }
  /// On a body the reference is its quaternion and rates alone; what stands in its Euler side is not read.
  static Reference<S> in_angles(const Vehicle<S>& vehicle, const Reference<S>& ref) noexcept {
    return on_body(vehicle) ? with_euler(ref) : ref;
  }
  S elapsed() const noexcept { return static_cast<S>(ticks_) * dt_; }
  S left() const noexcept { return std::max(path_.end() - elapsed(), S(0)); }

  Error error(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) const noexcept {
    Error now;
    if (on_body(vehicle)) {
      now.chi.angles = euler(x.q_NB);
      const S margin = std::cos(now.chi.angles[1]);
      now.chi.rates = margin > S(0) ? euler_rates(now.chi.angles, x.omega_BN_B) : Vec3<S>(Vec3<S>::Zero());
      // The pole may lie inside the coming period, or so near that the rates of roll and yaw have no digits.
      now.singular = !(margin > std::max(std::abs(now.chi.rates[1]) * dt_, S(1e-4)));
    } else {
      now.chi = {x.euler.angles, x.omega_BN_B};
    }
    now.z = now.chi.angles - ref.euler.angles;
    if (on_body(vehicle)) {
      for (int i = 0; i < 3; ++i) now.z[i] = wrapped(now.z[i]);
    }
    now.zd = now.chi.rates - ref.euler.rates;
    return now;
  }

  /// N m that a second derivative of the angles needs beyond the known torque.
  Vec3<S> torque_for(const Vehicle<S>& vehicle, const Error& now, const Vec3<S>& acceleration) const noexcept {
    if (!on_body(vehicle)) return vehicle.J_B.diagonal().cwiseProduct(acceleration);
    return vehicle.J_B * (euler_rate_matrix(now.chi.angles) * acceleration +
                          euler_rate_matrix_rate(now.chi.angles, now.chi.rates) * now.chi.rates);
  }

  /// Second derivative of the angles under a torque, the inverse of `torque_for`.
  Vec3<S> acceleration_under(const Vehicle<S>& vehicle, const Error& now, const Vec3<S>& tau_B) const noexcept {
    if (!on_body(vehicle)) return tau_B.cwiseQuotient(vehicle.J_B.diagonal());
    const Vec3<S> turning = euler_rate_matrix_rate(now.chi.angles, now.chi.rates) * now.chi.rates;
    return euler_rates<S>(now.chi.angles, vehicle.J_B.inverse() * tau_B - turning);
  }

  Vec3<S> known(const Vehicle<S>& vehicle, const Error& now, const Estimate<S>& x) const noexcept {
    return known_torque<S>(vehicle, now.chi.angles, x.omega_BN_B, x.axes.momentum_B(vehicle.D_B, x.h_w));
  }

  Vec3<S> free_acceleration(const Vehicle<S>& vehicle, const Error& now, const Estimate<S>& x,
                            const Reference<S>& ref) const noexcept {
    if (params_.start_acceleration == StartAcceleration::zero || now.singular) return Vec3<S>::Zero();
    return acceleration_under(vehicle, now, known(vehicle, now, x)) - ref.euler_accelerations;
  }

  Vec3<S> achieved_acceleration(const Vehicle<S>& vehicle, const Error& now, const Estimate<S>& x,
                                const Reference<S>& ref, const Allocation<S>& last) const noexcept {
    if (now.singular) return Vec3<S>::Zero();
    return acceleration_under(vehicle, now, known(vehicle, now, x) + last.achieved_B + x.d_B) - ref.euler_accelerations;
  }

  void plan(const Error& now, const Vec3<S>& acceleration, S T) noexcept {
    path_ = PreassignedPath<S>({now.z, now.zd, acceleration}, T);
    ticks_ = 0;
  }

  Demand<S> demand(const Vehicle<S>& vehicle, const Error& now, const Estimate<S>& x,
                   const Reference<S>& ref) noexcept {
    point_ = path_.at(elapsed());
    const Vec3<S> rate_error = now.zd - point_.rate;
    s_ = params_.c * (now.z - point_.p) + rate_error;
    const Vec3<S> acceleration = point_.acceleration + ref.euler_accelerations - params_.c * rate_error -
                                 params_.b * s_ - params_.eta * layer(s_, params_.layer);
    Demand<S> out;
    out.tau_B = torque_for(vehicle, now, acceleration) - known(vehicle, now, x) - x.d_B;
    if (now.singular) out.status.set(Flag::singular);
    return out;
  }

  S dt_;
  Params params_;
  S torque_;  ///< N m, usable
  bool tumbling_ = false;
  PreassignedPath<S> path_;
  PathPoint<S> point_;
  Vec3<S> s_ = Vec3<S>::Zero();  ///< rad/s
  std::uint32_t event_ = 0;
  Tick ticks_ = 0;  ///< since the path began
};

}  // namespace gyrostat
