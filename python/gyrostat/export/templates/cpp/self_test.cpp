// SPDX-License-Identifier: MIT
// Feeds the recorded measurements and references of the scenario to the stack and holds its outputs against the record.
#include <cstdio>

#include "@name@.hpp"
#include "gyrostat/flight/facade.hpp"
#include "recorded.h"

namespace {

using S = @scalar @;
using Flight = @name @ ::Flight<S>;

struct Measured {
  std::uint64_t tick;
  double q_NB[4], omega_BN_B[3], h_w[Flight::actuators];
};
struct Wanted {
  double q_NR[4], omega_RN_R[3], omegadot_RN_R[3];
  std::uint32_t event;
};

template <class V>
void hold(deviation& d, const char* name, int column, const V& now, int n) {
  for (int i = 0; i < n; ++i) hold_against_record(&d, name, column + i, static_cast<double>(now[i]));
}

}  // namespace

int main(int argc, char** argv) {
  std::FILE* file = open_recording(argc > 1 ? argv[1] : "recorded.csv");
  if (file == nullptr) return 2;
  const gyrostat::Status<S> status = Flight::check(Flight::parameters());
  if (!status.ok()) {
    std::printf("refused: %s = %g, must be %s %g\n", status.quantity, static_cast<double>(status.value),
                status.relation, static_cast<double>(status.limit));
    return 1;
  }
  Flight::Stack stack = Flight::make();
  static deviation d;
  d.exact = sizeof(S) == sizeof(double);
  Measured y = {};
  Wanted ref = {};
  for (; next_row(file, d.row); ++y.tick) {
    take_recorded(d.row, measurement_q_NB, y.q_NB, 4);
    take_recorded(d.row, measurement_omega_BN_B, y.omega_BN_B, 3);
    take_recorded(d.row, measurement_h_w, y.h_w, Flight::actuators);
    take_recorded(d.row, reference_q_NR, ref.q_NR, 4);
    take_recorded(d.row, reference_omega_RN_R, ref.omega_RN_R, 3);
    take_recorded(d.row, reference_omegadot_RN_R, ref.omegadot_RN_R, 3);
    ref.event = static_cast<std::uint32_t>(d.row[reference_event]);
    const gyrostat::Allocation<S>& a = stack.step(gyrostat::measurement_from<S>(y), gyrostat::reference_from<S>(ref));
    const gyrostat::Estimate<S>& x = stack.estimate();
    hold(d, "allocation.u", allocation_u, a.u, Flight::actuators);
    hold(d, "allocation.achieved_B", allocation_achieved_B, a.achieved_B, 3);
    hold(d, "demand.tau_B", demand_tau_B, stack.demand().tau_B, 3);
    hold(d, "estimate.omega_BN_B", estimate_omega_BN_B, x.omega_BN_B, 3);
    hold(d, "estimate.d_B", estimate_d_B, x.d_B, 3);
    hold(d, "estimate.effectiveness", estimate_effectiveness, x.effectiveness, Flight::actuators);
    if (d.exact) {  // in float a flag may come a sample earlier or later
      hold_against_record(&d, "allocation.saturated", allocation_saturated, a.saturated.bits());
      hold_against_record(&d, "allocation.status", allocation_status, a.status.bits());
      hold_against_record(&d, "detection.enabled", detection_enabled, stack.detection().enabled.bits());
      hold_against_record(&d, "detection.event", detection_event, stack.detection().event);
    }
  }
  return verdict(&d, file);
}
