# SPDX-License-Identifier: MIT
"""The stack to begin with, chosen on faulty flights that all components flew. Page: docs/recommended.md."""

from __future__ import annotations

from gyrostat.components import Component, allocator, controller, detector, observer


def recommended(*, tachometers: bool = True) -> dict[str, Component]:
    """Observer, detector, controller and allocator, to be unpacked into a `Scenario`.

    Parameters are defaults, which scale with vehicle and period, but for one: the detector takes no wheel away.

    Parameters
    ----------
    tachometers
        Whether the momentum of the wheels is measured; without it, and for torquers, only rates teach.

    Returns
    -------
    dict
        Components by role.

    Examples
    --------
    >>> import gyrostat as gs
    >>> scenario = gs.Scenario(vehicle=gs.vehicle.ftc_4rw(), **gs.recommended(), duration=60.0, dt=0.1)
    >>> scenario.run().status
    'completed'
    """
    blind = {} if tachometers else {"use_momentum": False}
    return {
        "observer": observer("joint_kalman", **blind),
        "detector": detector("evidence", drop=False, **blind, **({} if tachometers else {"use_torque": True})),
        "controller": controller("integral_sliding_mode"),
        "allocator": allocator("lexicographic"),
    }


__all__ = ["recommended"]
