# SPDX-License-Identifier: MIT
"""The figure of the README: a wheel sticks, under a plain law and under the recommended stack.

Run: python docs/figures/wheel_lost.py
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

import gyrostat as gs

ONSET, STUCK = 20.0, 1  # s; the wheel
INSTANTS = (10.0, 30.0, 45.0, 60.0, 120.0)  # s
GOOD, BAD, INK, PALE = "#2b8a3e", "#e03131", "#343a40", "#adb5bd"
RIGHT, UP = np.array([0.92, -0.39, 0.0]), np.array([0.16, 0.38, 0.91])  # of the picture
TARGET = np.array([0.55, 0.1, 0.8])  # where the instrument looks at first, in the frame of the picture


def fly() -> dict[str, np.ndarray]:
    """Attitude and pointing error (deg) of both flights."""
    scenario = gs.Scenario(
        name="a wheel sticks at three quarters of its torque",
        vehicle=gs.vehicle.ftc_4rw(),
        **gs.recommended(),
        disturbances=[gs.disturbances.Constant(torque_B=(1e-3, -2e-3, 1.5e-3))],
        sensors=[gs.sensors.Gyro(noise=1e-5), gs.sensors.Attitude(noise=2e-5)],
        faults=[gs.faults.Stuck(actuator=STUCK, t_on=ONSET, torque=0.15)],
        integrator="rk4",
        duration=150.0,
        dt=0.1,
    )
    plain = scenario.replace(
        observer="passthrough", detector="none", controller="mrp_feedback", allocator="pseudo_inverse"
    )
    found = {}
    for name, flown in (("plain", plain), ("tolerant", scenario)):
        result = flown.run(channels=["error.angle", "truth.q_NB"], every=5)
        found |= {"t": result.t, f"{name}_deg": np.degrees(result["error.angle"]), f"{name}_q_NB": result["q_NB"]}
    return found


def draw(data: dict[str, np.ndarray]) -> Figure:
    """The spacecraft at a few instants, above the pointing error."""
    mpl.rcParams["svg.hashsalt"] = "gyrostat"
    canvas = Figure(figsize=(9.0, 5.6), layout="constrained", facecolor="white")
    grid = canvas.add_gridspec(3, 1, height_ratios=(1.0, 1.0, 1.25))
    for row, (name, label) in enumerate((("plain", "feedback\nalone"), ("tolerant", "recommended\nstack"))):
        axis = canvas.add_subplot(grid[row])
        for i, t in enumerate(INSTANTS):
            k = int(np.argmin(np.abs(data["t"] - t)))
            error = data[f"{name}_deg"][k]
            _spacecraft(axis, data[f"{name}_q_NB"][k], 4.2 * i, failed=t > ONSET)
            axis.text(
                4.2 * i,
                -2.45,
                f"{error:.0f}°" if error > 10.0 else f"{error:.2g}°",
                ha="center",
                fontsize=10,
                color=BAD if error > 1.0 else GOOD,
            )
            if row == 0:
                axis.text(4.2 * i, 2.35, f"{t:.0f} s", ha="center", fontsize=9, color=INK)
        axis.text(-2.3, 0.2, label, ha="right", va="center", fontsize=10.5, color=INK, weight="bold")
        axis.set(xlim=(-5.2, 19.3), ylim=(-2.6, 2.8), aspect="equal")
        axis.axis("off")
    axis = canvas.add_subplot(grid[2])
    for name, color in (("plain", BAD), ("tolerant", GOOD)):
        axis.semilogy(data["t"], np.maximum(data[f"{name}_deg"], 1e-5), color=color, linewidth=1.6)
    axis.axvline(ONSET, color=INK, linewidth=0.9, linestyle=":")
    axis.text(
        ONSET + 8.0,
        0.06,
        f"wheel {STUCK} sticks at 75 % of its torque;\nnobody on board is told",
        fontsize=9,
        color=INK,
    )
    axis.set(xlim=(0.0, 150.0), ylim=(1e-4, 400.0), xlabel="time (s)", ylabel="pointing error (deg)")
    axis.grid(visible=True, color="#e9ecef", linewidth=0.6)
    axis.spines[["top", "right"]].set_visible(False)
    return canvas


def _turned(q: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Body points, shape (n, 3), in the plane of the picture."""
    C_NB = gs.attitude.dcm_from_quat(q).T
    return points @ C_NB.T @ np.column_stack([RIGHT, UP])


def _spacecraft(axis, q: np.ndarray, x: float, *, failed: bool) -> None:
    """A body with two panels, an instrument that looks along its axis, and four wheels."""
    here = np.array([x, 0.0])
    look = TARGET / np.linalg.norm(TARGET)
    start = here + _turned(np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.55 * look, 2.35 * look]))
    axis.plot(*start.T, color=PALE, linewidth=1.0, linestyle=(0, (4, 3)))
    axis.plot(*start[1], marker="*", color="#f59f00", markersize=10)
    for side in (-1.0, 1.0):
        panel = np.array(
            [[side * 0.5, -0.3, 0.0], [side * 1.7, -0.3, 0.0], [side * 1.7, 0.3, 0.0], [side * 0.5, 0.3, 0.0]]
        )
        axis.add_patch(Polygon(here + _turned(q, panel), facecolor="#a5d8ff", edgecolor=INK, linewidth=0.7))
    corners = np.array([[i, j, k] for i in (-0.45, 0.45) for j in (-0.45, 0.45) for k in (-0.45, 0.45)])
    for fixed in range(3):
        for value in (-0.45, 0.45):
            face = corners[corners[:, fixed] == value][[0, 1, 3, 2]]
            normal = np.eye(3)[fixed] * value
            if _depth(q, normal) > 0.0:
                axis.add_patch(Polygon(here + _turned(q, face), facecolor="#f8f9fa", edgecolor=INK, linewidth=0.8))
    beam = here + _turned(q, np.array([0.55 * look, 1.9 * look]))
    axis.annotate("", beam[1], beam[0], arrowprops={"arrowstyle": "-|>", "color": "#1971c2", "linewidth": 1.8})
    for i, place in enumerate(np.array([[0.22, 0.22], [-0.22, 0.22], [-0.22, -0.22], [0.22, -0.22]])):
        wheel = np.array(
            [[place[0] + 0.13 * np.cos(a), place[1] + 0.13 * np.sin(a), 0.46] for a in np.linspace(0, 6.28, 14)]
        )
        if _depth(q, np.array([0.0, 0.0, 1.0])) > 0.0:
            color = BAD if failed and i == STUCK else GOOD
            axis.add_patch(Polygon(here + _turned(q, wheel), facecolor=color, edgecolor="none", zorder=3))


def _depth(q: np.ndarray, direction: np.ndarray) -> float:
    """How much a body direction points to the reader."""
    return float(gs.attitude.dcm_from_quat(q).T @ direction @ np.cross(RIGHT, UP))


def save(path: Path) -> None:
    """Write the picture, and what it shows beside it."""
    data = fly()
    np.savez_compressed(path.with_suffix(".npz"), **{k: v.astype(np.float32) for k, v in data.items()})
    draw(data).savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    save(Path(__file__).with_suffix(".svg"))
