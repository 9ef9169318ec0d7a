# SPDX-License-Identifier: MIT
"""A controller written in Python flies in the same loop as the compiled ones.

Run: python examples/02_python_controller.py
"""

import math

import gyrostat as gs


class QuaternionPd:
    """tau = -K q_vec - P omega, about the short way round."""

    def setup(self, setup):
        self.K, self.P = 0.05 * setup.vehicle.J_B, 0.35 * setup.vehicle.J_B

    def step(self, x, det, ref, last):
        w, *vector = x.q_NB  # body against inertial: the reference of this example is at rest there
        short_way = 1.0 if w >= 0.0 else -1.0
        return -short_way * self.K @ vector - self.P @ x.omega_BN_B


scenario = gs.Scenario(
    vehicle=gs.vehicle.ftc_4rw(),
    initial=gs.Initial(mrp=(0.1, 0.2, -0.3)),
    controller=QuaternionPd(),
    faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=20.0, remaining=0.4)],
    duration=120.0,
    dt=0.01,
)
for controller in (QuaternionPd(), gs.controller("mrp_feedback")):
    result = scenario.replace(controller=controller).run()
    print(f"{type(controller).__name__:14} ends at {math.degrees(result.metrics.final_error):.2g} deg")
