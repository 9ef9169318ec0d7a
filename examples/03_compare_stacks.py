# SPDX-License-Identifier: MIT
"""Several control laws on one failing vehicle, in threads: the compiled loop runs without Python's global lock.

Run: python examples/03_compare_stacks.py
"""

import math
from concurrent.futures import ThreadPoolExecutor

import gyrostat as gs

base = gs.Scenario.load("wheel2_degraded")
controllers = ("mrp_feedback", "saturated_pd", "finite_time", "integral_sliding_mode")

with ThreadPoolExecutor() as pool:
    results = list(pool.map(lambda name: base.replace(controller=name).run(every=10), controllers))

print(f"{'controller':24}{'settled (s)':>12}{'error (deg)':>14}{'variation (N m/s)':>20}")
for name, result in zip(controllers, results, strict=True):
    m = result.metrics
    print(f"{name:24}{m.settling_time:12.1f}{math.degrees(m.pointing_error):14.2g}{m.command_variation:20.2g}")
