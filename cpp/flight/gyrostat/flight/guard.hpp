// SPDX-License-Identifier: MIT
/// @file  What cannot be on this vehicle at this period, and what to fly on where nothing was measured.
///
/// A signal is impossible when it has not one number an actuator, when a number in it is not finite, or when it is beyond any
/// motion that samples could follow. The scales, with J the largest inertia and T the torque of all actuators together, at
/// least 0.04 J rad/s^2, an actuator without limit counting as what defaults count on (stiffness.hpp):
///
///   quaternion    a tenth off unit length
///   rate          100 rad a sample
///   reference     1 rad a sample; 1000 T / J, but at least 0.2 rad/s a sample
///   momentum      1000 J rad a sample
///   field         1 mT
///   demand        1e6 J rad a sample^2
///   d_B           1000 T;                    without limits, 1e6 J rad a sample^2
///   command       no less than the limits;   without limits, 1000 J rad a sample^2
///
/// A command beyond its scale is issued, for who sets no limit has none, but it is not issued again and nothing is learned from it.
/// No motion leads from one sample to the next when the rate changes by more than 100 T dt / J (at least 0.02 rad/s) beyond
/// twice what the command and the rate explain, wheel momentum likewise, or the attitude by more than 0.2 rad beyond the rate.
/// All this parts garbage from flight, no more: a wrong number inside is flown. Page: docs/flight_software.md
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gyrostat/flight/parts/euler_model.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// What the guard did at one sample.
struct GuardActions {
  bool attitude = false, rate = false, momentum = false, reference = false;  ///< input replaced
  bool navigator = false, observer = false, detector = false, controller = false,
       allocator = false;  ///< component started again
  bool command = false;    ///< the previous one issued once more

  constexpr bool measurement() const noexcept { return attitude || rate || momentum; }
};

/// What of a measurement tells a jump.
template <class S>
struct Motion {
  Quat<S> q_NB = Quat<S>::Identity();
  Vec3<S> omega_BN_B = Vec3<S>::Zero();  ///< rad/s
  VecN<S> h_w;                           ///< N m s
};

template <class S>
class Guard {
 public:
  explicit Guard(const Setup<S>& setup) noexcept : vehicle_(setup.vehicle), dt_(setup.dt) {
    const S J = largest_inertia(vehicle_.J_B), unit = J / (dt_ * dt_);
    least_ = smallest_inertia(vehicle_.J_B);
    bool unlimited = false;
    S all = S(0);
    command_ = S(0);
    for (int i = 0; i < vehicle_.actuators(); ++i) {
      const S lever = vehicle_.D_B.col(i).norm();
      const S limit = std::max(std::abs(vehicle_.u_lo[i]), std::abs(vehicle_.u_up[i]));
      const bool limited = lever * limit <= S(1000) * unit;  // not where there is neither
      all += limited ? lever * limit : std::min(usable_torque(vehicle_), unit);
      command_ = std::max(command_, limited ? limit : S(1000) * unit / (lever > S(0) ? lever : S(1)));
      unlimited = unlimited || !limited;
    }
    torque_ = std::max(all, S(0.04) * J);
    acceleration_ = std::max(S(100) * torque_ / J, S(0.02) / dt_);
    rate_ = S(100) / dt_;
    momentum_ = S(1000) * J / dt_;
    demand_ = S(1e6) * unit;
    d_B_ = unlimited ? demand_ : S(1000) * torque_;
  }

  const Vehicle<S>& vehicle() const noexcept { return vehicle_; }

  bool attitude_possible(const Measurement<S>& y) const noexcept {
    return unit(y.q_NB) && (on_body() || within<Vec3<S>>(y.euler.angles, S(1e6)));
  }
  /// Whether what it calls measured could be.
  bool possible(const Measurement<S>& y) const noexcept {
    return (!y.attitude_valid || attitude_possible(y)) && (!y.rate_valid || rate_possible(y.omega_BN_B)) &&
           (!y.momentum_valid || momentum_possible(y.h_w)) && within(y.rate_step, rate_);
  }
  bool rate_possible(const Vec3<S>& omega) const noexcept { return within(omega, rate_); }
  bool momentum_possible(const VecN<S>& h_w) const noexcept { return one_each(h_w) && within(h_w, momentum_); }

  bool field_possible(const Vec3<S>& field_B) const noexcept { return within(field_B, S(1e-3)); }
  bool sun_possible(const Vec3<S>& sun_B) const noexcept { return within(sun_B, S(1.1)); }

  bool possible(const Reference<S>& r) const noexcept {
    const bool body =
        unit(r.q_NR) && within(r.omega_RN_R, S(0.01) * rate_) && within(r.omegadot_RN_R, S(10) * acceleration_);
    return body && (on_body() || (within(r.euler.angles, S(1e6)) && within(r.euler.rates, S(0.01) * rate_) &&
                                  within(r.euler_accelerations, S(10) * acceleration_)));
  }
  /// An infinite effectiveness_bound means "never excited" and is possible; NaN is not.
  bool possible(const Estimate<S>& x) const noexcept {
    return unit(x.q_NB) && rate_possible(x.omega_BN_B) && momentum_possible(x.h_w) && one_each(x.effectiveness) &&
           within(x.effectiveness, S(1000)) && one_each(x.effectiveness_bound) &&
           (x.effectiveness_bound.array() >= S(0)).all() && within(x.d_B, d_B_) &&
           (on_body() || within(x.euler.angles, S(1e6)));
  }
  bool possible(const Detection<S>& det) const noexcept {
    return none_or_one_each(det.u_probe) && none_or_one_each(det.gain) && none_or_one_each(det.bias);
  }
  bool possible(const Demand<S>& demand) const noexcept {
    return within(demand.tau_B, demand_) && none_or_one_each(demand.u_pref);
  }
  bool possible(const Allocation<S>& a) const noexcept {
    return one_each(a.u) && a.u.allFinite() && a.achieved_B.allFinite();
  }

  /// Whether an issued command may be issued again, and learned from.
  bool sane(const VecN<S>& u) const noexcept { return within(u, command_); }

  /// Whether no motion leads from one sample to the next: one of the two is wrong.
  /// @param axes  at `from`
  /// @param u  what was issued in between
  bool jumps(const Motion<S>& from, const Axes<S>& axes, const Measurement<S>& to, const VecN<S>& u) const noexcept {
    return rates_jump(from, axes, to, u) || attitude_jumps(from, to);
  }

  /// Of rate and wheel momentum: the interval teaches nothing.
  bool rates_jump(const Motion<S>& from, const Axes<S>& axes, const Measurement<S>& to,
                  const VecN<S>& u) const noexcept {
    const Vec3<S> rate = to.omega_BN_B - from.omega_BN_B - to.rate_step;
    const VecN<S> momentum = to.h_w - from.h_w;
    if (within(rate, dt_ * acceleration_) && within(momentum, dt_ * S(100) * torque_)) return false;  // as a rule
    S pushed = S(0);
    for (int i = 0; i < vehicle_.actuators(); ++i)
      pushed += S(2) * axes.of(vehicle_.D_B).col(i).norm() * std::abs(u[i]);
    const S turned = std::min(from.omega_BN_B.squaredNorm(), to.omega_BN_B.squaredNorm());
    const S most = u.template lpNorm<Eigen::Infinity>();
    return !within(rate, dt_ * (acceleration_ + pushed / least_ + S(2) * turned)) ||
           !within(momentum, dt_ * (S(100) * torque_ + S(2) * most));
  }

  bool attitude_jumps(const Motion<S>& from, const Measurement<S>& to) const noexcept {
    const S cosine = to.q_NB.dot(from.q_NB);
    const S squared_sine = S(1) - cosine * cosine / (to.q_NB.squaredNorm() * from.q_NB.squaredNorm());
    if (squared_sine <= S(0.01)) return false;  // 0.2 rad
    const S half = S(0.1) + dt_ * std::min(from.omega_BN_B.norm(), to.omega_BN_B.norm());
    return half < S(1.5) && squared_sine > std::sin(half) * std::sin(half);
  }

  /// Puts into `y` what it has not measured: the sample before carried on over one interval by the model of all components.
  /// @param x  what was known then
  /// @param u  what was issued then
  void carry_on(const Measurement<S>& before, const Estimate<S>& x, const VecN<S>& u,
                Measurement<S>& y) const noexcept {
    const VecN<S> delivered = x.effectiveness.cwiseProduct(u);
    if (!y.momentum_valid) {
      y.h_w = before.h_w;
      for (int i = 0; i < vehicle_.actuators(); ++i)
        if (vehicle_.wheels.test(i)) y.h_w[i] -= dt_ * delivered[i];
      if (!momentum_possible(y.h_w)) y.h_w = before.h_w;
    }
    if (!y.rate_valid)
      y.omega_BN_B = next_rate(before, torque<S>(before.axes.of(vehicle_.D_B), delivered) + known(x.d_B));
    if (!y.attitude_valid) {
      const Vec3<S> turn = dt_ / S(2) * (before.omega_BN_B + y.omega_BN_B);
      y.q_NB = on_body() ? (before.q_NB * quat_exp(turn)).normalized() : quat_from_euler<S>(before.euler.angles + turn);
      if (!on_body()) y.euler.angles = before.euler.angles + turn;
    }
    if (!on_body()) y.euler.rates = y.omega_BN_B;
  }

 private:
  bool on_body() const noexcept { return vehicle_.coordinates == Coordinates::body; }
  bool one_each(const VecN<S>& v) const noexcept { return v.size() == vehicle_.actuators(); }
  bool none_or_one_each(const VecN<S>& v) const noexcept { return (v.size() == 0 || one_each(v)) && v.allFinite(); }

  /// False for NaN.
  template <class V>
  static bool within(const V& v, S limit) noexcept {
    return (v.array().abs() <= limit).all();
  }
  static bool unit(const Quat<S>& q) noexcept {
    const S square = q.coeffs().squaredNorm();
    return square >= S(0.81) && square <= S(1.21);
  }

  /// A torque that actuators could make good for is believed.
  Vec3<S> known(const Vec3<S>& d_B) const noexcept { return d_B.cwiseMax(-torque_).cwiseMin(torque_); }

  /// By the midpoint rule under a held torque; held where the model leads nowhere.
  Vec3<S> next_rate(const Measurement<S>& before, const Vec3<S>& torque_B) const noexcept {
    const Mat3<S> J_inv = vehicle_.J_B.inverse();
    const Vec3<S> h_B = before.axes.momentum_B(vehicle_.D_B, before.h_w);
    const auto rate = [&](const Vec3<S>& omega) -> Vec3<S> {
      return J_inv * (torque_B + known_torque<S>(vehicle_, before.euler.angles, omega, h_B));
    };
    const Vec3<S> middle = before.omega_BN_B + dt_ / S(2) * rate(before.omega_BN_B);
    const Vec3<S> next = before.omega_BN_B + dt_ * rate(middle);
    return rate_possible(next) ? next : before.omega_BN_B;
  }

  Vehicle<S> vehicle_;
  S dt_;
  S least_;         ///< kg m^2, smallest inertia
  S torque_;        ///< N m, T
  S acceleration_;  ///< rad/s^2
  S rate_;          ///< rad/s
  S momentum_;      ///< N m s
  S demand_, d_B_;  ///< N m
  S command_;       ///< N m
};

}  // namespace gyrostat
