# SPDX-License-Identifier: MIT
"""Yang et al. 2023, end to end: the data say what was chosen, the claims hold, the figures show something."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import papers
from gyrostat.papers.yang2023 import signals

Array = NDArray[np.float64]

PAPER = "yang2023"


def test_every_claim_is_accepted(claims: dict[str, Any]) -> None:
    assert [c["id"] for c in claims["claims"] if not c["ok"]] == []
    assert claims["passed"] == len(claims["claims"]) > 400


def test_published_statements_that_do_not_hold_are_reported_as_such(claims: dict[str, Any]) -> None:
    verdicts = {c["id"]: c["verdict"] for c in claims["claims"]}
    for claim in ("max_z@afppc", "fixed.breach@ppc_fixed", "socp_h10.energy_ratio", "fd_a.ilo_rmse_e1@fd_a"):
        assert verdicts[claim] == "reproduces", claim
    for claim in ("fd_a.ailo_rmse_e1@fd_a", "fd_a.ailo_t5@fd_a", "socp.energy_ratio", "ftsmc_b1_0p12.energy_ratio"):
        assert verdicts[claim] == "does not reproduce", claim


def test_the_report_has_every_figure_with_its_data(report: Path) -> None:
    names = {f.name for f in papers.load("yang2023").figures}
    assert {f"fig{i}" for i in range(2, 8)} < names
    for name in names:
        assert (report / "yang2023" / f"{name}.js").stat().st_size > 400
        with np.load(report / "yang2023" / f"{name}.npz") as data:
            for signal in data.files:
                if signal != "units":
                    assert np.isfinite(data[signal]).all(), f"{name}: {signal}"
                    assert len(data[signal]) > 100, f"{name}: {signal}"
            if any(signal.startswith("q_e") for signal in data.files):
                assert any(signal.endswith("upper") for signal in data.files), f"{name}: an error without its funnel"


@pytest.fixture(scope="module")
def bench() -> dict[str, gs.Result]:
    """Both benches with what they inject and command."""
    cases = papers.load("yang2023").cases
    channels = ["truth.effectiveness", "truth.external_B", "allocation.u"]
    return {k: cases[f"fd_{k}"].scenario.replace(shadows=[]).run(channels=channels) for k in ("a", "b")}


def test_the_bench_flies_the_square_torques_and_the_chosen_faults(bench: dict[str, gs.Result]) -> None:
    t = bench["a"].t
    after = t + 5e-3  # a command holds from its sample on
    for result in bench.values():
        for i, period in enumerate((20.0, 24.0, 28.0)):
            expected = np.where(np.mod(after + period / 4, period) < period / 2, 0.2, -0.2)
            np.testing.assert_array_equal(result["allocation.u"][:, i], expected)
        assert not result["allocation.u"][:, 3].any(), "the spare stays off"
    t, before = t[1:], t[1:] - 1e-6  # a sample shows the interval just ended
    e = bench["a"]["truth.effectiveness"][1:]
    np.testing.assert_array_equal(e[:, 0], np.select([before < 20.0, before < 70.0], [1.0, 0.7], 0.4))
    np.testing.assert_array_equal(e[:, 1], np.where(before < 35.0, 1.0, 0.5))
    np.testing.assert_array_equal(e[:, 2], np.select([before < 50.0, before < 90.0], [1.0, 0.6], 0.8))
    e = bench["b"]["truth.effectiveness"][1:]
    for i, (mean, size, rate, on) in enumerate(((0.8, 0.2, 0.3, 10.0), (0.8, 0.2, 0.5, 20.0), (0.75, 0.25, 0.4, 30.0))):
        expected = np.where(before < on, 1.0, mean + size * np.cos(rate * (t - on)))
        np.testing.assert_allclose(e[:, i], expected, rtol=0, atol=1e-13)  # rounding of the phase


def test_the_disturbance_is_the_printed_function_of_time(bench: dict[str, gs.Result]) -> None:
    t = bench["a"].t
    printed = 1e-3 * np.column_stack(
        [
            0.6 * np.cos(0.05 * t) * np.sin(0.11 * t),
            1.0 + 3.0 * np.sin(0.06 * t),
            1.0 + np.cos(0.07 * t) * np.cos(0.21 * t),
        ]
    )
    np.testing.assert_allclose(bench["a"]["truth.external_B"], printed, rtol=0, atol=1e-16)


def test_the_index_of_a_quiet_plant_is_the_ratio_of_model_and_truth() -> None:
    scenario = (
        papers.load("yang2023")
        .cases["fd_healthy"]
        .scenario.replace(shadows=[], sensors=[], disturbances=[], duration=4.0)
    )
    result = scenario.run(channels=["truth.lumped_mean_B", "allocation.u"])
    # J0 w' + w x J0 w with J = 1.1 J0 and D = 1.01 D0 is 1.01 / 1.1 of the command, rates being proportional to it.
    np.testing.assert_allclose(signals.index(result)[1:], 1.01 / 1.1, rtol=1e-7)


def test_open_loop_says_what_is_wrong() -> None:
    scenario = gs.Scenario.load("ftc_4rw").replace(
        controller=gs.controller("open_loop", command=[0.1, 0.2]), duration=1.0
    )
    with pytest.raises(ValueError, match="entries of command = 2"):
        scenario.run()
    with pytest.raises(ValueError, match="period"):
        scenario.replace(
            controller={"type": "open_loop", "command": [{"type": "square", "period": -1.0}, 0, 0, 0]}
        ).run()


@pytest.mark.parametrize(("metric", "given"), [("event_time", {"count": 3}), ("first_event_after", {"after": 60.0})])
def test_a_counter_that_did_not_move_is_not_measured(
    bench: dict[str, gs.Result], metric: str, given: dict[str, float]
) -> None:
    with pytest.raises(ValueError, match=r"'controller\.arms' did not count"):
        signals.METRICS[metric](bench["a"], name="controller.arms", **given)
