# SPDX-License-Identifier: MIT
"""The torques that four wheels can give, and what is left of them when one fades.

Run: python docs/figures/attainable_set.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from gyrostat import allocation

D_B = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3.0)
LIMIT = 0.2  # N m a wheel
LEFT = (1.0, 0.4, 0.0)  # effectiveness of wheel 1


def draw() -> Figure:
    """One polytope a panel, the healthy one's edges around it."""
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    healthy = allocation.attainable_set(D_B, LIMIT)
    for k, left in enumerate(LEFT):
        reach = allocation.attainable_set(D_B, LIMIT, effectiveness=[1.0, left, 1.0, 1.0])
        axis = figure.add_subplot(1, len(LEFT), k + 1, projection="3d")
        axis.add_collection3d(Poly3DCollection(healthy.faces(), facecolor="none", edgecolor="#adb5bd", linewidth=0.6))
        axis.add_collection3d(
            Poly3DCollection(reach.faces(), facecolor="#0b6bcb55", edgecolor="#0b6bcb", linewidth=0.8)
        )
        axis.set_title(
            f"wheel 1 at {100 * left:.0f} %: {reach.in_every_direction:.2f} N m everywhere,\n"
            f"{reach.volume / healthy.volume:.0%} of the volume",
            fontsize=8,
        )
        corner = np.abs(healthy.vertices()).max()
        axis.set(xlim=(-corner, corner), ylim=(-corner, corner), zlim=(-corner, corner))
        axis.set_box_aspect((1, 1, 1))
        axis.view_init(elev=18, azim=-28)
        axis.tick_params(labelsize=6)
        axis.set_xlabel("x (N m)", fontsize=7)
        axis.set_ylabel("y (N m)", fontsize=7)
        axis.set_zlabel("z (N m)", fontsize=7)
    return figure


if __name__ == "__main__":
    target = Path(__file__).with_suffix(".png")
    draw().savefig(target, dpi=130)
    print(target)
