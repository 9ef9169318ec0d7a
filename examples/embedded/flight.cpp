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

}  // namespace

bool flight_init() {
  Made* made = new (memory) Made(Flight::make());
  if (*made) stack = &**made;
  return stack != nullptr;
}

void flight_step(std::uint64_t tick, const Row& row, Answer& answer) {
  struct {
    std::uint64_t tick;
    double q_NB[4], omega_BN_B[3], h_w[Flight::actuators];
    bool attitude_invalid, rate_invalid, momentum_invalid;
  } y{};
  struct {
    double q_NR[4], omega_RN_R[3], omegadot_RN_R[3];
    std::uint32_t event;
  } ref{};
  y.tick = tick;
  for (int i = 0; i < 4; ++i) {
    y.q_NB[i] = row.q_NB[i];
    ref.q_NR[i] = row.q_NR[i];
  }
  for (int i = 0; i < 3; ++i) {
    y.omega_BN_B[i] = row.omega_BN_B[i];
    ref.omega_RN_R[i] = row.omega_RN_R[i];
    ref.omegadot_RN_R[i] = row.omegadot_RN_R[i];
  }
  for (int i = 0; i < Flight::actuators; ++i) y.h_w[i] = row.h_w[i];
  ref.event = static_cast<std::uint32_t>(row.event);
  const gyrostat::Allocation<S>& out = stack->step(gyrostat::measurement_from<S>(y), gyrostat::reference_from<S>(ref));
  for (int i = 0; i < Flight::actuators; ++i) answer.u[i] = static_cast<double>(out.u[i]);
  answer.iterations = static_cast<std::uint32_t>(out.iterations);
  answer.status = out.status.bits();
}

unsigned flight_bytes() { return sizeof(Flight::Stack); }
