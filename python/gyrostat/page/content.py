# SPDX-License-Identifier: MIT
"""The data of a page: what the browser draws, small enough to open at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.page import geometry, marks, panels
from gyrostat.page.packing import clock, cost, pack, pack_indices
from gyrostat.results import Result
from gyrostat.thinning import within
from gyrostat.vehicle import ControlMomentGyros, all_actuators

Array = NDArray[np.float64]

LINES = 290_000
"""Characters for all lines of a page."""
FRAMES = 130_000
"""Characters for the attitudes, arrows and colours of the bodies."""
_most_frames = 1500
_most_rows = 40
"""Of ticks, a run that is alone on its page."""
_most_faults = 200
_most_marks = 60
"""Of one kind through all panels; more would cover them, and are ticks only."""

_channels = (
    "truth.q_NB",
    "truth.omega_BN_B",
    "truth.h_w",
    "truth.gimbal",
    "truth.rotor_momentum",
    "truth.delivered",
    "truth.effectiveness",
    "truth.lumped_B",
    "error.angle",
    "reference.q_NR",
    "estimate.effectiveness",
    "estimate.effectiveness_bound",
    "estimate.d_B",
    "detection.changed",
    "detection.event",
    "demand.tau_B",
    "allocation.u",
    "allocation.saturated",
)
"""What a page draws or reads, and with the inner signals all that is usually recorded."""


@dataclass(frozen=True)
class Content:
    """The data of a page and how much of the runs they are."""

    data: dict[str, Any]
    stretch: int
    """Samples of which the smallest and the largest are drawn."""
    frames: int
    """Attitudes of the longest run."""


def wanted_channels(names: Sequence[str], chosen: Sequence[str] | None = None) -> list[str]:
    """What to record for a page: what was chosen (the usual when None) and what a page shows.

    Parameters
    ----------
    names
        All channels that the scenario offers.
    chosen
        The scenario's own choice, patterns allowed.
    """
    usual = [name for name in names if name.partition(".")[0] not in _groups and ".detection." not in name]
    own = usual if chosen is None else list(chosen)
    return list(dict.fromkeys([*(name for name in _channels if name in names), *own]))


_groups = {name.partition(".")[0] for name in _channels} | {"measurement"}


def content(runs: Mapping[str, Result]) -> Content:
    """Thin and pack everything that a page of these runs shows."""
    results = list(runs.values())
    drawn = panels.of_run(results[0]) if len(results) == 1 else panels.of_runs(results)
    lines = {f"{p.name} {i}": line.x for p in drawn for i, line in enumerate(p.lines)}
    longest = max(len(r) for r in results)
    thinned = within(lines, LINES, lambda kept: cost(longest, kept))

    def packed(panel: panels.Panel, i: int, line: panels.Line) -> dict[str, Any]:
        kept = thinned.kept[f"{panel.name} {i}"]
        facts = {"label": line.label, "color": line.color, "style": line.style, "run": line.run}
        return facts | {"k": pack_indices(kept, len(line.x)), "y": pack(line.x[kept])}

    tables = [
        {
            "name": panel.name,
            "title": panel.title,
            "unit": panel.unit,
            "log": panel.log,
            "note": panel.note,
            "levels": panel.levels,
            "lines": [packed(panel, i, line) for i, line in enumerate(panel.lines)],
        }
        for panel in drawn
    ]
    flown = [_run(label, result, color, FRAMES // len(results)) for color, (label, result) in enumerate(runs.items())]
    return Content(
        {"runs": [table for table, _ in flown], "panels": tables}, thinned.stretch, max(frames for _, frames in flown)
    )


def _run(label: str, result: Result, color: int, budget: int) -> tuple[dict[str, Any], int]:
    vehicle = all_actuators(result.description)
    arrows = _arrows(result)
    per_actuator = {
        key: result.channels[name]
        for key, name in (
            ("u", "allocation.u"),
            ("true", "truth.effectiveness"),
            ("estimate", "estimate.effectiveness"),
        )
        if name in result.channels and not (key == "estimate" and np.all(result[name] == 1.0))
    }
    attitudes = {
        key: result.channels[name]
        for key, name in (("q", "truth.q_NB"), ("q_ref", "reference.q_NR"))
        if name in result.channels
    }
    columns = sum(x.shape[1] for x in (*attitudes.values(), *per_actuator.values(), *(a for *_, a in arrows)))
    most = min(max(budget // (columns * 16 // 3 + 6), 2), _most_frames)
    kept = np.unique(np.linspace(0, len(result) - 1, min(most, len(result))).round().astype(int))
    u = np.abs(np.nan_to_num(per_actuator.get("u", np.zeros((1, np.shape(vehicle["D_B"])[1])))))
    table = {
        "label": label,
        "color": color,
        "clock": clock(result.t),
        "frames": {
            "k": pack_indices(kept, len(result)),
            **{key: pack(x[kept]) for key, x in (attitudes | per_actuator).items()},
            "arrows": [
                {"name": name, "label": text, "unit": unit, "v": pack(x[kept])} for name, text, unit, x in arrows
            ],
        },
        "box": geometry.box(vehicle["J_B"]).round(6).tolist(),
        "actuators": geometry.actuators(vehicle),
        "most_u": u.max(axis=0).tolist(),
        "marks": _marks(result),
        "rows": [
            {"name": name, "kind": kind, "t": [round(t, 6) for t in times], "count": count}
            for name, kind, times, count in marks.rows(result)[: _most_rows if budget == FRAMES else 6]
        ],
    }
    return table, len(kept)


def _marks(result: Result) -> list[dict[str, Any]]:
    """What is marked through all panels: faults, and of the rest what happens seldom; the strip of ticks has all."""
    found = [*marks.declared(result), *(m for m in marks.others(result) if m.kind != "counter")]
    number = Counter(m.kind for m in found)
    seldom = [m for m in found if number[m.kind] <= _most_marks]
    return [vars(m) for m in (*marks.faults(result)[:_most_faults], *seldom)]


def _arrows(result: Result) -> list[tuple[str, str, str, Array]]:
    """Vectors in body axes: the total momentum, the torque that the actuators gave, the lumped torque."""
    vehicle = all_actuators(result.description)
    D = np.asarray(vehicle["D_B"], dtype=float)
    found: list[tuple[str, str, str, Array]] = []
    rate, h = (result.channels.get(name) for name in ("truth.omega_BN_B", "truth.h_w"))
    rotors: Array | float = 0.0
    block = result.description.get("cmg")
    if block is not None:
        gimbal, stored = (result.channels.get(name) for name in ("truth.gimbal", "truth.rotor_momentum"))
        if gimbal is None or stored is None:
            return found
        gyros = ControlMomentGyros(**block)
        others = D.shape[1] - gyros.count
        axes, spin = gyros.turned(gimbal[:, others:])
        D = np.concatenate([np.broadcast_to(D[:, :others], (len(result), 3, others)), axes], axis=2)
        rotors = np.einsum("kij,kj->ki", spin, stored[:, others:])

    def along(h: Array) -> Array:
        return np.asarray(np.einsum("kij,kj->ki", D, h) if D.ndim == 3 else h @ D.T)

    if rate is not None and h is not None:
        momentum = rate @ geometry.body_inertia(vehicle).T + along(h) + rotors
        found.append(("momentum", "angular momentum", "N m s", momentum))
    delivered = result.channels.get("truth.delivered")
    if delivered is not None:
        found.append(("torque", "torque of the actuators", "N m", along(delivered)))
    if "truth.lumped_B" in result.channels:
        found.append(("lumped", "lumped torque", "N m", result["truth.lumped_B"]))
    return found
