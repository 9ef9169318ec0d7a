// SPDX-License-Identifier: MIT
/// @file  What sliding-mode laws on a surface s(sigma, sigma') share: the motion in MRP and the way back to a torque.
///
///   z1 = sigma_BR,  z2 = sigma_BR' = G e,  G' along the motion;   e the rate error, h = J w + D h_w
///   tau_B = feedforward + e x h - k_s sat(s / phi) - J G^-1 (G' e + wanted) - d_B
///
/// so that sigma_BR'' = -wanted + G J^-1 (d - d_B - k_s sat(s / phi)) on the nominal model.
#pragma once
#include <Eigen/LU>
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/controllers/parts/tracking.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// The switching part. `surface`: along s as usual; s' G J^-1 sgn(s) is then negative for some attitudes beyond |sigma| = 0.2.
/// `matched`: along J^-1 G' s, which never is.
enum class SwitchingDirection : std::uint8_t { surface, matched };

/// Parameters that laws on such a surface have in common.
template <class S>
struct MrpSurfaceParams {
  S k_s;
  S phi;
  SwitchingDirection direction = SwitchingDirection::surface;
  S shadow_switch = S(1);

  static constexpr void describe(auto& p, auto&& field) {
    field(p.k_s, Field{"k_s", "N m", 0, 1e9, "switching torque"});
    field(p.phi, Field{"phi", "1/s", 0, 1e3, "boundary layer of s; 0: sign(s)"});
    field(p.direction,
          Choice{"direction", "surface|matched", "of the switching torque: s, or J^-1 G' s, which always opposes s"});
    field(p.shadow_switch, shadow_switch_field);
  }

  /// 5 % of the usable torque, in a layer of 2 % of the rate of the MRP that it reaches in a full turn, or of the slope that
  /// `fastest_law` allows.
  explicit MrpSurfaceParams(const Setup<S>& setup) noexcept {
    const S a = usable_torque(setup.vehicle);
    k_s = S(0.05) * a;
    phi = std::max(S(0.02) * std::sqrt(a / largest_inertia(setup.vehicle.J_B)) / S(4),
                   k_s / (S(4) * smallest_inertia(setup.vehicle.J_B) * fastest_law(setup)));
  }

  /// Of the layer, per s, about the smallest inertia, 1/s.
  S slope(const Setup<S>& setup) const noexcept {
    return phi > S(0) ? k_s / (S(4) * smallest_inertia(setup.vehicle.J_B) * phi) : S(0);
  }
};

/// Attitude motion relative to the reference.
template <class S>
struct MrpMotion {
  Vec3<S> z1, z2;
  Mat3<S> G, G_inv, G_rate;
  Vec3<S> error_B;  ///< rad/s
  Vec3<S> given_B;  ///< N m, feed-forward and gyroscopic torque
};

template <class S>
class MrpSurface {
 public:
  MrpSurface(const Setup<S>& setup, const MrpSurfaceParams<S>& params) noexcept
      : J_inv_(setup.vehicle.J_B.inverse()),
        scale_(S(4) * setup.vehicle.J_B.trace() / S(3)),
        params_(params),
        set_(params.shadow_switch) {}

  void start() noexcept { set_.start(); }

  MrpMotion<S> motion(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const Tracking<S> error = track(vehicle, x, ref, set_);
    MrpMotion<S> m;
    m.z1 = error.sigma_BR;
    m.error_B = error.omega_BR_B;
    m.G = mrp_rate_matrix(m.z1);
    m.G_inv = mrp_rate_matrix_inverse(m.z1);
    m.z2 = m.G * m.error_B;
    m.G_rate = mrp_rate_matrix_rate(m.z1, m.z2);
    m.given_B = error.equivalent_B();
    return m;
  }

  /// N m.
  Vec3<S> torque_B(const Vehicle<S>& vehicle, const MrpMotion<S>& m, const Vec3<S>& s, const Vec3<S>& wanted,
                   const Vec3<S>& d_B) const noexcept {
    Vec3<S> along = s;
    if (params_.direction == SwitchingDirection::matched)
      along = scale_ * (J_inv_ * (m.G.transpose() * s));  // s for small angles
    const Vec3<S> shape = m.G_inv * (m.G_rate * m.error_B + wanted);
    return m.given_B - params_.k_s * layer(along, params_.phi) - vehicle.J_B * shape - d_B;
  }

 private:
  Mat3<S> J_inv_;
  S scale_;
  MrpSurfaceParams<S> params_;
  MrpSwitching<S> set_;
};

}  // namespace gyrostat
