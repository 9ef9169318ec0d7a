// SPDX-License-Identifier: MIT
/// @file  Least-norm allocation by the pseudo-inverse, clipped to the limits.
///
///   u = clip(u_pref + A+ (tau - A u_pref)),   A+ = A'(A A')^-1,   A = D diag(effectiveness) or D
///
/// An estimate whose bound is infinite may be refused (`unknown`). Columns of actuators that are failed, not enabled or weaker
/// than e_min are zero. Page: docs/components/pseudo_inverse.md
#pragma once
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/parts/served_geometry.hpp"

namespace gyrostat {

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
    S rank_tolerance = default_rank_tolerance<S>;
    /// What an infinite effectiveness_bound (never excited, or forgotten) does to the estimate beside it.
    Unknown unknown = Unknown::estimate;

    explicit Params(const Setup<S>&) noexcept {}

    static constexpr void describe(auto& p, auto&& field) {
      field(p.use_effectiveness, Switch{"use_effectiveness", "invert D diag(effectiveness) instead of D"});
      field(p.e_min, Field{"e_min", "", 0, 1, "weaker actuators are not used (with use_effectiveness)"});
      field(p.rank_tolerance, rank_tolerance_field);
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

  PseudoInverse(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params), du_max_(setup.vehicle.u_rate * setup.dt), geometry_(params.e_min, params.rank_tolerance) {
    reset(setup.vehicle);
  }

  /// The previous command is zero again (or the limit nearest to it).
  void reset(const Vehicle<S>& vehicle) noexcept {
    const int n = vehicle.actuators();
    u_ = clip<S>(VecN<S>::Zero(n), vehicle.u_lo, vehicle.u_up);
    geometry_.reset();
  }

  [[nodiscard]] Allocation<S> step(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x,
                                   const Detection<S>& det) noexcept {
    update_inverse(x.axes.of(vehicle.D_B), x, det);
    const VecN<S> wish = least_norm(demand);

    Allocation<S> out;
    // Inside the box, and as near to the previous command as the rate limit asks.
    const VecN<S> lo = vehicle.u_lo.cwiseMax(u_ - du_max_), up = vehicle.u_up.cwiseMin(u_ + du_max_);
    out.u = clip<S>(wish, lo, up);
    out.saturated = saturated<S>(out.u, lo, up);
    out.demand_B = demand.tau_B;
    out.achieved_B = torque<S>(x.axes.of(vehicle.D_B), x.effectiveness.cwiseProduct(out.u));
    if (geometry_.rank() < 3) out.status.set(Flag::rank_lost);
    if (not_met(out)) out.status.set(Flag::demand_not_met);
    u_ = out.u;
    return out;
  }

  void telemetry(auto&& log) const { log("rank", static_cast<S>(geometry_.rank())); }

 private:
  /// A+ changes only with the masks and, where it is used, the effectiveness.
  void update_inverse(const Mat3N<S>& D_B, const Estimate<S>& x, const Detection<S>& det) noexcept {
    const Eigen::Index n = D_B.cols();
    usable_ = det.enabled.without(det.failed);
    const VecN<S> e = params_.use_effectiveness ? believed(x) : VecN<S>(VecN<S>::Ones(n));
    if (!geometry_.update(D_B, usable_, e, x.axes.revision)) return;
    A_plus_transposed_.resize(3, n);
    for (int i = 0; i < n; ++i) A_plus_transposed_.col(i) = geometry_.inverse() * geometry_.A().col(i);
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

  VecN<S> least_norm(const Demand<S>& demand) const noexcept {
    if (demand.u_pref.size() == 0) return project<S>(A_plus_transposed_, demand.tau_B);
    VecN<S> preferred(u_.size());
    for (int i = 0; i < preferred.size(); ++i) preferred[i] = usable_.test(i) ? demand.u_pref[i] : S(0);
    const Vec3<S> missing_B = demand.tau_B - torque<S>(geometry_.A(), preferred);
    return preferred + project<S>(A_plus_transposed_, missing_B);
  }

  /// The torque left over is more than rounding.
  static bool not_met(const Allocation<S>& a) noexcept {
    const S rounding = S(64) * Eigen::NumTraits<S>::epsilon();
    return (a.achieved_B - a.demand_B).norm() > rounding * (a.demand_B.norm() + a.u.norm());
  }

  Params params_;
  VecN<S> du_max_;  ///< N m a sample
  ServedGeometry<S> geometry_;
  Mat3N<S> A_plus_transposed_;
  Mask usable_;
  VecN<S> u_;  ///< issued at the previous sample
};

}  // namespace gyrostat
