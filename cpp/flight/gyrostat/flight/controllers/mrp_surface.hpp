// SPDX-License-Identifier: MIT
/// @file  What sliding-mode laws on a surface s(sigma, sigma') share: the motion in MRP and the way back to a torque.
///
///   z1 = sigma_BR,  z2 = sigma_BR' = G e,  G' along the motion;   e the rate error, h = J w + D h_w
///   tau_B = feedforward + e x h - k_s sat(s / phi) - J G^-1 (G' e + wanted) - d_B
///
/// so that sigma_BR'' = -wanted + G J^-1 (d - d_B - k_s sat(s / phi)) on the nominal model.
#pragma once
#include <Eigen/LU>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/controllers/tracking.hpp"

namespace gyrostat {

/// The switching part. `surface`: along s as usual; s' G J^-1 sgn(s) is then negative for some attitudes beyond |sigma| = 0.2.
/// `matched`: along J^-1 G' s, which never is.
enum class SwitchingDirection : std::uint8_t { surface, matched };

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
  MrpSurface(const Vehicle<S>& vehicle, S k_s, S phi, SwitchingDirection direction, S shadow_switch) noexcept
      : vehicle_(vehicle),
        J_inv_(vehicle.J_B.inverse()),
        scale_(S(4) * vehicle.J_B.trace() / S(3)),
        k_s_(k_s),
        phi_(phi),
        direction_(direction),
        set_(shadow_switch) {}

  void start() noexcept { set_.start(); }

  MrpMotion<S> motion(const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const Tracking<S> error = track(vehicle_, x, ref, set_);
    MrpMotion<S> m;
    m.z1 = error.sigma_BR;
    m.error_B = error.omega_BR_B;
    m.G = mrp_rate_matrix(m.z1);
    m.G_inv = mrp_rate_matrix_inverse(m.z1);
    m.z2 = m.G * m.error_B;
    m.G_rate = mrp_rate_matrix_rate(m.z1, m.z2);
    const Vec3<S> momentum_B = vehicle_.J_B * x.omega_BN_B + torque<S>(vehicle_.D_B, x.h_w);
    m.given_B = error.feedforward_B + m.error_B.cross(momentum_B);
    return m;
  }

  /// N m.
  Vec3<S> torque_B(const MrpMotion<S>& m, const Vec3<S>& s, const Vec3<S>& wanted, const Vec3<S>& d_B) const noexcept {
    Vec3<S> along = s;
    if (direction_ == SwitchingDirection::matched)
      along = scale_ * (J_inv_ * (m.G.transpose() * s));  // s for small angles
    const Vec3<S> shape = m.G_inv * (m.G_rate * m.error_B + wanted);
    return m.given_B - k_s_ * layer(along, phi_) - vehicle_.J_B * shape - d_B;
  }

 private:
  Vehicle<S> vehicle_;
  Mat3<S> J_inv_;
  S scale_, k_s_, phi_;
  SwitchingDirection direction_;
  ShadowSet<S> set_;
};

}  // namespace gyrostat
