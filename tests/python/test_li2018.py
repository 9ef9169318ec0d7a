# SPDX-License-Identifier: MIT
"""Li et al. 2018, end to end: the data say what the paper prints, the claims hold, the figures show something."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import papers
from gyrostat.papers import measures
from gyrostat.papers.li2018 import signals

Array = NDArray[np.float64]

PAPER = "li2018"


def data(report: Path, figure: str) -> dict[str, Array]:
    """The data behind a figure, without its units."""
    with np.load(report / "li2018" / f"{figure}.npz") as file:
        return {name: file[name] for name in file.files if name != "units"}


@pytest.fixture(scope="module")
def flown() -> gs.Result:
    """Table 2 at 10 ms with everything that the printed formulas can be held against."""
    scenario = papers.load("li2018").cases["table2_command_limit"].scenario.replace(dt=0.01, duration=120.0)
    truth = [f"truth.{n}" for n in ("omega_BN_B", "effectiveness", "bias", "external_B", "lumped_B")]
    return scenario.run(channels=[*truth, "allocation.u"])


def test_every_claim_is_accepted(claims: dict[str, Any]) -> None:
    assert claims["paper"] == "li2018"
    assert [c["id"] for c in claims["claims"] if not c["ok"]] == []
    assert claims["failed"] == 0
    assert claims["passed"] == len(claims["claims"]) > 200


def test_published_statements_that_do_not_hold_are_reported_as_such(claims: dict[str, Any]) -> None:
    verdicts = {c["id"]: c["verdict"] for c in claims["claims"]}
    for claim in ("t1.z1_40_50@table1", "t1.settling_1e-3@table1", "t2b.settling_1e-4@table2_output_limit"):
        assert verdicts[claim] == "reproduces"
    for claim in ("t1.settling_1e-4@table1", "t1.z2_sign", "t2.pd_bounded@table2_command_limit_spd_tuned"):
        assert verdicts[claim] == "does not reproduce"


def test_the_report_has_every_figure_with_its_data(report: Path) -> None:
    names = {f.name for f in papers.load("li2018").figures}
    assert {f"fig{i}" for i in range(1, 9)} < names
    page = (report / "index.html").read_text()
    assert "http" not in page, "self-contained"
    for name in names:
        assert f'id="li2018-{name}"' in page
        assert (report / "li2018" / f"{name}.js").stat().st_size > 400
        found = data(report, name)
        clocks = [n for n in found if n.split(" of ")[0] in ("t", "period", "effectiveness")]
        lengths = {len(found[c]) for c in clocks}
        for signal in set(found) - set(clocks):
            x = found[signal]
            assert np.isfinite(x).all(), f"{name}: {signal}"
            assert (np.ptp(x, axis=0) > 0.0).all(), f"{name}: {signal} is constant"
            assert len(x) in lengths, f"{name}: {signal}"


def test_the_figures_show_what_the_claims_say(report: Path) -> None:
    attitude = data(report, "fig3")
    np.testing.assert_allclose(attitude["x: MRP, table1"][0], -0.1579, rtol=1e-12)
    assert attitude["t"][[0, -1]].tolist() == [0.0, 150.0]
    assert np.abs(attitude["x: MRP, table1"][-1]) < 1e-7
    assert attitude["largest: MRP, table1_spd_soft"][attitude["t"] > 100.0].max() > 1e-2
    assert data(report, "fig8")["command 1 (N m), table2_command_limit"].min() == -0.25
    assert data(report, "fig8")["command 1 (N m), table2_output_limit"].min() < -0.9
    z1 = data(report, "fig1")
    settled = (z1["t"] > 40.0) & (z1["t"] < 49.9)
    assert z1["z1, implicit observer"][settled].max() < 1e-9 < z1["z1, explicit Euler"][settled].max() < 2e-5
    study = data(report, "discretisation")
    assert study["period"].tolist() == [0.5, 1, 2, 5, 10, 20]
    assert (np.diff(study["|z1| (rad per s), explicit Euler"]) > 0.0).all()
    np.testing.assert_allclose(study["|z1| (rad per s), implicit"], 3.3e-12, rtol=0.05)  # does not depend on the period
    sweep = data(report, "effectiveness")
    assert (sweep["z1"][sweep["effectiveness"] < 0.19] > 1e-3).all()
    assert (sweep["z1"][sweep["effectiveness"] > 0.19] <= 1e-15).all()


def test_faults_are_the_printed_functions_of_time(flown: gs.Result) -> None:
    t = flown.t[1:]  # before the first interval there is no command, so no fault to see
    before = t - 1e-6  # a sample shows the interval just ended
    e = flown["truth.effectiveness"][1:]
    np.testing.assert_array_equal(e[:, 0], np.where(before < 10.0, 1.0, 0.5))
    np.testing.assert_array_equal(e[:, 1], np.where(np.mod(before, 100.0) < 50.0, 0.85, 0.6))
    np.testing.assert_allclose(e[:, 2], 0.2 + 0.07 * np.sin(0.2 * t), rtol=1e-13)
    np.testing.assert_array_equal(e[:, 3], np.where(before < 10.0, 1.0, 0.0))
    bias = np.column_stack([0.0 * t, 0.008 + 0.0 * t, 0.05 * np.sin(t), 0.005 + 0.0 * t])
    np.testing.assert_allclose(flown["truth.bias"][1:], bias, rtol=1e-12, atol=1e-16)  # sin near its zeros


def test_the_disturbance_is_the_printed_function_of_time_and_rate(flown: gs.Result) -> None:
    t, sigma = flown.t, 10.0 * np.linalg.norm(flown["truth.omega_BN_B"], axis=1)
    d_B = 0.25e-3 * np.column_stack(
        [
            2.0 * np.cos(10.0 * sigma * t) + 3.0 * np.sin(3.0 * sigma * t) - 8.0,
            -1.5 * np.sin(2.0 * sigma * t) + 3.0 * np.cos(5.0 * sigma * t) + 12.0,
            3.0 * np.sin(10.0 * sigma * t) - 6.0 * np.sin(4.0 * sigma * t) + 9.0,
        ]
    )
    # The phase reaches 100 rad, so rounding of the products and of cos(x) = sin(x + pi/2) is some 1e-13 of 1e-3 N m.
    np.testing.assert_allclose(flown["truth.external_B"], d_B, rtol=0, atol=1e-14)
    np.testing.assert_allclose(signals._disturbance_at_rest(flown), [-1.5e-3, 3.75e-3, 2.25e-3], rtol=1e-12)


def test_the_lumped_torque_is_equation_4(flown: gs.Result) -> None:
    """Equation (4), with D before the bias, which the paper leaves out."""
    D_B = np.array(flown.description["vehicle"]["D_B"])
    held = np.vstack([np.zeros(4), flown["allocation.u"][:-1]])
    e, bias = flown["truth.effectiveness"], flown["truth.bias"]
    dbar = ((e - 1.0) * held + bias) @ D_B.T + flown["truth.external_B"]
    np.testing.assert_allclose(flown["truth.lumped_B"][1:], dbar[1:], rtol=0, atol=1e-13)  # rounding of 0.25 N m


def test_two_tables_differ_in_the_two_weak_wheels_only() -> None:
    cases = papers.load("li2018").cases
    one, other = (cases[c].scenario.to_dict() for c in ("table1", "table2_command_limit"))
    for tables in (one, other):
        for key in ("name", "description", "record"):
            del tables[key]
    assert one != other
    other["faults"][2]["remaining"]["offset"] = 0.9
    other["faults"][3]["remaining"] = 0.2
    assert one == other


def test_metrics_of_the_study_on_made_up_signals() -> None:
    t = np.linspace(0.0, 10.0, 1001)
    result = gs.Result({"duration": 10.0}, t, {}, end_time=10.0)
    bump = np.where((t > 2.0 + 1e-9) & (t < 2.055), 1.0, 0.0)  # the samples 2.01 ... 2.05
    assert measures.recovery(result, signal=bump, band=0.5, after=2.0, until=9.0) == pytest.approx(0.06, abs=1e-9)
    assert measures.recovery(result, signal=bump, band=2.0, after=2.0, until=9.0) == pytest.approx(0.01, abs=1e-9)
    assert np.isnan(measures.recovery(result, signal=1.0 - bump, band=0.5, after=5.0, until=9.0))
    assert signals.largest_increase(result, signal=-t) == pytest.approx(-0.01)
    assert signals.largest_increase(result, signal=bump) == 1.0
    twice = gs.Result({"duration": 10.0}, t, {}, end_time=10.0)
    assert measures.ratio(result, signal=4.0 * t, against=twice, other=2.0 * t, window=(1.0, 9.0)) == pytest.approx(2.0)
    late = np.where(t < 7.0, 1.0, 0.0)
    early = np.where(t < 4.0, 1.0, 0.0)
    found = signals.settling_difference(result, signal=late, against=twice, other=early, band=0.5)
    assert found == pytest.approx(3.0)
