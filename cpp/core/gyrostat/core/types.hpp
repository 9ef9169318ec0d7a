// SPDX-License-Identifier: MIT
/// @file  The few types every layer speaks: small vectors whose storage is inline, masks of actuators.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace gyrostat {

/// Largest number of actuators a vehicle may have. Storage is inline, so it bounds every per-actuator vector.
inline constexpr int max_actuators = 16;

template <class S>
using Vec3 = Eigen::Matrix<S, 3, 1>;
template <class S>
using Mat3 = Eigen::Matrix<S, 3, 3>;
/// Hamilton quaternion. `v_N = q_NB * v_B`; the matrix of q_NB is the transpose of the A(q) of most papers.
template <class S>
using Quat = Eigen::Quaternion<S>;
/// One number an actuator: length chosen at run time, storage inline.
template <class S>
using VecN = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, max_actuators, 1>;
/// Actuator axes in columns, body frame.
template <class S>
using Mat3N = Eigen::Matrix<S, 3, Eigen::Dynamic, 0, 3, max_actuators>;

/// Sample number since start. Flight counts ticks, never seconds.
using Tick = std::uint64_t;

/// A set of actuators.
class Mask {
 public:
  constexpr Mask() noexcept = default;
  static constexpr Mask all(int n) noexcept { return Mask(n >= 16 ? 0xFFFFu : (1u << n) - 1u); }

  constexpr bool test(int i) const noexcept { return ((bits_ >> i) & 1u) != 0u; }
  constexpr void set(int i, bool on = true) noexcept {
    bits_ = static_cast<std::uint16_t>(on ? bits_ | (1u << i) : bits_ & ~(1u << i));
  }
  constexpr bool any() const noexcept { return bits_ != 0; }
  constexpr std::uint16_t bits() const noexcept { return bits_; }
  constexpr Mask operator&(Mask o) const noexcept { return Mask(bits_ & unsigned{o.bits_}); }
  constexpr Mask operator|(Mask o) const noexcept { return Mask(bits_ | unsigned{o.bits_}); }
  /// Members of this set that are not in `o`.
  constexpr Mask without(Mask o) const noexcept { return Mask(bits_ & ~unsigned{o.bits_}); }
  constexpr bool operator==(const Mask&) const noexcept = default;

 private:
  explicit constexpr Mask(unsigned bits) noexcept : bits_(static_cast<std::uint16_t>(bits)) {}
  std::uint16_t bits_ = 0;
};
static_assert(max_actuators <= 16, "Mask holds 16 actuators");

/// D * u for bounded sizes. Written out, because the general matrix-vector kernel costs more than the sum itself here.
template <class S>
Vec3<S> torque(const Mat3N<S>& D, const VecN<S>& u) noexcept {
  Vec3<S> sum = Vec3<S>::Zero();
  for (Eigen::Index i = 0; i < D.cols(); ++i) sum += D.col(i) * u[i];
  return sum;
}

/// D' * tau.
template <class S>
VecN<S> project(const Mat3N<S>& D, const Vec3<S>& tau_B) noexcept {
  VecN<S> out(D.cols());
  for (Eigen::Index i = 0; i < D.cols(); ++i) out[i] = D.col(i).dot(tau_B);
  return out;
}

}  // namespace gyrostat
