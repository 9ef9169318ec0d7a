# SPDX-License-Identifier: MIT
"""A scenario's flight stack as code: a C++ header, a C library, or an FMI 2.0 co-simulation unit.

Each folder that is written stands alone: beside the code it holds the flight headers it needs (only Eigen is taken from
elsewhere) and a self-test, the recorded inputs and outputs of the scenario's own closed loop.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from gyrostat.errors import InputError, suggestion
from gyrostat.export import c, cpp, fmu
from gyrostat.export.folder import new_folder
from gyrostat.export.model import SAMPLES, FlightCode, flight_code
from gyrostat.scenario import Scenario

TARGETS: dict[str, Callable[[FlightCode, Path], None]] = {"cpp": cpp.write, "c": c.write, "fmu": fmu.write}
"""What writes the folder of each target."""


def export(
    scenario: Scenario,
    target: str,
    out: str | Path,
    *,
    scalar: str = "double",
    samples: int = SAMPLES,
    name: str | None = None,
) -> FlightCode:
    """Write the flight stack of a scenario as code.

    Parameters
    ----------
    scenario
        Its nominal vehicle, components and parameters are written; it is flown for the rows of the self-test.
    target
        ``cpp``, ``c`` or ``fmu``.
    out
        A folder that is not there yet, or empty. It appears when it is complete.
    scalar
        ``double`` or ``float``: what the C library and the self-test compute in. The C++ header is a template on it.
    samples
        Rows of the recording, from the first sample on; 0: the whole run.
    name
        Of files, namespace and C functions; by default made of the scenario's own name.

    Returns
    -------
    FlightCode
        What was written, the recorded rows included.

    Raises
    ------
    InputError
        What cannot be exported, a folder that cannot be written, or (``fmu``) a compiler that is not there. Nothing is
        written then.
    """
    if target not in TARGETS:
        raise InputError(f"no target '{target}'{suggestion(target, TARGETS)}")
    if scalar not in ("double", "float"):
        raise InputError(f"no scalar '{scalar}'; there are: double, float")
    if target == "fmu" and scalar != "double":
        raise InputError("an FMU exchanges double: export it with scalar double")
    with new_folder(Path(out)) as folder:
        code = flight_code(scenario, scalar=scalar, samples=samples, name=name)
        TARGETS[target](code, folder)
    return code


__all__ = ["TARGETS", "FlightCode", "export"]
