# SPDX-License-Identifier: MIT
"""Wang, Jia, Yu 2023, end to end: the data say what the paper prints, the claims hold, the signs do not matter."""

from __future__ import annotations

import copy
import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import papers
from gyrostat.papers.wang2023 import signals

PAPER = "wang2023"


def test_every_claim_is_accepted(claims: dict[str, Any]) -> None:
    assert [c["id"] for c in claims["claims"] if not c["ok"]] == []
    assert claims["passed"] == len(claims["claims"]) > 100


def test_published_statements_that_do_not_hold_are_reported_as_such(claims: dict[str, Any]) -> None:
    verdicts = {c["id"]: c["verdict"] for c in claims["claims"]}
    for claim in ("observer.fault_error_z", "smc.q1", "smc.q3", "P1_identity.q1", "P1_identity.q3", "smc.worse_q1"):
        assert verdicts[claim] == "reproduces", claim
    for claim in ("observer.fault_error_x", "ilsmo.fair_x", "noise.std_mixed", "integral.end", "smc.omega_z"):
        assert verdicts[claim] == "does not reproduce", claim


def test_noise_passes_through_all_shares_alike(claims: dict[str, Any]) -> None:
    measured = {c["id"]: c["measured"] for c in claims["claims"]}
    spread = [measured[f"noise.std_{share}"] for share in ("mixed", "repetitive", "half", "iterative")]
    assert max(spread) < 1.03 * min(spread)
    assert measured["noise.roughness"] == pytest.approx(np.sqrt(0.9**2 + 0.1**2), rel=0.02), "by the shares alone"
    assert measured["noise.roughness_half"] == pytest.approx(np.sqrt(0.5**2 + 0.5**2), rel=0.02)


def test_the_report_has_every_figure_with_its_data(report: Path) -> None:
    names = {f.name for f in papers.load("wang2023").figures}
    assert {f"fig{i}" for i in range(1, 11)} < names
    for name in names:
        assert (report / "wang2023" / f"{name}.js").stat().st_size > 400
        with np.load(report / "wang2023" / f"{name}.npz") as file:
            for key in set(file.files) - {"units"}:
                assert np.isfinite(file[key]).all(), f"{name}: {key}"
                if (name, key) == ("fig1", "fault y"):
                    assert (file[key] == 0.0).all(), "there is no fault about y"
                else:
                    assert np.ptp(file[key]) > 0.0, f"{name}: {key} is constant"


def test_faults_and_disturbance_are_the_printed_functions_of_time() -> None:
    scenario = papers.load("wang2023").cases["mlsmc_clip"].scenario
    flown = scenario.replace(duration=120.0).run(channels=["truth.bias", "truth.external_B"], every=100)
    t = flown.t[1:]
    before = t - 1e-6  # a sample shows the interval just ended
    fault = np.zeros((len(t), 3))
    fault[:, 0] = np.where(before > 50.0, 0.1 + 0.08 * np.sin(np.pi * t / 5.0), 0.0)
    fault[:, 2] = np.where(before > 100.0, 0.1, 0.0)
    np.testing.assert_allclose(flown["truth.bias"][1:], fault, rtol=0, atol=1e-12)
    n, J = 0.0012 * t, np.array([18.73, 20.77, 23.63])
    waves = np.column_stack([3.0 * np.cos(n) + 1.0, 1.5 * np.sin(n) + 3.0 * np.cos(n), 3.0 * np.sin(n) + 1.0])
    np.testing.assert_allclose(flown["truth.external_B"][1:], 1.5e-5 * J * waves, rtol=0, atol=1e-15)


def test_the_signs_that_the_text_lost_do_not_matter() -> None:
    """Signs of the initial attitude and rate: the late errors of the observer agree within a per cent."""
    case = papers.load("wang2023").cases["mlsmc"].scenario.replace(duration=200.0)
    found = []
    for signs in itertools.islice(itertools.product((1.0, -1.0), repeat=6), 0, 64, 9):
        q = np.array([0.5150, *np.array([0.7221, 0.3760, 0.2681]) * signs[:3]])
        initial = {"q_NB": q.tolist(), "omega_BN_B": (np.array([0.16, 0.12, 0.10]) * signs[3:]).tolist()}
        result = case.replace(initial=initial).run(channels=["truth.bias", "estimate.d_B"], every=5)
        found.append(np.abs(signals.fault_error(result)[result.t > 150.0]).max(axis=0)[[0, 2]])
    np.testing.assert_allclose(found, np.broadcast_to(found[0], (len(found), 2)), rtol=0.01)


def test_a_relabelling_and_reflection_of_the_axes_turns_the_whole_loop() -> None:
    """Inertias, torquers, gains, disturbance and initial state turned by a signed permutation: the run is turned."""
    R = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
    case = papers.load("wang2023").cases["mlsmc_warm"].scenario
    given = case.replace(duration=60.0).to_dict()
    turned = copy.deepcopy(given)
    turned["vehicle"]["J_B"] = (R @ np.array(given["vehicle"]["J_B"]) @ R.T).tolist()
    turned["vehicle"]["D_B"] = R.tolist()
    turned["truth"]["dJ_B"] = (R @ np.array(given["truth"]["dJ_B"]) @ R.T).tolist()
    for part, key in (("observer", "K1"), ("observer", "K2"), ("controller", "K3")):
        turned[part][key] = (R @ np.array(given[part][key]) @ R.T).tolist()
    q, w = np.array(given["initial"]["q_NB"]), np.array(given["initial"]["omega_BN_B"])
    turned["initial"] = {"q_NB": [q[0], *(R @ q[1:])], "omega_BN_B": (R @ w).tolist()}
    torque = np.array([1.1e-3, 9.3e-4, 3.5e-4])  # that of the paper at the start
    given["disturbances"] = [{"type": "constant", "torque_B": torque.tolist()}]
    turned["disturbances"] = [{"type": "constant", "torque_B": (R @ torque).tolist()}]
    channels = ["truth.q_NB", "estimate.d_B"]
    one, other = (gs.Scenario.from_dict(x).run(channels=channels, every=100) for x in (given, turned))
    # Sums in another order: measured 1e-16 and 8e-15 N m.
    np.testing.assert_allclose(other["truth.q_NB"][:, 1:], one["truth.q_NB"][:, 1:] @ R.T, atol=1e-14)
    np.testing.assert_allclose(other["estimate.d_B"], one["estimate.d_B"] @ R.T, atol=1e-12)


def test_the_constant_offset_of_the_sliding_mode_is_its_closed_form() -> None:
    """(|d| - k_sgn) / (k_lin delta), without disturbance and inertia error."""
    case = papers.load("wang2023").cases["smc"].scenario
    result = case.replace(
        faults=[{"type": "bias", "actuator": 2, "torque": 0.1}], disturbances=[], truth={}, initial={}
    ).run(channels=["truth.q_NB"], every=100)
    assert abs(result["truth.q_NB"][-1, 3]) == pytest.approx((0.1 - 0.01) / 0.3, rel=1e-4)
