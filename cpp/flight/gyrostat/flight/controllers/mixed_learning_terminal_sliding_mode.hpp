// SPDX-License-Identifier: MIT
/// @file  Terminal sliding mode with the learning of `mixed_learning_sliding_mode`: finite time instead of exponential.
///
///   s = w_e + delta q + terminal sig^power(q)
///   tau_B = equivalent - k_lin s - k_power sig^power_s(s) - k_sgn sat(s / width) - learnt - d_B
///
/// Ours: Wang, Jia, Yu 2023 name it as future work and give no law. Page: docs/components/mixed_learning_terminal_sliding_mode.md
#pragma once
#include <cmath>

#include "gyrostat/flight/controllers/mixed_learning_sliding_mode.hpp"

namespace gyrostat {

/// Inside `core` the power of the surface is replaced by a smooth odd function: no singular torque, and the last part of the
/// approach is exponential again, at (delta + (2 - power) terminal core^(power - 1)) / 2.
template <class S>
class MixedLearningTerminalSlidingMode : public MixedLearningSlidingMode<S> {
 public:
  using Linear = MixedLearningSlidingMode<S>;
  static constexpr const char* name = "mixed_learning_terminal_sliding_mode";

  struct Params : Linear::Params {
    S terminal;
    S power = S(0.7);
    S core;
    S k_power;
    S power_s = S(0.7);

    static constexpr void describe(auto& p, auto&& field) {
      Linear::Params::describe(p, field);
      field(p.terminal, Field{"terminal", "rad/s", 0, 1e9, "gain of the terminal part of the surface"});
      field(p.power, Field{"power", "", 0.5, 1, "of the attitude error in the surface"});
      field(p.core, Field{"core", "", 1e-9, 1, "quaternion error below which the surface is smooth"});
      field(p.k_power, Field{"k_power", "N m s^power_s", 0, 1e9, "gain of sig^power_s(s)"});
      field(p.power_s, Field{"power_s", "", 0.01, 1, "power of s"});
    }

    typename Linear::Surface surface() const noexcept { return {this->delta, terminal, power, core}; }

    /// Those of the linear law; the terminal part equals the linear one at a quaternion error of 0.1, and its decay rate at zero
    /// is at most `fastest_law`.
    explicit Params(const Setup<S>& setup) noexcept : Linear::Params(setup) {
      terminal = this->delta * std::pow(S(0.1), S(1) - power);
      core =
          std::max(S(0.01), std::pow(S(0.5) * (S(2) - power) * terminal / fastest_law(setup), S(1) / (S(1) - power)));
      k_power = this->k_lin * std::pow(S(0.5) * this->width, S(1) - power_s);
    }
  };

  /// That of the linear law, and the steepest part of the surface must be slow against the period.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S rate = S(0.5) * (p.delta + (S(2) - p.power) * p.terminal * std::pow(p.core, p.power - S(1)));
    return Linear::check(setup, p) && Status<S>::require(rate * setup.dt < S(1), "decay rate of the core * dt",
                                                         rate * setup.dt, S(1), "<", Status<S>::Code::unstable);
  }

  MixedLearningTerminalSlidingMode(Unchecked, const Setup<S>&, const Params& params) noexcept
      : Linear(params, params.surface(), {params.k_power, params.power_s}) {}
};

}  // namespace gyrostat
