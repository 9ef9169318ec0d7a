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
    S k_q = S(1.5);
    S k_omega = S(8);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.k_q, gyrostat::Field{"k_q", "N m", 0, 1e3, "torque per half-angle error"});
      field(p.k_omega, gyrostat::Field{"k_omega", "N m s", 0, 1e3, "torque per rate"});
    }
  };

  static gyrostat::Status<S> check(const gyrostat::Setup<S>&, const Params&) noexcept { return {}; }

  QuaternionLaw(const gyrostat::Setup<S>&, const Params& params) noexcept : params_(params) {}

  [[nodiscard]] gyrostat::Demand<S> start(const gyrostat::Estimate<S>& x, const gyrostat::Detection<S>&,
                                          const gyrostat::Reference<S>& ref) noexcept {
    return demand(x, ref);
  }
  [[nodiscard]] gyrostat::Demand<S> step(const gyrostat::Estimate<S>& x, const gyrostat::Detection<S>&,
                                         const gyrostat::Reference<S>& ref, const gyrostat::Allocation<S>&) noexcept {
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
