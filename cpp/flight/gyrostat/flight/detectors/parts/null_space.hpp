// SPDX-License-Identifier: MIT
/// @file  Commands that make no torque: projector onto the null space of the actuator axes.
#pragma once

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

/// For each actuator of `members` the command nearest to "it alone" that makes no net torque, largest entry 1; empty of
/// torque: without redundancy it is zero. Built once, from an orthonormal basis of the rows of D (Gram-Schmidt, twice).
template <class S>
class NullSpace {
 public:
  NullSpace() noexcept = default;
  NullSpace(const Mat3N<S>& D_B, Mask members) noexcept : members_(members), n_(static_cast<int>(D_B.cols())) {
    for (int r = 0; r < 3 && n_ > 0; ++r) {
      VecN<S> row(n_);
      for (int i = 0; i < n_; ++i) row[i] = members.test(i) ? D_B(r, i) : S(0);
      const S length = row.norm();
      orthogonalise(row);
      orthogonalise(row);
      if (row.norm() > S(1e-3) * length) basis_[rank_++] = row / row.norm();  // less may be misalignment alone
    }
  }

  int dimension() const noexcept {
    int count = 0;
    for (int i = 0; i < n_; ++i) count += members_.test(i) ? 1 : 0;
    return count - rank_;
  }

  VecN<S> direction(int actuator) const noexcept {
    VecN<S> v = VecN<S>::Zero(n_);
    if (!members_.test(actuator)) return v;
    v[actuator] = S(1);
    orthogonalise(v);
    orthogonalise(v);
    const S largest = v.cwiseAbs().maxCoeff();
    if (largest < S(1e-3)) return VecN<S>::Zero(n_);
    return v / largest;
  }

 private:
  void orthogonalise(VecN<S>& v) const noexcept {
    for (int r = 0; r < rank_; ++r) v -= basis_[r].dot(v) * basis_[r];
  }

  Mask members_;
  int n_ = 0, rank_ = 0;
  VecN<S> basis_[3];
};

}  // namespace gyrostat
