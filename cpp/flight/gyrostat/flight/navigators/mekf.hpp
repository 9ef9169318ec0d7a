// SPDX-License-Identifier: MIT
/// @file  Multiplicative extended Kalman filter: attitude and gyro bias from a gyro and a star tracker that is slower and late,
///        and from directions to the sun and of the magnetic field.
///
///     q_true = q (x) quat_exp(a),  b_true = b + beta,   a' = -omega x a - beta - n_v,  beta' = n_u
///     y_gyro = omega + b + noise,  q_tracker = q_true (x) quat_exp(C_SB' noise),  b_seen = C_BN n + noise
///
/// It is kinematic: no torque and no inertia stand in it, so that a fault torque is not taken for a bias. It lives `latency` samples
/// ago, where the tracker's fix belongs, and is predicted to now by the gyro samples in between, which is exact for any latency.
/// Sources: Lefferts, Markley, Shuster 1982; Farrenkopf 1978 for its steady state. Page: docs/components/mekf.md
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/navigators/parts/vector_attitude.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// What became of the attitude measurement of a sample.
enum class Fix : std::int8_t { not_started = -1, none = 0, first = 1, used = 2, rejected = 3, restarted = 4 };

template <class S>
class Mekf {
 public:
  using Scalar = S;
  static constexpr const char* name = "mekf";
  static constexpr bool axiswise = false;
  static constexpr int max_latency = 64;  ///< samples
  using Covariance = Eigen::Matrix<S, 6, 6>;
  enum class Acquisition : std::uint8_t { quest, triad };

  struct Params {
    S angle_random_walk = S(1e-5);
    S rate_random_walk = S(1e-8);
    Vec3<S> attitude_noise{S(2e-5), S(2e-5), S(1.2e-4)};
    Quat<S> q_BS = Quat<S>::Identity();
    int latency = 0;
    int gyro_every = 1;
    S bias0 = S(2e-3);
    S gate = S(25);
    int recover = 5;
    S attitude0 = S(0);
    S sun_noise = S(0);
    S field_noise = S(0);
    Acquisition acquisition = Acquisition::quest;

    explicit Params(const Setup<S>&) noexcept {}

    static constexpr void describe(auto& p, auto&& field) {
      field(p.angle_random_walk,
            Field{"angle_random_walk", "rad/sqrt(s)", 1e-15, 1, "of the gyro: its noise a sample times sqrt(dt)"});
      field(p.rate_random_walk, Field{"rate_random_walk", "rad/s^1.5", 1e-15, 1,
                                      "of the gyro's bias; at zero the filter would stop listening"});
      field(p.attitude_noise, Field{"attitude_noise", "rad", 1e-12, 1,
                                    "of the tracker, one sigma across (x, y) and about (z) its boresight"});
      field(p.q_BS, Field{"q_BS", "", -1.1, 1.1, "mounting of the tracker, boresight z; scalar first"});
      field(p.latency, Field{"latency", "samples", 0, max_latency, "age of what the tracker shows"});
      field(p.gyro_every, Field{"gyro_every", "samples", 1, 1000, "from one rate of the gyro to the next"});
      field(p.bias0, Field{"bias0", "rad/s", 1e-12, 1, "one sigma of the bias at turn-on"});
      field(p.gate,
            Field{"gate", "", 1, 1e6, "of the normalised innovation (chi square, 3): beyond it a fix is rejected"});
      field(p.recover, Field{"recover", "fixes", 1, 1000,
                             "rejected fixes in a row, agreeing with each other, that start it again"});
      field(p.attitude0,
            Field{"attitude0", "rad", 0, 4, "one sigma of a coarse first attitude; 0: the noise of what gave it"});
      field(p.sun_noise,
            Field{"sun_noise", "rad", 0, 1, "of the sun sensor, one sigma an axis; 0: the sun is not used"});
      field(p.field_noise,
            Field{"field_noise", "T", 0, 1e-3,
                  "of the magnetometer, one sigma an axis, with what the model of the field lacks; 0: the "
                  "field is not used"});
      field(p.acquisition,
            Choice{"acquisition", "quest|triad", "how sun and field make a first attitude where no tracker has"});
    }
  };

  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S off = std::abs(p.q_BS.norm() - S(1));
    return needs_body_coordinates(setup) && Status<S>::require(off < S(1e-3), "| |q_BS| - 1 |", off, S(1e-3));
  }

  Mekf(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params),
        h_(setup.dt),
        unknown_(usable_acceleration(setup.vehicle) * setup.dt * setup.dt / S(2)),
        C_SB_(dcm(params.q_BS)),
        delay_(std::clamp(params.latency, 0, max_latency)) {}

  /// First sample: the gyro is taken to have shown this all the time.
  [[nodiscard]] Measurement<S> start(const Vehicle<S>&, const Measurement<S>& y) noexcept {
    const Rate first{y.rate_valid ? y.omega_BN_B : Vec3<S>(Vec3<S>::Zero()), y.rate_valid ? 0 : 1};
    ring_.fill(first);
    newest_ = 0;
    started_ = false;
    b_.setZero();
    P_.setZero();
    rejected_in_a_row_ = vectors_rejected_in_a_row_ = 0;
    q_out_ = y.attitude_valid ? y.q_NB : Quat<S>::Identity();
    return filtered(y);
  }

  [[nodiscard]] Measurement<S> step(const Vehicle<S>&, const Measurement<S>& y) noexcept {
    Rate now = at(0);
    now = y.rate_valid ? Rate{y.omega_BN_B, 0} : Rate{now.omega, now.missing + 1};
    newest_ = (newest_ + 1) % size();
    ring_[static_cast<std::size_t>(newest_)] = now;
    if (started_) propagate();
    return filtered(y);
  }

  const Vec3<S>& bias() const noexcept { return b_; }  ///< rad/s
  S nis() const noexcept { return nis_; }  ///< normalised innovation squared of the last fix that was judged
  Fix fix() const noexcept { return fix_; }
  int vectors() const noexcept { return vectors_; }  ///< directions that were used at this sample
  /// Of (a, beta) as handed out now, rad and rad/s.
  Covariance covariance() const noexcept {
    if (!started_) return Covariance::Zero();
    Quat<S> turn = Quat<S>::Identity();
    S lost = S(0);
    for (int age = delay_ - 1; age >= 0; --age) {
      turn = turn * quat_exp(turned(at(age + 1), at(age)));
      lost += lost_variance(at(age).missing);
    }
    Covariance P = P_;
    if (delay_ > 0) move(P, quat_log(turn), static_cast<S>(delay_) * h_);
    P.template topLeftCorner<3, 3>().diagonal().array() += lost;
    return P;
  }

  void telemetry(auto&& log) const {
    const Covariance P = covariance();
    log("bias", b_);
    log("attitude_sigma", Vec3<S>(P.diagonal().template head<3>().cwiseSqrt()));
    log("bias_sigma", Vec3<S>(P.diagonal().template tail<3>().cwiseSqrt()));
    log("nis", nis_);
    log("fix", static_cast<S>(fix_));
    log("vectors", static_cast<S>(vectors_));
    log(Counter{"rejected"}, rejected_);
    log(Counter{"vectors_rejected"}, vectors_rejected_);
    log(Counter{"restarts"}, restarts_);
  }

 private:
  using Row = Eigen::Matrix<S, 6, 1>;

  /// A gyro sample; `missing` counts the samples since it was fresh.
  struct Rate {
    Vec3<S> omega = Vec3<S>::Zero();
    int missing = 0;
  };

  int size() const noexcept { return delay_ + 2; }
  /// The gyro sample of `age` samples ago.
  const Rate& at(int age) const noexcept { return ring_[static_cast<std::size_t>((newest_ - age + size()) % size())]; }

  /// Rotation from one sample to the next, by the trapezoid: a body that accelerates would else look like a bias. Where a slower gyro
  /// shows a new rate, the samples that held the one before get theirs: their trapezoid spans all of them.
  Vec3<S> turned(const Rate& from, const Rate& to) const noexcept {
    const S held = static_cast<S>(std::min(from.missing, params_.gyro_every - 1));
    return h_ * (S(0.5) * (from.omega + to.omega) - b_) + S(0.5) * h_ * held * (to.omega - from.omega);
  }

  /// rad^2 an axis, that an unknown acceleration adds over a sample without a gyro.
  S lost_variance(int missing) const noexcept {
    const int m = missing - (params_.gyro_every - 1);
    if (m <= 0) return S(0);
    const S now = static_cast<S>(m) * static_cast<S>(m), before = static_cast<S>(m - 1) * static_cast<S>(m - 1);
    return unknown_ * unknown_ * (now * now - before * before);
  }

  /// Right Jacobian of the exponential map.
  static Mat3<S> right_jacobian(const Vec3<S>& f) noexcept {
    const S square = f.squaredNorm(), n = std::sqrt(square);
    const bool small = n < S(1e-2);
    const S first = small ? S(0.5) - square / S(24) : (S(1) - std::cos(n)) / square;
    const S second = small ? S(1) / S(6) - square / S(120) : (n - std::sin(n)) / (square * n);
    const Mat3<S> X = cross_matrix(f);
    return Mat3<S>::Identity() - first * X + second * X * X;
  }

  /// P = Phi P Phi' + Q over a rotation f that took `time`.
  void move(Covariance& P, const Vec3<S>& f, S time) const noexcept {
    const Mat3<S> F = dcm(quat_exp(f)), G = -time * right_jacobian(f);
    const Mat3<S> A = P.template topLeftCorner<3, 3>(), B = P.template topRightCorner<3, 3>(),
                  C = P.template bottomRightCorner<3, 3>();
    const Mat3<S> mixed = F * B * G.transpose();
    const S v = params_.angle_random_walk * params_.angle_random_walk,
            u = params_.rate_random_walk * params_.rate_random_walk;
    Mat3<S> A_next = F * A * F.transpose() + mixed + mixed.transpose() + G * C * G.transpose();
    Mat3<S> B_next = F * B + G * C;
    A_next.diagonal().array() += v * time + u * time * time * time / S(3);
    B_next.diagonal().array() -= u * time * time / S(2);
    P.template topLeftCorner<3, 3>() = S(0.5) * (A_next + A_next.transpose());
    P.template topRightCorner<3, 3>() = B_next;
    P.template bottomLeftCorner<3, 3>() = B_next.transpose();
    P.template bottomRightCorner<3, 3>().diagonal().array() += u * time;
  }

  void propagate() noexcept {
    const Vec3<S> f = turned(at(delay_ + 1), at(delay_));
    const Quat<S> turn = quat_exp(f);
    q_ = (q_ * turn).normalized();
    move(P_, f, h_);
    P_.template topLeftCorner<3, 3>().diagonal().array() += lost_variance(at(delay_).missing);
    doubted_ = dcm(turn) * doubted_;
    doubt_age_ += h_;
  }

  Measurement<S> filtered(Measurement<S> y) noexcept {
    const Vec3<S> b_before = b_;
    fix_ = started_ ? Fix::none : Fix::not_started;
    if (y.attitude_valid) listen(y.q_NB.normalized());
    look(y);
    y.attitude_valid = started_;
    if (!started_) return y;
    Quat<S> q = q_ * turn_to_now();
    q.normalize();
    if (q.dot(q_out_) < S(0)) q.coeffs() = -q.coeffs();
    q_out_ = y.q_NB = q;
    y.omega_BN_B = at(0).omega - b_;
    y.rate_step = b_before - b_;
    return y;
  }

  void listen(const Quat<S>& q_measured) noexcept {
    if (!started_) {
      begin(q_measured);
      fix_ = Fix::first;
      return;
    }
    const Vec3<S> nu = quat_log(q_.conjugate() * q_measured);
    Covariance P = P_;
    Row x = Row::Zero();
    nis_ = S(0);
    for (int i = 0; i < 3; ++i) {
      Row c = Row::Zero();
      c.template head<3>() = C_SB_.row(i).transpose();
      take(c, c.template head<3>().dot(nu), params_.attitude_noise[i] * params_.attitude_noise[i], x, P, nis_);
    }
    if (nis_ <= params_.gate) {
      correct(x, P);
      rejected_in_a_row_ = vectors_rejected_in_a_row_ = 0;
      fix_ = Fix::used;
      return;
    }
    ++rejected_;
    fix_ = Fix::rejected;
    doubt(nu, q_measured);
  }

  /// A scalar update in Joseph's form: `measured` = c . (a, beta) + noise of variance r. The attitude's reset needs no Jacobian: the
  /// tracker's noise is given in the axes after it.
  static void take(const Row& c, S measured, S r, Row& x, Covariance& P, S& nis) noexcept {
    const Row p = P * c;
    const S variance = c.dot(p) + r;
    const Row K = p / variance;
    const S e = measured - c.dot(x);
    nis += e * e / variance;
    x += K * e;
    P -= K * p.transpose();
    const Row left = P * c;
    P += r * K * K.transpose() - left * K.transpose();
    P = (S(0.5) * (P + P.transpose())).eval();
  }

  void correct(const Row& x, const Covariance& P) noexcept {
    P_ = P;
    q_ = (q_ * quat_exp(Vec3<S>(x.template head<3>()))).normalized();
    b_ += x.template tail<3>();
  }

  /// Rotation from where the filter lives to now.
  Quat<S> turn_to_now() const noexcept {
    Quat<S> turn = Quat<S>::Identity();
    for (int age = delay_ - 1; age >= 0; --age) turn = turn * quat_exp(turned(at(age + 1), at(age)));
    return turn;
  }

  /// Sun and field of this sample, the less noisy first.
  void look(const Measurement<S>& y) noexcept {
    vectors_ = 0;
    std::array<Sighting<S>, 2> seen;
    std::size_t count = 0;
    const auto add = [&](bool valid, const Vec3<S>& seen_B, const Vec3<S>& known_N, S sigma) {
      if (!valid || !(sigma > S(0)) || !(seen_B.norm() > S(0)) || !(known_N.norm() > S(0))) return;
      seen[count++] = {seen_B.normalized(), known_N.normalized(), sigma};
    };
    add(y.sun_valid, y.sun_B, y.sun_N, params_.sun_noise);
    const S field = y.field_N.norm();
    add(y.field_valid, y.field_B, y.field_N, field > S(0) ? params_.field_noise / field : S(0));
    if (count == 2 && seen[1].sigma < seen[0].sigma) std::swap(seen[0], seen[1]);
    const bool both = count == 2 && name_an_attitude(seen[0], seen[1]);
    if (!started_) {
      if (both) acquire(seen, Vec3<S>::Zero(), Fix::first);
      return;
    }
    if (fix_ == Fix::first || fix_ == Fix::restarted) return;
    for (std::size_t i = 0; i < count; ++i) sight(seen[i]);
    if (!both || vectors_rejected_in_a_row_ < params_.recover) return;
    acquire(seen, b_, Fix::restarted);
    ++restarts_;
  }

  /// A first attitude from two directions of now, carried back to where the filter lives.
  void acquire(const std::array<Sighting<S>, 2>& seen, Vec3<S> bias, Fix how) noexcept {
    const bool best = params_.acquisition == Acquisition::quest;
    const Quat<S> q_now = best ? quest(seen) : triad(seen[0], seen[1]);
    Mat3<S> P_now = best ? quest_covariance(seen) : triad_covariance(seen[0], seen[1]);
    if (params_.attitude0 > S(0)) P_now = params_.attitude0 * params_.attitude0 * Mat3<S>::Identity();
    b_ = bias;
    const Quat<S> turn = turn_to_now();
    const Motion m = motion(turn);
    const S v = params_.bias0 * params_.bias0;
    begin((q_now * turn.conjugate()).normalized());
    b_ = bias;
    const Mat3<S> back = m.F.transpose(), mixed = -v * back * m.G;
    P_.template topLeftCorner<3, 3>() = back * (P_now + v * m.G * m.G.transpose()) * m.F;
    P_.template topRightCorner<3, 3>() = mixed;
    P_.template bottomLeftCorner<3, 3>() = mixed.transpose();
    fix_ = how;
    vectors_ = 2;
  }

  /// How an error at the filter's time shows now: F a + G beta.
  struct Motion {
    Mat3<S> F = Mat3<S>::Identity(), G = Mat3<S>::Zero();
  };
  Motion motion(const Quat<S>& turn) const noexcept {
    if (delay_ == 0) return {};
    return {dcm(turn), -static_cast<S>(delay_) * h_ * right_jacobian(quat_log(turn))};
  }

  /// A direction as three scalar updates: seen - C n = (C n) x a + noise. That the gyro's noise since the filter's time is in it and
  /// comes once more with the next samples is neglected: it is far below that of a sensor of directions.
  void sight(const Sighting<S>& s) noexcept {
    const Quat<S> turn = turn_to_now();
    const Motion m = motion(turn);
    const Vec3<S> expected = dcm(Quat<S>(q_ * turn)) * s.known_N, nu = s.seen_B - expected;
    const Mat3<S> X = cross_matrix(expected);
    Eigen::Matrix<S, 3, 6> H;
    H << X * m.F, X * m.G;
    const S drift = params_.angle_random_walk * params_.angle_random_walk * static_cast<S>(delay_) * h_;
    Covariance P = P_;
    Row x = Row::Zero();
    S nis = S(0);
    for (int i = 0; i < 3; ++i) take(H.row(i).transpose(), nu[i], s.sigma * s.sigma + drift, x, P, nis);
    if (nis <= params_.gate) {
      correct(x, P);
      ++vectors_;
      vectors_rejected_in_a_row_ = 0;
      return;
    }
    ++vectors_rejected_;
    ++vectors_rejected_in_a_row_;
  }

  /// A rejected fix; as many as `recover` in a row that agree with each other are right, and the filter is not.
  void doubt(const Vec3<S>& nu, const Quat<S>& q_measured) noexcept {
    const Vec3<S> apart = C_SB_ * (nu - doubted_);
    const S drift = params_.bias0 * doubt_age_;
    S distance = S(0);
    for (int i = 0; i < 3; ++i) {
      const S sigma = params_.attitude_noise[i];
      distance += apart[i] * apart[i] / (S(2) * sigma * sigma + drift * drift);
    }
    rejected_in_a_row_ = rejected_in_a_row_ > 0 && distance <= params_.gate ? rejected_in_a_row_ + 1 : 1;
    doubted_ = nu;
    doubt_age_ = S(0);
    if (rejected_in_a_row_ < params_.recover) return;
    const Vec3<S> b = b_;
    begin(q_measured);
    b_ = b;
    fix_ = Fix::restarted;
    ++restarts_;
  }

  void begin(const Quat<S>& q_measured) noexcept {
    q_ = q_measured;
    b_.setZero();
    P_.setZero();
    Mat3<S> R = params_.attitude0 * params_.attitude0 * Mat3<S>::Identity();
    if (!(params_.attitude0 > S(0))) R = C_SB_.transpose() * params_.attitude_noise.cwiseAbs2().asDiagonal() * C_SB_;
    P_.template topLeftCorner<3, 3>() = R;
    P_.template bottomRightCorner<3, 3>().diagonal().setConstant(params_.bias0 * params_.bias0);
    rejected_in_a_row_ = vectors_rejected_in_a_row_ = 0;
    started_ = true;
  }

  Params params_;
  S h_;
  S unknown_;  ///< rad, that an unknown acceleration turns the body in a sample
  Mat3<S> C_SB_;
  int delay_;

  std::array<Rate, max_latency + 2> ring_{};
  int newest_ = 0;
  bool started_ = false;
  Quat<S> q_ = Quat<S>::Identity(), q_out_ = Quat<S>::Identity();  ///< `delay_` samples ago; handed out last
  Vec3<S> b_ = Vec3<S>::Zero();
  Covariance P_ = Covariance::Zero();
  S nis_ = S(0);
  Fix fix_ = Fix::not_started;
  Vec3<S> doubted_ = Vec3<S>::Zero();  ///< rad, innovation of the last rejected fix, turned with the body
  S doubt_age_ = S(0);                 ///< s
  int rejected_in_a_row_ = 0, vectors_rejected_in_a_row_ = 0;
  int vectors_ = 0;
  std::uint32_t rejected_ = 0, vectors_rejected_ = 0, restarts_ = 0;
};

}  // namespace gyrostat
