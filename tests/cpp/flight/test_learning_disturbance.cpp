// SPDX-License-Identifier: MIT
// The learning observer: stability of its sampled recursion, exact propagation, what it finds and what it leaves.
#include <gtest/gtest.h>

#include "alone.hpp"
#include "gyrostat/flight/observers/learning_disturbance.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_learning_disturbance {
namespace {

LearningErrorLoop published(double step, int delay) { return {18, 0.98, 15, 5, step, delay}; }

TEST(LearningErrorLoop, HasThePublishedGainsSpectralRadii) {
  // Roots of the characteristic polynomial by numpy: memory of 10 samples, then of 2, then held over one interval.
  EXPECT_NEAR(published(0.001, 10).spectral_radius(), 0.99899, 1e-4);
  EXPECT_NEAR(published(0.0021, 10).spectral_radius(), 1.0001, 1e-4);
  EXPECT_NEAR(published(0.005, 10).spectral_radius(), 1.0031, 1e-4);
  EXPECT_NEAR(published(0.010, 10).spectral_radius(), 1.0083, 1e-4);
  EXPECT_NEAR(published(0.001, 2).spectral_radius(), 0.99496, 1e-4);
  EXPECT_NEAR(published(0.0021, 2).spectral_radius(), 1.0005, 1e-4);
  EXPECT_NEAR(published(0.005, 2).spectral_radius(), 1.0152, 1e-4);
  EXPECT_NEAR(published(0.010, 2).spectral_radius(), 1.041, 5e-4);
  for (const double Tc :
       {0.01, 0.02, 0.05}) {  // N = 1: complex pair, so the modulus is the root of the last coefficient
    const double a = std::exp(-18 * Tc), b = (1 - a) / 18;
    EXPECT_NEAR(published(Tc, 1).spectral_radius(), std::sqrt(0.98 * a + 5 * b), 1e-8);
  }
}

TEST(LearningErrorLoop, LosesItsHalfSampleRateModeWhereTheClosedFormSays) {
  // z = -1 for even N: tanh(M h / 2) / M = (1 - k1) / (k2 + k3).
  const double h = 2.0 / 18 * std::atanh(18 * 0.02 / 20);
  EXPECT_NEAR(h, 2e-3, 1e-6);
  for (const int N : {2, 10, 64}) {
    EXPECT_TRUE(published(h * (1 - 1e-6), N).inside(1)) << N;
    EXPECT_FALSE(published(h * (1 + 1e-6), N).inside(1)) << N;
  }
}

/// The published gains.
template <class S>
typename LearningDisturbanceObserver<S>::Params gains(const gyrostat::Setup<S>& setup, S interval,
                                                      typename LearningDisturbanceObserver<S>::Form form) {
  typename LearningDisturbanceObserver<S>::Params p(setup);
  p.M = S(18);
  p.k1 = S(0.98);
  p.k2 = S(15);
  p.k3 = S(5);
  p.interval = interval;
  p.form = form;
  return p;
}

template <class S>
class LearningDisturbance : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(LearningDisturbance, Scalars);

TYPED_TEST(LearningDisturbance, RefusesTheUnstableSettingWithItsRadius) {
  using S = TypeParam;
  using Observer = LearningDisturbanceObserver<S>;
  auto setup = ftc_4rw<S>();
  auto p = gains<S>(setup, S(0.01), Observer::Form::rolling);
  setup.dt = S(0.005);
  const Status<S> refused = Observer::check(setup, p);
  EXPECT_EQ(refused.code, Status<S>::Code::unstable);
  EXPECT_NEAR(refused.value, 1.0152, 1e-3);
  p.form = Observer::Form::held;
  EXPECT_TRUE(Observer::check(setup, p).ok());
  setup.dt = S(0.001);
  p.form = Observer::Form::rolling;
  EXPECT_TRUE(Observer::check(setup, p).ok());
  p.interval = S(0.0105);  // ten and a half periods
  EXPECT_EQ(Observer::check(setup, p).code, Status<S>::Code::refused);
  p.interval = S(0.1);  // longer than the memory
  EXPECT_EQ(Observer::check(setup, p).code, Status<S>::Code::refused);
}

TYPED_TEST(LearningDisturbance, LeavesTheShareOfAConstantTorqueThatItsGainsSay) {
  using S = TypeParam;
  using Observer = LearningDisturbanceObserver<S>;
  for (const auto form : {Observer::Form::held, Observer::Form::rolling}) {
    auto setup = ftc_4rw<S>();
    setup.dt = S(0.001);
    const auto p = gains<S>(setup, S(0.01), form);
    setup.vehicle.J_B.setIdentity();  // no gyroscopic torque: the rate grows by exactly f h a sample
    Alone<Observer> observer(unchecked, setup, p);
    const Vec3<S> f(S(0.02), S(0), S(0));
    Measurement<S> y;
    y.h_w = VecN<S>::Zero(4);
    const Allocation<S> last = Allocation<S>::idle(4);
    Estimate<S> x = observer.start(y);
    EXPECT_EQ(x.d_B.norm(), S(0));
    for (int k = 1; k <= 20000; ++k) {
      y.omega_BN_B = S(k) * setup.dt * f;
      x = observer.step(y, last);
    }
    const S share = S(18) * S(0.02) / (S(18) * S(0.02) + S(20));
    EXPECT_NEAR(x.d_B[0], f[0] * (S(1) - share),
                (std::is_same_v<S, float> ? 1e-2 : 1e-7) * 0.02);  // float: rounding of the rate over h
    EXPECT_LT(std::abs(x.d_B[1]) + std::abs(x.d_B[2]), S(1e-6));
  }
}

TYPED_TEST(LearningDisturbance, CountsWheelsCommandsAndGyroscopicTorqueOnce) {
  using S = TypeParam;
  auto setup = ftc_4rw<S>();
  const Vehicle<S>& v = setup.vehicle;
  auto observer = alone<LearningDisturbanceObserver<S>>(setup);
  Measurement<S> y;
  y.omega_BN_B = Vec3<S>(S(0.1), S(-0.2), S(0.15));
  y.h_w = VecN<S>(4);
  y.h_w << S(0.5), S(-1), S(2), S(0.3);
  Allocation<S> last = Allocation<S>::idle(4);
  Estimate<S> x = observer.start(y);
  // The command that holds this rate and these wheels: nothing is left to be found.
  const Vec3<S> gyro_B = y.omega_BN_B.cross(v.J_B * y.omega_BN_B + torque<S>(v.D_B, y.h_w));
  const Mat3<S> DD = v.D_B * v.D_B.transpose();
  last.u = project<S>(v.D_B, DD.inverse() * gyro_B);
  for (int k = 0; k < 50; ++k) x = observer.step(y, last);
  EXPECT_LT(x.d_B.norm(), S(200) * Eigen::NumTraits<S>::epsilon() * gyro_B.norm());
  EXPECT_EQ(x.effectiveness, VecN<S>(VecN<S>::Ones(4)));
}

TEST(LearningDisturbance, MovesItsErrorByTheExactSolution) {
  auto setup = ftc_4rw<double>();
  setup.dt = 0.01;
  setup.vehicle.J_B.setIdentity();
  using Observer = LearningDisturbanceObserver<double>;
  Alone<Observer> observer(unchecked, setup, gains<double>(setup, 0.05, Observer::Form::held));
  Measurement<double> y;
  y.h_w = VecN<double>::Zero(4);
  Estimate<double> x = observer.start(y);
  const Allocation<double> last = Allocation<double>::idle(4);
  for (int k = 1; k <= 4; ++k) {  // no learning yet: e' = f - M e from zero
    y.omega_BN_B[0] = 0.3 * 0.01 * k;
    x = observer.step(y, last);
    EXPECT_NEAR(telemetry_of(observer).at("e")[0], 0.3 / 18 * -std::expm1(-18 * 0.01 * k), 1e-16);
    EXPECT_EQ(x.d_B[0], 0);
  }
}

TEST(LearningDisturbanceObserver, IsItsRecursionWithTheMeanOfTheKnownTorque) {
  using Observer = LearningDisturbanceObserver<double>;
  const auto setup = ftc_4rw<double>();
  const Mat3<double>& J = setup.vehicle.J_B;
  const Mat3N<double>& D = setup.vehicle.D_B;
  for (const auto form : {Observer::Form::held, Observer::Form::rolling}) {
    for (const auto from : {Observer::Start::measured, Observer::Start::zero}) {
      auto p = gains<double>(setup, 0.03, form);
      p.start = from;
      Alone<Observer> observer(unchecked, setup, p);
      const bool held = form == Observer::Form::held;
      const std::size_t back = held ? 1 : 3;
      for (int start = 0; start < 2; ++start) {
        Measurement<double> y;
        y.omega_BN_B = {0.3, -0.2, 0.1};
        y.h_w = VecN<double>::Constant(4, 2);
        Vec3<double> e = from == Observer::Start::measured ? Vec3<double>(Vec3<double>::Zero()) : y.omega_BN_B;
        std::vector<Vec3<double>> f(back, Vec3<double>::Zero()), past(f);
        const auto learn = [&] {
          f.push_back(0.98 * f[f.size() - back] + 15 * e + 5 * past[past.size() - back]);
          past.push_back(e);
        };
        learn();
        EXPECT_LT((observer.start(y).d_B - J * f.back()).norm(), 1e-12);
        const double a = std::exp(-18 * setup.dt), b = (1 - a) / 18;
        for (int k = 1; k <= 60; ++k) {
          const Measurement<double> before = y;
          y.omega_BN_B = Vec3<double>(std::cos(0.3 * k), std::sin(0.2 * k), 0.5 * std::cos(0.1 * k));
          y.h_w = VecN<double>::Constant(4, 2 + std::sin(0.4 * k));
          Allocation<double> last = Allocation<double>::idle(4);
          last.u << 0.1 * std::sin(k), 0.1, -0.05, 0.02;
          const auto known = [&](const Measurement<double>& m) -> Vec3<double> {
            return -m.omega_BN_B.cross(J * m.omega_BN_B + D * m.h_w);
          };
          const Vec3<double> explained = (known(before) + known(y)) / 2 + D * last.u;
          e = a * e + b * ((y.omega_BN_B - before.omega_BN_B) / setup.dt - J.inverse() * explained - f.back());
          if (!held || k % 3 == 0) learn();
          EXPECT_LT((observer.step(y, last).d_B - J * f.back()).norm(), 1e-9) << k;  // of some 1000 N m
        }
      }
    }
  }
}

}  // namespace
}  // namespace gyrostat::test::test_learning_disturbance
