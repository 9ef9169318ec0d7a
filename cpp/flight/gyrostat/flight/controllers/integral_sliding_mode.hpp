// SPDX-License-Identifier: MIT
/// @file  Integral sliding mode around the homogeneous law, with an adaptive switching gain.
///
///   s = P { w - w(0) - integral J^-1 ( -w x (J w + D h_w) + u_nm ) }          P = J or I
///   tau_B = u_nm - d_B - rho .* sat(s / eps) - K3 s - K4 sig^gamma(s)
///   rho' = zeta1 |s|^kappa sgn(|s| - eps) where rho > mu, zeta2 |s| elsewhere
///   kappa = 1/2 + 1/2 sat((4 |s| - 3 eps) / eps)
///
/// Source: Li, Hu, Yang, Postolache 2018, eq. (23)-(29), with a boundary layer and an anti-windup clamp.
/// Page: docs/components/integral_sliding_mode.md
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "gyrostat/flight/controllers/parts/nominal_law.hpp"
#include "gyrostat/flight/parts/chart.hpp"

namespace gyrostat {

/// s(0) = 0: no reaching phase as long as the limiter is idle. A moving reference enters through u_nm.
template <class S>
class IntegralSlidingMode {
 public:
  using Scalar = S;
  static constexpr const char* name = "integral_sliding_mode";
  static constexpr bool switching = true;
  static constexpr bool regulates = true;

  enum class Surface : std::uint8_t { inertia, identity };
  enum class Switching : std::uint8_t { layer, sign };

  struct Params {
    typename NominalLaw<S>::Params nominal;
    Vec3<S> K3;
    Vec3<S> K4;
    S gamma = S(0.88);
    S zeta1;
    S zeta2;
    S mu;
    Vec3<S> gain_0;
    S eps;
    S s_lim;
    Surface surface = Surface::inertia;
    Switching switching = Switching::layer;

    /// Of the layer that is flown.
    constexpr S width() const noexcept { return switching == Switching::sign ? S(0) : eps; }

    static constexpr void describe(auto& p, auto&& field) {
      constexpr double infinite = std::numeric_limits<double>::infinity();
      NominalLaw<S>::Params::describe(p.nominal, field);
      field(p.K3, Field{"K3", "1/s (surface inertia)", 0, 1e9, "linear gain of s"});
      field(p.K4, Field{"K4", "N m (N m s)^-gamma", 0, 1e9, "gain of sig^gamma(s)"});
      field(p.gamma, Field{"gamma", "", 0.01, 1, "power of s"});
      field(p.zeta1, Field{"zeta1", "N m/s (N m s)^-kappa", 0, 1e9, "rate of the switching gain above mu"});
      field(p.zeta2, Field{"zeta2", "1/s^2", 0, 1e9, "rate of the switching gain below mu"});
      field(p.mu, Field{"mu", "N m", 0, 1e9, "floor of the switching gain"});
      field(p.gain_0, Field{"gain_0", "N m", 0, 1e9, "switching gain at start"});
      field(p.eps, Field{"eps", "N m s (surface inertia)", 0, 1e9, "boundary layer, and where the gain turns round"});
      field(p.s_lim, Field{"s_lim", "N m s", 0, infinite,
                           "anti-windup: largest momentum error J P^-1 s; infinite: printed integral"});
      field(p.surface, Choice{"surface", "inertia|identity", "P of the sliding surface: J (s in N m s) or I (rad/s)"});
      field(p.switching, Choice{"switching", "layer|sign", "sat(s / eps), or sign(s) as printed"});
    }

    /// With a = usable torque and the rate r = min(0.05 / dt, 50 natural frequencies) of the linear part: all of a is spent at
    /// s_lim = a / r, a tenth of it is the layer, the floor of the switching gain is a twentieth of a. The gain moves by a tenth
    /// of a r at most: zeta1 |s|^kappa has no unit of its own, so it is held at kappa = 0 and at s_lim with kappa = 1.
    explicit Params(const Setup<S>& setup) noexcept : nominal(setup) {
      const S a = usable_torque(setup.vehicle);
      const S r = std::min(fastest_law(setup), S(50) * default_stiffness(setup).frequency);
      s_lim = a / r;
      eps = S(0.1) * s_lim;
      K3.setConstant(r);
      K4.setConstant(S(0.5) * r * std::pow(s_lim, S(1) - gamma));
      mu = S(0.05) * a;
      gain_0.setConstant(S(0.075) * a);
      zeta1 = S(0.1) * a * r / std::max(s_lim, S(1));
      zeta2 = S(0.1) * r * r;
    }
  };

  static constexpr Estimates uses(const Params&) noexcept { return {.d_B = true}; }

  /// The slope of the correction inside the layer must be stable when sampled. (K4 is left out: its slope has no bound at s = 0.)
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S J = smallest_inertia(setup.vehicle.J_B);
    const S per_momentum = p.surface == Surface::inertia ? S(1) : S(1) / J;
    const S slope = p.K3.maxCoeff() + (p.width() > S(0) ? p.mu / p.width() : S(0));
    return needs_body_coordinates(setup) && NominalLaw<S>::check(setup, p.nominal) &&
           Status<S>::require(slope * per_momentum * setup.dt < S(2), "(K3 + mu / eps) * dt",
                              slope * per_momentum * setup.dt, S(2), "<", Status<S>::Code::unstable);
  }

  IntegralSlidingMode(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt),
        params_(params),
        J_inv_(setup.vehicle.J_B.inverse()),
        nominal_(params.nominal),
        set_(params.nominal.shadow_switch),
        gain_(params.gain_0) {}

  /// First sample: no interval has passed, s = 0.
  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    set_.start();
    momentum_error_.setZero();
    s_.setZero();
    gain_ = params_.gain_0;
    event_ = x.event;
    remember(vehicle, x);
    return demand(vehicle, x, ref);
  }

  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    integrate(vehicle, x);
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const {
    log("s", s_);
    log("gain", gain_used_);
    log("u_nominal", u_nominal_);
  }

 private:
  /// J P^-1 s = J (w - w(0)) - integral of the nominal torque, one interval at a time: the gyroscopic torque by the
  /// trapezoid of its ends, the nominal torque by the rectangle, which is exact because it was held. Keeping its growth
  /// and not both terms saves the digits of s. The clamp moves the integral, so that saturation does not wind it up.
  void integrate(const Vehicle<S>& vehicle, const Estimate<S>& x) noexcept {
    const Vec3<S> omega = omega_, gyro_B = gyro_B_;
    remember(vehicle, x);
    if (x.event != event_) {  // a jump of the state is nothing that a torque has done
      event_ = x.event;
      return;
    }
    momentum_error_ += vehicle.J_B * (omega_ - omega) + dt_ * (S(0.5) * (gyro_B + gyro_B_) - u_nominal_);
    momentum_error_ = momentum_error_.cwiseMax(-params_.s_lim).cwiseMin(params_.s_lim);
    s_ = params_.surface == Surface::inertia ? momentum_error_ : Vec3<S>(J_inv_ * momentum_error_);
  }

  void remember(const Vehicle<S>& vehicle, const Estimate<S>& x) noexcept {
    omega_ = x.omega_BN_B;
    gyro_B_ = omega_.cross(vehicle.J_B * omega_ + x.axes.momentum_B(vehicle.D_B, x.h_w));
  }

  /// The gain moves after it has been used.
  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    u_nominal_ = nominal_(track(vehicle, x, ref, set_));
    gain_used_ = gain_;
    Demand<S> out;
    out.tau_B = u_nominal_ - x.d_B - gain_.cwiseProduct(layer(s_, params_.width())) - params_.K3.cwiseProduct(s_) -
                params_.K4.cwiseProduct(sig(s_, params_.gamma));
    for (int i = 0; i < 3; ++i) gain_[i] += dt_ * gain_rate(std::abs(s_[i]), gain_[i]);
    return out;
  }

  S gain_rate(S s, S gain) const noexcept {
    if (gain <= params_.mu) return params_.zeta2 * s;
    const S kappa = S(0.5) + S(0.5) * layer(S(4) * s - S(3) * params_.eps, params_.eps);
    return params_.zeta1 * power(s, kappa) * sgn(s - params_.eps);
  }

  /// s^kappa with 0^0 = 1; the ends of the range of kappa are the usual case.
  static S power(S s, S kappa) noexcept { return kappa == S(0) ? S(1) : (kappa == S(1) ? s : std::pow(s, kappa)); }

  S dt_;
  Params params_;
  Mat3<S> J_inv_;
  NominalLaw<S> nominal_;
  MrpSwitching<S> set_;
  Vec3<S> omega_ = Vec3<S>::Zero();           ///< rad/s, at the sample before
  Vec3<S> gyro_B_ = Vec3<S>::Zero();          ///< N m, w x (J w + D h_w) at the sample before
  Vec3<S> momentum_error_ = Vec3<S>::Zero();  ///< N m s, J P^-1 s
  Vec3<S> s_ = Vec3<S>::Zero();
  Vec3<S> u_nominal_ = Vec3<S>::Zero();  ///< N m, held since the sample before
  Vec3<S> gain_;                         ///< N m, for the next demand
  Vec3<S> gain_used_ = Vec3<S>::Zero();  ///< N m, in the last demand
  std::uint32_t event_ = 0;              ///< of the estimate before
};

}  // namespace gyrostat
