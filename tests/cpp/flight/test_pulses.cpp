// SPDX-License-Identifier: MIT
#include "gyrostat/flight/pulses.hpp"

#include <gtest/gtest.h>

#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_pulses {
namespace {

template <class S>
class Pulses : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Pulses, Scalars);

/// Six thrusters, a pair of opposite ones an axis, of `ticks` ticks a period; the last actuator is a wheel.
template <class S>
Setup<S> six_and_a_wheel(int ticks, int min_on, int min_off) {
  Setup<S> setup;
  setup.dt = S(0.5);
  Vehicle<S>& v = setup.vehicle;
  v.J_B = Vec3<S>(S(120), S(100), S(110)).asDiagonal();
  v.D_B.resize(3, 7);
  v.D_B << Mat3<S>::Identity(), -Mat3<S>::Identity(), Vec3<S>::UnitX();
  v.u_lo = VecN<S>::Zero(7);
  v.u_up = VecN<S>::Constant(7, S(0.8));
  v.u_lo[6] = S(-0.8);
  v.u_rate = VecN<S>::Constant(7, std::numeric_limits<S>::infinity());
  v.h_max = v.u_rate;
  v.u_quantum = v.u_up / S(ticks);
  v.u_quantum[6] = S(0);
  v.u_dead = S(min_on) * v.u_quantum;
  v.u_gap = S(min_off) * v.u_quantum;
  v.wheels.set(6);
  return setup;
}

TYPED_TEST(Pulses, AreTheNearestWholeTicksWithNeitherShortPulsesNorShortPauses) {
  using S = TypeParam;
  for (const int ticks : {7, 32, 100, 1000}) {
    const Vehicle<S> v = six_and_a_wheel<S>(ticks, 2, 3).vehicle;
    for (int k = 0; k <= 2000; ++k) {
      const S share = S(k) / S(2000), exact = share * S(ticks);
      if (std::abs(exact - std::floor(exact) - S(0.5)) < S(1e-3)) continue;  // a tie, or as good as one in float
      const VecN<S> u = as_pulses<S>(v, VecN<S>::Constant(7, share * S(0.8)));
      const S nearest = std::round(exact);
      const S wanted = nearest < S(2) ? S(0) : S(ticks) - nearest < S(3) ? S(ticks) : nearest;
      ASSERT_NEAR(u[0] / v.u_quantum[0], wanted, S(ticks) * S(10) * std::numeric_limits<S>::epsilon()) << share;
      ASSERT_EQ(u[6], share * S(0.8));   // the wheel's is its own
      ASSERT_EQ(as_pulses<S>(v, u), u);  // to the last bit
    }
  }
}

TYPED_TEST(Pulses, AVehicleWithoutOnOffActuatorsHasNone) {
  using S = TypeParam;
  EXPECT_FALSE(any_pulses(ftc_4rw<S>().vehicle));
  Vehicle<S> v = six_and_a_wheel<S>(32, 1, 1).vehicle;
  EXPECT_TRUE(any_pulses(v));
  v.u_quantum.setZero();
  EXPECT_FALSE(any_pulses(v));
}

TYPED_TEST(Pulses, OfTheStackAreWhatItSaysItAchieved) {
  using S = TypeParam;
  using Stack = FlightStack<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>;
  const Setup<S> setup = six_and_a_wheel<S>(32, 2, 2);
  const typename Stack::Params params(setup);
  Checked<Stack> checked(setup, params);
  ASSERT_TRUE(checked);
  int pulses = 0;
  for (Tick k = 0; k < 200; ++k) {
    Measurement<S> y;
    y.tick = k;
    y.omega_BN_B = Vec3<S>(std::sin(S(0.1) * S(k)), std::cos(S(0.13) * S(k)), S(0.3)) * S(0.01);
    y.h_w = VecN<S>::Zero(7);
    const Allocation<S>& a = checked->step(y, {});
    ASSERT_EQ(as_pulses<S>(setup.vehicle, a.u), a.u);
    ASSERT_LT((a.achieved_B - torque<S>(setup.vehicle.D_B, a.u)).norm(), S(1e-6));
    for (int i = 0; i < 6; ++i) pulses += a.u[i] > S(0);
  }
  EXPECT_GT(pulses, 100);
}

}  // namespace
}  // namespace gyrostat::test::test_pulses
