# SPDX-License-Identifier: MIT
"""The file of ``gyrostat new``: a vehicle, the recommended stack, a fault, and comments that say what to change."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from gyrostat import toml
from gyrostat.errors import InputError, suggestion
from gyrostat.files import file_errors
from gyrostat.scenario import Scenario, find, shipped
from gyrostat.stacks import recommended

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


_of_wheels = {
    *("name", "description", "duration", "dt", "seed", "integrator", "vehicle", "flexible", "initial", "reference"),
    *("record", "shadows", "faults", "disturbances", "sensors", "truth"),
    *("navigator", "observer", "detector", "controller", "allocator"),
}
"""Tables of a scenario whose actuators are all wheels."""


@cache
def vehicles() -> dict[str, Scenario]:
    """A scenario with each vehicle that comes with the package, by its name; of those that share one the first."""
    from gyrostat.campaign import Campaign

    named = {name: Scenario.load(name) for name in shipped() if "/" not in name}
    named = {"cubesat_6u": Campaign.load("faulty_cubesat").base} | named
    kept: dict[str, Scenario] = {}
    for name, scenario in sorted(named.items()):
        if all(scenario.vehicle != other.vehicle or scenario.flexible != other.flexible for other in kept.values()):
            kept[name] = scenario
    return kept


def has_wheels_alone(scenario: Scenario) -> bool:
    """Whether the recommended stack flies the vehicle: nothing but wheels acts on it."""
    tables = scenario.to_dict()
    inertia = np.asarray(tables["vehicle"].get("wheel_inertia", 0.0), dtype=float)
    return set(tables) <= _of_wheels and bool(np.all(inertia > 0.0))


def like(name: str) -> str:
    """The text of a scenario: a shipped one by its name, or a file.

    Raises
    ------
    InputError
        There is none, or it is none.
    """
    path = find(name)
    Scenario.from_toml(path)
    with file_errors(path, "cannot be read"):
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    text = "".join(line for line in lines if not line.startswith("# SPDX")).lstrip("\n")
    return f"# As {name}. What else there is: gyrostat list; every parameter: gyrostat describe FAMILY NAME\n{text}"


def vehicle_called(name: str) -> str:
    """One of `vehicles` by its name, or by how that begins.

    Raises
    ------
    InputError
        There is none, or several begin so.
    """
    known = vehicles()
    found = [name] if name in known else [k for k in known if name and k.startswith(name)]
    if len(found) != 1:
        more = f": {', '.join(found)}" if found else suggestion(name, known)
        raise InputError(f"{'several vehicles' if found else 'no vehicle'} '{name}'{more}")
    return found[0]


def first_scenario(vehicle: str = "ftc_4rw") -> str:
    """The text of a scenario file that flies.

    Parameters
    ----------
    vehicle
        As `vehicle_called` takes it. With other actuators than wheels, or an observer of its own, its scenario as
        shipped.
    """
    vehicle = vehicle_called(vehicle)
    if not has_wheels_alone(vehicles()[vehicle]) or vehicles()[vehicle].observer is not None:
        return like(vehicle)
    given = vehicles()[vehicle].to_dict()
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


__all__ = ["first_scenario", "has_wheels_alone", "like", "vehicle_called", "vehicles"]
