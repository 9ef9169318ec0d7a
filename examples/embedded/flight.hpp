// SPDX-License-Identifier: MIT
/// @file  The exported stack of one scenario behind three functions; a row of the recording in, a command out.
#pragma once
#include <cstdint>

/// What one recorded sample holds, in `double` whatever the stack computes in; zero where this stack has no such input.
struct Row {
  double q_NB[4], omega_BN_B[3], h_w[16], attitude_valid, rate_valid, momentum_valid, gimbal[16];
  double field_B[3], field_N[3], field_valid, sun_B[3], sun_N[3], sun_valid;
  double q_NR[4], omega_RN_R[3], omegadot_RN_R[3], event;
};

/// What the target writes for each sample.
struct Answer {
  double u[16];
  std::uint32_t instructions, iterations, status, unused;
};

/// Whether the stack takes its own parameters.
bool flight_init();
void flight_step(std::uint64_t tick, const Row& row, Answer& answer);
unsigned flight_bytes();
