// SPDX-License-Identifier: MIT
/// @file  Sliding surfaces of rate and quaternion error, and the torque that keeps the motion on them.
///
///   s = w_e + delta q + terminal sig^power(q)        (near zero a smooth core with a bounded slope)
///
/// Source: the linear part is Wang, Jia, Yu 2023, eq. (27) and (29). Page: docs/components/mixed_learning_sliding_mode.md
#pragma once
#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/controllers/parts/tracking.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// On s = 0 the scalar part grows, q0' = (delta |q|^2 + terminal q . sig^power(q)) / 2, so only q0 = 1 is stable; the error is
/// taken the short way round.
template <class S>
class RateAttitudeSurface {
 public:
  struct Value {
    Vec3<S> s;             ///< rad/s
    Vec3<S> equivalent_B;  ///< N m, makes J s' vanish without disturbance
  };

  explicit RateAttitudeSurface(const TerminalShape<S>& shape) noexcept : shape_(shape) {}

  /// J s' = tau - equivalent + d.
  Value operator()(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) const noexcept {
    const Tracking<S> error = track(vehicle, x, ref);
    const Vec3<S>& w = error.omega_BR_B;
    const Quat<S> q_RB = quat_from_mrp(error.sigma_BR);
    const Vec3<S> q = q_RB.vec();
    const Vec3<S> qdot = S(0.5) * (q.cross(w) + q_RB.w() * w);
    return {shape_(q, w), error.equivalent_B() - vehicle.J_B * shape_.rate(q, qdot)};
  }

 private:
  TerminalShape<S> shape_;
};

/// What every sliding mode on this surface has: slope of the surface, gains of reaching it, compensation.
template <class S>
struct SurfaceGains {
  S delta;
  S k_lin;
  S k_sgn;
  S width;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.delta, Field{"delta", "1/s", 1e-9, 1e9, "slope of the surface; the attitude decays at half of it"});
    field(p.k_lin, Field{"k_lin", "N m s", 0, 1e9, "linear gain of s"});
    field(p.k_sgn, Field{"k_sgn", "N m", 0, 1e9, "switching gain"});
    field(p.width, Field{"width", "rad/s", 0, 1e9, "boundary layer of s; 0: sign"});
  }

  /// a = usable torque, f = natural frequency of the default stiffness, J = largest inertia: the attitude decays at 0.7 f,
  /// k_lin = J f, k_sgn = a / 20, and the layer ends where the linear torque is as large.
  explicit SurfaceGains(const Setup<S>& setup) noexcept {
    const S f = default_stiffness(setup).frequency;
    delta = S(1.4) * f;
    k_lin = largest_inertia(setup.vehicle.J_B) * f;
    k_sgn = S(0.05) * usable_torque(setup.vehicle);
    width = k_sgn / k_lin;
  }

  /// N m s, added to k_lin inside the layer.
  S slope() const noexcept { return width > S(0) ? k_sgn / width : S(0); }

  /// N m, drives s to zero.
  Vec3<S> reaching(const Vec3<S>& s) const noexcept { return -k_lin * s - k_sgn * layer(s, width); }
};

}  // namespace gyrostat
