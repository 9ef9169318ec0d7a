# SPDX-License-Identifier: MIT
"""The file of ``gyrostat new``: a vehicle, the recommended stack, a fault, and comments that say what to change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gyrostat import toml
from gyrostat.errors import InputError, suggestion
from gyrostat.stacks import recommended


def _shipped(name: str) -> dict[str, Any]:
    from gyrostat.scenario import Scenario

    return Scenario.load(name).to_dict()


def _cubesat() -> dict[str, Any]:
    from gyrostat.campaign import Campaign

    return Campaign.load("faulty_cubesat").base.to_dict()


VEHICLES: dict[str, Callable[[], dict[str, Any]]] = {
    "ftc_4rw": lambda: _shipped("ftc_4rw"),
    "flexible_4": lambda: _shipped("flexible_4"),
    "cubesat_6u": _cubesat,
}
"""Tables that hold the vehicle, by name."""

_remarks = {
    "vehicle": """What flight knows: inertia J_B (kg m^2), actuator axes in the columns of D_B, largest command (N m),
and the axial inertia of each wheel (kg m^2; 0 is an ideal torquer). Put yours here.
All keys: gyrostat describe vehicle""",
    "flexible": "Appendages that bend; flight does not know them. Without them leave this table out.",
    "initial": "A turn of 82 deg. Attitudes are q_NB (scalar first), mrp or euler, rates rad/s.",
    "observer": """The recommended stack, reasons in docs/recommended.md.
Parameters that are not written scale with the vehicle and dt.
The observer learns what each wheel really delivers, from rates and wheel momenta, and the disturbance beside it.
No tachometers, or torquers: add use_momentum = false""",
    "detector": """Says which wheel changed, and how. drop = true also lets it take a stuck wheel away.
No tachometers, or torquers: add use_momentum = false, use_torque = true""",
    "controller": "Others: gyrostat list controller",
    "allocator": "Makes commands of the torque, inside the limits, with what the wheels have left.",
    "sensors": "Noise is one sigma a sample, rad/s and rad. Without sensors everything is measured as it is.",
    "disturbances": "N m, in body axes; nobody on board knows it.",
    "faults": """Wheel 2 drops to 40 % of its torque at 20 s. Others: gyrostat list fault.
Several at once: repeat [[faults]]. Try type = "stuck" with a torque.""",
}


def first_scenario(vehicle: str = "ftc_4rw") -> str:
    """The text of a scenario file that flies.

    Parameters
    ----------
    vehicle
        One of `VEHICLES`.

    Raises
    ------
    InputError
        There is no such vehicle.
    """
    if vehicle not in VEHICLES:
        raise InputError(f"no vehicle '{vehicle}'{suggestion(vehicle, VEHICLES)}")
    given = VEHICLES[vehicle]()
    most = float(np.max(np.asarray(given["vehicle"]["u_max"])))
    tables: dict[str, Any] = {"vehicle": given["vehicle"]}
    tables |= {"flexible": given["flexible"]} if "flexible" in given else {}
    tables |= {
        "initial": {"mrp": [0.1, 0.2, -0.3]},
        **{role: component.to_dict() for role, component in recommended().items()},
        "sensors": [{"type": "gyro", "noise": 1e-5}, {"type": "attitude", "noise": 2e-5}],
        "disturbances": [{"type": "constant", "torque_B": [most * share for share in (5e-3, -1e-2, 7.5e-3)]}],
        "faults": [{"type": "loss_of_effectiveness", "actuator": 2, "t_on": 20.0, "remaining": 0.4}],
    }
    head: dict[str, Any] = {
        "name": f"{vehicle}, wheel 2 at 40 %",
        "duration": 200.0,
        "dt": 0.1,
        "integrator": given.get("integrator", "rk4"),
    }
    parts = [toml.write(head)]
    for name, table in tables.items():
        remark = "".join(f"# {line}\n" for line in _remarks[name].splitlines())
        parts.append(remark + toml.write({name: table}).lstrip("\n"))
    return "\n".join(parts)


__all__ = ["VEHICLES", "first_scenario"]
