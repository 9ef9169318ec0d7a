// SPDX-License-Identifier: MIT
/// @file  Least-norm allocation by the pseudo-inverse, clipped to the limits.
///
///   u = clip(u_pref + A+ (tau - A u_pref)),   A+ = A'(A A')^-1,   A = D diag(effectiveness) or D
///
/// An estimate whose bound is infinite may be refused (`unknown`). Columns of actuators that are failed, not enabled or weaker
/// than e_min are zero. Page: docs/components/pseudo_inverse.md
#pragma once
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/effectiveness_floor.hpp"

namespace gyrostat {

/// Geometry is never known exactly: a singular value of A below rank_tolerance times the largest one may be nothing but
/// misalignment (Weyl: moving A by delta moves no singular value by more than |delta|). It counts as zero, its axis of
/// torque is dropped and Flag::rank_lost is set, instead of gains of 1 / singular value.
template <class S>
class PseudoInverse {
 public:
  using Scalar = S;
  static constexpr const char* name = "pseudo_inverse";
  static constexpr bool axiswise = true;

  enum class Unknown : std::uint8_t { estimate, nominal };

  struct Params {
    /// True, because the model all components share has D diag(effectiveness) u in it: an observer that estimates it has
    /// taken that share out of d_B, and nobody else would make up for it. Without such an observer it is all ones.
    bool use_effectiveness = true;
    S e_min = default_effectiveness_floor<S>;
    S rank_tolerance = S(0.01);
    /// What an infinite effectiveness_bound (never excited, or forgotten) does to the estimate beside it.
    Unknown unknown = Unknown::estimate;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.use_effectiveness, Switch{"use_effectiveness", "invert D diag(effectiveness) instead of D"});
      field(p.e_min, Field{"e_min", "", 0, 1, "weaker actuators are not used (with use_effectiveness)"});
      field(p.rank_tolerance, Field{"rank_tolerance", "", 1e-6, 0.5, "relative singular value that counts as zero"});
      field(p.unknown, Choice{"unknown", "estimate|nominal",
                              "effectiveness of infinite bound: as estimated, or 1 (not divided by)"});
    }
  };

  static constexpr Estimates uses(const Params& p) noexcept { return {.effectiveness = p.use_effectiveness}; }
  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.use_effectiveness ? p.e_min : S(0); }

  static Status<S> check(const Setup<S>& setup, const Params&) noexcept {
    const int n = setup.vehicle.actuators();
    return Status<S>::require(n >= 1, "actuators", static_cast<S>(n), S(1), ">=");
  }

  PseudoInverse(const Setup<S>& setup, const Params& params) noexcept
      : vehicle_(setup.vehicle), params_(params), du_max_(setup.vehicle.u_rate * setup.dt) {
    reset();
  }

  /// The previous command is zero again (or the limit nearest to it).
  void reset() noexcept {
    const int n = vehicle_.actuators();
    u_ = clip<S>(VecN<S>::Zero(n), vehicle_.u_lo, vehicle_.u_up);
    known_ = false;
  }

  [[nodiscard]] Allocation<S> step(const Demand<S>& demand, const Estimate<S>& x, const Detection<S>& det) noexcept {
    update_inverse(x, det);
    const VecN<S> wish = least_norm(demand);

    Allocation<S> out;
    // Inside the box, and as near to the previous command as the rate limit asks.
    const VecN<S> lo = vehicle_.u_lo.cwiseMax(u_ - du_max_), up = vehicle_.u_up.cwiseMin(u_ + du_max_);
    out.u = clip<S>(wish, lo, up);
    out.saturated = saturated<S>(out.u, lo, up);
    out.demand_B = demand.tau_B;
    out.achieved_B = torque<S>(vehicle_.D_B, x.effectiveness.cwiseProduct(out.u));
    if (rank_ < 3) out.status.set(Flag::rank_lost);
    if (not_met(out)) out.status.set(Flag::demand_not_met);
    u_ = out.u;
    return out;
  }

  void telemetry(auto&& log) const { log("rank", static_cast<S>(rank_)); }

 private:
  /// A and its inverse change only with the masks and, where it is used, the effectiveness.
  void update_inverse(const Estimate<S>& x, const Detection<S>& det) noexcept {
    const Mask usable = det.enabled.without(det.failed);
    if (known_ && usable == usable_ && (!params_.use_effectiveness || believed(x) == effectiveness_)) return;
    known_ = true;
    usable_ = usable;
    effectiveness_ = believed(x);
    A_ = vehicle_.D_B;
    for (int i = 0; i < vehicle_.actuators(); ++i) {
      const S e = params_.use_effectiveness ? effectiveness_[i] : S(1);
      A_.col(i) *= usable.test(i) && e >= params_.e_min ? e : S(0);
    }
    invert();
  }

  /// An estimate without a bound is no reason to ask for more: it counts as healthy with Unknown::nominal.
  VecN<S> believed(const Estimate<S>& x) const noexcept {
    VecN<S> e = x.effectiveness;
    if (params_.unknown == Unknown::nominal) {
      for (int i = 0; i < e.size(); ++i)
        if (!std::isfinite(x.effectiveness_bound[i])) e[i] = S(1);
    }
    return e;
  }

  void invert() noexcept {
    Mat3<S> AAt = Mat3<S>::Zero();
    for (Eigen::Index i = 0; i < A_.cols(); ++i) AAt += A_.col(i) * A_.col(i).transpose();
    Mat3<S> inverse;
    if (certainly_regular(AAt)) {
      inverse = AAt.inverse();
      rank_ = 3;
    } else {
      inverse = truncated_inverse(AAt);
    }
    A_plus_transposed_.resize(3, A_.cols());
    for (Eigen::Index i = 0; i < A_.cols(); ++i) A_plus_transposed_.col(i) = inverse * A_.col(i);
  }

  /// Sufficient, and cheap: the two larger eigenvalues have a product below (trace / 2)^2, so the smallest one is above
  /// 4 det / trace^2.
  bool certainly_regular(const Mat3<S>& AAt) const noexcept {
    const S trace = AAt.trace();
    return S(4) * AAt.determinant() > params_.rank_tolerance * params_.rank_tolerance * trace * trace * trace;
  }

  /// Inverse on the axes whose singular value counts, zero on the others.
  Mat3<S> truncated_inverse(const Mat3<S>& AAt) noexcept {
    const Eigen::SelfAdjointEigenSolver<Mat3<S>> eigen(AAt);
    const S least = params_.rank_tolerance * params_.rank_tolerance * eigen.eigenvalues()[2];
    Mat3<S> inverse = Mat3<S>::Zero();
    rank_ = 0;
    for (int i = 0; i < 3; ++i) {
      const S square = eigen.eigenvalues()[i];
      if (!(square > least)) continue;
      const Vec3<S> axis = eigen.eigenvectors().col(i);
      inverse += axis * axis.transpose() / square;
      ++rank_;
    }
    return inverse;
  }

  VecN<S> least_norm(const Demand<S>& demand) const noexcept {
    const Eigen::Index n = A_.cols();
    if (demand.u_pref.size() == 0) return project<S>(A_plus_transposed_, demand.tau_B);
    VecN<S> preferred(n);
    for (int i = 0; i < n; ++i) preferred[i] = usable_.test(i) ? demand.u_pref[i] : S(0);
    const Vec3<S> missing_B = demand.tau_B - torque<S>(A_, preferred);
    return preferred + project<S>(A_plus_transposed_, missing_B);
  }

  /// The torque left over is more than rounding.
  static bool not_met(const Allocation<S>& a) noexcept {
    const S rounding = S(64) * Eigen::NumTraits<S>::epsilon();
    return (a.achieved_B - a.demand_B).norm() > rounding * (a.demand_B.norm() + a.u.norm());
  }

  Vehicle<S> vehicle_;
  Params params_;
  VecN<S> du_max_;  ///< N m a sample
  Mat3N<S> A_, A_plus_transposed_;
  Mask usable_;
  VecN<S> effectiveness_;
  VecN<S> u_;  ///< issued at the previous sample
  int rank_ = 0;
  bool known_ = false;
};

}  // namespace gyrostat
