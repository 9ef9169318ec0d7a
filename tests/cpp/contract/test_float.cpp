// SPDX-License-Identifier: MIT
// What holds of every component in float beside double, and how large signals are.
#include "contract/counted_eigen.hpp"  // first

#include <gtest/gtest.h>

#include "any_components.hpp"

namespace gyrostat::test::test_float {
namespace {

// ---- float ---------------------------------------------------------------------------------------------------------

template <class S>
Allocation<S> commanded(Tick k) {
  const double t = 0.01 * static_cast<double>(k);
  Allocation<S> a = Allocation<S>::idle(4);
  a.u << S(0.1 * std::sin(t)), S(-0.05), S(0.08 * std::cos(2 * t)), S(0.03);
  return a;
}

template <class S>
Estimate<S> estimated(Tick k) {
  const double t = 0.01 * static_cast<double>(k);
  Estimate<S> x = Estimate<S>::healthy(wobble<S>(k, 4));
  x.d_B = {S(0.01), S(-0.02 * std::sin(t)), S(0.015)};
  x.effectiveness << S(0.9), S(0.4 + 0.1 * std::cos(t)), S(1), S(0.7);
  x.effectiveness_bound.setConstant(S(0.1));
  return x;
}

// What a component gives at sample k, whatever its scalar.
template <Observer T, class S = typename T::Scalar>
VecN<double> answer(T& observer, Tick k) {
  const Vehicle<S> vehicle = ftc_4rw<S>().vehicle;
  const Measurement<S> y = wobble<S>(k, 4);
  const Estimate<S> x = k == 0 ? observer.start(vehicle, y) : observer.step(vehicle, y, commanded<S>(k - 1));
  VecN<double> out(7);
  out << x.d_B.template cast<double>(), x.effectiveness.template cast<double>();
  return out;
}
template <Detector T, class S = typename T::Scalar>
VecN<double> answer(T& detector, Tick k) {
  const Vehicle<S> vehicle = ftc_4rw<S>().vehicle;
  const Estimate<S> x = estimated<S>(k);
  const Detection<S> det = k == 0 ? detector.start(vehicle, x) : detector.step(vehicle, x, commanded<S>(k - 1));
  return VecN<double>::Constant(1, det.enabled.bits() + 16.0 * det.changed.bits());
}
template <Controller T, class S = typename T::Scalar>
VecN<double> answer(T& controller, Tick k) {
  const Vehicle<S> vehicle = ftc_4rw<S>().vehicle;
  const Estimate<S> x = estimated<S>(k);
  const Detection<S> det = Detection<S>::none(vehicle);
  return (k == 0 ? controller.start(vehicle, x, det, {}) : controller.step(vehicle, x, det, {}, commanded<S>(k - 1)))
      .tau_B.template cast<double>();
}
template <Allocator T, class S = typename T::Scalar>
VecN<double> answer(T& allocator, Tick k) {
  const Vehicle<S> vehicle = ftc_4rw<S>().vehicle;
  Demand<S> demand;
  demand.tau_B = vehicle.D_B * commanded<S>(k).u;
  demand.u_pref.setZero(4);
  const Estimate<S> x = estimated<S>(k);
  return allocator.step(vehicle, demand, x, Detection<S>::none(vehicle)).u.template cast<double>();
}

/// Over 500 samples, of the largest number that the component gives.
double float_deviation(auto& one, auto& other) {
  double worst = 0, largest = 0;
  for (Tick k = 0; k < 500; ++k) {
    const VecN<double> a = answer(one, k), b = answer(other, k);
    worst = std::max(worst, (a - b).cwiseAbs().maxCoeff());
    largest = std::max(largest, b.cwiseAbs().maxCoeff());
  }
  return largest > 0 ? worst / largest : worst;
}

/// Every component of a role but those that say `switching`; how many there were.
template <template <class> class Any, template <class> class Role>
int expect_float_to_follow_double() {
  const gyrostat::Setup<float> setup = ftc_4rw<float>();
  const gyrostat::Setup<double> same = ftc_4rw<double>();
  int held = 0;
  for (std::size_t i = 0; i < makers<Role<double>>().size(); ++i) {
    Any<float> one(makers<Role<float>>()[i], setup, setup);
    Any<double> other(makers<Role<double>>()[i], same, same);
    if (other.traits().switching) continue;
    EXPECT_LT(float_deviation(one, other), 1e-3) << other.name();
    ++held;
  }
  return held;
}

TEST(EmbeddedFloat, FollowsDoubleSampleBySampleWhereNothingSwitches) {
  EXPECT_GT((expect_float_to_follow_double<AnyObserver, ObserverRole>()), 0);
  EXPECT_GT((expect_float_to_follow_double<AnyDetector, DetectorRole>()), 0);
  EXPECT_GT((expect_float_to_follow_double<AnyController, ControllerRole>()), 0);
  EXPECT_GT((expect_float_to_follow_double<AnyAllocator, AllocatorRole>()), 0);
}

TEST(Signals, StaySmall) {
  EXPECT_LE(sizeof(Estimate<double>), 640u + sizeof(Axes<double>));
  EXPECT_LE(sizeof(Allocation<double>), 384u);
}

}  // namespace
}  // namespace gyrostat::test::test_float
