// SPDX-License-Identifier: MIT
/// @file  Effectiveness of the actuators, torque of the wheels and disturbance in one Kalman filter, with a bound that holds.
///
///   J w' = -w x (J w + D h_w) + sum_i D_i del_i + d,   del_i = e_i u_i + b_i (wheel), e_i u_i (torquer)
///   h_i' = -del_i (wheels);   e, b, d: random walks;   x = [w, h, e, b, d], measured: w, h (of `momentum_delay` samples ago)
///
/// The rate is a state and is not differenced: one tuning holds from 1 ms to 0.1 s. What a wheel delivers is read from its
/// momentum, free of disturbance, inertia and gyro. A torquer has no b, which nothing could tell from d.
/// Page: docs/components/joint_kalman.md
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/observers/parts/covariance.hpp"
#include "gyrostat/flight/observers/parts/innovation_gate.hpp"
#include "gyrostat/flight/observers/parts/issued_effectiveness.hpp"
#include "gyrostat/flight/observers/parts/noise_meter.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/delay_line.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// 18 states for four wheels, 54 for sixteen, 22 for sixteen torquers; work and memory touched grow with their square.
template <class S>
class JointKalmanObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "joint_kalman";
  static constexpr Estimates estimates{.d_B = true, .effectiveness = true};
  static constexpr bool switching = true;  ///< openings, edges of e

  static constexpr int most_momentum_delay = 32;  ///< samples

  struct Params {
    S rate_noise;
    S momentum_noise;
    bool use_momentum = true;
    int momentum_delay = 0;
    S q_e = S(0.05);
    S q_b = S(0.01);
    S q_d = S(0.03);
    S restless = S(5);
    S inertia_error = S(0.2);
    S timing = S(0.5);
    S momentum_timing = S(0.02);
    S gate = S(30);
    S e_min = default_effectiveness_floor<S>;
    S unknown_above = S(0.5);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.rate_noise, Field{"rate_noise", "rad/s", 1e-12, 1e3,
                                "standard deviation of the rate at start; then it is measured, down to a fiftieth"});
      field(p.momentum_noise, Field{"momentum_noise", "N m s", 1e-12, 1e9, "likewise of a wheel's momentum"});
      field(p.use_momentum, Switch{"use_momentum", "read the momentum of wheels; else they are taken for torquers"});
      field(p.momentum_delay,
            Field{"momentum_delay", "samples", 0, most_momentum_delay, "age of the momentum that is shown"});
      field(p.q_e, Field{"q_e", "1/sqrt(s)", 0, 1e3, "random walk of the effectiveness"});
      field(p.q_b, Field{"q_b", "1/sqrt(s)", 0, 1e3, "of a wheel's own torque, share of its largest command"});
      field(p.q_d, Field{"q_d", "1/sqrt(s)", 0, 1e3, "of the disturbance, share of the usable torque"});
      field(p.restless,
            Field{"restless", "", 0, 1e6, "more q_e^2 an opening of the last minute: an intermittent fault"});
      field(p.inertia_error, Field{"inertia_error", "", 0, 10,
                                   "share of a step of the command that may appear as a disturbance: inertia off"});
      field(p.timing, Field{"timing", "samples", 0, 10, "how late a step of the command may appear in the rate"});
      field(p.momentum_timing,
            Field{"momentum_timing", "samples", 0, 10, "likewise in the momentum of a wheel, beside `momentum_delay`"});
      field(p.gate, Field{"gate", "", 0, 1e6, "squared innovation that noise does not explain: the covariance opens"});
      field(p.e_min, Field{"e_min", "", 0, 1,
                           "smallest estimate; no less than the e_min of the allocator, or it would stay there"});
      field(p.unknown_above, Field{"unknown_above", "", 1e-3, 1, "half-width from which the bound is infinite"});
    }

    /// Noise that a five-hundredth of the usable torque makes in a second, and a thousandth of the largest command.
    explicit Params(const Setup<S>& setup) noexcept {
      rate_noise = S(2e-3) * usable_acceleration(setup.vehicle);
      momentum_noise = S(1e-3) * largest_commands(setup.vehicle).maxCoeff();
    }
  };

  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.e_min; }

  /// No condition of stability: a Kalman filter is stable at every period.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    return needs_body_coordinates(setup) && Status<S>::require(p.gate > S(1), "gate", p.gate, S(1), ">") &&
           Status<S>::require(p.e_min > S(0), "e_min", p.e_min, S(0), ">") &&
           Status<S>::require(p.e_min < S(1), "e_min", p.e_min, S(1), "<");
  }

  JointKalmanObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params),
        wheels_(params.use_momentum ? setup.vehicle.wheels & Mask::all(setup.vehicle.actuators()) : Mask{}),
        dt_(setup.dt),
        usable_(usable_torque(setup.vehicle)),
        u_max_(largest_commands(setup.vehicle)),
        dt_J_inv_(setup.dt * setup.vehicle.J_B.inverse()),
        dt_J_inv_D_(dt_J_inv_.lazyProduct(setup.vehicle.D_B)),
        n_(setup.vehicle.actuators()),
        n_w_(members(wheels_)),
        P_(6 + n_ + 2 * n_w_),
        rate_meter_(params.rate_noise),
        momentum_meters_(filled<NoiseMeter<S>>(NoiseMeter<S>(params.momentum_noise))),
        past_u_(std::clamp(params.momentum_delay, 1, most_momentum_delay), VecN<S>::Zero(n_)) {
    begin();
  }

  /// First sample: healthy, and not known to be.
  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    begin();
    event_ = y.event;
    turn(y.axes);
    measure(y);
    remember(vehicle, y);
    return estimate(vehicle, y);
  }

  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    const bool sensible = credible(last.u), moved = y.event == event_ && sensible;
    turn(y.axes);
    const Mat3N<S>& D_B = y.axes.of(vehicle.D_B);
    VecN<S> du = VecN<S>::Zero(n_), shown_du = du;
    if (sensible) {
      const VecN<S> shown = params_.momentum_delay > 0 ? past_u_.oldest() : last.u;
      if (moved) du = last.u - u_, shown_du = shown - shown_u_;
      u_ = last.u;
      shown_u_ = shown;
      past_u_.push(last.u);
    }
    if (moved) {
      meter(D_B, y, du, shown_du);
      predict(vehicle, y);
    } else {  // no motion leads here
      rate_known_ = momentum_known_ = false;
      rates_ = momenta_ = 0;
    }
    age(D_B, du, shown_du);
    if (moved) open(D_B, y);
    measure(y);
    project();
    event_ = y.event;
    remember(vehicle, y);
    return estimate(vehicle, y);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept {
    x_.template head<3>() += step;
    omega_ += step;
    omega_1_ += step;
  }

  /// What was measured still teaches: a channel that was not is predicted, and measured again when it is back.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    return step(vehicle, y, last);
  }

  void telemetry(auto&& log) const {
    VecN<S> bias = VecN<S>::Zero(n_), sigma_h = VecN<S>::Zero(n_);
    for (int i = 0, k = 0; i < n_; ++i) {
      if (!wheels_.test(i)) continue;
      bias[i] = x_[b(k++)];
      sigma_h[i] = std::sqrt(momentum_variance(i));
    }
    log("bias", bias);
    log("disturbance_B", Vec3<S>(x_.template tail<3>()));
    log("sigma_omega", std::sqrt(rate_meter_.variance()));
    log("sigma_h", sigma_h);
    log(Counter{"openings"}, openings_);
  }

  static constexpr int most_states = 6 + 3 * max_actuators;
  using StateCovariance = Covariance<S, most_states>;
  using Vector = typename StateCovariance::Vector;

  /// [w, h, e, b, d]: rad/s, N m s a wheel, 1 an actuator, N m a wheel, N m.
  const Vector& state() const noexcept { return x_; }
  const StateCovariance& covariance() const noexcept { return P_; }
  /// (N m s)^2, as measured in flight, of wheel `i`.
  S momentum_variance(int i) const noexcept { return momentum_meters_[static_cast<std::size_t>(i)].variance(); }
  std::uint32_t openings() const noexcept { return openings_; }

 private:
  static constexpr int most_moving = 3 + max_actuators, most_driving = 3 + 2 * max_actuators;
  using Moving = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, most_moving, 1>;    ///< of w, h
  using Driving = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, most_driving, 1>;  ///< of e, b, d

  /// Largest command of each actuator, N m; where flight knows none, what makes the usable torque.
  static VecN<S> largest_commands(const Vehicle<S>& vehicle) noexcept {
    const S usable = usable_torque(vehicle);
    VecN<S> out(vehicle.actuators());
    for (int i = 0; i < vehicle.actuators(); ++i) {
      const S limit = std::max(std::abs(vehicle.u_lo[i]), std::abs(vehicle.u_up[i]));
      const S lever = vehicle.D_B.col(i).norm();
      out[i] = limit > S(0) && std::isfinite(limit) ? limit : usable / (lever > S(0) ? lever : S(1));
    }
    return out;
  }
  static int members(Mask mask) noexcept {
    int count = 0;
    for (int i = 0; i < max_actuators; ++i) count += mask.test(i) ? 1 : 0;
    return count;
  }
  template <class T>
  static std::array<T, max_actuators> filled(const T& value) noexcept {
    return [&]<std::size_t... i>(std::index_sequence<i...>) {
      return std::array<T, max_actuators>{((void)i, value)...};
    }(std::make_index_sequence<max_actuators>{});
  }
  static S square(S x) noexcept { return x * x; }

  int moving() const noexcept { return 3 + n_w_; }       ///< states that are measured
  int h(int wheel) const noexcept { return 3 + wheel; }  ///< of the wheels alone, in their order
  int e(int i) const noexcept { return moving() + i; }
  int b(int wheel) const noexcept { return moving() + n_ + wheel; }
  int d(int axis) const noexcept { return moving() + n_ + n_w_ + axis; }

  void begin() noexcept {
    x_.setZero(P_.size());
    P_.set_zero();
    for (int i = 0, k = 0; i < n_; ++i) {
      x_[e(i)] = S(1);
      P_.variance(e(i)) = square(S(0.3));
      if (wheels_.test(i)) P_.variance(b(k++)) = square(S(0.05) * u_max_[i]);
    }
    for (int axis = 0; axis < 3; ++axis) P_.variance(d(axis)) = square(S(0.05) * usable_);
    rate_meter_.start();
    rate_gate_.start();
    for (auto& meter : momentum_meters_) meter.start();
    for (auto& gate : momentum_gates_) gate.start();
    unrest_.setZero(n_);
    u_.setZero(n_);
    shown_u_ = u_;
    past_u_.fill(u_);
    rates_ = momenta_ = 0;
    rate_known_ = momentum_known_ = false;
    openings_ = 0;
  }

  /// A command a thousand times beyond sense says nothing about the motion.
  bool credible(const VecN<S>& u) const noexcept { return (u.array().abs() <= S(1e3) * u_max_.array()).all(); }

  /// What e, b and d in `v` do to w and h in the last interval: the upper right block of F, times v. A momentum shows what an
  /// older command did.
  template <class V>
  Moving driven(const Mat3N<S>& D_B, const V& v) const noexcept {
    Moving out(moving());
    Vec3<S> torque_B = v.template tail<3>();
    for (int i = 0, k = 0; i < n_; ++i) {
      S delivered = v[i] * u_[i];
      if (wheels_.test(i)) {
        delivered += v[n_ + k];
        out[h(k)] = -dt_ * (v[i] * shown_u_[i] + v[n_ + k]);
        ++k;
      }
      torque_B += D_B.col(i) * delivered;
    }
    out.template head<3>() = dt_J_inv_ * torque_B;
    return out;
  }

  /// Second differences less what the change of the command explains.
  void meter(const Mat3N<S>& D_B, const Measurement<S>& y, const VecN<S>& du, const VecN<S>& shown_du) noexcept {
    const VecN<S> change = x_.segment(e(0), n_).cwiseProduct(du);
    if (rates_ == 2 && y.rate_valid) {
      const Vec3<S> t = y.omega_BN_B - S(2) * omega_ + omega_1_ - dt_J_inv_ * torque<S>(D_B, change);
      rate_meter_.take(t.squaredNorm() / S(18));
    }
    if (momenta_ == 2 && y.momentum_valid) {
      for (int i = 0; i < n_; ++i) {
        if (!wheels_.test(i)) continue;
        const S t = y.h_w[i] - S(2) * h_w_[i] + h_w_1_[i] + dt_ * (x_[e(i)] * shown_du[i]);
        momentum_meters_[static_cast<std::size_t>(i)].take(t * t / S(6));
      }
    }
  }

  /// x and P over the interval. P_ms: motion against e, b, d. With A of `driven`, P_ms += A P_ss, P_mm += A H + H' A',
  /// H = P_sm + P_ss A' / 2: only what F moves is touched.
  void predict(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    const int m = moving(), s = P_.size() - m;
    const Mat3N<S>& D_B = y.axes.of(vehicle.D_B);
    x_.head(m) += driven(D_B, x_.tail(s));
    x_.template head<3>() -=
        S(0.5) * (dt_J_inv_ * (gyroscopic(vehicle.J_B, omega_, h_B_) +
                               gyroscopic(vehicle.J_B, y.omega_BN_B, y.axes.momentum_B(vehicle.D_B, y.h_w))));

    const Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, most_driving, most_driving> P_ss =
        P_.lower().bottomRightCorner(s, s).template selfadjointView<Eigen::Lower>();
    Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, most_driving, most_moving> step(s, m);  // P_ss A'
    Eigen::Matrix<S, Eigen::Dynamic, 3, 0, most_driving, 3> torque_B = P_ss.template rightCols<3>();
    for (int i = 0, k = 0; i < n_; ++i) {
      Driving delivered = u_[i] * P_ss.col(i);
      if (wheels_.test(i)) {
        delivered += P_ss.col(n_ + k);
        step.col(h(k)) = -dt_ * (shown_u_[i] * P_ss.col(i) + P_ss.col(n_ + k));
        ++k;
      }
      for (int axis = 0; axis < 3; ++axis) torque_B.col(axis) += D_B(axis, i) * delivered;
    }
    step.template leftCols<3>() = torque_B.lazyProduct(dt_J_inv_.transpose());
    for (int c = 0; c < m; ++c) {
      const Driving half = P_.lower().col(c).tail(s) + S(0.5) * step.col(c);
      const Moving moved = driven(D_B, half);
      for (int r = 0; r < m; ++r) P_.lower()(std::max(r, c), std::min(r, c)) += r == c ? S(2) * moved[r] : moved[r];
    }
    P_.lower().block(m, 0, s, m) += step;
  }

  static Vec3<S> gyroscopic(const Mat3<S>& J_B, const Vec3<S>& omega, const Vec3<S>& h_B) noexcept {
    return omega.cross(J_B * omega + h_B);
  }

  void turn(const Axes<S>& axes) noexcept {
    if (axes.move()) dt_J_inv_D_ = dt_J_inv_.lazyProduct(axes.D_B);
  }

  /// Process noise. A step of the command appears a little late in the rate, and as a torque where the inertia is off.
  void age(const Mat3N<S>& D_B, const VecN<S>& du, const VecN<S>& shown_du) noexcept {
    Vec3<S> step_B = Vec3<S>::Zero();
    for (int i = 0, k = 0; i < n_; ++i) {
      unrest_[i] /= S(1) + dt_ / S(60);
      widen_effectiveness(i, square(params_.q_e) * (S(1) + params_.restless * unrest_[i]) * dt_);
      if (wheels_.test(i)) {
        P_.variance(h(k)) += square(params_.momentum_timing * dt_ * shown_du[i]);
        P_.variance(b(k++)) += square(params_.q_b * u_max_[i]) * dt_;
      }
      for (int axis = 0; axis < 3; ++axis) P_.variance(axis) += square(params_.timing * dt_J_inv_D_(axis, i) * du[i]);
      step_B += D_B.col(i) * (x_[e(i)] * du[i]);
    }
    for (int axis = 0; axis < 3; ++axis)
      P_.variance(d(axis)) += square(params_.q_d * usable_) * dt_ + square(params_.inertia_error * step_B[axis]);
  }

  /// Variance that is still to be had: 1 is anything between dead and healthy.
  S room(int i, S wanted) const noexcept { return std::clamp(S(1) - P_.variance(e(i)), S(0), wanted); }
  void widen_effectiveness(int i, S growth) noexcept { P_.variance(e(i)) += room(i, growth); }

  /// Innovations that noise does not explain: something changed, and what may have is uncertain again.
  void open(const Mat3N<S>& D_B, const Measurement<S>& y) noexcept {
    bool body = false;
    Mask wheels;
    if (rate_known_ && y.rate_valid) {
      Mat3<S> spread = P_.lower().template topLeftCorner<3, 3>();
      spread.diagonal().array() += rate_meter_.variance();
      const Eigen::LLT<Mat3<S>> root(spread);
      body = rate_gate_.exceeded(root.matrixL().solve(y.omega_BN_B - x_.template head<3>()), params_.gate);
    }
    if (momentum_known_ && y.momentum_valid) {
      for (int i = 0, k = 0; i < n_; ++i) {
        if (!wheels_.test(i)) continue;
        const S spread = P_.variance(h(k)) + momentum_variance(i);
        const Eigen::Matrix<S, 1, 1> z((y.h_w[i] - x_[h(k++)]) / std::sqrt(spread));
        wheels.set(i, momentum_gates_[static_cast<std::size_t>(i)].exceeded(z, params_.gate));
      }
    }
    for (int axis = 0; body && axis < 3; ++axis) open(D_B, d(axis), square(S(0.2) * usable_));
    for (int i = 0, k = 0; i < n_; ++i) {
      const bool wheel = wheels_.test(i);
      if (wheel ? wheels.test(i) : body && std::abs(u_[i]) > S(0.02) * u_max_[i]) {
        unrest_[i] += wheel ? S(1) : S(0.3);  // the body names no torquer
        open(D_B, e(i), room(i, square(S(0.5))));
        if (wheel) open(D_B, b(k), square(S(0.3) * u_max_[i]));
      }
      k += wheel ? 1 : 0;
    }
    openings_ += body || wheels.any() ? 1u : 0u;
  }

  /// Variance `v` more of a state, as if it had been there before the interval.
  void open(const Mat3N<S>& D_B, int state, S v) noexcept {
    Vector column = Vector::Zero(P_.size());
    column[state] = S(1);
    column.head(moving()) = driven(D_B, column.tail(P_.size() - moving()));
    P_.widen(column, v);
  }

  /// A channel whose prediction is lost, or was never there, is taken as it is.
  void measure(const Measurement<S>& y) noexcept {
    if (!y.momentum_valid && momentum_is_lost()) momentum_known_ = false;
    for (int i = 0, k = 0; i < n_; ++i) {
      if (wheels_.test(i)) measure(h(k++), y.h_w[i], momentum_variance(i), momentum_known_, y.momentum_valid);
    }
    momentum_known_ = momentum_known_ || y.momentum_valid;
    if (!y.rate_valid && is_lost(0, rate_meter_.variance())) rate_known_ = false;
    for (int axis = 0; axis < 3; ++axis)
      measure(axis, y.omega_BN_B[axis], rate_meter_.variance(), rate_known_, y.rate_valid);
    rate_known_ = rate_known_ || y.rate_valid;
    keep_positive();
  }
  void measure(int state, S y, S R, bool known, bool valid) noexcept {
    if (!known) {
      x_[state] = y;
      P_.renew(state, R);
    } else if (valid) {
      const S innovation = y - x_[state];
      x_ += innovation * P_.measure(state, R);
    }
  }
  /// More than a thousand sigma wide: the next measurement says all, and float could not weigh the two.
  bool is_lost(int state, S R) const noexcept { return P_.variance(state) > S(1e6) * R; }
  bool momentum_is_lost() const noexcept {
    bool lost = false;
    for (int i = 0, k = 0; i < n_; ++i)
      if (wheels_.test(i)) lost = is_lost(h(k++), momentum_variance(i)) || lost;
    return lost;
  }

  void keep_positive() noexcept {
    const auto at_least = [&](int state, S v) { P_.variance(state) = std::max(P_.variance(state), v); };
    const S torque = S(1e-8) * square(usable_);
    for (int axis = 0; axis < 3; ++axis) at_least(axis, S(1e-6) * rate_meter_.variance());
    for (int i = 0, k = 0; i < n_; ++i) {
      at_least(e(i), S(1e-8));
      if (!wheels_.test(i)) continue;
      at_least(h(k), S(1e-6) * momentum_variance(i));
      at_least(b(k++), torque);
    }
    for (int axis = 0; axis < 3; ++axis) at_least(d(axis), torque);
  }

  /// e inside [0, 1.05], and what goes with it along the covariance; then once more, for what that moved.
  void project() noexcept {
    constexpr S top = S(1.05);
    for (int i = 0; i < n_; ++i) {
      const S before = x_[e(i)], inside = std::clamp(before, S(0), top);
      if (inside != before) x_ += (inside - before) / P_.variance(e(i)) * P_.column(e(i));
    }
    for (int i = 0, k = 0; i < n_; ++i) {
      x_[e(i)] = std::clamp(x_[e(i)], S(0), top);
      if (!wheels_.test(i)) continue;
      x_[b(k)] = std::clamp(x_[b(k)], S(-2) * u_max_[i], S(2) * u_max_[i]);
      ++k;
    }
    for (int axis = 0; axis < 3; ++axis) x_[d(axis)] = std::clamp(x_[d(axis)], S(-10) * usable_, S(10) * usable_);
  }

  void remember(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    omega_1_ = omega_;
    h_w_1_ = h_w_;
    omega_ = y.omega_BN_B;
    h_w_ = y.h_w;
    h_B_ = y.axes.momentum_B(vehicle.D_B, y.h_w);
    rates_ = y.rate_valid ? std::min(rates_ + 1, 2) : 0;
    momenta_ = y.momentum_valid ? std::min(momenta_ + 1, 2) : 0;
  }

  /// The effectiveness that is issued, and in d_B all that it leaves over.
  Estimate<S> estimate(const Vehicle<S>& vehicle, const Measurement<S>& y) const noexcept {
    Estimate<S> out = Estimate<S>::healthy(y);
    const Mat3N<S>& D_B = y.axes.of(vehicle.D_B);
    out.d_B = x_.template tail<3>();
    issue_effectiveness<S>(out, x_.segment(e(0), n_), params_.e_min, S(1), D_B, u_);
    for (int i = 0, k = 0; i < n_; ++i) {
      const bool wheel = wheels_.test(i);
      const S issued = out.effectiveness[i];
      if (wheel) out.d_B += D_B.col(i) * x_[b(k++)];
      const S spread = S(2.5) * std::sqrt(P_.variance(e(i)));
      const S half = wheel ? spread + S(0.005) : S(1.6) * spread + params_.inertia_error * issued;
      if (half <= params_.unknown_above) out.effectiveness_bound[i] = half / issued;
    }
    return out;
  }

  Params params_;
  Mask wheels_;  ///< whose momentum is read
  S dt_;
  S usable_;       ///< N m
  VecN<S> u_max_;  ///< N m
  Mat3<S> dt_J_inv_;
  Mat3N<S> dt_J_inv_D_;
  int n_, n_w_;

  Vector x_;
  StateCovariance P_;
  NoiseMeter<S> rate_meter_;
  std::array<NoiseMeter<S>, max_actuators> momentum_meters_;
  InnovationGate<S, 3> rate_gate_;
  std::array<InnovationGate<S, 1>, max_actuators> momentum_gates_;
  VecN<S> unrest_;  ///< openings of each actuator, forgotten within a minute

  Vec3<S> omega_ = Vec3<S>::Zero(), omega_1_ = Vec3<S>::Zero();  ///< as measured at the last two samples
  VecN<S> h_w_, h_w_1_;
  Vec3<S> h_B_ = Vec3<S>::Zero();  ///< N m s, stored at the last sample
  VecN<S> u_;                      ///< of the last interval with a command that was no nonsense
  VecN<S> shown_u_;                ///< whose doing the momentum shows: `momentum_delay` samples older
  DelayLine<VecN<S>, most_momentum_delay> past_u_;
  int rates_ = 0, momenta_ = 0;                       ///< measured in a row, up to two
  bool rate_known_ = false, momentum_known_ = false;  ///< the prediction is worth comparing
  std::uint32_t event_ = 0, openings_ = 0;
};

}  // namespace gyrostat
