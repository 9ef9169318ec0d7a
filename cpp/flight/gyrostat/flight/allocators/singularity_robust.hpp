// SPDX-License-Identifier: MIT
/// @file  Steering of control moment gyros: an inverse that stays finite where their axes lie in a plane, and leaves that place.
///
///   u = clip(u_pref + A'(A A' + lambda E)^-1 (tau - A u_pref)),   lambda = lambda_0 exp(-decay det(B B')),   A = D diag(effectiveness)
///
/// B is A over its longest column. E is the unit matrix (sr: Nakamura, Hanafusa 1986; Bedrossian and others 1990), or has
/// off-diagonals that swing, so that a demand along the lost axis turns gimbals too (gsr: Wie, Bailey, Heiberg 2001).
/// Far from a singularity it is the pseudo-inverse. Page: docs/components/singularity_robust.md
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"

namespace gyrostat {

template <class S>
class SingularityRobust {
 public:
  using Scalar = S;
  static constexpr const char* name = "singularity_robust";

  enum class Method : std::uint8_t { sr, gsr };

  struct Params {
    Method method = Method::gsr;
    S lambda_0 = S(0.01), decay = S(10);
    S swing = S(0.1), swing_rate = S(1.5707963267948966);
    S m_singular = S(0.1);
    bool use_effectiveness = true;  ///< as in pseudo_inverse
    S e_min = default_effectiveness_floor<S>;

    explicit Params(const Setup<S>&) noexcept {}

    static constexpr void describe(auto& p, auto&& field) {
      field(p.method, Choice{"method", "sr|gsr", "unit matrix, or off-diagonals that swing"});
      field(p.lambda_0, Field{"lambda_0", "", 1e-6, 10, "regularisation at a singularity, for axes of length one"});
      field(p.decay, Field{"decay", "", 0, 1000, "how quickly it fades with det(B B')"});
      field(p.swing, Field{"swing", "", 0, 0.49, "amplitude of the off-diagonals (gsr)"});
      field(p.swing_rate, Field{"swing_rate", "rad/s", 0, 1e3, "of the off-diagonals (gsr)"});
      field(p.m_singular, Field{"m_singular", "", 0, 1, "singularity measure below which Flag::singular is set"});
      field(p.use_effectiveness, Switch{"use_effectiveness", "invert D diag(effectiveness) instead of D"});
      field(p.e_min, Field{"e_min", "", 0, 1, "weaker actuators are not used (with use_effectiveness)"});
    }
  };

  static constexpr Estimates uses(const Params& p) noexcept { return {.effectiveness = p.use_effectiveness}; }
  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.use_effectiveness ? p.e_min : S(0); }

  static Status<S> check(const Setup<S>& setup, const Params&) noexcept {
    const int n = setup.vehicle.actuators();
    return Status<S>::require(n >= 3, "actuators", static_cast<S>(n), S(3), ">=");
  }

  SingularityRobust(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params),
        du_max_(setup.vehicle.u_rate * setup.dt),
        phase_step_(static_cast<double>(params.swing_rate) * static_cast<double>(setup.dt)) {
    reset(setup.vehicle);
  }

  /// The previous command is zero again (or the limit nearest to it).
  void reset(const Vehicle<S>& vehicle) noexcept {
    u_ = clip<S>(VecN<S>::Zero(vehicle.actuators()), vehicle.u_lo, vehicle.u_up);
    in_use_ = {};
  }

  [[nodiscard]] Allocation<S> step(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x,
                                   const Detection<S>& det) noexcept {
    const Mat3N<S>& D_B = x.axes.of(vehicle.D_B);
    Allocation<S> out;
    const VecN<S> wish = steered(demand, D_B, x, det.enabled.without(det.failed));
    const VecN<S> lo = vehicle.u_lo.cwiseMax(u_ - du_max_), up = vehicle.u_up.cwiseMin(u_ + du_max_);
    out.u = clip<S>(wish, lo, up);
    out.saturated = saturated<S>(out.u, lo, up);
    out.demand_B = demand.tau_B;
    out.achieved_B = torque<S>(D_B, x.effectiveness.cwiseProduct(out.u));
    if (measure_ < params_.m_singular) out.status.set(Flag::singular);
    const S rounding = S(64) * Eigen::NumTraits<S>::epsilon() * out.u.norm();
    if ((out.achieved_B - out.demand_B).norm() > S(1e-3) * demand.tau_B.norm() + rounding)
      out.status.set(Flag::demand_not_met);
    u_ = out.u;
    return out;
  }

  void telemetry(auto&& log) const {
    log("m", measure_);
    log("lambda", lambda_);
  }

 private:
  VecN<S> steered(const Demand<S>& demand, const Mat3N<S>& D_B, const Estimate<S>& x, Mask usable) noexcept {
    const Eigen::Index n = D_B.cols();
    Mat3N<S> A = D_B;
    Mat3<S> AAt = Mat3<S>::Zero();
    VecN<S> preferred = demand.u_pref.size() == n ? demand.u_pref : VecN<S>(VecN<S>::Zero(n));
    S strongest = S(0);  // squared length of a column
    for (int i = 0; i < n; ++i) {
      const S e = params_.use_effectiveness ? x.effectiveness[i] : S(1);
      const S least = in_use_.test(i) ? params_.e_min * (S(2) / S(3)) : params_.e_min;  // no chatter about it
      const bool on = usable.test(i) && !(e < least);
      in_use_.set(i, on);
      A.col(i) *= on ? e : S(0);
      if (!on) preferred[i] = S(0);
      AAt += A.col(i) * A.col(i).transpose();
      strongest = std::max(strongest, A.col(i).squaredNorm());
    }
    measure_ = strongest > S(0) ? std::sqrt(std::max((AAt / strongest).determinant(), S(0))) : S(0);
    lambda_ = params_.lambda_0 * std::exp(-params_.decay * measure_ * measure_);
    if (!(strongest > S(0))) return preferred;
    const Mat3<S> regular = AAt + lambda_ * strongest * weight(x.tick);
    const Vec3<S> missing_B = demand.tau_B - torque<S>(A, preferred);
    return preferred + project<S>(A, Vec3<S>(regular.inverse() * missing_B));
  }

  /// E, positive definite as long as swing < 1/2. In double: the phase of a long flight has no room in a float.
  Mat3<S> weight(Tick tick) const noexcept {
    Mat3<S> E = Mat3<S>::Identity();
    if (params_.method == Method::sr) return E;
    const S phase = static_cast<S>(std::fmod(static_cast<double>(tick) * phase_step_, 6.283185307179586477));
    const S a = params_.swing * std::sin(phase), b = params_.swing * std::cos(phase);
    E(1, 2) = E(2, 1) = a;   // sin(phase)
    E(0, 2) = E(2, 0) = b;   // sin(phase + pi / 2)
    E(0, 1) = E(1, 0) = -a;  // sin(phase + pi)
    return E;
  }

  Params params_;
  VecN<S> du_max_;     ///< N m a sample
  double phase_step_;  ///< rad a sample
  VecN<S> u_;          ///< issued at the previous sample
  Mask in_use_;        ///< then
  S measure_ = S(0), lambda_ = S(0);
};

}  // namespace gyrostat
