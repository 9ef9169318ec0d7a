// SPDX-License-Identifier: MIT
/// @file  Feeds recorded inputs to an exported stack and writes all it gives; tests/python/test_export_stacks.py compares.
#pragma once
#include <cstdio>
#include <string>
#include <vector>

#include "gyrostat/flight/facade.hpp"

/// Rows of NAME.in, each as the inputs of gyrostat.export.model; NAME.SCALAR gets a row of its outputs for each.
template <class S, template <class> class Flight>
int replay(const std::string& name, const char* scalar) {
  using Stack = Flight<S>;
  struct {
    std::uint64_t tick;
    double q_NB[4], omega_BN_B[3], h_w[Stack::actuators];
    bool attitude_invalid, rate_invalid, momentum_invalid;
  } y = {};
  struct {
    double q_NR[4], omega_RN_R[3], omegadot_RN_R[3];
    std::uint32_t event;
  } ref = {};
  struct {
    double u[Stack::actuators], demand_B[3], achieved_B[3];
    std::uint16_t saturated, status;
  } command = {};
  struct {
    double q_NB[4], omega_BN_B[3], d_B[3], effectiveness[Stack::actuators], effectiveness_bound[Stack::actuators];
    std::uint16_t changed, failed, enabled;
    std::uint32_t events;
    std::uint8_t fault_class[Stack::actuators];
    double gain[Stack::actuators], bias[Stack::actuators];
  } state = {};

  auto made = Stack::make();
  if (!made) {
    const gyrostat::Status<S>& status = made.status();
    std::fprintf(stderr, "%s in %s: %s = %g, must be %s %g\n", name.c_str(), scalar, status.quantity,
                 static_cast<double>(status.value), status.relation, static_cast<double>(status.limit));
    return 1;
  }
  auto& stack = *made;
  std::FILE* in = std::fopen((name + ".in").c_str(), "rb");
  std::FILE* out = std::fopen((name + "." + scalar).c_str(), "wb");
  if (in == nullptr || out == nullptr) return 2;
  const auto read = [in](auto& block) { return std::fread(&block, sizeof block, 1, in) == 1; };
  const auto write = [out](const auto& block) { std::fwrite(&block, sizeof block, 1, out); };
  const auto count = [&write](double number) { write(number); };
  for (double event, valid[3]; read(y.q_NB) && read(y.omega_BN_B) && read(y.h_w) && read(valid) && read(ref.q_NR) &&
                               read(ref.omega_RN_R) && read(ref.omegadot_RN_R) && read(event);
       ++y.tick) {
    y.attitude_invalid = valid[0] == 0;
    y.rate_invalid = valid[1] == 0;
    y.momentum_invalid = valid[2] == 0;
    ref.event = static_cast<std::uint32_t>(event);
    gyrostat::to_plain(stack.step(gyrostat::measurement_from<S>(y), gyrostat::reference_from<S>(ref)), command);
    gyrostat::to_plain(stack.estimate(), stack.detection(), state);
    write(command.u);
    write(command.achieved_B);
    count(command.saturated);
    count(command.status);
    write(command.demand_B);
    write(state.q_NB);
    write(state.omega_BN_B);
    write(state.d_B);
    write(state.effectiveness);
    write(state.effectiveness_bound);
    count(state.changed);
    count(state.failed);
    count(state.enabled);
    count(state.events);
    for (const std::uint8_t fault_class : state.fault_class) count(fault_class);
    write(state.gain);
    write(state.bias);
  }
  std::fclose(in);
  return std::fclose(out);
}
