/* SPDX-License-Identifier: MIT */
/* Feeds the recorded measurements and references of the scenario to the stack and holds its outputs against the record. */
#include "@name@.h"
#include "recorded.h"

static void hold(deviation* d, const char* name, int column, const @name@_real* now, int n) {
  int i;
  for (i = 0; i < n; ++i) hold_against_record(d, name, column + i, (double)now[i]);
}

int main(int argc, char** argv) {
  static @name@ flight;
  static deviation d;
  static @name@_measurement y;
  static @name@_reference ref;
  @name@_command command;
  @name@_state state;
  FILE* file = open_recording(argc > 1 ? argv[1] : "recorded.csv");
  if (file == NULL) return 2;
  d.exact = sizeof(@name@_real) == sizeof(double);
  if (@name@_step(&flight, &y, &ref, &command) != @NAME@_NOT_READY) {
    printf("a stack was flown that nobody initialised\n");
    return 1;
  }
  if (@name@_init(&flight) != @NAME@_OK) {
    printf("the components refuse their parameters\n");
    return 1;
  }
  for (; next_row(file, d.row); ++y.tick) {
    take_recorded(d.row, measurement_q_NB, y.q_NB, 4);
    take_recorded(d.row, measurement_omega_BN_B, y.omega_BN_B, 3);
    take_recorded(d.row, measurement_h_w, y.h_w, @NAME@_ACTUATORS);
    take_recorded(d.row, reference_q_NR, ref.q_NR, 4);
    take_recorded(d.row, reference_omega_RN_R, ref.omega_RN_R, 3);
    take_recorded(d.row, reference_omegadot_RN_R, ref.omegadot_RN_R, 3);
    ref.event = (uint32_t)d.row[reference_event];
    if (@name@_step(&flight, &y, &ref, &command) != @NAME@_OK || @name@_status(&flight, &state) != @NAME@_OK) return 1;
    hold(&d, "allocation.u", allocation_u, command.u, @NAME@_ACTUATORS);
    hold(&d, "allocation.achieved_B", allocation_achieved_B, command.achieved_B, 3);
    hold(&d, "demand.tau_B", demand_tau_B, command.demand_B, 3);
    hold(&d, "estimate.omega_BN_B", estimate_omega_BN_B, state.omega_BN_B, 3);
    hold(&d, "estimate.d_B", estimate_d_B, state.d_B, 3);
    hold(&d, "estimate.effectiveness", estimate_effectiveness, state.effectiveness, @NAME@_ACTUATORS);
    if (d.exact) { /* in float a flag may come a sample earlier or later */
      hold_against_record(&d, "allocation.saturated", allocation_saturated, (double)command.saturated);
      hold_against_record(&d, "allocation.status", allocation_status, (double)command.status);
      hold_against_record(&d, "detection.enabled", detection_enabled, (double)state.enabled);
      hold_against_record(&d, "detection.event", detection_event, (double)state.events);
    }
  }
  return verdict(&d, file);
}
