# SPDX-License-Identifier: MIT
"""How much torque the faults of a run leave: by it flights that nobody could keep are told from lost ones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.allocation import attainable_set
from gyrostat.campaign.sampled_faults import NONE
from gyrostat.campaign.spec import Fault
from gyrostat.campaign.streams import Array

if TYPE_CHECKING:
    from gyrostat.campaign.campaign import Campaign


def torque_left(campaign: Campaign, first: int, last: int) -> Array:
    """Least torque over all directions that the actuators can make with every sampled fault at its worst.

    A drift is where it is at the end, an actuator that comes and goes is gone, a dead, locked or hard-over one gives
    nothing more; a torque that stays has to be pushed against. Momentum that fills up is not seen.

    Parameters
    ----------
    campaign
        Whose runs.
    first, last
        Runs first to last - 1.

    Returns
    -------
    ndarray
        In the largest ``u_max`` of the vehicle, shape (last - first,); 0 or less: some direction is out of reach.
    """
    columns = campaign.draws(first, last)
    vehicle = campaign.base.vehicle
    D = np.asarray(vehicle.D_B, dtype=float)
    u = np.broadcast_to(np.asarray(vehicle.u_max, dtype=float), (D.shape[1],))
    left = np.empty(last - first)
    for run in range(len(left)):
        gain, bias = np.ones(len(u)), np.zeros(len(u))
        row = {name: x[run] for name, x in columns.items()}
        for fault in campaign.spec.fault:
            for k in range(fault.most):
                _strike(gain, bias, u, campaign.base.duration, _drawn(fault, k, row))
        reach = attainable_set(D, gain * u, -gain * u, rank_tolerance=0.0)
        inside = reach.heights + reach.normals @ (reach.centre + D @ bias) if len(reach.normals) else np.zeros(1)
        left[run] = np.min(inside) / u.max()
    return left


def _drawn(fault: Fault, k: int, row: Mapping[str, Any]) -> dict[str, Any]:
    """Type, actuators, onset and parameters of an occurrence; empty where it does not happen."""
    head = f"fault.{fault.name}.{k}"
    type_ = str(row[f"{head}.kind"])
    if type_ == NONE:
        return {}
    (given,) = (kind.parameters for kind in fault.kind if kind.type == type_)
    parameters = {name: row.get(f"{head}.{type_}.{name}", value) for name, value in given.items()}
    who = fault.actuators or [int(row[f"{head}.actuator"])]
    return parameters | {"type": type_, "who": who, "t_on": float(row[f"{head}.t_on"])}


def _strike(gain: Array, bias: Array, u_max: Array, end: float, fault: Mapping[str, Any]) -> None:
    """Take from the actuators what a fault takes by the end, s."""
    type_ = fault.get("type")
    for i in fault.get("who", ()):
        if type_ in ("loss_of_effectiveness", "intermittent"):
            gain[i] *= float(fault.get("remaining", 0.0))
        elif type_ == "bias":
            bias[i] += float(fault["torque"])
        elif type_ == "drift":
            bias[i] += float(fault["rate"]) * max(0.0, end - fault["t_on"])
        elif type_ == "hard_over":
            gain[i], bias[i] = 0.0, math.copysign(u_max[i], float(fault.get("sign", 1.0)))
        elif type_ in ("stuck", "dead", "lock"):
            gain[i], bias[i] = 0.0, float(fault.get("torque", 0.0))


__all__ = ["torque_left"]
