// SPDX-License-Identifier: MIT
#include "gyrostat/flight/observers/joint_kalman.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <type_traits>
#include <vector>

#include "../algebra.hpp"
#include "../random.hpp"
#include "alone.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_joint_kalman {
namespace {

/// Rigid body with wheels or torquers, one RK4 step a sample; an actuator delivers effectiveness * u + bias.
struct Plant {
  Vehicle<double> vehicle;
  double dt;
  Vec3<double> omega = Vec3<double>::Zero(), d_B = Vec3<double>::Zero();
  VecN<double> h, effectiveness, bias;

  explicit Plant(const Setup<double>& setup)
      : vehicle(setup.vehicle),
        dt(setup.dt),
        h(VecN<double>::Zero(vehicle.actuators())),
        effectiveness(VecN<double>::Ones(vehicle.actuators())),
        bias(VecN<double>::Zero(vehicle.actuators())) {}

  VecN<double> delivered(const VecN<double>& u) const { return effectiveness.cwiseProduct(u) + bias; }

  void advance(const VecN<double>& u) {
    const VecN<double> del = delivered(u);
    VecN<double> slope = -del;
    for (int i = 0; i < vehicle.actuators(); ++i)
      if (!vehicle.wheels.test(i)) slope[i] = 0;
    const auto rate = [&](const Vec3<double>& w, double t) -> Vec3<double> {
      const Vec3<double> momentum = vehicle.J_B * w + vehicle.D_B * (h + t * slope);
      return vehicle.J_B.inverse() * (vehicle.D_B * del + d_B - w.cross(momentum));
    };
    const Vec3<double> k1 = rate(omega, 0), k2 = rate(omega + dt / 2 * k1, dt / 2);
    const Vec3<double> k3 = rate(omega + dt / 2 * k2, dt / 2), k4 = rate(omega + dt * k3, dt);
    omega += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    h += dt * slope;
  }

  /// With white noise on rate and wheel momentum.
  template <class S>
  Measurement<S> measured(Tick tick, Random& random, double rate_noise, double momentum_noise) const {
    const auto white = [&](double sigma) {  // twelve uniforms: variance one
      double sum = 0;
      for (int i = 0; i < 12; ++i) sum += random.uniform(-0.5, 0.5);
      return sigma * sum;
    };
    Measurement<S> y;
    y.tick = tick;
    Vec3<double> w = omega;
    for (int a = 0; a < 3; ++a) w[a] += white(rate_noise);
    VecN<double> h_w = h;
    for (int i = 0; i < vehicle.actuators(); ++i)
      if (vehicle.wheels.test(i)) h_w[i] += white(momentum_noise);
    y.omega_BN_B = w.cast<S>();
    y.h_w = h_w.cast<S>();
    return y;
  }
};

template <class S>
Setup<S> wheels_of(Setup<S> setup, Mask wheels) {
  setup.vehicle.wheels = wheels;
  return setup;
}

/// FTC-4RW at 10 Hz, its actuators wheels.
template <class S>
Setup<S> four_wheels() {
  return wheels_of(vehicle_with<S>(satellite_inertia<S>(), pyramid<S>(), S(0.2), S(0.1)), Mask::all(4));
}

/// The same body with three wheels along the axes and two skew torquers.
Setup<double> mixed() {
  Mat3N<double> D(3, 5);
  D << 1, 0, 0, 0.6, -0.5, 0, 1, 0, 0.64, 0.5, 0, 0, 1, 0.48, std::sqrt(0.5);
  return wheels_of(vehicle_with<double>(satellite_inertia<double>(), D, 0.2, 0.1), Mask::all(3));
}

template <class S>
Setup<S> cast(const Setup<double>& setup) {
  Setup<S> out = vehicle_with<S>(setup.vehicle.J_B.template cast<S>(), setup.vehicle.D_B.template cast<S>(), S(1),
                                 static_cast<S>(setup.dt));
  out.vehicle.u_up = setup.vehicle.u_up.template cast<S>();
  out.vehicle.u_lo = setup.vehicle.u_lo.template cast<S>();
  out.vehicle.wheels = setup.vehicle.wheels;
  return out;
}

/// Commands of all signs and sizes, different for every actuator, small net rotation.
VecN<double> exciting(const Setup<double>& setup, int k) {
  const int n = setup.vehicle.actuators();
  VecN<double> u(n);
  for (int i = 0; i < n; ++i)
    u[i] =
        0.4 * setup.vehicle.u_up[i] * (std::sin(0.31 * (1 + 0.37 * i) * k + i) + std::sin(0.057 * (1 + 0.2 * i) * k));
  return u;
}

template <class S>
Allocation<S> issued(const VecN<double>& u) {
  Allocation<S> last = Allocation<S>::idle(static_cast<int>(u.size()));
  last.u = u.cast<S>();
  return last;
}

/// Compiled once: the filter is much code for every test of its own.
template <class S>
[[gnu::noinline]] Estimate<S> advance(Alone<JointKalmanObserver<S>>& observer, const Measurement<S>& y,
                                      const Allocation<S>& last) {
  return observer.skip(y, last);
}

/// A symmetric matrix of its lower triangle, each element times the scales of its row and its column.
MatrixXd scaled(MatrixXd A, const VectorXd& scale) {
  for (Eigen::Index i = 0; i < A.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) A(i, j) = A(j, i) = A(i, j) * scale[i] * scale[j];
  return A;
}

/// The filter by the book: dense F, one update with a 3 + n_w square inverse, and an opening that adds its variance before
/// the interval and propagates again.
struct DenseFilter {
  using Params = JointKalmanObserver<double>::Params;
  const Setup<double>& setup;
  Params p;
  std::vector<int> wheels;
  int n, nw, N;
  double a, dt;
  VectorXd x;
  MatrixXd P;
  double s2_w;
  VectorXd s2_h, unrest;
  int seen = 0, opened = 0, projected = 0;
  std::vector<Measurement<double>> past;
  std::vector<VecN<double>> us;
  VecN<double> u1;
  std::vector<VectorXd> means;

  DenseFilter(const Setup<double>& s, const Params& params)
      : setup(s), p(params), n(s.vehicle.actuators()), a(usable_torque(s.vehicle)), dt(s.dt) {
    for (int i = 0; i < n; ++i)
      if (s.vehicle.wheels.test(i)) wheels.push_back(i);
    nw = static_cast<int>(wheels.size());
    N = 6 + n + 2 * nw;
  }
  static double sq(double v) { return v * v; }
  double u_max(int i) const { return setup.vehicle.u_up[i]; }
  MatrixXd D() const { return setup.vehicle.D_B; }
  MatrixXd E() const {  // rows: wheels
    MatrixXd out = MatrixXd::Zero(nw, n);
    for (int k = 0; k < nw; ++k) out(k, wheels[std::size_t(k)]) = 1;
    return out;
  }

  void start(const Measurement<double>& y) {
    x = VectorXd::Zero(N);
    VectorXd diagonal(N);
    x.head<3>() = y.omega_BN_B;
    x.segment(3, nw) = applied(E(), y.h_w);
    x.segment(3 + nw, n).setOnes();
    diagonal << VectorXd::Constant(3, sq(p.rate_noise)), VectorXd::Constant(nw, sq(p.momentum_noise)),
        VectorXd::Constant(n, 0.09), VectorXd::Zero(nw), VectorXd::Constant(3, sq(0.05 * a));
    for (int k = 0; k < nw; ++k) diagonal[3 + nw + n + k] = sq(0.05 * u_max(wheels[std::size_t(k)]));
    P = diagonal.asDiagonal();
    s2_w = sq(p.rate_noise);
    s2_h = VectorXd::Constant(nw, sq(p.momentum_noise));
    unrest = VectorXd::Zero(n);
    u1 = VecN<double>::Zero(n);
    means.assign(3, VectorXd::Zero(3 + nw));
    past = {y};
    us = {};
  }

  /// The command whose doing a momentum shows after the latest of `us`, and what it changed by.
  VecN<double> shown(std::size_t ago) const {
    const std::size_t back = ago + std::size_t(p.momentum_delay);
    return back < us.size() ? us[us.size() - 1 - back] : VecN<double>(VecN<double>::Zero(n));
  }

  void step(const Measurement<double>& y, const VecN<double>& u) {
    us.push_back(u);
    const VectorXd uh = shown(0), duh = uh - VectorXd(shown(1));
    const MatrixXd J_inv = inverse(setup.vehicle.J_B), by = dt * times(J_inv, D()), E = this->E();
    const VectorXd du = u - u1, e = x.segment(3 + nw, n), h = applied(E, y.h_w);
    if (past.size() > 1) {
      const Measurement<double>&y1 = past.back(), &y2 = past[past.size() - 2];
      const VectorXd t = y.omega_BN_B - 2 * y1.omega_BN_B + y2.omega_BN_B - applied(by, e.cwiseProduct(du));
      const VectorXd th = h + applied(E, y2.h_w - 2 * y1.h_w + dt * e.cwiseProduct(duh));
      ++seen;
      const auto mean = [&](double& s2, double s, double nominal) {
        s2 = seen <= 30 ? s2 + (s - s2) / seen : s2 + 0.01 * (std::min(s, 9 * s2) - s2);
        s2 = std::max(s2, sq(0.02 * nominal));
      };
      mean(s2_w, t.squaredNorm() / 18, p.rate_noise);
      for (int k = 0; k < nw; ++k) mean(s2_h[k], sq(th[k]) / 6, p.momentum_noise);
    }
    MatrixXd F = MatrixXd::Identity(N, N);
    F.block(0, 3 + nw, 3, n) = columns_times(by, u);
    F.block(0, 3 + nw + n, 3, nw) = times(by, E.transpose());
    F.block(0, 3 + 2 * nw + n, 3, 3) = dt * J_inv;
    F.block(3, 3 + nw, nw, n) = -dt * columns_times(E, uh);
    F.block(3, 3 + nw + n, nw, nw) = -dt * MatrixXd::Identity(nw, nw);
    const auto gyro = [&](const Measurement<double>& m) -> Vec3<double> {
      return m.omega_BN_B.cross(setup.vehicle.J_B * m.omega_BN_B + setup.vehicle.D_B * m.h_w);
    };
    x = applied(F, x);
    x.head<3>() -= applied(J_inv, dt / 2 * (gyro(past.back()) + gyro(y)));
    const MatrixXd before = P;
    MatrixXd Q = MatrixXd::Zero(N, N);
    unrest /= 1 + dt / 60;
    const Vec3<double> jolt = applied(D(), x.segment(3 + nw, n).cwiseProduct(du));
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < n; ++i) Q(axis, axis) += sq(p.timing * by(axis, i) * du[i]);
      Q(N - 3 + axis, N - 3 + axis) = sq(p.q_d * a) * dt + sq(p.inertia_error * jolt[axis]);
    }
    for (int i = 0; i < n; ++i)
      Q(3 + nw + i, 3 + nw + i) =
          std::min(sq(p.q_e) * (1 + p.restless * unrest[i]) * dt, 1 - before(3 + nw + i, 3 + nw + i));
    for (int k = 0; k < nw; ++k) {
      Q(3 + k, 3 + k) = sq(p.momentum_timing * dt * duh[wheels[std::size_t(k)]]);
      Q(3 + nw + n + k, 3 + nw + n + k) = sq(p.q_b * u_max(wheels[std::size_t(k)])) * dt;
    }
    P = times(F, before, F.transpose()) + Q;

    const int m = 3 + nw;
    VectorXd measured(m), R(m);
    measured << y.omega_BN_B, h;
    R << VectorXd::Constant(3, s2_w), s2_h;
    VectorXd z(m);
    const MatrixXd spread = P.topLeftCorner(3, 3) + s2_w * MatrixXd::Identity(3, 3);
    z.head<3>() = solved(cholesky(spread), measured.head<3>() - x.head<3>());
    for (int k = 0; k < nw; ++k) z[3 + k] = (h[k] - x[3 + k]) / std::sqrt(P(3 + k, 3 + k) + s2_h[k]);
    bool body = false;
    std::vector<bool> wheel(std::size_t(nw), false);
    const double lambda[] = {1, 1. / 8, 1. / 64};
    for (int s = 0; s < 3; ++s) {
      VectorXd& mean = means[std::size_t(s)];
      mean += lambda[s] * (z - mean);
      const double f = (2 - lambda[s]) / lambda[s];
      body = body || f * mean.head<3>().squaredNorm() > p.gate;
      for (int k = 0; k < nw; ++k) wheel[std::size_t(k)] = wheel[std::size_t(k)] || f * sq(mean[3 + k]) > p.gate;
    }
    VectorXd extra = VectorXd::Zero(N);
    const auto room = [&](int i) { return std::min(0.25, 1 - P(3 + nw + i, 3 + nw + i)); };
    if (body) {
      extra.tail<3>().setConstant(sq(0.2 * a));
      for (auto& mean : means) mean.head<3>().setZero();
      for (int i = 0; i < n; ++i) {
        if (setup.vehicle.wheels.test(i) || std::abs(u[i]) <= 0.02 * u_max(i)) continue;
        extra[3 + nw + i] = room(i);
        unrest[i] += 0.3;
      }
    }
    for (int k = 0; k < nw; ++k) {
      if (!wheel[std::size_t(k)]) continue;
      const int i = wheels[std::size_t(k)];
      extra[3 + nw + i] = room(i);
      extra[3 + nw + n + k] = sq(0.3 * u_max(i));
      unrest[i] += 1;
      for (auto& mean : means) mean[3 + k] = 0;
    }
    opened += extra.any() ? 1 : 0;
    MatrixXd opened_up = before;
    opened_up.diagonal() += extra;
    P = times(F, opened_up, F.transpose()) + Q;

    MatrixXd S = P.topLeftCorner(m, m);
    S.diagonal() += R;
    const MatrixXd K = times(P.leftCols(m), inverse(S));
    x += applied(K, measured - x.head(m));
    P -= times(K, P.topRows(m));
    P = (P + P.transpose()).eval() / 2;
    for (int i = 0; i < n; ++i) {
      const int j = 3 + nw + i;
      const double inside = std::clamp(x[j], 0.0, 1.05), off = inside - x[j];
      projected += off != 0 ? 1 : 0;
      if (off != 0) x += off / P(j, j) * VectorXd(P.col(j));
    }
    x.segment(3 + nw, n) = x.segment(3 + nw, n).cwiseMax(0.0).cwiseMin(1.05);
    past.push_back(y);
    u1 = u;
  }
};

/// Its momenta are shown `delay` samples late.
void expect_the_dense_filter(int delay) {
  const auto setup = mixed();
  JointKalmanObserver<double>::Params p(setup);
  p.momentum_delay = delay;
  p.momentum_timing = delay > 0 ? 0.3 : p.momentum_timing;
  Alone<JointKalmanObserver<double>> observer(unchecked, setup, p);
  DenseFilter oracle(setup, p);
  Plant plant(setup);
  plant.d_B = {2e-3, -1e-3, 1e-3};
  Random random(5);
  Measurement<double> y = plant.measured<double>(0, random, 1e-5, 1e-5);
  (void)observer.start(y);
  oracle.start(y);
  std::vector<VecN<double>> momenta(std::size_t(delay) + 1, y.h_w);
  double worst_x = 0, worst_P = 0;
  for (int k = 1; k <= 600; ++k) {
    const VecN<double> u = exciting(setup, k);
    if (k == 150) plant.effectiveness[1] = 0.4;
    if (k == 250) plant.bias[2] = 0.03;
    if (k == 350) plant.effectiveness[3] = 0.2;
    if (k == 450) plant.effectiveness[0] = 0;
    plant.advance(u);
    y = plant.measured<double>(static_cast<Tick>(k), random, 1e-5, 1e-5);
    momenta.push_back(y.h_w);
    y.h_w = momenta[momenta.size() - 1 - std::size_t(delay)];
    (void)advance(observer, y, issued<double>(u));
    oracle.step(y, u);
    const VectorXd scale = oracle.P.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd P = observer.covariance().lower();
    worst_x = std::max(worst_x, VectorXd(observer.state() - oracle.x).cwiseProduct(scale).cwiseAbs().maxCoeff());
    worst_P = std::max(worst_P, scaled(P - oracle.P, scale).cwiseAbs().maxCoeff());
  }
  EXPECT_GE(oracle.opened, 3) << "every fault of a wheel opens";
  EXPECT_GE(oracle.projected, 1);
  EXPECT_EQ(static_cast<int>(observer.openings()), oracle.opened);
  // Rounding of a dense update whose innovations have a condition of 1e6 or so, in units of the standard deviations.
  EXPECT_LT(worst_x, 1e-6);
  EXPECT_LT(worst_P, 1e-6);
}

TEST(JointKalmanObserver, IsTheDenseFilterOfItsModel) { expect_the_dense_filter(0); }
TEST(JointKalmanObserver, IsTheDenseFilterOfItsModelWithMomentaThatAreShownLate) { expect_the_dense_filter(3); }

template <class S>
class JointKalmanOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(JointKalmanOf, Scalars);

/// Flies `observer` open loop; `before(k, plant)` changes the plant, `look(k, estimate)` looks.
template <class S>
void fly(Alone<JointKalmanObserver<S>>& observer, Plant& plant, int samples, double rate_noise, double momentum_noise,
         const Setup<double>& setup, const std::function<void(int, Plant&, VecN<double>&)>& before,
         const std::type_identity_t<std::function<void(int, const Estimate<S>&, const VecN<double>&)>>& look) {
  Random random(1);
  (void)observer.start(plant.measured<S>(0, random, rate_noise, momentum_noise));
  for (int k = 1; k <= samples; ++k) {
    VecN<double> u = exciting(setup, k);
    before(k, plant, u);
    plant.advance(u);
    look(k,
         advance(observer, plant.measured<S>(static_cast<Tick>(k), random, rate_noise, momentum_noise), issued<S>(u)),
         u);
  }
}
const auto nothing = [](auto&&...) {};

/// One wheel weak, one with a torque of its own, one dead, and a disturbance: each is what it is.
TYPED_TEST(JointKalmanOf, FourWheelsAreToldApart) {
  using S = TypeParam;
  const Setup<double> setup = four_wheels<double>();
  auto observer = alone<JointKalmanObserver<S>>(four_wheels<S>());
  Plant plant(setup);
  plant.d_B = {3e-3, -2e-3, 1e-3};
  Estimate<S> x;
  VecN<double> u;
  fly(
      observer, plant, 900, 1e-5, 1e-5, setup,
      [](int k, Plant& p, VecN<double>&) {
        if (k == 300) p.effectiveness[1] = 0.4;
        if (k == 300) p.effectiveness[3] = 0;
        if (k == 500) p.bias[0] = 0.04;
      },
      [&](int, const Estimate<S>& now, const VecN<double>& command) {
        x = now;
        u = command;
      });
  EXPECT_NEAR(static_cast<double>(x.effectiveness[0]), 1, 0.02);
  EXPECT_NEAR(static_cast<double>(x.effectiveness[1]), 0.4, 0.02);
  EXPECT_NEAR(static_cast<double>(x.effectiveness[2]), 1, 0.02);
  EXPECT_EQ(x.effectiveness[3], default_effectiveness_floor<S>);
  for (int i = 0; i < 3; ++i) {
    const double off = std::abs(static_cast<double>(x.effectiveness[i]) - plant.effectiveness[i]);
    EXPECT_LE(off, static_cast<double>(x.effectiveness_bound[i] * x.effectiveness[i])) << i;
  }
  const auto inner = telemetry_of(observer);
  EXPECT_NEAR(inner.at("bias")[0], 0.04, 1e-3);
  // What is issued explains what acts: the floor of the dead wheel comes back in d_B.
  const Vec3<double> told =
      setup.vehicle.D_B * x.effectiveness.template cast<double>().cwiseProduct(u) + x.d_B.template cast<double>();
  const Vec3<double> acts = setup.vehicle.D_B * plant.delivered(u) + plant.d_B;
  EXPECT_LT((told - acts).norm(), 2e-3);
}

/// A body lighter than known answers more than it should: 1 is issued, and d_B makes up for the rest.
TYPED_TEST(JointKalmanOf, WhatTheIssuedEffectivenessLeavesOverIsInTheDisturbance) {
  using S = TypeParam;
  Setup<double> truth = four_wheels<double>();
  truth.vehicle.wheels = {};
  Setup<double> known = truth;
  truth.vehicle.J_B /= 1.05;
  auto observer = alone<JointKalmanObserver<S>>(cast<S>(known));
  Plant plant(truth);
  double handed_on = 0, missing = 0;
  int counted = 0;
  fly(observer, plant, 600, 1e-6, 0, known, nothing, [&](int k, const Estimate<S>& x, const VecN<double>& u) {
    EXPECT_LE(x.effectiveness.maxCoeff(), S(1));
    if (k < 100) return;
    const Vec3<double> excess = 0.05 * (known.vehicle.D_B * u);  // J_known w' less what was told
    missing += excess.squaredNorm();
    const Vec3<double> told =
        known.vehicle.D_B *
            VecN<double>(x.effectiveness.template cast<double>() - VecN<double>::Ones(4)).cwiseProduct(u) +
        x.d_B.template cast<double>();
    handed_on += (told - excess).squaredNorm();
    ++counted;
  });
  ASSERT_GT(counted, 0);
  EXPECT_LT(std::sqrt(handed_on / missing), 0.25) << "of the excess, all but a quarter is made up for";
}

/// Without commands nothing is known; with them soon; and again not after (0.2^2 - P) / q_e^2 = 16 s at rest.
TYPED_TEST(JointKalmanOf, TheBoundIsInfiniteUntilCommandsHaveTaughtAndAgainWhenTheyStop) {
  using S = TypeParam;
  const Setup<double> setup = four_wheels<double>();
  auto observer = alone<JointKalmanObserver<S>>(four_wheels<S>());
  Plant plant(setup);
  int finite_from = -1, infinite_from = -1;
  fly(
      observer, plant, 700, 1e-5, 1e-5, setup,
      [](int k, Plant&, VecN<double>& u) {
        if (k <= 100 || k > 400) u.setZero();
      },
      [&](int k, const Estimate<S>& x, const VecN<double>&) {
        const bool finite = x.effectiveness_bound.array().isFinite().all();
        const bool none = !x.effectiveness_bound.array().isFinite().any();
        EXPECT_TRUE(k > 100 || none) << k;
        if (finite && finite_from < 0) finite_from = k;
        if (k > 400 && none && infinite_from < 0) infinite_from = k;
      });
  EXPECT_GT(finite_from, 100);
  EXPECT_LT(finite_from, 115);
  EXPECT_NEAR(infinite_from, 400 + 157, 15) << "samples of 0.1 s";
}

TYPED_TEST(JointKalmanOf, ActuatorsInAnotherOrderAreTheSameActuators) {
  using S = TypeParam;
  const Setup<double> setup = mixed();
  const std::array<int, 5> order{3, 2, 4, 0, 1};
  Setup<double> other = setup;
  other.vehicle.wheels = {};
  for (int i = 0; i < 5; ++i) {
    const int from = order[std::size_t(i)];
    other.vehicle.D_B.col(i) = setup.vehicle.D_B.col(from);
    other.vehicle.wheels.set(i, setup.vehicle.wheels.test(from));
  }
  auto one = alone<JointKalmanObserver<S>>(cast<S>(setup)), two = alone<JointKalmanObserver<S>>(cast<S>(other));
  Plant plant(setup);
  Random random(2);
  const auto shuffled = [&](const auto& v) {
    auto out = v;
    for (int i = 0; i < 5; ++i) out[i] = v[order[std::size_t(i)]];
    return out;
  };
  const auto turned = [&](Measurement<S> y) {
    y.h_w = shuffled(y.h_w);
    return y;
  };
  Measurement<S> y = plant.measured<S>(0, random, 1e-5, 1e-5);
  (void)one.start(y);
  (void)two.start(turned(y));
  for (int k = 1; k <= 300; ++k) {
    const VecN<double> u = exciting(setup, k);
    if (k == 100) plant.effectiveness[1] = 0.3;
    plant.advance(u);
    y = plant.measured<S>(static_cast<Tick>(k), random, 1e-5, 1e-5);
    const Estimate<S> x = advance(one, y, issued<S>(u)), z = advance(two, turned(y), issued<S>(shuffled(u)));
    // Sums in another order; float then decides about an opening or an edge a little differently.
    const double tolerance = sizeof(S) == 8 ? 1e-7 : 2e-2;
    EXPECT_LT(static_cast<double>((shuffled(x.effectiveness) - z.effectiveness).cwiseAbs().maxCoeff()), tolerance) << k;
    EXPECT_LT(static_cast<double>((x.d_B - z.d_B).norm()), 0.2 * tolerance) << k;
  }
}

/// A body a hundred times heavier, with actuators to match, at a tenth of the rate: the same flight.
TYPED_TEST(JointKalmanOf, TheScaleOfTheVehicleIsOfNoConsequence) {
  using S = TypeParam;
  const Setup<double> setup = mixed();
  const double mass = 128, time = 0.25;  // powers of two: the same digits
  Setup<double> other = setup;
  other.vehicle.J_B *= mass;
  other.vehicle.u_up *= mass / (time * time);
  other.vehicle.u_lo *= mass / (time * time);
  other.dt *= time;
  auto observer = alone<JointKalmanObserver<S>>(cast<S>(setup));
  typename JointKalmanObserver<S>::Params p(cast<S>(other));
  for (S* q : {&p.q_e, &p.q_b, &p.q_d}) *q /= static_cast<S>(std::sqrt(time));
  p.rate_noise = static_cast<S>(typename JointKalmanObserver<S>::Params(cast<S>(setup)).rate_noise / S(time));
  p.momentum_noise = typename JointKalmanObserver<S>::Params(cast<S>(setup)).momentum_noise * S(mass / time);
  Alone<JointKalmanObserver<S>> scaled(unchecked, cast<S>(other), p);
  Plant plant(setup);
  Random random(3);
  const auto larger = [&](Measurement<S> y) {
    y.omega_BN_B /= S(time);
    y.h_w *= S(mass / time);
    return y;
  };
  Measurement<S> y = plant.measured<S>(0, random, 1e-5, 1e-5);
  (void)observer.start(y);
  (void)scaled.start(larger(y));
  for (int k = 1; k <= 300; ++k) {
    const VecN<double> u = exciting(setup, k);
    if (k == 100) plant.effectiveness[1] = 0.3;
    plant.advance(u);
    y = plant.measured<S>(static_cast<Tick>(k), random, 1e-5, 1e-5);
    const Estimate<S> x = advance(observer, y, issued<S>(u));
    const Estimate<S> z = advance(scaled, larger(y), issued<S>(VecN<double>(u * (mass / (time * time)))));
    // unrest is forgotten in seconds, not in samples: it shows after an opening, and little
    EXPECT_LT(static_cast<double>((x.effectiveness - z.effectiveness).cwiseAbs().maxCoeff()), k < 100 ? 1e-5 : 1e-2)
        << k;
  }
}

/// Smallest eigenvalue of the correlations: zero where they contradict each other.
template <class S>
double smallest_correlation(const JointKalmanObserver<S>& observer) {
  const MatrixXd P = observer.covariance().lower().template cast<double>();
  return symmetric_eigenvalues(scaled(P, P.diagonal().cwiseSqrt().cwiseInverse()))[0];
}

/// Noise, commands, faults, gaps and jumps at random: P stays a covariance.
TYPED_TEST(JointKalmanOf, TheCovarianceStaysPositive) {
  using S = TypeParam;
  const Setup<double> setup = mixed();
  auto observer = alone<JointKalmanObserver<S>>(cast<S>(setup));
  Plant plant(setup);
  Random random(11);
  (void)observer.start(plant.measured<S>(0, random, 1e-5, 1e-5));
  double least = 1;
  std::uint32_t event = 0;
  VecN<double> u = VecN<double>::Zero(5);
  for (int k = 1; k <= 100000; ++k) {
    for (int i = 0; i < 5; ++i)
      if (random.uniform(0, 1) < 0.3) u[i] = random.uniform(0, 1) < 0.2 ? 0.0 : random.uniform(-0.2, 0.2);
    if (random.uniform(0, 1) < 0.002)
      for (int i = 0; i < 5; ++i) plant.effectiveness[i] = random.uniform(0, 1);
    plant.advance(u);
    plant.omega *= 0.98;  // keeps it slow
    plant.h *= 0.98;
    Measurement<S> y = plant.measured<S>(static_cast<Tick>(k), random, 1e-5, 1e-5);
    if (k % 1000 > 900) y.rate_valid = random.uniform(0, 1) < 0.3;
    if (k % 1000 > 850) y.momentum_valid = random.uniform(0, 1) < 0.3;
    if (k % 1000 > 980) y.rate_valid = y.momentum_valid = false;
    if (random.uniform(0, 1) < 0.0005) ++event;
    y.event = event;
    const Estimate<S> x = advance(observer, y, issued<S>(u));
    ASSERT_TRUE(x.effectiveness.allFinite() && x.d_B.allFinite()) << k;
    for (int j = 0; j < observer.covariance().size(); ++j) ASSERT_GT(observer.covariance().variance(j), S(0)) << k;
    if (k % 97 == 0) least = std::min(least, smallest_correlation(observer));
  }
  // Float: the rows of a state measured a thousand times better than it was predicted keep 1e-7 / 1e-6 of their digits.
  EXPECT_GT(least, sizeof(S) == 8 ? -1e-9 : -1e-2);
}

/// Stated: 1.4e-6 a body sample and scale, 4e-8 a wheel's. 1e5 samples: 0.4 expected, four or more by chance 1 in 1000.
TYPED_TEST(JointKalmanOf, HealthyActuatorsOpenNothingBeyondTheStatedRate) {
  using S = TypeParam;
  const Setup<double> setup = four_wheels<double>();
  auto observer = alone<JointKalmanObserver<S>>(four_wheels<S>());
  Plant plant(setup);
  fly(observer, plant, 100000, 1e-5, 1e-5, setup, nothing, nothing);
  EXPECT_LE(observer.openings(), 3u);
}

/// A channel that is not measured is predicted; the other one goes on teaching, and what was learned stays.
TYPED_TEST(JointKalmanOf, OneChannelAloneStillTeaches) {
  using S = TypeParam;
  const Setup<double> setup = four_wheels<double>();
  for (const bool rate_fails : {true, false}) {
    auto observer = alone<JointKalmanObserver<S>>(four_wheels<S>());
    Plant plant(setup);
    Random random(4);
    (void)observer.start(plant.measured<S>(0, random, 1e-5, 1e-5));
    Estimate<S> x;
    for (int k = 1; k <= 400; ++k) {
      const bool fails = k > 100 && k <= 300;
      const VecN<double> u = exciting(setup, k);
      if (k == 150) plant.effectiveness[2] = 0.3;
      plant.advance(u);
      Measurement<S> y = plant.measured<S>(static_cast<Tick>(k), random, 1e-5, 1e-5);
      if (fails) {
        (rate_fails ? y.rate_valid : y.momentum_valid) =
            false;  // the numbers are the truth carried on: nothing to learn from
      }
      x = advance(observer, y, issued<S>(u));
      ASSERT_TRUE(x.effectiveness.allFinite() && x.d_B.allFinite()) << k;
      // Its momentum tells on a wheel in full; the rates see the body change its answer, whoever it was.
      if (k == 250 && rate_fails) {
        EXPECT_NEAR(static_cast<double>(x.effectiveness[2]), 0.3, 0.02);
      }
      if (k == 250 && !rate_fails) {
        const VecN<double> lost = x.effectiveness.template cast<double>() - VecN<double>::Ones(4);
        const Vec3<double> told = setup.vehicle.D_B * lost.cwiseProduct(u) + x.d_B.template cast<double>();
        const Vec3<double> acts = setup.vehicle.D_B * (plant.delivered(u) - u);
        EXPECT_LT((told - acts).norm(), 0.3 * acts.norm() + 5e-3);
      }
    }
    EXPECT_NEAR(static_cast<double>(x.effectiveness[2]), 0.3, 0.02) << rate_fails;
  }
}

/// The state jumps, no motion leads there: what was learned stays, nothing opens.
TYPED_TEST(JointKalmanOf, AJumpOfTheStateTeachesNothing) {
  using S = TypeParam;
  const Setup<double> setup = four_wheels<double>();
  auto observer = alone<JointKalmanObserver<S>>(four_wheels<S>());
  Plant plant(setup);
  plant.effectiveness[1] = 0.5;
  Random random(6);
  (void)observer.start(plant.measured<S>(0, random, 1e-5, 1e-5));
  std::uint32_t before = 0;
  for (int k = 1; k <= 300; ++k) {
    const VecN<double> u = exciting(setup, k);
    plant.advance(u);
    if (k == 200) {
      plant.omega += Vec3<double>(0.1, -0.2, 0.05);
      plant.h.setConstant(1);
      before = observer.openings();
    }
    Measurement<S> y = plant.measured<S>(static_cast<Tick>(k), random, 1e-5, 1e-5);
    y.event = k >= 200 ? 1 : 0;
    const Estimate<S> x = advance(observer, y, issued<S>(u));
    if (k > 50) {
      EXPECT_NEAR(static_cast<double>(x.effectiveness[1]), 0.5, 0.03) << k;
    }
  }
  EXPECT_EQ(observer.openings(), before);
}

/// A command beyond sense is not what moved the body.
TYPED_TEST(JointKalmanOf, ACommandBeyondSenseTeachesNothing) {
  using S = TypeParam;
  const Setup<double> setup = four_wheels<double>();
  auto observer = alone<JointKalmanObserver<S>>(four_wheels<S>());
  Plant plant(setup);
  Random random(7);
  (void)observer.start(plant.measured<S>(0, random, 1e-5, 1e-5));
  for (int k = 1; k <= 100; ++k) {
    const VecN<double> u = exciting(setup, k);
    plant.advance(u);
    Allocation<S> last = issued<S>(u);
    if (k == 60) last.u.setConstant(S(1e12));
    const Measurement<S> y = plant.measured<S>(static_cast<Tick>(k), random, 1e-5, 1e-5);
    const Estimate<S> x = advance(observer, y, last);
    EXPECT_GT(x.effectiveness.minCoeff(), S(0.95)) << k;
    EXPECT_LT(x.d_B.norm(), S(0.02)) << k;
  }
  EXPECT_EQ(observer.openings(), 0u);
}

/// One actuator, sixteen, with and without momentum, without limits: as many states as the vehicle needs, and it learns.
TYPED_TEST(JointKalmanOf, FliesWhateverVehicleThereIs) {
  using S = TypeParam;
  struct Fleet {
    int n;
    Mask wheels;
    double u_max;
    int states;
  };
  const double unlimited = std::numeric_limits<double>::infinity();
  Mask half;
  for (int i = 0; i < 8; ++i) half.set(2 * i);
  for (const Fleet& fleet :
       {Fleet{1, Mask::all(1), 0.2, 9}, Fleet{1, {}, unlimited, 7}, Fleet{2, Mask::all(2), 0.2, 12},
        Fleet{16, Mask::all(16), 0.2, 54}, Fleet{16, {}, 0.2, 22}, Fleet{16, half, unlimited, 38}}) {
    Random random(8);
    Mat3N<double> D(3, fleet.n);
    for (int i = 0; i < fleet.n; ++i) D.col(i) = random.vector<double>(1).normalized();
    Setup<double> setup =
        wheels_of(vehicle_with<double>(satellite_inertia<double>(), D, fleet.u_max, 0.1), fleet.wheels);
    Setup<double> commands = setup;
    commands.vehicle.u_up.setConstant(0.2);
    const Setup<S> flown = [&] {
      Setup<S> s = wheels_of(vehicle_with<S>(satellite_inertia<S>(), D.cast<S>(), static_cast<S>(fleet.u_max), S(0.1)),
                             fleet.wheels);
      return s;
    }();
    Checked<Alone<JointKalmanObserver<S>>> observer(flown);
    ASSERT_TRUE(observer) << observer.status().quantity;
    EXPECT_EQ(observer->state().size(), fleet.states);
    Plant plant(setup);
    plant.effectiveness[0] = 0.4;
    Estimate<S> x;
    fly(*observer, plant, 400, 1e-5, 1e-5, commands, nothing,
        [&](int, const Estimate<S>& now, const VecN<double>&) { x = now; });
    ASSERT_TRUE(x.effectiveness.allFinite() && x.d_B.allFinite());
    if (fleet.wheels.test(0)) {
      EXPECT_NEAR(static_cast<double>(x.effectiveness[0]), 0.4, 0.02) << fleet.n;
    }
  }
}

TEST(JointKalmanObserver, RefusesWhatCannotWork) {
  const auto setup = four_wheels<double>();
  JointKalmanObserver<double>::Params p(setup);
  EXPECT_TRUE(JointKalmanObserver<double>::check(setup, p).ok());
  p.gate = 1;
  EXPECT_STREQ(JointKalmanObserver<double>::check(setup, p).quantity, "gate");
  p = JointKalmanObserver<double>::Params(setup);
  p.e_min = 0;
  EXPECT_STREQ(JointKalmanObserver<double>::check(setup, p).quantity, "e_min");
  p.e_min = 1;
  EXPECT_STREQ(JointKalmanObserver<double>::check(setup, p).quantity, "e_min");
}

}  // namespace
}  // namespace gyrostat::test::test_joint_kalman
