// SPDX-License-Identifier: MIT
/// @file  Momentum management: what a stack prefers of its magnetorquers so that wheels do not fill, or a tumble dies out.
///
/// Of the momentum h to be taken off, the dipole that turns against it, m = (k / |B|^2) h x B, makes the torque
/// -k (h - b (b . h)), b = B / |B|: all of h but what lies along the field, which the next quarter of an orbit brings across it.
/// In the axes of this sample that is u_i = -(k / |B|^2) D_i . h of each torquer, which never adds momentum whatever torquers
/// there are. Scaled as a whole into their limits.
///
/// Camillo, Markley 1980; for `total`, Avanzini, Giulietti 2012. Page: docs/orbit.md
#pragma once
#include <algorithm>

#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// A policy of a stack that may add to what its controller asks for.
template <class M, class S>
concept Management =
    requires(M m, const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det, Demand<S>& demand) {
      { m(vehicle, x, det, demand) } noexcept;
    };

/// None: nothing is added.
struct NoManagement {
  struct Params {
    template <class S>
    explicit Params(const Setup<S>&) noexcept {}
    static constexpr void describe(auto&, auto&&) {}
  };

  NoManagement() noexcept = default;
  template <class S>
  NoManagement(Unchecked, const Setup<S>&, const Params&) noexcept {}
};

template <class S>
class CrossProductDesaturation {
 public:
  using Scalar = S;
  static constexpr const char* name = "desaturation";

  /// `wheels`: the wheels' momentum, whose torquers' torque the allocator lets the wheels cancel, so that the attitude does
  /// not move. `total`: that of the whole vehicle, and the torque acts: a body that tumbles comes to rest.
  enum class Momentum : std::uint8_t { wheels, total };

  struct Params {
    S gain = S(2);
    Momentum momentum = Momentum::wheels;
    Vec3<S> keep_B = Vec3<S>::Zero();

    explicit Params(const Setup<S>&) noexcept {}

    static constexpr void describe(auto& p, auto&& field) {
      field(p.gain, Field{"gain", "", 0, 1e4, "k, in units of the orbit's rate"});
      field(p.momentum,
            Choice{"momentum", "wheels|total",
                   "wheels: theirs, the attitude does not move; total: of the vehicle, which comes to rest"});
      field(p.keep_B, Field{"keep_B", "N m s", -1e6, 1e6, "momentum that is left, in body axes"});
    }
  };

  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S k_dt = p.gain * setup.vehicle.orbit_rate * setup.dt;
    return Status<S>::require(setup.vehicle.magnetorquers.any(), "magnetorquers", S(0), S(1), ">=") &&
           Status<S>::require(setup.vehicle.orbit_rate > S(0), "orbit_rate", setup.vehicle.orbit_rate, S(0), ">") &&
           Status<S>::require(k_dt < S(1), "gain * orbit_rate * dt", k_dt, S(1), "<", Status<S>::Code::unstable);
  }

  CrossProductDesaturation(Unchecked, const Setup<S>& setup, const Params& p) noexcept
      : p_(p), k_(p.gain * setup.vehicle.orbit_rate) {}

  /// Adds the dipoles to the preferred command.
  void operator()(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                  Demand<S>& demand) const noexcept {
    const S field2 = x.field_B.squaredNorm();
    if (!x.axes.move() || !(field2 > S(1e-14))) return;  // 0.1 uT: no field
    Vec3<S> h_B = x.axes.h_B - p_.keep_B;
    if (p_.momentum == Momentum::total) h_B += vehicle.J_B * x.omega_BN_B;
    const Mask usable = (vehicle.magnetorquers & det.enabled).without(det.failed);
    VecN<S> u = VecN<S>::Zero(vehicle.actuators());
    S scale = S(1);
    for (int i = 0; i < vehicle.actuators(); ++i) {
      if (!usable.test(i)) continue;
      u[i] = -k_ / field2 * x.axes.D_B.col(i).dot(h_B);
      const S limit = u[i] < S(0) ? -vehicle.u_lo[i] : vehicle.u_up[i];
      if (std::abs(u[i]) > limit) scale = std::min(scale, limit / std::abs(u[i]));
    }
    u *= scale;
    demand.u_pref += u;
    if (p_.momentum == Momentum::total) demand.tau_B += torque<S>(x.axes.D_B, u);
  }

 private:
  Params p_;
  S k_;  ///< 1/s
};

}  // namespace gyrostat
