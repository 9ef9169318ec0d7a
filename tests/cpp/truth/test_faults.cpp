// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <tuple>

#include "gyrostat/truth/actuators.hpp"

namespace gyrostat::truth::test_faults {
namespace {

TEST(Faults, SwitchAtOnsetAtTheirLawsJumpsAndAtTheirEnd) {
  const LossOfEffectiveness fault{.window = {.actuator = 1, .t_on = 10, .t_off = 200},
                                  .remaining = StepsWave{{0, 50, 300}, {1, 2, 3}}};
  EXPECT_EQ(next_switch(fault, 0), 10);
  EXPECT_EQ(next_switch(fault, 10), 50);
  EXPECT_EQ(next_switch(fault, 50), 200);  // the law's next jump comes after the end
  EXPECT_EQ(next_switch(fault, 200), infinity);
}

TEST(Faults, IntermittentCountsItsPeriodsFromTheOnset) {
  const Intermittent fault{.window = {.actuator = 0, .t_on = 10}, .period = 4, .duty = 0.25};
  EXPECT_EQ(next_switch(fault, 0), 10);
  EXPECT_EQ(next_switch(fault, 10), 11);
  EXPECT_EQ(next_switch(fault, 11), 14);
  EXPECT_TRUE(fault.gate().is_high(10.5));
  EXPECT_FALSE(fault.gate().is_high(11.5));
}

using List = std::vector<Fault>;

TEST(Faults, ThatDecideOneOutputAtTheSameTimeContradict) {
  const List faults{Bias{.window = {.actuator = 2}}, StuckOutput{.window = {.actuator = 2, .t_on = 5, .t_off = 20}},
                    LossOfEffectiveness{.window = {.actuator = 2}}, Dead{.window = {.actuator = 2, .t_on = 15}}};
  EXPECT_EQ(contradiction(faults), "faults of actuator 2 contradict: stuck (from 5 s to 20 s) and dead (from 15 s)");
}

TEST(Faults, DoNotContradictOneAfterTheOtherOrOnOtherActuators) {
  EXPECT_EQ(contradiction(List{StuckOutput{.window = {.actuator = 2, .t_on = 5, .t_off = 15}},
                               Dead{.window = {.actuator = 2, .t_on = 15}}}),
            "");
  EXPECT_EQ(contradiction(List{Lock{.window = {.actuator = 1}}, HardOver{.window = {.actuator = 0}}}), "");
  EXPECT_EQ(contradiction(List{LossOfEffectiveness{}, Bias{}, Dead{}, Drift{}, Intermittent{}, DeadZone{}}), "");
}

TEST(Faults, SayWhatIsWrong) {
  const std::vector<Limits> four(4);
  EXPECT_EQ(check(Dead{.window = {.actuator = 3}}, four), "");
  EXPECT_NE(check(Dead{.window = {.actuator = 4}}, four).find("actuator 4 does not exist"), std::string::npos);
  EXPECT_EQ(check(Dead{}, four), "fault dead: needs its actuator");
  EXPECT_NE(check(Dead{.window = {.actuator = 0, .t_on = 5, .t_off = 5}}, four).find("t_on"), std::string::npos);
  EXPECT_EQ(check(Dead{.window = {.actuator = 0, .t_on = infinity}}, four), "");  // never
  EXPECT_EQ(check(Intermittent{.window = {.actuator = 0, .t_on = infinity}}, four), "");
  EXPECT_NE(check(HardOver{.window = {.actuator = 0}, .sign = 0}, four).find("sign"), std::string::npos);
  EXPECT_EQ(check(HardOver{.window = {.actuator = 1}}, four),
            "fault hard_over: actuator 1 has no finite limit to run to");
  EXPECT_NE(check(Bias{.window = {.actuator = 0}, .torque = SquareWave{.period = 0}}, four).find("fault bias: period"),
            std::string::npos);
}

// ---- the contract, of every kind there is ----------------------------------------------------------------------------

/// The waveforms that a law may be given, with jumps, kinks and what is smooth.
const Waveform waves[] = {SineWave{0.4, 0.3, 2, 0.1}, SquareWave{.low = 0.2, .high = 0.9, .period = 0.77},
                          TableWave{{0, 2.3, 3.1, 9}, {1, 0.3, 0.8, 0.1}},
                          SumWave{{StepsWave{{0, 1.7, 4}, {0.1, 0.5, 0.2}}, SineWave{0, 0.1, 5, 0}}}};

/// A fault of actuator 0 with a waveform where it has one, and numbers that are not its defaults.
template <FaultLaw F>
F with(const Waveform& wave) {
  F fault;
  F::describe(fault, [&]<class M>(M& member, const Field& f) {
    if constexpr (std::is_same_v<M, Waveform>) member = wave;
    if constexpr (std::is_same_v<M, double>) member = std::clamp(0.37, f.lo, f.hi);
  });
  fault.window = {.actuator = 0, .t_on = 1.2345, .t_off = 8.1};
  return fault;
}

constexpr Limits limits{-0.7, 0.9}, of_a_valve{0, 0.9, true};

/// How much a law does between its switches that it does not say of itself: a jump, a change although it is constant, or more
/// of its third difference on steps of 0.05 rad than a smooth law has.
template <FaultLaw F>
double not_said(const F& fault, double t_end) {
  const auto value = [&](double t, double branch) {
    Effect e;
    fault.apply(e, {t, branch, limits, 0.123});
    return e.effectiveness + 3 * e.bias + 7 * e.dead_zone;
  };
  double worst = 0;
  for (double t = 0; t < t_end;) {
    const double stop = std::min(next_switch(fault, t), t_end), branch = 0.5 * (t + stop);
    const double steps = std::max(8.0, std::ceil((stop - t) * std::max(fastest(fault), 1.0) / 0.05));
    for (double k = 1; fault.window.holds(branch) && k + 3 < steps; ++k) {
      double e[4];
      for (int j = 0; j < 4; ++j) {
        const double at = t + (stop - t) * (k + j) / steps;
        e[j] = value(at, branch);
        worst = std::max(worst, std::abs(e[j] - value(at, at)));  // the branch moves with t
      }
      worst = std::max(worst, std::abs(piecewise_constant(fault) ? e[1] - e[0] : e[3] - 3 * e[2] + 3 * e[1] - e[0]));
    }
    t = stop;
  }
  return worst;
}

template <class List>
struct EveryKind;
template <FaultLaw... F>
struct EveryKind<std::variant<F...>> {
  static void each(auto&& f) { (f.template operator()<F>(), ...); }
};

TEST(FaultContract, EveryKindSaysWhereItsLawSwitchesAndHowQuickItIs) {
  for (const Waveform& wave : waves) {
    EveryKind<Fault>::each([&]<class F>() {
      EXPECT_TRUE(check(with<F>(wave), {limits}).empty() || check(with<F>(wave), {of_a_valve}).empty()) << F::name;
      EXPECT_LT(not_said(with<F>(wave), 10), 3 * 1.3e-4)
          << F::name;  // (0.05)^3 of the amplitude, of three times a bias
    });
  }
}

TEST(FaultContract, EveryKindThatDecidesTheOutputLeavesNothingOfTheOthers) {
  EveryKind<Fault>::each([&]<class F>() {
    Effect e{0.3, 0.2, 0.1};
    with<F>(0.5).apply(e, {2, 2, limits, 0.123});
    const bool alone = e.effectiveness == 0 && e.dead_zone == 0 && e.bias != 0.2;
    EXPECT_EQ(alone, F::decides_output) << F::name;
  });
}

// ---- kinds of one's own ----------------------------------------------------------------------------------------------

/// Loss of effectiveness under another name, outside of the shipped list.
struct Fade {
  static constexpr const char* name = "fade";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  Waveform remaining = 0.5;
  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.remaining, Field{"remaining", "", -2, 2, "delivered / commanded"});
  }
  void waveforms(auto&& see) const { see(remaining); }
  void apply(Effect& e, const At& at) const noexcept { e.effectiveness *= remaining(at.t, at.branch); }
  std::string check(const Limits&) const { return {}; }
};
/// It does not say which waveform it reads: this compiles, and the contract finds it.
struct Silent : Fade {
  void waveforms(auto&&) const noexcept {}
};
/// Half a law: `waveforms`, from which next_switch follows, and `decides_output` are missing. Neither is in a list.
struct NeverSwitches {
  static constexpr const char* name = "never_switches";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  void apply(Effect&, const At&) const noexcept {}
  std::string check(const Limits&) const { return {}; }
};
struct DecidesNothing {
  static constexpr const char* name = "decides_nothing";
  static constexpr int degree = 0;
  Window window;
  void waveforms(auto&&) const noexcept {}
  void apply(Effect&, const At&) const noexcept {}
  std::string check(const Limits&) const { return {}; }
};
template <class F>
concept MayBeListed = requires { typename FaultList<LossOfEffectiveness, F>; };
static_assert(MayBeListed<Fade>);
static_assert(!MayBeListed<NeverSwitches> && !MayBeListed<DecidesNothing>);

TEST(FaultContract, FindsALawThatDoesNotSayWhatItReads) {
  for (const Waveform& wave : waves) {
    EXPECT_LT(not_said(with<Fade>(wave), 10), 1.3e-4);
    Silent silent;
    static_cast<Fade&>(silent) = with<Fade>(wave);
    EXPECT_GT(not_said(silent, 10), 1e-3);
  }
}

/// Bits of what an actuator with this loss and a bias delivers, and of the piece that each number belongs to.
template <class Loss>
std::vector<double> delivered_with(const Waveform& remaining) {
  Actuators actuators = Actuators::ideal(2);
  actuators.u_lo.setConstant(-0.2);
  actuators.u_up.setConstant(0.25);
  FaultyActuatorsOf<FaultList<Loss, Bias>> bank(
      actuators, {Loss{.window = {.actuator = 1, .t_on = 0.7003, .t_off = 6.3}, .remaining = remaining},
                  Bias{.window = {.actuator = 1, .t_on = 2}, .torque = SineWave{0, 0.05, 1, 0}}});
  std::vector<double> out;
  for (double t = 0; t < 10;) {
    const double stop = std::min(bank.next_switch(t), 10.0);
    bank.enter(t, 0.5 * (t + stop));
    VecN<double> u(2);
    u << 0.1, 0.3 * std::sin(t);
    bank.command(u);
    out.insert(out.end(), {t, bank.fastest(), double(bank.constant(1)), bank.constant_delivered(1)});
    for (int k = 0; k <= 8; ++k) out.push_back(bank.delivered(1, t + (stop - t) * k / 8));
    t = stop;
  }
  return out;
}

TEST(FaultContract, ARenamedLossOfEffectivenessActsAsTheOriginalToTheLastBit) {
  for (const Waveform& wave : waves) {
    const std::vector<double> a = delivered_with<LossOfEffectiveness>(wave), b = delivered_with<Fade>(wave);
    ASSERT_EQ(a.size(), b.size());
    ASSERT_GT(a.size(), 50u);
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0);
  }
}

}  // namespace
}  // namespace gyrostat::truth::test_faults
