# SPDX-License-Identifier: MIT
"""A wheel fades: what the other three make of one torque, and what is within reach at all.

Run: python examples/04_allocation_under_failure.py
"""

import numpy as np

from gyrostat import allocation

D_B = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3.0)  # four wheels of a pyramid
LIMIT = 0.2  # N m
demand = np.array([0.15, -0.10, 0.12])  # N m

left = np.linspace(1.0, 0.0, 11)  # effectiveness of wheel 1
effectiveness = np.ones((len(left), 4))
effectiveness[:, 1] = left

closest = allocation.solve(D_B, demand, LIMIT, effectiveness=effectiveness)
scaled = allocation.solve(D_B, demand, LIMIT, effectiveness=effectiveness, mode="lexicographic_scaled")
robust = allocation.solve(
    D_B, demand, LIMIT, effectiveness=effectiveness, bound=0.1, mode="robust_socp", residual_weight=1e3
)

print(f"{'wheel 1':>8} {'every direction':>16} {'missing':>10} {'share':>7} {'robust worst':>13}  command (N m)")
for k, e in enumerate(effectiveness):
    reach = allocation.attainable_set(D_B, LIMIT, effectiveness=e)
    print(
        f"{e[1]:8.0%} {reach.in_every_direction:12.3f} N m {closest.residual_norm[k]:10.2g} {scaled.scale[k]:7.0%} "
        f"{robust.worst_case[k]:13.3f}  {np.array2string(closest.command[k], precision=3, suppress_small=True)}"
    )
