// SPDX-License-Identifier: MIT
// The flight code alone: its object file is what `size` is asked about.
#include "flight.hpp"

#include <new>

#include FLIGHT_HEADER
#include "gyrostat/flight/facade.hpp"

namespace {

using S = FLIGHT_SCALAR;
using Flight = FLIGHT_NAMESPACE::Flight<S>;

using Made = gyrostat::Checked<Flight::Stack>;
alignas(Made) unsigned char memory[sizeof(Made)];
Flight::Stack* stack = nullptr;

/// FLIGHT_GIMBALS and FLIGHT_SKY say whether this stack has the inputs that not every one has.
struct Measured {
  std::uint64_t tick;
  double q_NB[4], omega_BN_B[3], h_w[Flight::actuators];
  bool attitude_invalid, rate_invalid, momentum_invalid;
#if FLIGHT_GIMBALS
  double gimbal[Flight::actuators];
#endif
#if FLIGHT_SKY
  double field_B[3], field_N[3], sun_B[3], sun_N[3];
  bool field_valid, sun_valid;
#endif
};
struct Wanted {
  double q_NR[4], omega_RN_R[3], omegadot_RN_R[3];
  std::uint32_t event;
};

/// As many numbers as the stack takes.
template <std::size_t N, std::size_t M>
void take(const double (&from)[M], double (&to)[N]) {
  static_assert(N <= M);
  for (std::size_t i = 0; i < N; ++i) to[i] = from[i];
}

}  // namespace

bool flight_init() {
  Made* made = new (memory) Made(Flight::make());
  if (*made) stack = &**made;
  return stack != nullptr;
}

void flight_step(std::uint64_t tick, const Row& row, Answer& answer) {
  Measured y{};
  Wanted ref{};
  y.tick = tick;
  take(row.q_NB, y.q_NB);
  take(row.omega_BN_B, y.omega_BN_B);
  take(row.h_w, y.h_w);
  y.attitude_invalid = row.attitude_valid == 0.0;
  y.rate_invalid = row.rate_valid == 0.0;
  y.momentum_invalid = row.momentum_valid == 0.0;
#if FLIGHT_GIMBALS
  take(row.gimbal, y.gimbal);
#endif
#if FLIGHT_SKY
  take(row.field_B, y.field_B);
  take(row.field_N, y.field_N);
  take(row.sun_B, y.sun_B);
  take(row.sun_N, y.sun_N);
  y.field_valid = row.field_valid != 0.0;
  y.sun_valid = row.sun_valid != 0.0;
#endif
  take(row.q_NR, ref.q_NR);
  take(row.omega_RN_R, ref.omega_RN_R);
  take(row.omegadot_RN_R, ref.omegadot_RN_R);
  ref.event = static_cast<std::uint32_t>(row.event);
  const gyrostat::Allocation<S>& out = stack->step(gyrostat::measurement_from<S>(y), gyrostat::reference_from<S>(ref));
  for (int i = 0; i < Flight::actuators; ++i) answer.u[i] = static_cast<double>(out.u[i]);
  answer.iterations = static_cast<std::uint32_t>(out.iterations);
  answer.status = out.status.bits();
}

unsigned flight_bytes() { return sizeof(Flight::Stack); }
