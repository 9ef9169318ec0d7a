# SPDX-License-Identifier: MIT
"""Delivered against demanded torque, through the edge of what the wheels can do, for each way of allocating.

Run: python docs/figures/allocation_edge.py
"""

from pathlib import Path
from typing import Any

import numpy as np

from gyrostat import allocation, plots

D_B = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3.0)
LIMIT = 0.2  # N m a wheel
EFFECTIVENESS = np.array([1.0, 0.4, 1.0, 1.0])
DIRECTION = np.array([0.80, 0.52, 0.30]) / np.linalg.norm([0.80, 0.52, 0.30])

MODES: dict[str, dict[str, Any]] = {
    "lexicographic": {},
    "lexicographic_scaled": {"mode": "lexicographic_scaled"},
    "weighted_least_squares, weight 10": {"mode": "weighted_least_squares", "residual_weight": 10.0},
    "robust_socp, weight 100": {"mode": "robust_socp", "residual_weight": 100.0},
    "robust_socp, weight 3": {"mode": "robust_socp", "residual_weight": 3.0},
}


def pseudo_inverse(demand: np.ndarray) -> np.ndarray:
    """Commands clipped after the fact."""
    return np.clip(demand @ np.linalg.pinv(D_B * EFFECTIVENESS).T, -LIMIT, LIMIT)


def draw() -> plots.Figure:
    """Sweep the demand along one direction."""
    size = np.linspace(0.0, 0.6, 301)
    demand = size[:, None] * DIRECTION
    commands = {
        name: allocation.solve(D_B, demand, LIMIT, effectiveness=EFFECTIVENESS, bound=0.1, **settings).command
        for name, settings in MODES.items()
    }
    commands["pseudo-inverse, clipped"] = pseudo_inverse(demand)
    figure = plots.Figure(
        "Wheel 1 at 40 %, demand along one direction", rows=3, size=(7.5, 7.0), along="demanded torque", unit="N m"
    )
    for name, u in commands.items():
        delivered = (u * EFFECTIVENESS) @ D_B.T
        along = delivered @ DIRECTION
        across = np.linalg.norm(delivered - along[:, None] * DIRECTION, axis=1)
        style = "--" if name.startswith("pseudo") else "-"
        figure.line(0, size, along, name, "N m", style=style)
        figure.line(1, size, across, f"{name}, across", "N m", style=style)
        figure.line(2, size, np.linalg.norm(u, axis=1), f"{name}, effort", "N m", style=style)
    for axis, label in zip(
        figure.axes, ("delivered along it", "delivered across it", "length of the command"), strict=True
    ):
        axis.set_ylabel(f"{label} (N m)", fontsize=9)
        axis.lines[-1].set_color("#495057")
        axis.get_legend().remove()
    figure.axes[0].legend(list(figure.axes[0].lines), list(commands), fontsize=8, frameon=False)
    edge = float(allocation.attainable_set(D_B, LIMIT, effectiveness=EFFECTIVENESS).radius(DIRECTION))
    figure.mark([(edge, "edge of the attainable set")])
    return figure


if __name__ == "__main__":
    print(draw().save(Path(__file__).with_suffix(".png")))
