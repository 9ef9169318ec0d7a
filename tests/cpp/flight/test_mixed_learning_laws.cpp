// SPDX-License-Identifier: MIT
// The sliding modes that share a surface: sliding_mode, mixed_learning_sliding_mode, mixed_learning_terminal_sliding_mode.
#include <gtest/gtest.h>

#include "../random.hpp"
#include "alone.hpp"
#include "closed_loop.hpp"
#include "gyrostat/flight/controllers/mixed_learning_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/sliding_mode.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_mixed_learning_laws {
namespace {

using Surface = RateAttitudeSurface<double>;

template <class S>
Estimate<S> some_estimate(Random& random) {
  Measurement<S> y;
  y.h_w = VecN<S>::Constant(4, S(0.3));
  y.q_NB = quat_exp<S>(random.vector<S>(1));
  y.omega_BN_B = random.vector<S>(0.1);
  Estimate<S> x = Estimate<S>::healthy(y);
  x.d_B = random.vector<S>(0.1);
  return x;
}

TEST(RateAttitudeSurface, ItsTorqueKeepsTheSlidingVariableWhileTheReferenceMoves) {
  Random random(5);
  const auto setup = ftc_4rw<double>();
  for (int trial = 0; trial < 40; ++trial) {
    const Surface surface({0.2, trial % 2 == 0 ? 0.0 : 0.1, 0.7, trial % 4 == 1 ? 0.5 : 0.01});
    const double h = 1e-4;
    Body body(setup.vehicle);
    body.q_NB = random.attitude<double>();
    body.omega_BN_B = random.vector<double>(0.2);
    Reference<double> ref;
    ref.q_NR = random.attitude<double>();
    const Vec3<double> rate = random.vector<double>(0.2);
    ref.omega_RN_R = rate;
    ref.omegadot_RN_R = random.vector<double>(0.05);
    const auto estimate = [&] { return Estimate<double>::healthy(body.measured<double>(0)); };
    const Surface::Value at = surface(setup.vehicle, estimate(), ref);
    body.d_B = at.equivalent_B;
    body.advance(VecN<double>::Zero(4), h);
    ref.q_NR = ref.q_NR * quat_exp<double>(h * (rate + h / 2 * ref.omegadot_RN_R));
    ref.omega_RN_R += h * ref.omegadot_RN_R;
    const Vec3<double> s = surface(setup.vehicle, estimate(), ref).s;
    // The second derivative of s, of order one, times h; a missing term shows as 1e-2.
    EXPECT_LT((s - at.s).norm() / h, 5e-4) << trial;
  }
}

TEST(RateAttitudeSurface, TheTerminalPartIsContinuousAndItsTorqueBounded) {
  const auto setup = ftc_4rw<double>();
  const Surface surface({0.1, 0.05, 0.7, 0.01});
  Vec3<double> before = Vec3<double>::Zero();
  for (double q = -0.02; q < 0.02; q += 1e-6) {
    Measurement<double> y;
    y.h_w = VecN<double>::Zero(4);
    y.q_NB = Quat<double>(std::sqrt(1 - q * q), q, 0, 0);
    y.omega_BN_B = {0.01, 0, 0};
    const Surface::Value at = surface(setup.vehicle, Estimate<double>::healthy(y), {});
    if (q > -0.02) {
      ASSERT_LT((at.s - before).norm(), 1e-6) << q;  // slope below 1
    }
    before = at.s;
    ASSERT_LT(at.equivalent_B.norm(), 0.1) << q;
  }
}

TEST(SlidingMode, TheNetworkStaysBoundedByItsForgetting) {
  const auto setup = ftc_4rw<double>();
  SlidingMode<double>::Params p(setup);
  p.network_rate = 0.3;
  Alone<SlidingMode<double>> law(unchecked, setup, p);
  Measurement<double> y;
  y.h_w = VecN<double>::Zero(4);
  y.omega_BN_B = {0.5, -0.5, 0.5};  // held by force: nothing the network does helps
  const Estimate<double> x = Estimate<double>::healthy(y);
  const Detection<double> det = Detection<double>::none(setup.vehicle);
  Demand<double> out = law.start(x, det, {});
  for (int k = 0; k < 200000; ++k) out = law.step(x, det, {}, Allocation<double>::idle(4));
  // W -> phi s' / (leak |s|) entry by entry, so |network| -> |phi|^2 / leak <= 13 / 0.05
  const std::vector<double> network = telemetry_of(law).at("network");
  const double size = std::hypot(network[0], network[1], network[2]);
  EXPECT_GT(size, 1);
  EXPECT_LT(size, 13 / 0.05);
  EXPECT_TRUE(out.tau_B.allFinite());
}

template <class S>
class MixedLearningLaws : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(MixedLearningLaws, Scalars);

template <class Law>
class SlidingLaws : public testing::Test {};
using Laws = testing::Types<SlidingMode<float>, SlidingMode<double>, MixedLearningSlidingMode<float>,
                            MixedLearningSlidingMode<double>, MixedLearningTerminalSlidingMode<float>,
                            MixedLearningTerminalSlidingMode<double>>;
TYPED_TEST_SUITE(SlidingLaws, Laws);

TYPED_TEST(SlidingLaws, StartTwiceIsStartOnceAndTheOtherSignOfTheQuaternionIsTheSameAttitude) {
  using S = typename TypeParam::Scalar;
  const Setup<S> setup = ftc_4rw<S>();
  const typename TypeParam::Params p(setup);
  Alone<TypeParam> fresh(unchecked, setup, p), used(unchecked, setup, p);
  Measurement<S> y;
  y.h_w = VecN<S>::Zero(4);
  y.q_NB = Quat<S>(S(0.8), S(0.36), S(-0.4), S(0.2689)).normalized();
  y.omega_BN_B = {S(0.05), S(0.1), S(-0.02)};
  const Estimate<S> x = Estimate<S>::healthy(y);
  y.q_NB.coeffs() = -y.q_NB.coeffs();
  const Estimate<S> other = Estimate<S>::healthy(y);
  const Detection<S> det = Detection<S>::none(setup.vehicle);
  const Allocation<S> last = Allocation<S>::idle(4);
  static_cast<void>(used.start(x, det, {}));
  for (int k = 0; k < 20; ++k) static_cast<void>(used.step(x, det, {}, last));
  EXPECT_EQ(used.start(x, det, {}).tau_B, fresh.start(x, det, {}).tau_B);
  EXPECT_EQ(used.step(other, det, {}, last).tau_B, fresh.step(x, det, {}, last).tau_B);
}

TYPED_TEST(SlidingLaws, RefuseAGainThatTheirPeriodDoesNotAllow) {
  using S = typename TypeParam::Scalar;
  const Setup<S> setup = ftc_4rw<S>();
  typename TypeParam::Params p(setup);
  EXPECT_TRUE(TypeParam::check(setup, p).ok());
  p.k_lin = S(1e4);
  EXPECT_EQ(TypeParam::check(setup, p).code, Status<S>::Code::unstable);
}

TYPED_TEST(MixedLearningLaws, WithoutItsPowersTheTerminalLawIsTheLinearOne) {
  using S = TypeParam;
  const Setup<S> setup = ftc_4rw<S>();
  typename MixedLearningTerminalSlidingMode<S>::Params p(setup);
  p.terminal = p.k_power = S(0);
  auto linear = alone<MixedLearningSlidingMode<S>>(setup);
  Alone<MixedLearningTerminalSlidingMode<S>> terminal(unchecked, setup, p);
  const Detection<S> det = Detection<S>::none(setup.vehicle);
  const Allocation<S> last = Allocation<S>::idle(4);
  Random random(7);
  for (int k = 0; k < 50; ++k) {
    const Estimate<S> x = some_estimate<S>(random);
    const Vec3<S> tau = k == 0 ? linear.start(x, det, {}).tau_B : linear.step(x, det, {}, last).tau_B;
    ASSERT_EQ(tau, (k == 0 ? terminal.start(x, det, {}) : terminal.step(x, det, {}, last)).tau_B) << k;
  }
}

TYPED_TEST(MixedLearningLaws, AJumpOfTheStateTeachesNothing) {
  using S = TypeParam;
  const Setup<S> setup = ftc_4rw<S>();
  const auto expect = [&](auto law) {
    const Detection<S> det = Detection<S>::none(setup.vehicle);
    const Allocation<S> last = Allocation<S>::idle(4);
    Random random(8);
    Estimate<S> x = some_estimate<S>(random);
    static_cast<void>(law.start(x, det, {}));
    for (int k = 0; k < 20; ++k) static_cast<void>(law.step(x, det, {}, last));
    const std::vector<double> learnt = telemetry_of(law).at("learnt");
    x.omega_BN_B += Vec3<S>(S(0.3), S(-0.2), S(0.1));
    ++x.event;
    static_cast<void>(law.step(x, det, {}, last));
    EXPECT_EQ(telemetry_of(law).at("learnt"), learnt);
    static_cast<void>(law.step(x, det, {}, last));
    EXPECT_NE(telemetry_of(law).at("learnt"), learnt) << "it goes on";
  };
  expect(alone<MixedLearningSlidingMode<S>>(setup));
  expect(alone<MixedLearningTerminalSlidingMode<S>>(setup));
}

TEST(SlidingMode, TheNetworkIsTheOneOfItsPage) {
  const auto setup = ftc_4rw<double>();
  SlidingMode<double>::Params p(setup);
  Alone<SlidingMode<double>> plain(unchecked, setup, p);
  p.network_rate = 0.3;
  p.network_leak = 0.7;
  p.network_reach = 0.4;
  Alone<SlidingMode<double>> law(unchecked, setup, p);
  // The origin, and one node each way along each of q and w.
  Eigen::Matrix<double, 13, 6> node = Eigen::Matrix<double, 13, 6>::Zero();
  for (int i = 0; i < 6; ++i) {
    node(1 + 2 * i, i) = p.network_reach;
    node(2 + 2 * i, i) = -p.network_reach;
  }
  const Detection<double> det = Detection<double>::none(setup.vehicle);
  const Allocation<double> last = Allocation<double>::idle(4);
  Random random(8);
  for (int start = 0; start < 2; ++start) {
    Eigen::Matrix<double, 13, 3> W = Eigen::Matrix<double, 13, 3>::Zero();
    for (int k = 0; k < 50; ++k) {
      const Estimate<double> x = some_estimate<double>(random);
      const Vec3<double> with = k == 0 ? law.start(x, det, {}).tau_B : law.step(x, det, {}, last).tau_B;
      const Vec3<double> without = k == 0 ? plain.start(x, det, {}).tau_B : plain.step(x, det, {}, last).tau_B;
      Eigen::Matrix<double, 6, 1> input;
      input << short_way(x.q_NB).vec(), x.omega_BN_B;
      Eigen::Matrix<double, 13, 1> phi;
      for (int i = 0; i < 13; ++i)
        phi[i] = std::exp(-(input - node.row(i).transpose()).squaredNorm() / (p.network_reach * p.network_reach));
      const Vec3<double> torque = W.transpose() * phi;
      ASSERT_LT((without - with - torque).norm(), 1e-13) << k;  // differences of torques of order one
      const std::vector<double> s_values = telemetry_of(law).at("s");
      const Vec3<double> s(s_values[0], s_values[1], s_values[2]);
      const double forgotten = setup.dt * p.network_rate * p.network_leak * s.norm();  // implicit Euler
      W = (W + setup.dt * p.network_rate * phi * s.transpose()) / (1 + forgotten);
    }
    EXPECT_GT(W.norm(), 1e-3) << "it learnt something, and a start forgets it";
  }
}

TYPED_TEST(SlidingLaws, SubtractTheEstimatedTorqueOnceWhereThatIsAskedFor) {
  using S = typename TypeParam::Scalar;
  const Setup<S> setup = ftc_4rw<S>();
  typename TypeParam::Params p(setup);
  p.compensate = true;
  Alone<TypeParam> with(unchecked, setup, p);
  p.compensate = false;
  Alone<TypeParam> without(unchecked, setup, p);
  Random random(9);
  const Estimate<S> x = some_estimate<S>(random);
  const Vec3<S> difference = without.start(x, {}, {}).tau_B - with.start(x, {}, {}).tau_B;
  EXPECT_LT((difference - x.d_B).norm(), S(8) * Eigen::NumTraits<S>::epsilon());  // of torques of order one
}

TYPED_TEST(SlidingLaws, CountTheSlopeOfTheirLayerForStability) {
  using S = typename TypeParam::Scalar;
  const Setup<S> setup = ftc_4rw<S>();
  typename TypeParam::Params p(setup);
  p.k_lin = S(1);
  p.k_sgn = S(1);
  // slope dt < 2 J of the smallest inertia, 14.8: a slope of 3600 N m s is too much, one of 2400 is not
  p.width = p.k_sgn / S(3600);
  EXPECT_EQ(TypeParam::check(setup, p).code, Status<S>::Code::unstable);
  p.width = p.k_sgn / S(2400);
  EXPECT_TRUE(TypeParam::check(setup, p).ok());
}

TEST(MixedLearningTerminal, ReachesWithThePowerOfS) {
  const auto setup = ftc_4rw<double>();
  MixedLearningTerminalSlidingMode<double>::Params p(setup);
  p.k_power = 0;
  Alone<MixedLearningTerminalSlidingMode<double>> without(unchecked, setup, p);
  p.k_power = 0.7;
  p.power_s = 0.6;
  Alone<MixedLearningTerminalSlidingMode<double>> with(unchecked, setup, p);
  Random random(10);
  const Estimate<double> x = some_estimate<double>(random);
  const Vec3<double> difference = without.start(x, {}, {}).tau_B - with.start(x, {}, {}).tau_B;
  const std::vector<double> s = telemetry_of(with).at("s");
  for (int i = 0; i < 3; ++i) {
    const double value = s[static_cast<std::size_t>(i)];
    EXPECT_NEAR(difference[i], 0.7 * std::copysign(std::pow(std::abs(value), 0.6), value), 1e-14);
  }
}

TEST(MixedLearningTerminal, RefusesACoreThatIsFasterThanThePeriod) {
  const auto setup = ftc_4rw<double>();
  MixedLearningTerminalSlidingMode<double>::Params p(setup);
  p.delta = 0.1;
  p.terminal = 0.5;
  p.power = 0.5;
  // (delta + 1.5 terminal / sqrt(core)) dt / 2 is one at core = (1.5 terminal dt / (2 - delta dt))^2, 1.41e-5
  p.core = 1.3e-5;
  EXPECT_EQ(MixedLearningTerminalSlidingMode<double>::check(setup, p).code, Status<double>::Code::unstable);
  p.core = 1.5e-5;
  EXPECT_TRUE(MixedLearningTerminalSlidingMode<double>::check(setup, p).ok());
}

TYPED_TEST(SlidingLaws, SwitchInTheirLayer) {
  using S = typename TypeParam::Scalar;
  const Setup<S> setup = ftc_4rw<S>();
  Random random(11);
  for (const S width : {S(0), S(0.2)}) {
    typename TypeParam::Params p(setup);
    p.width = width;
    p.k_sgn = S(0);
    Alone<TypeParam> without(unchecked, setup, p);
    p.k_sgn = S(0.5);
    Alone<TypeParam> with(unchecked, setup, p);
    for (int k = 0; k < 20; ++k) {
      const Estimate<S> x = some_estimate<S>(random);
      const Vec3<S> difference = without.start(x, {}, {}).tau_B - with.start(x, {}, {}).tau_B;
      const std::vector<double> s = telemetry_of(with).at("s");
      for (int i = 0; i < 3; ++i) {
        const double value = s[static_cast<std::size_t>(i)];
        const double shape = width > S(0) ? std::clamp(value / 0.2, -1.0, 1.0) : (value > 0 ? 1 : -1);
        EXPECT_NEAR(static_cast<double>(difference[i]), 0.5 * shape, sizeof(S) == 8 ? 1e-13 : 1e-5);
      }
    }
  }
}

}  // namespace
}  // namespace gyrostat::test::test_mixed_learning_laws
