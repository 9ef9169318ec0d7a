# SPDX-License-Identifier: MIT
"""One short loop per component through the sanitized bindings; `make asan` runs it.

The address sanitizer must be in the process before Python is: ``LD_PRELOAD=libasan.so``. Only the compiled module is
imported, from the folder given as the argument: no numpy-heavy package code under a sanitizer.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[1]).resolve()))
import _core  # type: ignore[import-not-found]

S = 1 / math.sqrt(3.0)
VEHICLE = {
    "J_B": [[20.0, 0.0, 0.9], [0.0, 17.0, 0.0], [0.9, 0.0, 15.0]],
    "D_B": [[S, S, -S, -S], [S, -S, -S, S], [S, S, S, S]],
    "u_max": 0.2,
    "wheel_inertia": 0.05,
    "orbit_rate": 1e-3,
}
BASE = {
    "duration": 1.0,
    "dt": 0.01,
    "seed": 1,
    "vehicle": VEHICLE,
    "initial": {"mrp": [0.1, 0.2, -0.3], "omega_BN_B": [0.01, -0.02, 0.03]},
    "controller": {"type": "mrp_feedback"},
    "faults": [{"type": "loss_of_effectiveness", "actuator": 2, "t_on": 0.5037, "remaining": 0.4}],
    "record": {
        "channels": ["truth.*", "measurement.*", "reference.*", "estimate.*", "detection.*", "demand.*", "allocation.*"]
    },
}
# What a part needs beyond its defaults to do something.
ARGUMENTS = {
    "slew": {"to_euler": [0.3, 0.2, -0.1], "duration": 0.8},
    "steps": {"times": [0.0, 0.5], "euler": [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]},
}


class PythonController:
    """Plain rate damping."""

    def step(self, x, det, ref, last):  # type: ignore[no-untyped-def]
        return -5.0 * x.omega_BN_B


def with_part(family: str, name: str) -> dict:
    """BASE with one part of the catalogue in it."""
    match family:
        case "fault":
            return {"faults": [{"type": name, "actuator": 1, "t_on": 0.2513}]}
        case "disturbance":
            return {"disturbances": [{"type": name}]}
        case "sensor":
            return {"sensors": [{"type": name, "noise": 1e-4, "delay": 3, "quantisation": 1e-5}]}
        case "waveform":
            wave = {"type": name} if name != "sum" else {"type": "sum", "terms": [{"type": "square"}, 1e-3]}
            return {"disturbances": [{"type": "periodic", "torque_B": [wave, 0.0, 0.0]}]}
        case _:
            return {family: {"type": name, **ARGUMENTS.get(name, {})}, "allow_unstable": True}


def scenarios() -> list[tuple[str, dict]]:
    """A scenario for every part of the catalogue, and two for what has no name there."""
    blocks = {"vehicle", "truth", "initial", "run"}
    parts = [(f, n) for f, names in _core.catalogue().items() if f not in blocks for n in names]
    out = [(f"{family} {name}", {**BASE, **with_part(family, name)}) for family, name in parts]
    wheels = {"viscous_friction": 1e-4, "coulomb_friction": 1e-3, "momentum_max": 0.05, "limit_on": "output"}
    out.append(("friction, momentum and output limits", {**BASE, "truth": wheels}))
    out.append(("shadows", {**BASE, "shadows": [{"observer": {"type": n}} for n in _core.catalogue()["observer"]]}))
    return out


def main() -> None:
    """Fly them all; a report of the sanitizer ends the process with its own status."""
    flown = scenarios()
    for name, scenario in flown:
        result = _core.simulate(scenario)
        if result["status"] != "completed":
            raise SystemExit(f"{name}: {result['status']}, {result['cause']}")
    controller = {**BASE, "controller": {"type": "python"}}
    if _core.simulate(controller, {"controller": PythonController()})["status"] != "completed":
        raise SystemExit("controller in Python: not completed")
    print(f"{len(flown) + 1} short loops under the sanitizers")


if __name__ == "__main__":
    main()
