// SPDX-License-Identifier: MIT
/// @file  Nonsingular fast terminal sliding mode in modified Rodrigues parameters.
///
///   s   = z2 + a z1 + b f(z1),   f = sig^g outside |z| < eta, smooth inside;   z1 = sigma_BR, z2 = sigma_BR'
///   tau = feedforward + e x (J w + D h_w) - k_s sat(s / phi) - J G^-1 ( G' e + a z2 + b f' + k1 s + k2 sig^g2(s) ) - d_B
///
/// The standard form; it stands in for the law that Cao, Gong, Han 2022 compare with and give no equations of.
/// Page: docs/components/terminal_sliding_mode.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/flight/controllers/parts/mrp_surface.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

template <class S>
class TerminalSlidingMode {
 public:
  using Scalar = S;
  static constexpr const char* name = "terminal_sliding_mode";
  static constexpr bool switching = true;
  static constexpr bool regulates = true;

  struct Params : MrpSurfaceParams<S> {
    S a;
    S b;
    S g = S(0.6);
    S eta;
    S k1;
    S k2;
    S g2 = S(0.6);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.a, Field{"a", "1/s", 0, 1e6, "linear rate on the surface"});
      field(p.b, Field{"b", "1/s", 0, 1e6, "terminal rate on the surface, at |sigma| = 1"});
      field(p.g, Field{"g", "", 0.01, 1, "power of the terminal part"});
      field(p.eta, Field{"eta", "", 1e-9, 1, "MRP below which the power is replaced, so that its slope is finite"});
      field(p.k1, Field{"k1", "1/s", 0, 1e6, "linear rate towards the surface"});
      field(p.k2, Field{"k2", "s^(g2-2)", 0, 1e6, "gain of sig^g2(s)"});
      field(p.g2, Field{"g2", "", 0.01, 1, "power of s"});
      MrpSurfaceParams<S>::describe(p, field);
    }

    /// Rates in proportion to the frequency of the default stiffness; the slope of the terminal part at zero is at most
    /// `fastest_law`.
    explicit Params(const Setup<S>& setup) noexcept : MrpSurfaceParams<S>(setup) {
      const S f = default_stiffness(setup).frequency;
      a = S(0.7) * f;
      b = S(0.35) * f;
      eta = std::max(S(0.01), std::pow((S(2) - g) * b / fastest_law(setup), S(1) / (S(1) - g)));
      k1 = S(1.2) * f;
      k2 = S(0.25) * f * std::pow(f, S(1) - g2);
    }
  };

  static constexpr Estimates uses(const Params&) noexcept { return {.d_B = true}; }

  /// Sampled slopes: of the surface at z1 = 0, of the way to it at |s| = 1e-3 /s, and of the layer.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S surface = (p.a + p.b * sig_core_slope(S(0), p.g, p.eta)) * setup.dt;
    const S reach = (p.k1 + p.k2 * std::pow(S(1e-3), p.g2 - S(1))) * setup.dt;
    const S slope = p.slope(setup) * setup.dt;
    return needs_body_coordinates(setup) &&
           Status<S>::require(surface < S(1), "surface slope at zero * dt", surface, S(1), "<", unstable) &&
           Status<S>::require(reach + slope < S(2), "(k1 + k2 slope at 1e-3) * dt + k_s / (4 J phi) * dt",
                              reach + slope, S(2), "<", unstable);
  }

  TerminalSlidingMode(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params), shape_{params.a, params.b, params.g, params.eta}, surface_(setup, params) {}

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    surface_.start();
    return demand(vehicle, x, ref);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const { log("s", s_); }

 private:
  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const MrpMotion<S> m = surface_.motion(vehicle, x, ref);
    s_ = shape_(m.z1, m.z2);
    const Vec3<S> reach = params_.k1 * s_ + params_.k2 * sig(s_, params_.g2);
    Demand<S> out;
    out.tau_B = surface_.torque_B(vehicle, m, s_, shape_.rate(m.z1, m.z2) + reach, x.d_B);
    return out;
  }

  Params params_;
  TerminalShape<S> shape_;
  MrpSurface<S> surface_;
  Vec3<S> s_ = Vec3<S>::Zero();  ///< 1/s
};

}  // namespace gyrostat
