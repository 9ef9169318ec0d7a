// SPDX-License-Identifier: MIT
/// @file  Finite-time disturbance observer: everything the nominal model does not explain, as one torque d_B.
///
///   J what' = -w x (J w + D h_w) + D u + theta,   z1 = w - what
///   theta = J (lambda1 sig^alpha1(z1) + eta),   eta' = lambda2 sig^alpha2(z1),   alpha2 = 2 alpha1 - 1
///
/// Source: Li, Hu, Yang, Postolache 2018, eq. (7)-(9). Valid while the derivative of the lumped torque is bounded.
/// Page: docs/components/finite_time_disturbance.md
#pragma once
#include <Eigen/LU>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/observers/parts/implicit_root.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// u is the issued command. Actuator faults, D (E - I) u + D bias, and the external torque come out together in d_B; the
/// effectiveness stays one, so nothing is counted twice.
template <class S>
class FiniteTimeDisturbanceObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "finite_time_disturbance";
  static constexpr Estimates estimates{.d_B = true};
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;  ///< infinite slope at z1 = 0

  enum class Method : std::uint8_t { implicit, explicit_euler };

  struct Params {
    S alpha1 = S(0.6);
    S lambda1;
    S lambda2;
    Method method = Method::implicit;
    int substeps = 1;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.alpha1,
            Field{"alpha1", "", 0.5, 1, "power of the rate error, inside the open interval; alpha2 = 2 alpha1 - 1"});
      field(p.lambda1, Field{"lambda1", "rad^(1-alpha1) s^(alpha1-2)", 1e-9, 1e9, "gain of the rate error"});
      field(p.lambda2, Field{"lambda2", "rad^(1-alpha2) s^(alpha2-3)", 1e-9, 1e9, "gain of its integral"});
      field(p.method, Choice{"method", "implicit|explicit_euler", "integration; the implicit step does not chatter"});
      field(p.substeps, Field{"substeps", "", 1, 1000, "Euler steps a period, the rate between samples on a line"});
    }

    /// Gains of the homogeneous error dynamics with time scale T, 10 periods or `observer_periods`, and rate scale a T, where a
    /// is the acceleration at hand: a step of all of it is found within a few T on every vehicle.
    explicit Params(const Setup<S>& setup) noexcept {
      const S alpha2 = S(2) * alpha1 - S(1);
      const S T = observer_periods(setup, S(10)) * setup.dt;
      const S rate = usable_acceleration(setup.vehicle) * T;
      lambda1 = std::pow(rate, S(1) - alpha1) / T;
      lambda2 = S(0.6) * std::pow(rate, S(1) - alpha2) / (T * T);
    }
  };

  /// The explicit form must be stable where the slope is lambda1 and lambda2, at a rate error of 1 rad/s: the eigenvalues of
  /// [1 - h lambda1, h; -h lambda2, 1] inside the unit circle. (Near zero it always ends in a small limit cycle.)
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S h = setup.dt / static_cast<S>(p.substeps);
    const Status<S> both = needs_body_coordinates(setup) &&
                           Status<S>::require(p.alpha1 > S(0.5), "alpha1", p.alpha1, S(0.5), ">") &&
                           Status<S>::require(p.alpha1 < S(1), "alpha1", p.alpha1, S(1), "<");
    if (p.method == Method::implicit) return both;
    return both &&
           Status<S>::require(h * p.lambda2 < p.lambda1, "lambda2 / lambda1 * dt / substeps", h * p.lambda2 / p.lambda1,
                              S(1), "<", unstable) &&
           Status<S>::require(h * p.lambda1 - h * h * p.lambda2 / S(2) < S(2),
                              "(lambda1 - lambda2 h / 2) h, h = dt / substeps",
                              h * p.lambda1 - h * h * p.lambda2 / S(2), S(2), "<", unstable);
  }

  FiniteTimeDisturbanceObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt),
        params_(params),
        J_inv_(setup.vehicle.J_B.inverse()),
        root_(dt_ * params.lambda1, dt_ * dt_ * params.lambda2, params.alpha1) {}

  /// First sample: the observer starts at the measured rate, with no torque.
  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    omega_ = y.omega_BN_B;
    h_w_B_ = y.axes.momentum_B(vehicle.D_B, y.h_w);
    z1_.setZero();
    eta_.setZero();
    theta_.setZero();
    return estimate(y);
  }

  /// Every later sample: over the interval just ended `last.u` was held.
  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    const Vec3<S> u_B = torque<S>(y.axes.of(vehicle.D_B), last.u);
    const Vec3<S> h_w_B = y.axes.momentum_B(vehicle.D_B, y.h_w);
    if (params_.method == Method::implicit) {
      implicit_step(vehicle, y.omega_BN_B, h_w_B, u_B);
    } else {
      explicit_steps(vehicle, y.omega_BN_B, h_w_B, u_B);
    }
    omega_ = y.omega_BN_B;
    h_w_B_ = h_w_B;
    return estimate(y);
  }

  /// Nothing is learned: z1 stays, what moves with w.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>&) noexcept {
    omega_ = y.omega_BN_B;
    h_w_B_ = y.axes.momentum_B(vehicle.D_B, y.h_w);
    return estimate(y);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { omega_ += step; }

  void telemetry(auto&& log) const {
    log("z1", z1_);
    log("eta", eta_);
    log("theta", theta_);
  }

 private:
  static Vec3<S> gyroscopic(const Vehicle<S>& vehicle, const Vec3<S>& omega, const Vec3<S>& h_w_B) noexcept {
    return omega.cross(vehicle.J_B * omega + h_w_B);
  }

  /// Backward Euler in z1 and eta, an axis at a time; the gyroscopic torque by the trapezoid of its ends. Written in z1, which
  /// keeps its digits when it is far smaller than the rate: what[k-1] = omega[k-1] - z1[k-1].
  void implicit_step(const Vehicle<S>& vehicle, const Vec3<S>& omega, const Vec3<S>& h_w_B,
                     const Vec3<S>& u_B) noexcept {
    const Vec3<S> gyro_B = S(0.5) * (gyroscopic(vehicle, omega_, h_w_B_) + gyroscopic(vehicle, omega, h_w_B));
    const Vec3<S> a = J_inv_ * (u_B - gyro_B);
    const Vec3<S> r = (omega - omega_) + z1_ - dt_ * (a + eta_);
    Vec3<S> acceleration;
    for (int i = 0; i < 3; ++i) {
      const typename ImplicitRoot<S>::Root root = root_(r[i]);
      z1_[i] = root.z;
      eta_[i] += dt_ * params_.lambda2 * root.sig_a2;
      acceleration[i] = params_.lambda1 * root.sig_a1 + eta_[i];
    }
    theta_ = vehicle.J_B * acceleration;
  }

  void explicit_steps(const Vehicle<S>& vehicle, const Vec3<S>& omega, const Vec3<S>& h_w_B,
                      const Vec3<S>& u_B) noexcept {
    const S alpha2 = S(2) * params_.alpha1 - S(1);
    const S h = dt_ / static_cast<S>(params_.substeps);
    const Vec3<S> domega = (omega - omega_) / static_cast<S>(params_.substeps);
    const Vec3<S> dh_w_B = (h_w_B - h_w_B_) / static_cast<S>(params_.substeps);
    for (int j = 0; j < params_.substeps; ++j) {
      const S at = static_cast<S>(j);
      const Vec3<S> a = J_inv_ * (u_B - gyroscopic(vehicle, omega_ + at * domega, h_w_B_ + at * dh_w_B));
      const Vec3<S> acceleration = params_.lambda1 * sig(z1_, params_.alpha1) + eta_;
      eta_ += h * params_.lambda2 * sig(z1_, alpha2);
      z1_ += domega - h * (a + acceleration);
    }
    theta_ = vehicle.J_B * (params_.lambda1 * sig(z1_, params_.alpha1) + eta_);
  }

  Estimate<S> estimate(const Measurement<S>& y) const noexcept {
    Estimate<S> x = Estimate<S>::healthy(y);
    x.d_B = theta_;
    return x;
  }

  S dt_;
  Params params_;
  Mat3<S> J_inv_;
  ImplicitRoot<S> root_;
  Vec3<S> omega_ = Vec3<S>::Zero();  ///< rad/s, at the previous sample
  Vec3<S> h_w_B_ = Vec3<S>::Zero();  ///< N m s, wheels at the previous sample
  Vec3<S> z1_ = Vec3<S>::Zero();     ///< rad/s
  Vec3<S> eta_ = Vec3<S>::Zero();    ///< rad/s^2
  Vec3<S> theta_ = Vec3<S>::Zero();  ///< N m
};

}  // namespace gyrostat
