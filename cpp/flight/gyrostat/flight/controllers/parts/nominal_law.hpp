// SPDX-License-Identifier: MIT
/// @file  The homogeneous attitude law that finite-time controllers share.
///
///   u_nm = -k1 G(sigma)' sig^beta1(sigma) - k2 sat_beta2(omega),   beta2 = 2 beta1 / (1 + beta1)
///   sat_b(x) = sig^b(x) where |x| <= 1, sgn(x) elsewhere
///
/// Source: Li, Hu, Yang, Postolache 2018, eq. (19)-(20), with the power of the rate that homogeneity asks for.
#pragma once
#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/controllers/parts/tracking.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// Settles a healthy vehicle in finite time; V = w'Jw/2 + k1/(1 + beta1) sum |sigma_i|^(1 + beta1) does not increase.
template <class S>
class NominalLaw {
 public:
  struct Params {
    S k1;
    S k2;
    S beta1 = S(0.9);
    S shadow_switch = S(1);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.k1, Field{"k1", "N m", 1e-9, 1e9, "gain of the attitude error"});
      field(p.k2, Field{"k2", "N m (rad/s)^-beta2", 1e-9, 1e9, "gain of the rate error"});
      field(p.beta1, Field{"beta1", "", 0.01, 1, "power of the attitude error"});
      field(p.shadow_switch, shadow_switch_field);
    }

    /// The torques of the default stiffness, at an error of 45 deg and at a rate of one natural frequency.
    explicit Params(const Setup<S>& setup) noexcept {
      const Stiffness<S> k = default_stiffness(setup);
      const S sigma = default_full_error<S>;
      k1 = k.k_sigma * sigma / (S(0.25) * (S(1) + sigma * sigma) * std::pow(sigma, beta1));
      k2 = k.k_omega * std::pow(k.frequency, S(1) - rate_power(beta1));
    }
  };

  /// The sampled damping must be stable at 1 rad/s about the smallest inertia. (Its slope grows without bound towards zero
  /// when beta1 < 1, but only so slowly that what is left is a limit cycle far below any sensor.)
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S J = smallest_inertia(setup.vehicle.J_B);
    return Status<S>::require(p.k2 * setup.dt < S(2) * J, "k2 * dt", p.k2 * setup.dt, S(2) * J, "<",
                              Status<S>::Code::unstable);
  }

  explicit NominalLaw(const Params& params) noexcept : params_(params), beta2_(rate_power(params.beta1)) {}

  /// N m. Includes the feed-forward of a moving reference.
  Vec3<S> operator()(const Tracking<S>& error) const noexcept {
    const Vec3<S> attitude = mrp_rate_matrix(error.sigma_BR).transpose() * sig(error.sigma_BR, params_.beta1);
    return error.feedforward_B - params_.k1 * attitude - params_.k2 * sat_sig(error.omega_BR_B, beta2_);
  }

 private:
  static S rate_power(S beta1) noexcept { return S(2) * beta1 / (S(1) + beta1); }

  Params params_;
  S beta2_;
};

}  // namespace gyrostat
