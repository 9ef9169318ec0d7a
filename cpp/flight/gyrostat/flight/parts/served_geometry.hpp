// SPDX-License-Identifier: MIT
/// @file  What of a vehicle's geometry an allocator counts on: the actuators that are fit for use, and the axes of torque that
///        they make independently of each other. Decided here for every allocator.
///
/// Geometry is never known exactly: a singular value of A = D diag(effectiveness) below `rank_tolerance` times the largest one
/// may be nothing but misalignment (Weyl: moving A by delta moves no singular value by more than |delta|). Its axis of torque is
/// dropped: the demand along it is ignored, and Flag::rank_lost says so, instead of gains of 1 / singular value and of
/// actuators at their limits for an axis that they hardly move.
///
/// Estimates move. What counts does so from its threshold on, and until it has fallen below two thirds of it: a command does not
/// chatter where an estimate lies on the threshold. Page: docs/allocation.md
#pragma once
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// The parameter that all allocators share.
inline constexpr Field rank_tolerance_field{
    "rank_tolerance", "", 1e-6, 0.5,
    "an axis of torque with a smaller singular value of D diag(effectiveness), relative to the largest, is dropped"};
template <class S>
inline constexpr S default_rank_tolerance = S(0.01);  // half a degree of misalignment

template <class S>
class ServedGeometry {
 public:
  ServedGeometry() noexcept = default;
  /// @param e_min below this effectiveness an actuator is not used
  ServedGeometry(S e_min, S rank_tolerance) noexcept : e_min_(e_min), tolerance_(rank_tolerance) {}

  /// Forgets what counted before.
  void reset() noexcept { known_ = false; }

  /// Masks are obeyed at once, and what counts is then decided afresh. @return false when nothing changed
  /// @param revision  of the axes: while it stands, D_B does
  bool update(const Mat3N<S>& D_B, Mask usable, const VecN<S>& effectiveness, std::uint32_t revision = 0) noexcept {
    const bool afresh = !known_ || !(usable == usable_);
    if (!afresh && revision == revision_ && effectiveness == given_) return false;
    known_ = true;
    revision_ = revision;
    usable_ = usable;
    given_ = effectiveness;
    used_ = effectiveness;
    A_ = D_B;
    for (int i = 0; i < A_.cols(); ++i) {
      const bool weak = effectiveness[i] < threshold(e_min_, !afresh && in_use_.test(i));
      in_use_.set(i, usable.test(i) && !weak);
      if (!in_use_.test(i)) used_[i] = S(0);
      A_.col(i) *= used_[i];
    }
    decide(afresh ? 0 : rank_);
    return true;
  }

  const Mat3N<S>& A() const noexcept { return A_; }                ///< D diag(effectiveness()), not projected
  const VecN<S>& effectiveness() const noexcept { return used_; }  ///< zero for actuators that are not used
  int rank() const noexcept { return rank_; }                      ///< axes that are served

  /// Projector onto the axes that are served.
  const Mat3<S>& projector() const noexcept { return projector_; }
  /// What is asked along them.
  Vec3<S> served(const Vec3<S>& tau_B) const noexcept { return rank_ == 3 ? tau_B : Vec3<S>(projector_ * tau_B); }
  /// (A A')^-1 on the axes that are served, zero on the others.
  const Mat3<S>& inverse() const noexcept { return inverse_; }

 private:
  static S threshold(S from, bool counted) noexcept { return counted ? from * (S(2) / S(3)) : from; }

  void decide(int before) noexcept {
    Mat3<S> AAt = Mat3<S>::Zero();
    for (Eigen::Index i = 0; i < A_.cols(); ++i) AAt += A_.col(i) * A_.col(i).transpose();
    projector_.setIdentity();
    rank_ = 3;
    if (certainly_regular(AAt) || !AAt.allFinite()) {
      inverse_ = AAt.inverse();
      return;
    }
    const Eigen::SelfAdjointEigenSolver<Mat3<S>> eigen(AAt);
    for (rank_ = 0; rank_ < 3; ++rank_) {
      const S least = threshold(tolerance(), rank_ < before);
      if (!(eigen.eigenvalues()[2 - rank_] > least * least * eigen.eigenvalues()[2])) break;
    }
    inverse_.setZero();
    if (rank_ < 3) projector_.setZero();
    for (int i = 3 - rank_; i < 3; ++i) {
      const Vec3<S> axis = eigen.eigenvectors().col(i);
      inverse_ += axis * axis.transpose() / eigen.eigenvalues()[i];
      if (rank_ < 3) projector_ += axis * axis.transpose();
    }
  }

  /// Sufficient, and cheap: the two larger eigenvalues have a product below (trace / 2)^2, so the smallest one is above
  /// 4 det / trace^2.
  bool certainly_regular(const Mat3<S>& AAt) const noexcept {
    const S trace = AAt.trace();
    return S(4) * AAt.determinant() > tolerance() * tolerance() * trace * trace * trace;
  }

  /// Squares of singular values are known to a few epsilon of the largest.
  S tolerance() const noexcept { return std::max(tolerance_, std::sqrt(S(8) * Eigen::NumTraits<S>::epsilon())); }

  S e_min_ = S(0), tolerance_ = default_rank_tolerance<S>;
  Mat3N<S> A_{3, 0};
  VecN<S> given_, used_;
  Mat3<S> projector_ = Mat3<S>::Identity(), inverse_ = Mat3<S>::Zero();
  Mask usable_, in_use_;
  int rank_ = 0;
  std::uint32_t revision_ = 0;
  bool known_ = false;
};

}  // namespace gyrostat
