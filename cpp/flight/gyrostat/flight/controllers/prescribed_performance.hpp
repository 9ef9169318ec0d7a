// SPDX-License-Identifier: MIT
/// @file  Attitude error kept inside a funnel that is drawn again at every jump of reference or state and every detected fault.
///
///   s = w_e + b1 eps + b2 sig^r(eps),   eps = ln((1 + z) / (1 - z)),   tau_B as in controllers/sliding_tracking.hpp
///   t_f = max(tf_min, max_i sqrt(4 kappa |angle_i| J_ii / torque_i))     at each arm
///
/// Source: Yang, Yang, Ji, Ma 2023, eq. (11)-(16), corrected. Page: docs/components/prescribed_performance.md
#pragma once
#include "gyrostat/flight/controllers/parts/funnel.hpp"
#include "gyrostat/flight/controllers/parts/sliding_tracking.hpp"
#include "gyrostat/flight/parts/chart.hpp"

namespace gyrostat {

/// On or outside the funnel is a breach of contract: Flag::breach, a counted event and the margin (negative), never a
/// logarithm of a negative number. A law of a moving reference as well: the funnel is around the tracking error.
template <class S>
class PrescribedPerformance {
 public:
  using Scalar = S;
  static constexpr const char* name = "prescribed_performance";
  static constexpr bool switching = true;  ///< arms
  static constexpr bool regulates = true;

  enum class Arming : std::uint8_t { adaptive, fixed };

  struct Params {
    S b1, b2, r = S(0.6), eps_core = S(0.3);
    S b3, b4, s_core;
    S rho_inf, q_floor = S(0.005), eta = S(1.05), power = S(0.5), kappa = S(2), tf_min;
    S delta_1 = S(1), delta_2 = S(1), z_max = S(0.9), e_min = S(0.05);
    Arming arming = Arming::adaptive;
    bool as_printed = false;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.b1, Field{"b1", "rad/s", 0, 1e3, "slope of the surface in the transformed error"});
      field(p.b2, Field{"b2", "rad/s", 0, 1e3, "its terminal part"});
      field(p.r, Field{"r", "", 0.05, 1, "power of the terminal parts"});
      field(p.eps_core, Field{"eps_core", "", 1e-12, 1e3, "below this the power of the error is a polynomial"});
      field(p.b3, Field{"b3", "N m s", 0, 1e9, "linear gain of s"});
      field(p.b4, Field{"b4", "N m (rad/s)^-r", 0, 1e9, "terminal gain of s"});
      field(p.s_core, Field{"s_core", "rad/s", 1e-12, 1e3, "below this the power of s is a polynomial"});
      field(p.rho_inf, Field{"rho_inf", "", 1e-9, 1, "half-width of the closed funnel, vector part of the quaternion"});
      field(p.q_floor, Field{"q_floor", "", 1e-9, 1, "a smaller error at an arm gets a symmetric funnel"});
      field(p.eta, Field{"eta", "", 1, 10, "opening at an arm over the error there; above 1"});
      field(p.power, Field{"power", "", 0.05, 1, "p of the closing law (1 - t / t_f)^(1/p)"});
      field(p.kappa, Field{"kappa", "", 1e-3, 1e3, "time to close, squared, over that of a bang-bang slew"});
      field(p.tf_min, Field{"tf_min", "s", 1e-6, 1e6, "shortest time to close"});
      field(p.delta_1, Field{"delta_1", "", 1e-3, 10, "bound on the far side of zero"});
      field(p.delta_2, Field{"delta_2", "", 1e-3, 10, "bound on the side of the error"});
      field(p.z_max, Field{"z_max", "", 0.1, 0.9999, "normalised error beyond which eps is continued linearly"});
      field(p.e_min, Field{"e_min", "", 1e-3, 1, "least effectiveness that t_f counts with"});
      field(p.arming,
            Choice{"arming", "adaptive|fixed", "funnel drawn at every jump and fault, or at the start alone"});
      field(p.as_printed,
            Switch{"as_printed", "published torque: gyroscopic sign reversed, no motion of the reference"});
    }

    /// With w the default natural frequency, a the usable torque: b1 = 0.2 w, 0.03 a of the terminal part at s = w, and a final
    /// width at which the loop is stable when sampled, up to z_max.
    explicit Params(const Setup<S>& setup) noexcept {
      const S w = default_stiffness(setup).frequency;
      b1 = S(0.2) * w;
      rho_inf = std::max(S(0.005), S(16) * b1 * setup.dt);
      b2 = b1 / S(3);
      b3 = std::min(S(8) * w, S(0.1) / setup.dt) * largest_inertia(setup.vehicle.J_B);
      b4 = S(0.03) * usable_torque(setup.vehicle) / std::pow(w, r);
      s_core = S(0.05) * w;
      tf_min = S(0.6) / w;
    }
  };

  static constexpr Estimates uses(const Params&) noexcept { return {.d_B = true}; }

  /// Rate loop, and attitude loop at z_max in the closed funnel, where the transformation is steepest, must be stable when
  /// sampled.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S J = smallest_inertia(setup.vehicle.J_B);
    const S rate = p.b3 + p.b4 * sig_core_slope(S(0), p.r, p.s_core);
    const S eps = std::log1p(p.z_max) - std::log1p(-p.z_max);
    const S steepest = S(2) / (S(1) - p.z_max * p.z_max) * S(2) / ((p.delta_1 + p.delta_2) * p.rho_inf);
    const S attitude = S(0.5) * (p.b1 + p.b2 * sig_core_slope(eps, p.r, p.eps_core)) * steepest * setup.dt;
    return needs_body_coordinates(setup) && Status<S>::require(p.eta > S(1), "eta", p.eta, S(1), ">") &&
           Status<S>::require(p.power < S(1), "power", p.power, S(1)) &&
           Status<S>::require(rate * setup.dt < S(2) * J, "(b3 + b4 (2 - r) s_core^(r-1)) * dt", rate * setup.dt,
                              S(2) * J, "<", unstable) &&
           Status<S>::require(attitude < S(2), "slope of b1 eps + b2 sig^r(eps) in the angle at z_max, * dt", attitude,
                              S(2), "<", unstable);
  }

  PrescribedPerformance(Unchecked, const Setup<S>& setup, const Params& p) noexcept
      : dt_(setup.dt),
        params_(p),
        gains_{{p.b1, p.b2, p.r, p.eps_core}, {p.b3, p.b4, p.r, p.s_core}},
        shape_{p.power, p.rho_inf, p.delta_1, p.delta_2} {}

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                                const Reference<S>& ref) noexcept {
    arms_ = breaches_ = 0;
    outside_ = false;
    lowest_margin_ = S(1);
    jump_event_ = ref.event + x.event;
    fault_event_ = det.event;
    side_ = short_side(x, ref);
    arm(vehicle, x, sliding_error(x, ref, side_));
    return demand(vehicle, x, ref);
  }

  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    ++since_arm_;
    const bool jumped = ref.event + x.event != jump_event_, failed = det.event != fault_event_;
    jump_event_ = ref.event + x.event;
    fault_event_ = det.event;
    if (params_.arming == Arming::adaptive && (jumped || failed)) {
      if (jumped) side_ = short_side(x, ref);  // between jumps a flip would throw the error out of its funnel
      arm(vehicle, x, sliding_error(x, ref, side_));
    }
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const {
    log("s", s_);
    log("q_error", qv_);
    log("lower", lower_);
    log("upper", upper_);
    log("z", z_);
    log("margin", margin_);
    log("lowest_margin", lowest_margin_);
    log("closing_time", funnel_[0].t_f);
    log(Counter{"arms"}, arms_);
    log(Counter{"breaches"}, breaches_);
  }

 private:
  /// Torque about a body axis that the actuators in regular use have, with their estimated effectiveness.
  S torque_about(const Vehicle<S>& vehicle, int axis, const Estimate<S>& x) const noexcept {
    S sum = S(0);
    const Mat3N<S>& D_B = x.axes.of(vehicle.D_B);
    for (int j = 0; j < vehicle.actuators(); ++j) {
      const S lever = std::abs(D_B(axis, j));
      if (vehicle.spare.test(j) || lever == S(0)) continue;
      sum += lever * std::max(x.effectiveness[j], params_.e_min) * std::min(vehicle.u_up[j], -vehicle.u_lo[j]);
    }
    return std::isfinite(sum) && sum > S(0) ? sum : usable_torque(vehicle);
  }

  void arm(const Vehicle<S>& vehicle, const Estimate<S>& x, const SlidingError<S>& error) noexcept {
    const Vec3<S> angles = euler(error.q_RB);
    S t_f = params_.tf_min;
    for (int i = 0; i < 3; ++i)
      t_f = std::max(
          t_f, std::sqrt(S(4) * params_.kappa * std::abs(angles[i]) * vehicle.J_B(i, i) / torque_about(vehicle, i, x)));
    for (int i = 0; i < 3; ++i) funnel_[i] = Funnel<S>::armed(error.qv[i], params_.eta, params_.q_floor, t_f);
    since_arm_ = 0;
    ++arms_;
  }

  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const SlidingError<S> error = sliding_error(x, ref, side_);
    const S t = static_cast<S>(since_arm_) * dt_;
    Vec3<S> eps, eps_dot;
    for (int i = 0; i < 3; ++i) {
      const FunnelBounds<S> b = funnel_bounds(funnel_[i], shape_, t);
      const Normalised<S> n = normalise(b, error.qv[i], error.qvdot[i], params_.z_max);
      lower_[i] = b.lower;
      upper_[i] = b.upper;
      z_[i] = n.z;
      eps[i] = n.eps;
      eps_dot[i] = n.eps_dot;
    }
    const SlidingLaw<S> law = sliding_law(vehicle, x, ref, error, gains_, eps, eps_dot, params_.as_printed);
    s_ = law.s;
    qv_ = error.qv;
    Demand<S> out;
    out.tau_B = law.tau_B;
    watch_contract(out.status);
    return out;
  }

  void watch_contract(Flags& status) noexcept {
    margin_ = S(1) - z_.cwiseAbs().maxCoeff();
    lowest_margin_ = std::min(lowest_margin_, margin_);
    const bool out = !(margin_ > S(0));
    if (out) status.set(Flag::breach);
    if (out && !outside_) ++breaches_;
    outside_ = out;
  }

  S dt_;
  Params params_;
  SlidingGains<S> gains_;
  FunnelShape<S> shape_;
  Funnel<S> funnel_[3];
  Tick since_arm_ = 0;
  S side_ = S(1);
  std::uint32_t jump_event_ = 0, fault_event_ = 0, arms_ = 0, breaches_ = 0;
  bool outside_ = false;
  S margin_ = S(1), lowest_margin_ = S(1);
  Vec3<S> s_ = Vec3<S>::Zero(), qv_ = Vec3<S>::Zero(), z_ = Vec3<S>::Zero();
  Vec3<S> lower_ = Vec3<S>::Zero(), upper_ = Vec3<S>::Zero();
};

}  // namespace gyrostat
