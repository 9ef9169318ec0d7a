# SPDX-License-Identifier: MIT
"""The whole loop of wang2023, plant included, against rows of an independent implementation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gyrostat import papers

GOLDEN = Path(__file__).parents[1] / "golden" / "wang2023_mlsmc_warm.csv"
CHANNELS = {
    "q": "truth.q_NB",
    "w": "truth.omega_BN_B",
    "w_hat": "observer.omega_hat",
    "uf_hat": "observer.learnt",
    "udf_hat": "controller.learnt",
    "S": "controller.s",
    "u": "allocation.u",
}


def test_the_closed_loop_gives_the_reference_rows() -> None:
    lines = [line for line in GOLDEN.read_text().splitlines() if not line.startswith("#")]
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    golden = dict(zip(lines[0].split(","), rows.T, strict=True))
    scenario = papers.load("wang2023").cases["mlsmc_warm"].scenario.replace(duration=0.1)
    assert scenario.resolve()["integrator"] == {"type": "rk4", "substeps": 1}
    result = scenario.run(channels=sorted(CHANNELS.values()))
    count = len(rows)
    assert count == 60
    np.testing.assert_allclose(result.t[:count], golden.pop("t"), rtol=1e-14)
    for column, theirs in golden.items():
        group, _, i = column.rpartition("_")
        # Both in double, one Runge-Kutta step a sample: measured 7e-14 of each column's scale.
        ours = result[CHANNELS[group]][:count, int(i)]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max(), err_msg=column)
    assert len(golden) == 22
