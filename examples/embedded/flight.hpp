// SPDX-License-Identifier: MIT
/// @file  The exported stack of one scenario behind three functions; a row of the recording in, a command out.
#pragma once
#include <cstdint>

/// What one recorded sample holds, in `double` whatever the stack computes in.
struct Row {
  double q_NB[4], omega_BN_B[3], h_w[16], q_NR[4], omega_RN_R[3], omegadot_RN_R[3], event;
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
