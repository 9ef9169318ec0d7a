// SPDX-License-Identifier: MIT
// A stack in memory of the caller, and its signals as plain structs.
#include "gyrostat/flight/facade.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_facade {
namespace {

using Stack = FlightStack<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>;
using Memory = CallerMemory<Stack>;

Stack some_stack() { return by_default<Stack>(ftc_4rw<double>()); }

struct PlainMeasurement {
  std::uint64_t tick = 7;
  double q_NB[4] = {0.5, -0.1, 0.7, 0.2}, omega_BN_B[3] = {1, 2, 3}, h_w[4] = {4, 5, 6, 7};
  std::uint8_t attitude_invalid = 0, rate_invalid = 0, momentum_invalid = 0;
};
struct PlainReference {
  double q_NR[4] = {0.1, 0.2, 0.3, 0.4}, omega_RN_R[3] = {1, 2, 3}, omegadot_RN_R[3] = {4, 5, 6};
  std::uint32_t event = 9;
};
struct PlainAllocation {
  double u[4], demand_B[3], achieved_B[3];
  std::uint16_t saturated = 0, status = 0;
};
struct PlainEstimate {
  double q_NB[4], omega_BN_B[3], d_B[3], effectiveness[4], effectiveness_bound[4];
  std::uint16_t changed = 0, failed = 0, enabled = 0;
  std::uint32_t events = 0;
};

TEST(CallerMemory, HoldsAStackAtAnyAlignmentAndOnlyWhereItWasMade) {
  std::array<unsigned char, Memory::bytes + 64> bytes{}, copy{};
  for (std::size_t offset = 0; offset < 33; ++offset) {
    void* memory = bytes.data() + offset;
    bytes.fill(0xA5);
    EXPECT_EQ(Memory::get(memory), nullptr) << "nothing was made here";
    Stack* stack = Memory::make(memory, some_stack());
    ASSERT_NE(stack, nullptr);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(stack) % alignof(Stack), 0u);
    EXPECT_GE(reinterpret_cast<unsigned char*>(stack), bytes.data() + offset);
    EXPECT_LE(reinterpret_cast<unsigned char*>(stack + 1), bytes.data() + offset + Memory::bytes);
    EXPECT_EQ(Memory::get(memory), stack);
    std::memcpy(copy.data() + offset, memory, Memory::bytes);
    EXPECT_EQ(Memory::get(copy.data() + offset), nullptr) << "copied memory has no stack";
  }
  EXPECT_EQ(Memory::make(nullptr, some_stack()), nullptr);
  EXPECT_EQ(Memory::get(static_cast<void*>(nullptr)), nullptr);
}

TEST(Facade, ReadsEveryNumberOfAMeasurementAndAReference) {
  const PlainMeasurement in;
  const auto y = measurement_from<double>(in);
  EXPECT_EQ(y.tick, 7u);
  EXPECT_EQ(y.q_NB.coeffs(), Quat<double>(0.5, -0.1, 0.7, 0.2).coeffs()) << "scalar first";
  EXPECT_EQ(y.omega_BN_B, Vec3<double>(1, 2, 3));
  ASSERT_EQ(y.h_w.size(), 4);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(y.h_w[i], 4 + i);
  EXPECT_TRUE(y.attitude_valid && y.rate_valid && y.momentum_valid) << "what nobody calls invalid is valid";
  const PlainReference given;
  const auto ref = reference_from<float>(given);
  EXPECT_EQ(ref.q_NR.coeffs(), Quat<float>(0.1f, 0.2f, 0.3f, 0.4f).coeffs());
  EXPECT_EQ(ref.omega_RN_R, Vec3<float>(1, 2, 3));
  EXPECT_EQ(ref.omegadot_RN_R, Vec3<float>(4, 5, 6));
  EXPECT_EQ(ref.event, 9u);
}

TEST(Facade, ReadsWhatWasNotMeasured) {
  for (int which = 0; which < 3; ++which) {
    PlainMeasurement in;
    std::uint8_t* invalid[] = {&in.attitude_invalid, &in.rate_invalid, &in.momentum_invalid};
    *invalid[which] = which == 0 ? 1 : 0x80;  // any number but zero
    const auto y = measurement_from<float>(in);
    EXPECT_EQ(y.attitude_valid, which != 0);
    EXPECT_EQ(y.rate_valid, which != 1);
    EXPECT_EQ(y.momentum_valid, which != 2);
  }
}

TEST(Facade, TellsEveryNumberOfAnAllocationAndAnEstimate) {
  Allocation<double> a = Allocation<double>::idle(4);
  a.u << 1, 2, 3, 4;
  a.demand_B = {5, 6, 7};
  a.achieved_B = {8, 9, 10};
  a.saturated.set(2);
  a.status = Flags(Flag::rank_lost) | Flag::breach;
  PlainAllocation out;
  to_plain(a, out);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(out.u[i], 1 + i);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(out.demand_B[i], 5 + i);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(out.achieved_B[i], 8 + i);
  EXPECT_EQ(out.saturated, 4);
  EXPECT_EQ(out.status, 64 + 256);

  Estimate<double> x = Estimate<double>::healthy(measurement_from<double>(PlainMeasurement{}));
  x.effectiveness << 0.1, 0.2, 0.3, 0.4;
  x.effectiveness_bound << 0.5, 0.6, 0.7, 0.8;
  x.d_B = {11, 12, 13};
  Detection<double> det;
  det.changed.set(0);
  det.failed.set(1);
  det.enabled.set(3);
  det.event = 5;
  PlainEstimate told;
  to_plain(x, det, told);
  const double q[4] = {0.5, -0.1, 0.7, 0.2};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(told.q_NB[i], q[i]);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(told.omega_BN_B[i], 1 + i);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(told.d_B[i], 11 + i);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(told.effectiveness[i], x.effectiveness[i]);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(told.effectiveness_bound[i], x.effectiveness_bound[i]);
  EXPECT_EQ(told.changed, 1);
  EXPECT_EQ(told.failed, 2);
  EXPECT_EQ(told.enabled, 8);
  EXPECT_EQ(told.events, 5u);
}

TEST(Facade, BeforeTheFirstStepActuatorsAreHealthyAndNobodyHasLookedAtThem) {
  PlainEstimate told;
  to_plain(Estimate<double>{}, Detection<double>{}, told);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(told.effectiveness[i], 1);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::isinf(told.effectiveness_bound[i]));
}

}  // namespace
}  // namespace gyrostat::test::test_facade
