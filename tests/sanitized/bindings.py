# SPDX-License-Identifier: MIT
"""The compiled module alone under the sanitizers: tables in, arrays out, a component in Python, a batch of problems.

``make matrix`` runs it; what the components themselves do is looked at by the C++ test ``host.ShortLoops``. The address
sanitizer must be in the process before Python is: ``LD_PRELOAD=libasan.so``. Only the module is imported, from the
folder given as the argument.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[1]).resolve()))
import _core  # type: ignore[import-not-found]

S = 1 / math.sqrt(3.0)
SCENARIO = {
    "duration": 1.0,
    "dt": 0.01,
    "vehicle": {
        "J_B": [[20.0, 0.0, 0.9], [0.0, 17.0, 0.0], [0.9, 0.0, 15.0]],
        "D_B": [[S, S, -S, -S], [S, -S, -S, S], [S, S, S, S]],
        "u_max": 0.2,
    },
    "initial": {"mrp": [0.1, 0.2, -0.3]},
    "controller": {"type": "mrp_feedback"},
    "record": {"channels": ["truth.*", "estimate.*", "allocation.*"]},
}


class Controller:
    """Plain rate damping."""

    def step(self, x, det, ref, last):  # type: ignore[no-untyped-def]
        return -5.0 * x.omega_BN_B


class Failing:
    """Raises at its first step."""

    def step(self, x, det, ref, last):  # type: ignore[no-untyped-def]
        raise ArithmeticError("asked to")


def main() -> None:
    """A report of the sanitizer ends the process with its own status."""
    python = {**SCENARIO, "controller": {"type": "python"}}
    for scenario, parts in ((SCENARIO, {}), (python, {"controller": Controller()})):
        result = _core.Compiled(scenario).simulate(parts)
        if result["status"] != "completed":
            raise SystemExit(f"{result['status']}: {result['cause']}")
    try:
        _core.Compiled(python).simulate({"controller": Failing()})
    except ArithmeticError:
        pass
    else:
        raise SystemExit("the exception of a component was lost")
    try:
        _core.Compiled({**SCENARIO, "dt": -1.0}).simulate({})
    except ValueError:
        pass
    else:
        raise SystemExit("a negative period was accepted")
    D = [SCENARIO["vehicle"]["D_B"]]  # type: ignore[index]
    ones = [[1.0] * 4]
    minus = [[-1.0] * 4]
    zeros = [[0.0] * 4]
    for mode in range(4):
        _core.allocate(
            D=D,
            row_weight=[[1.0] * 3],
            demand=[[0.1, 0.2, -0.1]],
            effectiveness=ones,
            lo=minus,
            up=ones,
            preferred=zeros,
            effort_weight=ones,
            bound=zeros,
            priority=[0, 0, 0],
            mode=mode,
            worst_case=0,
            residual_weight=1e3,
            margin=0.1,
            effectiveness_min=-1.0,
            rank_tolerance=_core.default_rank_tolerance,
            max_newton=200,
            warm=False,
        )
    print("bindings under the sanitizers: nothing to report")


if __name__ == "__main__":
    main()
