// SPDX-License-Identifier: MIT
/// @file  A control law of a user: proportional to the vector part of the error quaternion, and to the rate.
#pragma once
#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/params.hpp"

namespace consumer {

template <class S>
class QuaternionLaw {
 public:
  using Scalar = S;
  static constexpr const char* name = "consumer_quaternion";
  static constexpr bool regulates = true;

  struct Params {
    S k_q, k_omega;

    /// A natural frequency of 0.19 rad/s about the axis of largest inertia, critically damped.
    explicit Params(const gyrostat::Setup<S>& setup) noexcept {
      const S J = setup.vehicle.J_B.diagonal().maxCoeff();
      k_q = S(0.075) * J;
      k_omega = S(0.4) * J;
    }

    static constexpr void describe(auto& p, auto&& field) {
      field(p.k_q, gyrostat::Field{"k_q", "N m", 0, 1e3, "torque per half-angle error"});
      field(p.k_omega, gyrostat::Field{"k_omega", "N m s", 0, 1e3, "torque per rate"});
    }
  };

  /// The sampled damping must be stable.
  static gyrostat::Status<S> check(const gyrostat::Setup<S>& setup, const Params& p) noexcept {
    const S J = setup.vehicle.J_B.diagonal().minCoeff();
    return gyrostat::Status<S>::require(p.k_omega * setup.dt < J, "k_omega * dt", p.k_omega * setup.dt, J);
  }

  QuaternionLaw(gyrostat::Unchecked, const gyrostat::Setup<S>&, const Params& params) noexcept : params_(params) {}

  [[nodiscard]] gyrostat::Demand<S> start(const gyrostat::Vehicle<S>&, const gyrostat::Estimate<S>& x,
                                          const gyrostat::Detection<S>&, const gyrostat::Reference<S>& ref) noexcept {
    return demand(x, ref);
  }
  [[nodiscard]] gyrostat::Demand<S> step(const gyrostat::Vehicle<S>&, const gyrostat::Estimate<S>& x,
                                         const gyrostat::Detection<S>&, const gyrostat::Reference<S>& ref,
                                         const gyrostat::Allocation<S>&) noexcept {
    return demand(x, ref);
  }
  void telemetry(auto&&) const {}

 private:
  gyrostat::Demand<S> demand(const gyrostat::Estimate<S>& x, const gyrostat::Reference<S>& ref) const noexcept {
    const gyrostat::Quat<S> q_RB = ref.q_NR.conjugate() * x.q_NB;
    const S short_way = q_RB.w() < S(0) ? S(-1) : S(1);
    gyrostat::Demand<S> out;
    out.tau_B = -params_.k_q * short_way * q_RB.vec() - params_.k_omega * x.omega_BN_B;
    return out;
  }

  Params params_;
};

}  // namespace consumer
