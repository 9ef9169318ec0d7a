// SPDX-License-Identifier: MIT
/// The catalogue's optimal allocators as flight flies them: limits, rates, masks, estimates, flags; no heap, no exceptions.
#define EIGEN_RUNTIME_NO_MALLOC
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <string_view>
#include <utility>

#include "flight/alone.hpp"
#include "flight/telemetry_log.hpp"
#include "flight/vehicles.hpp"
#include "gyrostat/core/concepts.hpp"
#include "gyrostat/flight/allocators.hpp"
#include "random.hpp"

namespace {
long allocations = 0;  // of the whole program
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  std::abort();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace gyrostat::test::test_optimal_allocators {
namespace {

template <class S>
Estimate<S> healthy(int n) {
  Measurement<S> y;
  y.h_w = VecN<S>::Zero(n);
  return Estimate<S>::healthy(y);
}

template <class S>
Demand<S> demand(S x, S y, S z) {
  Demand<S> d;
  d.tau_B = {x, y, z};
  return d;
}

template <class S>
double missing(const Allocation<S>& a) {
  return static_cast<double>((a.demand_B - a.achieved_B).norm());
}

template <class S>
class OptimalAllocators : public testing::Test {
 protected:
  gyrostat::Setup<S> setup = ftc_4rw<S>();
  Detection<S> none = Detection<S>::none(setup.vehicle);

  /// Calls with(default allocator) for each of the optimal ones.
  void for_each(auto&& with) const {
    for_each([](auto&) {}, with);
  }
  /// The same with changed parameters.
  void for_each(auto&& change, auto&& with) const {
    Allocators::each<S>([&]<class A>() {
      if constexpr (std::derived_from<A, OptimalAllocator<S>>) with(make<A>(setup, change));
    });
  }
  /// Calls with(allocator) for every one of the catalogue that drops weak axes, with this rank_tolerance.
  void for_all(S rank_tolerance, auto&& with) const {
    const auto change = [&](auto& p) { p.rank_tolerance = rank_tolerance; };
    Allocators::each<S>([&]<class A>() {
      if constexpr (requires(typename A::Params p) { p.rank_tolerance; }) with(make<A>(setup, change));
    });
  }
  /// Wheels whose third axis is `weak` times as strong as the other two.
  void flatten(S weak) {
    Mat3N<S> D(3, 4);
    D << S(1), S(-1), S(1), S(-1), S(1), S(1), S(-1), S(-1), weak, -weak, -weak, weak;
    setup.vehicle.D_B = D / S(2);
  }
  template <class A>
  static Alone<A> make(const gyrostat::Setup<S>& s, auto&& change) {
    typename A::Params params(s);
    change(params);
    EXPECT_TRUE(A::check(s, params).ok());
    return Alone<A>(unchecked, s, params);
  }
  template <class A>
  static Alone<A> make(const gyrostat::Setup<S>& s) {
    return make<A>(s, [](auto&) {});
  }
  static constexpr bool single = sizeof(S) < 8;
};
#if defined(__SANITIZE_ADDRESS__)
using Scalars = testing::Types<double>;  // half the compilation; the code a sanitizer watches is the same
#else
using Scalars = testing::Types<double, float>;
#endif
TYPED_TEST_SUITE(OptimalAllocators, Scalars);

TYPED_TEST(OptimalAllocators, KeepLimitsAndRatesOnARandomWalkOfDemandsAndFaults) {
  using S = TypeParam;
  this->setup.vehicle.u_rate.setConstant(S(2));  // 0.02 N m a sample
  this->for_each([&](auto allocator) {
    static_assert(Allocator<typename decltype(allocator)::Component>);
    static_assert(noexcept(allocator.step(std::declval<const Demand<S>&>(), std::declval<const Estimate<S>&>(),
                                          std::declval<const Detection<S>&>())));
    Random random(9);
    Estimate<S> x = healthy<S>(4);
    VecN<S> last = VecN<S>::Zero(4);
    for (int k = 0; k < 400; ++k) {
      if (k % 20 == 0)
        for (int i = 0; i < 4; ++i) {
          x.effectiveness[i] = S(random.uniform(-0.1, 1.1));  // an observer may be wrong
          x.effectiveness_bound[i] =
              random.uniform(0, 1) < 0.3 ? std::numeric_limits<S>::infinity() : S(random.uniform(0, 0.3));
        }
      const Vec3<S> wish = random.vector<S>(0.3);
      const Allocation<S> a = allocator.step(demand<S>(wish[0], wish[1], wish[2]), x, this->none);
      EXPECT_LE(a.u.cwiseAbs().maxCoeff(), S(0.2)) << allocator.name;
      EXPECT_LE((a.u - last).cwiseAbs().maxCoeff(), S(0.02) * (1 + Eigen::NumTraits<S>::epsilon() * 16))
          << allocator.name;
      EXPECT_FALSE(a.status.has(Flag::bad_input) || a.status.has(Flag::cap_reached)) << allocator.name << ' ' << k;
      const Vec3<S> achieved = this->setup.vehicle.D_B * x.effectiveness.cwiseProduct(a.u);
      EXPECT_LE((a.achieved_B - achieved).norm(), S(4) * Eigen::NumTraits<S>::epsilon()) << allocator.name;
      last = a.u;
    }
  });
}

/// The worst case of a step, made to happen: the limit is lowered until solves end at it.
TYPED_TEST(OptimalAllocators, EndAtTheirLimitOfNewtonStepsInsideTheBoxAndSaySo) {
  using S = TypeParam;
  const auto few = [](auto& p) { p.max_newton = 1; };
  const auto walk = [this](auto allocator, int limit) {
    Random random(13);
    Estimate<S> x = healthy<S>(4);
    int reached = 0;
    for (int k = 0; k < 400; ++k) {
      for (int i = 0; i < 4; ++i) x.effectiveness[i] = S(random.uniform(0.05, 1));
      const Vec3<S> wish = random.vector<S>(0.5);  // mostly out of reach
      const Allocation<S> a = allocator.step(demand<S>(wish[0], wish[1], wish[2]), x, this->none);
      EXPECT_LE(a.u.cwiseAbs().maxCoeff(), S(0.2)) << allocator.name << ' ' << k;
      EXPECT_TRUE(std::isfinite(a.gap)) << allocator.name << ' ' << k;
      EXPECT_LE(a.iterations, limit) << allocator.name << ' ' << k;
      reached += a.status.has(Flag::cap_reached);
    }
    return reached;
  };
  const auto expect_ends = [&](auto limited, auto usual) {
    EXPECT_GT(walk(limited, 1), 100) << limited.name;
    EXPECT_EQ(walk(usual, 200), 0) << usual.name;
  };
  expect_ends(this->template make<Lexicographic<S>>(this->setup, few),
              this->template make<Lexicographic<S>>(this->setup));
  expect_ends(this->template make<LexicographicScaled<S>>(this->setup, few),
              this->template make<LexicographicScaled<S>>(this->setup));
  expect_ends(this->template make<WeightedLeastSquares<S>>(this->setup, few),
              this->template make<WeightedLeastSquares<S>>(this->setup));
  expect_ends(this->template make<RobustSocp<S>>(this->setup, few), this->template make<RobustSocp<S>>(this->setup));
}

TYPED_TEST(OptimalAllocators, UseNeitherFailedNorSpareActuatorsAndSayWhatThatCosts) {
  using S = TypeParam;
  this->setup.vehicle.spare.set(3);
  Detection<S> det = Detection<S>::none(this->setup.vehicle);
  this->for_each([&](auto allocator) {
    Allocation<S> a = allocator.step(demand<S>(S(0.05), S(0.02), S(0.1)), healthy<S>(4), det);
    EXPECT_EQ(a.u[3], S(0));
    EXPECT_FALSE(a.status.has(Flag::rank_lost));
    Detection<S> failed = det;
    failed.failed.set(1);  // two wheels are left: one axis is lost
    allocator.reset();
    a = allocator.step(demand<S>(S(0.05), S(0.02), S(0.1)), healthy<S>(4), failed);
    EXPECT_EQ(a.u[1], S(0));
    EXPECT_EQ(a.u[3], S(0));
    EXPECT_TRUE(a.status.has(Flag::rank_lost) && a.status.has(Flag::demand_not_met)) << allocator.name;
    EXPECT_FALSE(a.saturated.test(1) || a.saturated.test(3));
  });
}

TYPED_TEST(OptimalAllocators, AndThePseudoInverseIgnoreTheDemandAlongAWeakAxisAndServeTheOthers) {
  using S = TypeParam;
  for (const double weak : {0.0, 2e-5, 1e-3, 9e-3}) {
    this->flatten(S(weak));
    this->for_all(S(0.01), [&](auto allocator) {
      const Allocation<S> without = allocator.step(demand<S>(S(0.05), S(-0.03), S(0)), healthy<S>(4), this->none);
      allocator.reset();
      const Allocation<S> a = allocator.step(demand<S>(S(0.05), S(-0.03), S(0.02)), healthy<S>(4), this->none);
      EXPECT_TRUE(a.status.has(Flag::rank_lost) && a.status.has(Flag::demand_not_met)) << allocator.name << ' ' << weak;
      EXPECT_TRUE(without.status.has(Flag::rank_lost)) << allocator.name << ' ' << weak;
      EXPECT_FALSE(a.status.has(Flag::cap_reached)) << allocator.name << ' ' << weak;
      EXPECT_LE((a.u - without.u).norm(), this->single ? 1e-4 : 1e-9) << allocator.name << ' ' << weak;
      EXPECT_LE((a.achieved_B - a.demand_B).template head<2>().norm(), 0.03 * 0.06) << allocator.name << ' ' << weak;
      EXPECT_FALSE(a.saturated.any()) << allocator.name << ' ' << weak;
    });
  }
}

TYPED_TEST(OptimalAllocators, AndThePseudoInverseServeAnAxisAboveTheToleranceAndFlagNothing) {
  using S = TypeParam;
  const auto served = [&](double weak, double tolerance) {
    this->flatten(S(weak));
    this->for_all(S(tolerance), [&](auto allocator) {
      const S z = S(0.05 * weak);  // a quarter of the limits' worth
      const Allocation<S> a = allocator.step(demand<S>(S(0), S(0), z), healthy<S>(4), this->none);
      EXPECT_FALSE(a.status.has(Flag::rank_lost)) << allocator.name << ' ' << weak;
      const std::string_view name = allocator.name;
      if (name == "weighted_least_squares" || name == "robust_socp") return;  // the price of effort is against it
      EXPECT_NEAR(double(a.achieved_B[2] / z), 1, this->single ? 1e-3 : 1e-9) << name << ' ' << weak;
      EXPECT_FALSE(a.status.has(Flag::demand_not_met)) << name << ' ' << weak;
    });
  };
  served(0.011, 0.01);
  served(0.1, 0.01);
  served(2e-3, 1e-3);  // the tolerance is a parameter
}

TYPED_TEST(OptimalAllocators, AndThePseudoInverseSeeTheWeakAxisOfWheelsThatAreLeft) {
  using S = TypeParam;
  // Of three wheels, the third is what makes an axis: its effectiveness decides. 0.013 is a singular value of 0.0092 of the
  // largest, 0.016 one of 0.0113.
  Detection<S> failed = this->none;
  failed.failed.set(3);
  const auto small_e_min = [](auto& p) { p.e_min = S(0.01); };
  const auto expect_flag = [&](auto allocator) {
    for (const auto& [e, lost] : {std::pair{0.013, true}, std::pair{0.016, false}}) {
      Estimate<S> x = healthy<S>(4);
      x.effectiveness[1] = S(e);
      allocator.reset();
      const Allocation<S> a = allocator.step(demand<S>(S(0.01), S(0.01), S(0.01)), x, failed);
      EXPECT_EQ(a.status.has(Flag::rank_lost), lost) << allocator.name << ' ' << e;
    }
  };
  expect_flag(this->template make<PseudoInverse<S>>(this->setup, small_e_min));
  this->for_each(small_e_min, expect_flag);
}

/// Estimates of three wheels wander over the threshold of an axis, and over that of an actuator: few changes, not hundreds.
TYPED_TEST(OptimalAllocators, AndThePseudoInverseDoNotChatterWhereAnEstimateLiesOnAThreshold) {
  using S = TypeParam;
  Detection<S> failed = this->none;
  failed.failed.set(3);
  const auto small_e_min = [](auto& p) { p.e_min = S(0.01); };
  const auto large_e_min = [](auto& p) { p.e_min = S(0.05); };
  const auto expect_calm = [&](auto allocator, double threshold) {
    Random random(31);
    Estimate<S> x = healthy<S>(4);
    int changes = 0;
    bool last = false;
    for (int k = 0; k < 1000; ++k) {
      x.effectiveness[1] = S(threshold * random.uniform(0.85, 1.15));
      const Allocation<S> a = allocator.step(demand<S>(S(0.01), S(0.005), S(0.01)), x, failed);
      changes += k > 0 && a.status.has(Flag::rank_lost) != last ? 1 : 0;
      last = a.status.has(Flag::rank_lost);
    }
    EXPECT_LE(changes, 1) << allocator.name << ' ' << threshold;  // into use, once
  };
  expect_calm(this->template make<PseudoInverse<S>>(this->setup, small_e_min), 0.0141);  // singular value 0.01
  expect_calm(this->template make<PseudoInverse<S>>(this->setup, large_e_min), 0.05);
  this->for_each([&](auto allocator) { expect_calm(allocator, 0.0141); });
  expect_calm(this->template make<Lexicographic<S>>(this->setup, large_e_min), 0.05);
}

TYPED_TEST(OptimalAllocators, MeetAnAttainableDemandPastAWeakWheel) {
  using S = TypeParam;
  Estimate<S> x = healthy<S>(4);
  x.effectiveness[2] = S(0.4);
  const Demand<S> d = demand<S>(S(0.1), S(-0.05), S(0.08));
  const double exact = this->single ? 1e-6 : 1e-15;
  Allocation<S> a = this->template make<Lexicographic<S>>(this->setup).step(d, x, this->none);
  EXPECT_LE(missing(a), exact);
  EXPECT_FALSE(a.status.has(Flag::demand_not_met));
  EXPECT_LE(missing(this->template make<LexicographicScaled<S>>(this->setup).step(d, x, this->none)), exact);
  // 1 / residual_weight, over the smallest squared singular value of A, about 0.6
  EXPECT_LE(missing(this->template make<WeightedLeastSquares<S>>(this->setup).step(d, x, this->none)), 2e-4 * 0.14);
}

TYPED_TEST(OptimalAllocators, KeepThePreferredCommandWhereItCostsNoTorque) {
  using S = TypeParam;
  Demand<S> d = demand<S>(S(0), S(0), S(0));
  d.u_pref.resize(4);
  d.u_pref << S(0.05), S(-0.05), S(0.05), S(-0.05);  // the null motion of the pyramid
  const Allocation<S> a = this->template make<Lexicographic<S>>(this->setup).step(d, healthy<S>(4), this->none);
  EXPECT_LE((a.u - d.u_pref).norm(), this->single ? 1e-6 : 1e-15);
  EXPECT_LE(missing(a), this->single ? 1e-6 : 1e-15);
}

TYPED_TEST(OptimalAllocators, PhysicalBoundsLetAWeakWheelWorkToItsLimitDeratedOnesDoNot) {
  using S = TypeParam;
  Estimate<S> x = healthy<S>(4);
  x.effectiveness[0] = S(0.5);
  const Demand<S> d = demand<S>(S(1), S(1), S(1));  // far along the axis of wheel 0
  const Allocation<S> physical = this->template make<Lexicographic<S>>(this->setup).step(d, x, this->none);
  EXPECT_EQ(physical.u[0], S(0.2));
  EXPECT_TRUE(physical.saturated.test(0));
  const auto derated = [](auto& p) { p.bound_policy = BoundPolicy::derated; };
  const Allocation<S> a = this->template make<Lexicographic<S>>(this->setup, derated).step(d, x, this->none);
  EXPECT_FLOAT_EQ(static_cast<float>(a.u[0]), 0.1f);
  EXPECT_GT(missing(a), missing(physical));
}

TYPED_TEST(OptimalAllocators, DeratingAWheelThatJustFailedKeepsItsRate) {
  using S = TypeParam;
  this->setup.vehicle.u_rate.setConstant(S(1));
  auto allocator =
      this->template make<Lexicographic<S>>(this->setup, [](auto& p) { p.bound_policy = BoundPolicy::derated; });
  Estimate<S> x = healthy<S>(4);
  const Demand<S> d = demand<S>(S(1), S(1), S(1));
  Allocation<S> a;
  for (int k = 0; k < 30; ++k) a = allocator.step(d, x, this->none);
  ASSERT_EQ(a.u[0], S(0.2));
  x.effectiveness[0] = S(0.5);  // its limit falls from 0.2 to 0.1 at once
  a = allocator.step(d, x, this->none);
  EXPECT_NEAR(static_cast<double>(a.u[0]), 0.19, 1e-6);
  for (int k = 0; k < 20; ++k) a = allocator.step(d, x, this->none);
  EXPECT_NEAR(static_cast<double>(a.u[0]), 0.1, 1e-6);
}

TYPED_TEST(OptimalAllocators, WorkWithoutKnownLimits) {
  using S = TypeParam;
  this->setup.vehicle.u_up.setConstant(std::numeric_limits<S>::infinity());
  this->setup.vehicle.u_lo = -this->setup.vehicle.u_up;
  const Demand<S> d = demand<S>(S(3), S(-2), S(5));
  const Mat3N<S> D = this->setup.vehicle.D_B;
  const VecN<S> expected = S(0.75) * D.transpose() * d.tau_B;  // D D' = 4/3 I
  const Allocation<S> a = this->template make<Lexicographic<S>>(this->setup).step(d, healthy<S>(4), this->none);
  EXPECT_LE((a.u - expected).norm(), S(64) * Eigen::NumTraits<S>::epsilon() * expected.norm());
  EXPECT_FALSE(a.saturated.any());
  EXPECT_LE(missing(this->template make<RobustSocp<S>>(this->setup).step(d, healthy<S>(4), this->none)), 0.2);
}

TYPED_TEST(OptimalAllocators, AxisOfFirstPriorityGetsAllItCan) {
  using S = TypeParam;
  const auto z_first = [](auto& p) { p.axis_priority = {S(1), S(1), S(0)}; };
  const Demand<S> d = demand<S>(S(0.4), S(0.4), S(0.4));
  const double z_together = static_cast<double>(
      this->template make<Lexicographic<S>>(this->setup).step(d, healthy<S>(4), this->none).achieved_B[2]);
  const Allocation<S> a =
      this->template make<Lexicographic<S>>(this->setup, z_first).step(d, healthy<S>(4), this->none);
  EXPECT_LT(z_together, 0.39);
  EXPECT_NEAR(static_cast<double>(a.achieved_B[2]), 0.4,
              this->single ? 1e-5 : 1e-12);  // 4 x 0.2 / sqrt 3 = 0.46 can be had
}

TYPED_TEST(OptimalAllocators, UncertainWheelsAreSparedAtNoLossOfTorque) {
  using S = TypeParam;
  Estimate<S> x = healthy<S>(4);
  x.effectiveness_bound << S(0.1), S(0), S(0), S(0);
  const Demand<S> d = demand<S>(S(0.1), S(0), S(0.05));
  const auto careful = [](auto& p) { p.uncertainty_weight = S(1e3); };
  const Allocation<S> plain = this->template make<Lexicographic<S>>(this->setup).step(d, x, this->none);
  const Allocation<S> spared = this->template make<Lexicographic<S>>(this->setup, careful).step(d, x, this->none);
  EXPECT_LT(std::abs(spared.u[0]), S(0.5) * std::abs(plain.u[0]));
  EXPECT_LE(missing(spared), this->single ? 1e-6 : 1e-15);
  EXPECT_LT(spared.worst_case, plain.worst_case);
}

TYPED_TEST(OptimalAllocators, RefuseOtherNumbersOfWeightsThanActuators) {
  using S = TypeParam;
  typename Lexicographic<S>::Params params(this->setup);
  params.effort_weight = VecN<S>::Ones(3);
  EXPECT_FALSE(Lexicographic<S>::check(this->setup, params).ok());
}

TYPED_TEST(OptimalAllocators, TelemetryProvesAnUnreachableDemand) {
  using S = TypeParam;
  auto allocator = this->template make<Lexicographic<S>>(this->setup);
  const Demand<S> d = demand<S>(S(0.5), S(0.1), S(0.1));
  EXPECT_TRUE(allocator.step(d, healthy<S>(4), this->none).status.has(Flag::demand_not_met));
  const std::vector<double> v = telemetry_of(allocator).at("unreachable_B");
  double reached = 0, asked = 0;
  for (int i = 0; i < 4; ++i) {
    double along = 0;
    for (int r = 0; r < 3; ++r) along += v[std::size_t(r)] * static_cast<double>(this->setup.vehicle.D_B(r, i));
    reached += 0.2 * std::abs(along);
  }
  for (int r = 0; r < 3; ++r) asked += v[std::size_t(r)] * static_cast<double>(d.tau_B[r]);
  EXPECT_GT(asked, reached * 1.1);
}

TYPED_TEST(OptimalAllocators, AllocateNoMemory) {
  using S = TypeParam;
  this->for_each([&](auto allocator) {
    Estimate<S> x = healthy<S>(4);
    Random random(2);
    Eigen::internal::set_is_malloc_allowed(false);
    const long before = allocations;
    bool finite = true;
    for (int k = 0; k < 500; ++k) {
      x.effectiveness[k % 4] = S(random.uniform(0, 1));
      const Vec3<S> wish = random.vector<S>(0.3);
      finite = finite && allocator.step(demand<S>(wish[0], wish[1], wish[2]), x, this->none).u.allFinite();
    }
    allocator.reset();
    const long after = allocations;
    Eigen::internal::set_is_malloc_allowed(true);
    EXPECT_EQ(after, before) << allocator.name;
    EXPECT_TRUE(finite);
  });
}

/// What a component must pose to the solver, by hand, and what the solver answers.
template <class S>
struct Posed {
  AllocationSolver<S, 3, max_actuators> solver;
  AllocationProblem<S, 3, max_actuators> p;
  AllocationState<S, 3, max_actuators> state;

  Posed(const gyrostat::Setup<S>& setup, const Estimate<S>& x, const Demand<S>& d, AllocationMode mode,
        const Vec3<S>& axis_weight)
      : p(AllocationProblem<S, 3, max_actuators>::symmetric(setup.vehicle.actuators(), S(0.2))) {
    p.mode = mode;
    p.demand = d.tau_B;
    p.effectiveness = x.effectiveness;
    p.bound = x.effectiveness_bound.cwiseMin(S(0.1));
    p.effectiveness_min = S(0.01);
    EXPECT_TRUE(solver.configure(setup.vehicle.D_B, axis_weight));
  }
  AllocationSolution<S, 3, max_actuators> solution() { return solver.solve(p, state); }
};

TYPED_TEST(OptimalAllocators, PoseTheirParametersAndTellWhatTheSolverAnswers) {
  using S = TypeParam;
  Estimate<S> x = healthy<S>(4);
  x.effectiveness << S(0.9), S(0.5), S(1), S(0.7);
  x.effectiveness_bound << S(0.05), std::numeric_limits<S>::infinity(), S(0.02), S(0.3);
  const Vec3<S> weight(S(1), S(2), S(0.5));
  const auto shared = [&](auto& p) {
    p.axis_weight = weight;
    p.max_newton = 2;  // ends early: gaps that are not rounding
  };
  int gaps = 0;
  Random random(31);
  for (int k = 0; k < 60; ++k) {
    const Vec3<S> wish = random.vector<S>(0.4);
    const Demand<S> d = demand<S>(wish[0], wish[1], wish[2]);
    const auto expect = [&](auto component, AllocationMode mode, bool weighted, auto&& pose) {
      Posed<S> posed(this->setup, x, d, mode, weight);
      posed.p.max_newton = 2;
      pose(posed.p);
      const auto s = posed.solution();
      const Allocation<S> a = component.step(d, x, this->none);
      EXPECT_EQ(a.u, s.command) << component.name << ' ' << k;
      EXPECT_EQ(a.gap, weighted ? s.gap : s.residual_excess) << component.name << ' ' << k;
      EXPECT_EQ(a.worst_case, s.worst_case) << component.name;
      EXPECT_EQ(a.iterations, s.newton) << component.name;
      EXPECT_EQ(a.saturated.bits(), s.saturated) << component.name;
      EXPECT_EQ(a.status.has(Flag::cap_reached), s.status == AllocationStatus::cap_reached) << component.name;
      EXPECT_EQ(a.status.has(Flag::demand_not_met), s.status == AllocationStatus::optimal_reduced) << component.name;
      gaps += a.gap > S(1e-6) ? 1 : 0;
    };
    expect(this->template make<Lexicographic<S>>(this->setup, shared), AllocationMode::lexicographic, false,
           [](auto&) {});
    expect(this->template make<Lexicographic<S>>(this->setup,
                                                 [&](auto& p) {
                                                   shared(p);
                                                   p.axis_priority = {S(0), S(2), S(1)};
                                                 }),
           AllocationMode::lexicographic, false, [](auto& p) { p.priority = {0, 2, 1}; });
    expect(this->template make<LexicographicScaled<S>>(this->setup, shared), AllocationMode::lexicographic_scaled,
           false, [](auto&) {});
    expect(this->template make<WeightedLeastSquares<S>>(this->setup,
                                                        [&](auto& p) {
                                                          shared(p);
                                                          p.residual_weight = S(20);
                                                          p.uncertainty_weight = S(300);
                                                          p.effort_weight << S(1), S(2), S(3), S(4);
                                                        }),
           AllocationMode::weighted_least_squares, true, [&](auto& p) {
             p.residual_weight = S(20);
             for (int i = 0; i < 4; ++i) {
               const S spread = p.bound[i] * x.effectiveness[i];
               p.effort_weight[i] = static_cast<S>(i + 1) + S(300) * spread * spread;
             }
           });
    for (const WorstCase worst : {WorstCase::bound, WorstCase::exact, WorstCase::paper_constant})
      expect(this->template make<RobustSocp<S>>(this->setup,
                                                [&](auto& p) {
                                                  shared(p);
                                                  p.residual_weight = S(200);
                                                  p.worst_case = worst;
                                                  p.margin = S(0.03);
                                                }),
             AllocationMode::robust_socp, true, [&](auto& p) {
               p.residual_weight = S(200);
               p.worst_case = worst;
               p.margin = S(0.03);
             });
  }
  EXPECT_GT(gaps, 50) << "most of these solves end early, and say how far from the optimum";
}

TYPED_TEST(OptimalAllocators, ForgetActuatorsThatMayNotBeUsedAndTakeThemBack) {
  using S = TypeParam;
  this->setup.vehicle.u_lo.setZero();  // nozzles: an idle one sits on its limit
  this->for_each([&](auto allocator) {
    Demand<S> d = demand<S>(S(0), S(0), S(0.2));
    d.u_pref = VecN<S>::Constant(4, S(0.1));
    const Estimate<S> x = healthy<S>(4);
    const VecN<S> before = allocator.step(d, x, this->none).u;
    Detection<S> failed = this->none;
    failed.failed.set(1);
    const Allocation<S> a = allocator.step(d, x, failed);
    EXPECT_EQ(a.u[1], S(0)) << allocator.name << ": neither used nor preferred";
    EXPECT_FALSE(a.saturated.test(1)) << allocator.name;
    EXPECT_GT((a.u - before).norm(), S(0.01)) << allocator.name;
    const VecN<S> after = allocator.step(d, x, this->none).u;
    EXPECT_LT((after - before).norm(), this->single ? S(1e-3) : S(1e-8)) << allocator.name;
  });
}

TYPED_TEST(OptimalAllocators, RepeatTheCommandOfBeforeWhenTheyAreAskedForNonsense) {
  using S = TypeParam;
  this->for_each([&](auto allocator) {
    const Estimate<S> x = healthy<S>(4);
    const VecN<S> before = allocator.step(demand<S>(S(0.1), S(-0.05), S(0.02)), x, this->none).u;
    const S nan = std::numeric_limits<S>::quiet_NaN();
    const Allocation<S> a = allocator.step(demand<S>(S(0.1), nan, S(0)), x, this->none);
    EXPECT_TRUE(a.status.has(Flag::bad_input)) << allocator.name;
    EXPECT_EQ(a.u, before) << allocator.name;
  });
}

TYPED_TEST(OptimalAllocators, DeratingKeepsTheRateFromEitherSide) {
  using S = TypeParam;
  this->setup.vehicle.u_rate.setConstant(S(1));
  for (const S sign : {S(1), S(-1)}) {
    auto allocator =
        this->template make<Lexicographic<S>>(this->setup, [](auto& p) { p.bound_policy = BoundPolicy::derated; });
    Estimate<S> x = healthy<S>(4);
    const Demand<S> d = demand<S>(sign, sign, sign);
    Allocation<S> a;
    for (int k = 0; k < 30; ++k) a = allocator.step(d, x, this->none);
    ASSERT_EQ(a.u[0], sign * S(0.2));
    x.effectiveness[0] = S(0.5);
    a = allocator.step(d, x, this->none);
    EXPECT_NEAR(static_cast<double>(a.u[0]), static_cast<double>(sign) * 0.19, 1e-6);
  }
}

TYPED_TEST(OptimalAllocators, DefaultPricesAreThoseOfAUnitAxis) {
  using S = TypeParam;
  gyrostat::Setup<S> strong = this->setup;
  strong.vehicle.D_B.col(2) *= S(10);
  const auto ratio = [&]<class A>(std::type_identity<A>) {
    const S weak_price = typename A::Params(this->setup).residual_weight;
    return static_cast<double>(weak_price / typename A::Params(strong).residual_weight);
  };
  EXPECT_NEAR(ratio(std::type_identity<RobustSocp<S>>{}), 100, 1e-3);
  EXPECT_NEAR(ratio(std::type_identity<WeightedLeastSquares<S>>{}), 100, 1e-3);
}

}  // namespace
}  // namespace gyrostat::test::test_optimal_allocators
