# SPDX-License-Identifier: MIT
"""Figures and tables of the missions: what a shipped scenario flies, as it is and without its faults.

Run: python docs/figures/missions.py
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gyrostat as gs
from gyrostat.plots import Figure

FOLDER = Path(__file__).parent
FLOWN = ("as shipped", "without faults")


@dataclass(frozen=True)
class Line:
    """One panel of a figure."""

    channel: str
    name: str
    unit: str
    scale: float = 1.0
    norm: bool = False
    log: bool = False
    limit: float | None = None


@dataclass(frozen=True)
class Mission:
    """One shipped scenario: what its figure shows, and what its table says of a flight."""

    title: str
    lines: tuple[Line, ...]
    numbers: dict[str, Callable[[gs.Result], float]]
    channels: tuple[str, ...] = ()
    also: tuple[tuple[float, str], ...] = ()
    every: int = 1
    """Samples from one drawn point to the next."""


def error(result: gs.Result, t_on: float = 0.0, t_off: float = np.inf) -> np.ndarray:
    """Pointing error over a part of the run, deg."""
    return np.degrees(result["error.angle"][(result.t >= t_on) & (result.t <= t_off)])


def largest(t_on: float = 0.0, t_off: float = np.inf) -> Callable[[gs.Result], float]:
    """Largest pointing error, deg."""
    return lambda result: float(error(result, t_on, t_off).max())


def rms(t_on: float, t_off: float = np.inf) -> Callable[[gs.Result], float]:
    """Pointing error, deg rms."""
    return lambda result: float(np.sqrt(np.mean(error(result, t_on, t_off) ** 2)))


def settled(limit: float) -> Callable[[gs.Result], float]:
    """When the pointing error, deg, is below a limit for good, s."""

    def at(result: gs.Result) -> float:
        above = np.flatnonzero(error(result) > limit)
        return float(result.t[min(above[-1] + 1, len(result.t) - 1)]) if above.size else 0.0

    return at


def size(channel: str, t: float | None = None, scale: float = 1.0) -> Callable[[gs.Result], float]:
    """Norm of a signal at an instant; its largest without one."""

    def of(result: gs.Result) -> float:
        value = np.linalg.norm(np.reshape(result[channel], (len(result.t), -1)), axis=1)
        return scale * float(value.max() if t is None else value[np.searchsorted(result.t, t)])

    return of


def first(channel: str, value: float) -> Callable[[gs.Result], float]:
    """When a signal first has a value, s."""
    return lambda result: float(result.t[np.argmax(np.ravel(result[channel]) == value)])


POINTING = Line("error.angle", "pointing error", "deg", 180.0 / np.pi, log=True)

MISSIONS = {
    "cubesat_6u": Mission(
        "A 6U CubeSat comes to rest, points, and empties its wheels",
        (
            POINTING,
            Line("truth.omega_BN_B", "rate", "deg/s", 180.0 / np.pi, norm=True, log=True),
            Line("truth.h_w", "wheel momentum", "mN m s", 1e3, limit=30.0),
        ),
        {
            "rate at the start (deg/s)": size("truth.omega_BN_B", 0.0, 180.0 / np.pi),
            "below 1 deg from (s)": settled(1.0),
            "pointing error after 1000 s (deg rms)": rms(1000.0),
            "largest pointing error from the dead torquer on (deg)": largest(3000.0),
            "largest momentum of the wheels (mN m s)": size("truth.h_w", None, 1e3),
            "momentum of the wheels at 1500 s (mN m s)": size("truth.h_w", 1500.0, 1e3),
            "momentum of the wheels at the end (mN m s)": size("truth.h_w", 6000.0, 1e3),
        },
        every=10,
    ),
    "smallsat_flexible": Mission(
        "A spacecraft with panels turns by 57 deg; wheel 2 dies in the middle of the turn",
        (
            POINTING,
            Line("truth.h_w", "wheel momentum", "N m s", limit=1.5),
            Line("truth.eta", "modes", "kg^(1/2) mm", 1e3),
        ),
        {
            "largest pointing error after 5 s (deg)": largest(5.0),
            "largest pointing error from the loss on (deg)": largest(35.0),
            "pointing error after 150 s (deg rms)": rms(150.0),
            "largest motion of the panels (kg^(1/2) mm)": size("truth.eta", None, 1e3),
            "motion of the panels at the end (kg^(1/2) mm)": size("truth.eta", 200.0, 1e3),
            "largest momentum of the wheels (N m s)": size("truth.h_w"),
        },
    ),
    "geo_thrusters": Mission(
        "A geostationary body points to the Earth through an eclipse on twelve thrusters",
        (
            Line("error.angle", "pointing error", "deg", 180.0 / np.pi),
            Line("truth.external_B", "torque from outside", "uN m", 1e6, norm=True),
            Line("truth.propellant", "propellant", "g", 1e3),
        ),
        {
            "in the shadow from (s)": first("truth.eclipse", 1.0),
            "torque from outside in sunlight (uN m)": size("truth.external_B", 600.0, 1e6),
            "torque from outside in the shadow (uN m)": size("truth.external_B", 3000.0, 1e6),
            "largest pointing error before the fault (deg)": largest(0.0, 2400.0),
            "largest pointing error from the stuck valve on (deg)": largest(2400.0),
            "pointing error from the stuck valve on (deg rms)": rms(2400.0),
            "propellant until the leak (g)": lambda r: (
                1e3 * float(np.interp(4200.0, r.t, np.ravel(r["truth.propellant"])))
            ),
            "propellant in all (g)": size("truth.propellant", None, 1e3),
        },
        channels=("truth.eclipse",),
        every=4,
        also=((1199.0, "shadow"), (5364.0, "sunlight")),
    ),
    "agile_cmg": Mission(
        "Four control moment gyros turn 120 kg m^2 by 120 deg; gimbal 1 locks at 2 s",
        (
            POINTING,
            Line("truth.omega_BN_B", "rate", "deg/s", 180.0 / np.pi, norm=True),
            Line("truth.gimbal", "gimbals", "deg", 180.0 / np.pi),
            Line("truth.singularity", "sqrt det(D D')", ""),
        ),
        {
            "largest rate (deg/s)": size("truth.omega_BN_B", None, 180.0 / np.pi),
            "largest pointing error (deg)": largest(),
            "largest pointing error from 50 s on (deg)": largest(50.0),
            "smallest singularity measure": lambda r: float(np.min(r["truth.singularity"])),
        },
    ),
}


def fly(name: str) -> dict[str, gs.Result]:
    """Both flights of a mission."""
    mission, scenario = MISSIONS[name], gs.Scenario.load(name)
    shown = {line.channel for line in mission.lines}
    channels = sorted({"error.angle", "truth.omega_BN_B", *shown, *mission.channels})
    return {
        told: flown.run(channels=channels)
        for told, flown in zip(FLOWN, (scenario, scenario.replace(faults=[])), strict=True)
    }


def draw(name: str, flights: dict[str, gs.Result]) -> Figure:
    """The flight as shipped, over the error of the one without faults."""
    mission = MISSIONS[name]
    figure = Figure(mission.title, len(mission.lines))
    for row, line in enumerate(mission.lines):
        shown = FLOWN[::-1] if line.channel == "error.angle" else FLOWN[:1]
        for told in shown:
            every, t = mission.every, flights[told].t
            values = line.scale * np.reshape(flights[told][line.channel], (len(t), -1))[::every]
            label = [str(i) for i in range(values.shape[1])] if values.shape[1] > 1 else []
            if line.norm:
                values, label = np.linalg.norm(values, axis=1), []
            elif line.limit is not None:  # of those that store something: actuators that are no wheels stay at zero
                stores = np.flatnonzero(np.any(values != 0.0, axis=0))
                values, label = values[:, stores], [label[i] for i in stores]
            label = [told] if len(shown) > 1 else label
            figure.line(row, t[::every], values, line.name, line.unit, labels=label, log=line.log)
        if line.limit is not None:
            for side in (line.limit, -line.limit):
                figure.level(row, side, f"{side:g} {line.unit}")
    faults = [(float(f.params["t_on"]), f.type.replace("_", " ")) for f in gs.Scenario.load(name).faults]
    figure.mark([*faults, *mission.also])
    return figure


def table(name: str, flights: dict[str, gs.Result]) -> str:
    """What the page says of both flights."""
    rows = [
        ",".join([quantity, *(f"{number(flights[told]):.4g}" for told in FLOWN)])
        for quantity, number in MISSIONS[name].numbers.items()
    ]
    return "\n".join([f"quantity,{FLOWN[0]},{FLOWN[1]}", *rows]) + "\n"


def save(name: str) -> None:
    """Write figure, its data and table of a mission."""
    flights = fly(name)
    draw(name, flights).save(FOLDER / f"mission_{name}.png")
    (FOLDER / f"mission_{name}.csv").write_text(f"# python docs/figures/missions.py\n{table(name, flights)}")


if __name__ == "__main__":
    for each in MISSIONS:
        save(each)
