# SPDX-License-Identifier: MIT
"""A wheel drops to 40 % of its torque; the spacecraft keeps pointing.

Run: python examples/01_first_run.py
"""

import math

import gyrostat as gs

scenario = gs.Scenario(
    name="wheel 2 at 40 %",
    vehicle=gs.vehicle.ftc_4rw(),
    initial=gs.Initial(mrp=(0.1, 0.2, -0.3), omega_BN_B=(0.01, -0.02, 0.03)),
    observer=gs.observer("finite_time_disturbance"),
    controller=gs.controller("integral_sliding_mode"),
    faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=20.0, remaining=0.4)],
    disturbances=[gs.disturbances.Constant(torque_B=(1e-3, -2e-3, 1.5e-3))],
    duration=120.0,
    dt=0.01,
)
result = scenario.run()

print(f"body rate: {result['omega_BN_B'].shape}, time first")
print(f"settled to 0.1 deg {result.metrics.settling_time:.1f} s after the fault")
print(f"pointing error at the end: {math.degrees(result.metrics.final_error):.2g} deg")
