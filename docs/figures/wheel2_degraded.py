# SPDX-License-Identifier: MIT
"""The figure of the README: the shipped scenario with its observer and sliding mode, and with the plain law.

Run: python docs/figures/wheel2_degraded.py
"""

from pathlib import Path

import numpy as np

import gyrostat as gs
from gyrostat import plots

EVERY = 20  # samples a drawn point: keeps the saved data small
CHANNELS = ["error.angle", "allocation.u", "truth.lumped_B", "estimate.d_B"]


def draw() -> plots.Figure:
    """Fly both and draw them."""
    scenario = gs.Scenario.load("wheel2_degraded")
    tolerant = scenario.run(channels=CHANNELS, every=EVERY)
    plain = scenario.replace(observer="passthrough", controller="mrp_feedback").run(channels=CHANNELS, every=EVERY)

    figure = plots.Figure("Wheel 2 drops to 40 % of its torque at 20 s", rows=3, size=(7.5, 6.0))
    for result, label in ((plain, "mrp_feedback"), (tolerant, "integral_sliding_mode with observer")):
        figure.line(0, result.t, np.degrees(result["error.angle"]), label, "deg", log=True)
    figure.axes[0].set_ylabel("pointing error (deg)", fontsize=9)
    figure.line(1, tolerant.t, tolerant["allocation.u"], "command", "N m", labels=[f"wheel {i}" for i in range(4)])
    figure.line(2, tolerant.t, tolerant["truth.lumped_B"][:, 0], "lumped torque, x", "N m")
    figure.line(2, tolerant.t, tolerant["estimate.d_B"][:, 0], "its estimate", "N m", style="--")
    figure.axes[2].lines[-1].set_color(plots.COLORS[1])
    figure.axes[2].legend(loc="best", fontsize=8, frameon=False, ncols=2)
    figure.axes[2].set_ylabel("torque (N m)", fontsize=9)
    figure.mark(plots.fault_marks(tolerant))
    return figure


if __name__ == "__main__":
    print(draw().save(Path(__file__).with_suffix(".png")))
