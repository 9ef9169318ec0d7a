# SPDX-License-Identifier: MIT
"""The stability limit of the compensation, against roots of the characteristic polynomial."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import design

gains = st.floats(0.05, 20.0)


def largest_real_part(m: float, r: NDArray[np.float64] | float, l1: float, l2: float) -> float:
    """Of the roots of s^3 + m (r + l1) s^2 + m (l1 r + l2) s + m l2 r for every slope, as eigenvalues of companions."""
    slopes = np.atleast_1d(r)
    companion = np.zeros((slopes.size, 3, 3))
    companion[:, [1, 2], [0, 1]] = 1.0
    companion[:, 0] = -m * np.stack([slopes + l1, l1 * slopes + l2, l2 * slopes], axis=1)
    return float(np.linalg.eigvals(companion).real.max())


@given(gains, gains, st.floats(1e-3, 1e3))
def test_above_the_limit_every_correction_is_stable(lambda1: float, lambda2: float, slope: float) -> None:
    m = 1.001 * design.critical_effectiveness(lambda1, lambda2)
    assert largest_real_part(m, slope, lambda1, lambda2) < 0.0


@given(gains, gains)
def test_just_below_the_limit_some_correction_is_unstable(lambda1: float, lambda2: float) -> None:
    m = 0.99 * design.critical_effectiveness(lambda1, lambda2)
    slopes = np.geomspace(1e-4, 1e4, 4001)
    assert largest_real_part(m, slopes, lambda1, lambda2) > 0.0


def test_the_published_gains_have_a_limit_of_19_percent() -> None:
    # Li et al. 2018: lambda1 = 1, lambda2 = 0.6
    assert design.critical_effectiveness(1.0, 0.6) == pytest.approx(0.19, abs=5e-3)


def test_uniform_effectiveness_is_its_own_eigenvalue() -> None:
    D = np.asarray(gs.vehicle.pyramid4(J_B=(1.0, 1.0, 1.0)).D_B)
    low, high = design.effectiveness_range(D, np.full((3, 4), 0.3))
    assert (low, high) == pytest.approx((0.3, 0.3), rel=1e-13)


def test_the_eigenvalues_are_those_of_the_product_as_written() -> None:
    rng = np.random.default_rng(5)
    D, E = rng.normal(size=(3, 5)), rng.uniform(0.1, 1.0, size=(20, 5))
    written = [np.linalg.eigvals(D @ np.diag(e) @ np.linalg.pinv(D)).real for e in E]
    low, high = design.effectiveness_range(D, E)
    assert (low, high) == pytest.approx((np.min(written), np.max(written)), rel=1e-10)


def test_a_scenario_without_that_observer_has_no_margin(scenario: gs.Scenario) -> None:
    assert design.scenario_margin(scenario) is None


def test_impossible_gains_are_refused() -> None:
    with pytest.raises(gs.InputError, match="lambda1 = -1"):
        design.critical_effectiveness(-1.0, 0.6)
    with pytest.raises(gs.InputError, match="empty"):
        design.compensation_margin(1.0, 0.6, (0.9, 0.1))
