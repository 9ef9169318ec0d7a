# SPDX-License-Identifier: MIT
"""The loops of cao2022, plant included, against rows of an independent implementation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrostat import papers

Array = NDArray[np.float64]

GOLDEN = Path(__file__).parents[1] / "golden"
CHANNELS = {
    "sigma": "truth.mrp",
    "omega": "truth.omega_BN_B",
    "u": "allocation.u",
    "ehat": "estimate.effectiveness",
    "wtilde": "observer.rate_error",
    "s": "controller.s",
}
CASES = {"cao2022_repaired_smooth": "case1_repaired_smooth", "cao2022_literal_open_plus5": "open_plus5"}


def read(name: str) -> dict[str, Array]:
    """Columns of a file by name."""
    lines = [line for line in (GOLDEN / f"{name}.csv").read_text().splitlines() if not line.startswith("#")]
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    return dict(zip(lines[0].split(","), rows.T, strict=True))


FIRST_FAULT = 5.0  # s


@pytest.mark.parametrize("name", CASES)
def test_the_closed_loop_gives_the_reference_rows(name: str) -> None:
    """To 1e-9 of the largest value of a group until the first fault, and after it once its onset is the reference's.

    The reference evaluates the effectiveness at the stages of its Runge-Kutta steps, so that the step that ends at an
    onset already sees the fault in its last stage, with weight 1/6: it has the fault h / 6 early, h = 5 ms. Here
    switches are exact; with the onsets moved by h / 6 the states agree again.
    """
    golden = read(name)
    scenario = papers.load("cao2022").cases[CASES[name]].scenario
    assert scenario.resolve()["integrator"] == {"type": "rk4", "substeps": 2}
    early = scenario.dt / 2 / 6
    moved = scenario.replace(**{f"faults.{i}.t_on": t - early for i, t in enumerate((5.0, 8.0, 10.0))})
    columns = [c for c in golden if c != "t"]
    channels = sorted({CHANNELS[c.rpartition("_")[0]] for c in columns})
    printed, result = scenario.run(channels=channels), moved.run(channels=channels)
    rows = np.rint(golden["t"] / scenario.dt).astype(int)
    np.testing.assert_allclose(result.t[rows], golden["t"], rtol=1e-14)
    before = golden["t"] < FIRST_FAULT - 1e-9
    assert np.count_nonzero(before) > 60
    for column in columns:
        group, _, i = column.rpartition("_")
        theirs = golden[column]
        largest = max(np.abs(golden[c]).max() for c in columns if c.startswith(group + "_"))
        ours = printed[CHANNELS[group]][rows, int(i)]
        np.testing.assert_allclose(ours[before], theirs[before], rtol=0, atol=1e-9 * max(largest, 1.0), err_msg=column)
        # After the onsets: the varying fault over h / 6 (5e-10 rad/s), through gains of 20 s/rad (estimate) and, in the
        # limit cycle of the smooth law, of 1e5 N m per 1/s (command).
        within = {"u": 2e-5, "ehat": 1e-8}.get(group, 2e-9)
        np.testing.assert_allclose(result[CHANNELS[group]][rows, int(i)], theirs, rtol=0, atol=within, err_msg=column)
