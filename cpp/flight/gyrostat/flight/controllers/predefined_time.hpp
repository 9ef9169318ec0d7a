// SPDX-License-Identifier: MIT
/// @file  Predefined-time sliding mode in modified Rodrigues parameters.
///
///   psi(V, h, T) = exp(V^h) V^-h / (2 h T)         V1 = z1'z1 / 2,  z1 = sigma_BR, z2 = sigma_BR'
///   s   = z2 + xi,  xi = psi(V1, h1, T1) z1        V2 = s's / 2
///   tau = feedforward + e x (J w + D h_w) - k_s sat(s / phi) - J G^-1 ( G' e + xi' + psi(V2, h2, T2) s ) - d_B
///
/// V' = -2 V psi(V, h, T) ends at T (1 - exp(-V0^h)) < T: z1 = 0 before T1 + T2 with unlimited torque. V1 and V2 are floored inside
/// psi: for h1 > 1/4 xi' is unbounded at z1 = 0 (at h1 = 1/2 xi jumps there), and a floor makes xi linear in a small ball.
/// Source: Cao, Gong, Han 2022, eq. (25)-(26). Page: docs/components/predefined_time.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/flight/controllers/parts/mrp_surface.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// exp(V^h) V^-h / (2 h T), V no smaller than its floor.
template <class S>
S predefined_time_gain(S V, S h, S T, S floor) noexcept {
  const S power = std::pow(std::max(V, floor), h);
  return std::exp(power) / (power * S(2) * h * T);
}

/// The V at which that gain is `rate`; 2 h T rate > e.
template <class S>
S floor_of_rate(S rate, S h, S T) noexcept {
  const S least = S(1) / (S(2) * h * T * rate);
  S power = least;
  for (int i = 0; i < 40; ++i)
    power = least * std::exp(power);  // contracts by the power itself, below 0.26 for T = 200 dt
  return std::pow(power, S(1) / h);
}

template <class S>
class PredefinedTime {
 public:
  using Scalar = S;
  static constexpr const char* name = "predefined_time";
  static constexpr bool switching = true;
  static constexpr bool regulates = true;

  struct Params : MrpSurfaceParams<S> {
    S h1 = S(0.25);
    S T1;
    S h2 = S(0.25);
    S T2;
    S floor1;
    S floor2;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.h1, Field{"h1", "", 1e-3, 0.999, "power of V1 on the surface; above 1/4 the law needs floor1"});
      field(p.T1, Field{"T1", "s", 1e-6, 1e9, "longest time on the surface"});
      field(p.h2, Field{"h2", "", 1e-3, 0.999, "power of V2 towards the surface"});
      field(p.T2, Field{"T2", "s", 1e-6, 1e9, "longest time to the surface"});
      field(p.floor1, Field{"floor1", "", 1e-30, 1, "V1 counts as no smaller; the default is |sigma| = 0.03, 7 deg"});
      field(p.floor2, Field{"floor2", "1/s^2", 1e-30, 1, "V2 counts as no smaller"});
      MrpSurfaceParams<S>::describe(p, field);
    }

    /// In proportion to sqrt(J / usable torque): with the published 10 s twice, the vehicle of the publication turns 90 deg with
    /// 1.4 rad/s^2 at the peak; here a peak of twice the acceleration at hand, the rest is saturation. Of the promised T1 + T2 a
    /// third is for the surface, where the error decays: that settles a quarter sooner than halves (docs/verification.md). The
    /// linear rates inside the floors stay below `fastest_law`: sampled slowly the floors are wide, and the law is the linear one
    /// that they hold.
    explicit Params(const Setup<S>& setup) noexcept : MrpSurfaceParams<S>(setup) {
      const S promised = S(20) * std::sqrt(S(0.7) / usable_acceleration(setup.vehicle));
      T1 = std::max(promised / S(3), S(200) * setup.dt);
      T2 = std::max(S(2) * promised / S(3), S(200) * setup.dt);
      floor1 = std::max(S(0.5) * S(0.03) * S(0.03), floor_of_rate(fastest_law(setup), h1, T1));
      floor2 = std::max(S(0.5) * this->phi * this->phi, floor_of_rate(fastest_law(setup), h2, T2));
    }
  };

  static constexpr Estimates uses(const Params&) noexcept { return {.d_B = true}; }

  /// Sampled slopes: of xi inside its floor, of the way to the surface at |s| = 1e-3 /s (nearer to zero what is left is a limit
  /// cycle below any sensor), and of the layer.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S surface = predefined_time_gain(S(0), p.h1, p.T1, p.floor1) * setup.dt;
    const S reach = predefined_time_gain(S(5e-7), p.h2, p.T2, p.floor2) * setup.dt;
    const S slope = p.slope(setup) * setup.dt;
    return needs_body_coordinates(setup) &&
           Status<S>::require(surface < S(1), "psi(floor1) * dt", surface, S(1), "<", unstable) &&
           Status<S>::require(reach + slope < S(2), "psi(|s| = 1e-3) * dt + k_s / (4 J phi) * dt", reach + slope, S(2),
                              "<", unstable);
  }

  PredefinedTime(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params), surface_(setup, params) {}

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    surface_.start();
    return demand(vehicle, x, ref);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const {
    log("s", s_);
    log("xi", xi_);
  }

 private:
  /// xi' by the chain rule: d/dt [exp(V^h) V^-h] = h V' / V (V^h - 1) exp(V^h) V^-h, and nothing inside the floor.
  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const MrpMotion<S> m = surface_.motion(vehicle, x, ref);
    const S V1 = S(0.5) * m.z1.squaredNorm();
    const S gain = predefined_time_gain(V1, params_.h1, params_.T1, params_.floor1);
    xi_ = gain * m.z1;
    s_ = m.z2 + xi_;
    Vec3<S> xi_rate = gain * m.z2;
    if (V1 > params_.floor1)
      xi_rate += (params_.h1 * (m.z1.dot(m.z2) / V1) * (std::pow(V1, params_.h1) - S(1)) * gain) * m.z1;
    const S V2 = S(0.5) * s_.squaredNorm();
    const S reach = predefined_time_gain(V2, params_.h2, params_.T2, params_.floor2);
    Demand<S> out;
    out.tau_B = surface_.torque_B(vehicle, m, s_, xi_rate + reach * s_, x.d_B);
    return out;
  }

  Params params_;
  MrpSurface<S> surface_;
  Vec3<S> s_ = Vec3<S>::Zero();   ///< 1/s
  Vec3<S> xi_ = Vec3<S>::Zero();  ///< 1/s
};

}  // namespace gyrostat
