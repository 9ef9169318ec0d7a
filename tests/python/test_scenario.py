# SPDX-License-Identifier: MIT
"""Scenarios: one meaning in Python and TOML, frozen, hashable, changed by copy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gyrostat as gs
from gyrostat import _core, toml
from gyrostat.scenario import shipped


def test_toml_says_the_same_as_python(scenario: gs.Scenario, tmp_path: Path) -> None:
    path = tmp_path / "same.toml"
    scenario.to_toml(path)
    again = gs.Scenario.from_toml(path)
    assert again == scenario
    assert hash(again) == hash(scenario)


def test_nested_waveforms_and_tables_survive_the_way_through_toml(scenario: gs.Scenario, tmp_path: Path) -> None:
    wave = gs.waveforms.Sine(offset=0.9, amplitude=0.07, omega=0.2)
    nested = scenario.replace(
        name='with "quotes" and umlauts: ü',
        faults=[gs.faults.LossOfEffectiveness(actuator=0, remaining=wave), gs.faults.Bias(actuator=1, torque=wave)],
        shadows=[{"observer": "finite_time_disturbance"}],
        record={"channels": ["truth.omega_BN_B"], "every": 5},
    )
    path = tmp_path / "nested.toml"
    nested.to_toml(path)
    assert gs.Scenario.from_toml(path) == nested


def test_arrays_and_lists_mean_the_same() -> None:
    listed = gs.vehicle.pyramid4(J_B=[10.0, 12.0, 9.0], u_max=0.1)
    assert gs.vehicle.pyramid4(J_B=np.array([10.0, 12.0, 9.0]), u_max=np.float64(0.1)) == listed


def test_the_pyramid_gives_equal_authority_on_all_axes() -> None:
    D = np.asarray(gs.vehicle.pyramid4(J_B=(10.0, 12.0, 9.0)).D_B)
    np.testing.assert_allclose(D @ D.T, 4.0 / 3.0 * np.eye(3), atol=1e-15)  # rounding of 1 / sqrt 3


@pytest.mark.parametrize("make", [gs.vehicle.pyramid4, gs.vehicle.orthogonal_skew4])
def test_any_three_actuators_of_a_ready_made_layout_suffice(make) -> None:
    D = np.asarray(make(J_B=(10.0, 12.0, 9.0)).D_B)
    np.testing.assert_allclose(np.linalg.norm(D, axis=0), 1.0, atol=1e-15)
    for lost in range(4):
        assert np.linalg.matrix_rank(np.delete(D, lost, axis=1)) == 3


def test_a_scenario_cannot_be_changed_in_place(scenario: gs.Scenario) -> None:
    with pytest.raises(ValueError, match="frozen"):
        scenario.duration = 1.0
    assert scenario.replace(duration=1.0).duration == 1.0
    assert scenario.duration == 30.0


def test_dotted_keys_reach_inside(scenario: gs.Scenario) -> None:
    changed = scenario.replace(
        **{"faults.0.remaining": 0.3, "observer": "finite_time_disturbance", "vehicle.u_max": 0.1}
    )
    assert changed.faults[0].params["remaining"] == 0.3
    assert changed.vehicle.u_max == 0.1
    changed = changed.replace(**{"observer.lambda1": 2.0})
    assert changed.resolve()["observer"]["lambda1"] == 2.0


def test_a_component_equals_one_that_says_the_same_in_another_order() -> None:
    one = gs.observer("finite_time_disturbance", lambda1=1.0, lambda2=0.6)
    assert one == gs.observer("finite_time_disturbance", lambda2=0.6, lambda1=1.0)
    assert one != gs.observer("finite_time_disturbance", lambda1=1.0)


def test_resolve_fills_every_parameter_of_every_component(scenario: gs.Scenario) -> None:
    resolved = scenario.resolve()
    for role in ("observer", "detector", "controller", "allocator", "reference", "integrator"):
        given_ = set(resolved[role]) - {"type"}
        with_default = {
            p["name"] for p in _core.describe(role, resolved[role]["type"])["params"] if p["default"] is not None
        }
        assert with_default <= given_


@pytest.mark.parametrize("name", sorted(shipped()))
def test_every_shipped_scenario_is_valid(name: str) -> None:
    loaded = gs.Scenario.load(name)
    assert loaded.description, "a shipped scenario says what it shows"
    assert all(row["ok"] for row in loaded.check()) or loaded.allow_unstable


@pytest.mark.parametrize(("model", "family"), [(gs.Vehicle, "vehicle"), (gs.Truth, "truth"), (gs.Initial, "initial")])
def test_the_models_have_exactly_the_keys_of_the_catalogue(model, family: str) -> None:
    assert list(model.model_fields) == [p["name"] for p in _core.describe(family, family)["params"]]


def test_a_constructor_carries_signature_and_documentation_of_the_catalogue() -> None:
    import inspect

    parameters = inspect.signature(gs.faults.LossOfEffectiveness).parameters
    assert parameters["actuator"].default is inspect.Parameter.empty
    assert parameters["t_on"].default == 0.0
    assert "delivered / commanded" in (gs.faults.LossOfEffectiveness.__doc__ or "")


_plain = st.one_of(
    st.booleans(), st.integers(-(2**53), 2**53), st.floats(allow_nan=False), st.text(st.characters(codec="utf-8"))
)
_values = st.recursive(_plain, lambda inner: st.lists(inner, max_size=4), max_leaves=12)
_tables = st.dictionaries(st.text(max_size=8), _values, max_size=4)


@given(
    st.dictionaries(
        st.text(max_size=8), st.one_of(_values, _tables, st.lists(_tables, min_size=1, max_size=3)), max_size=5
    )
)
def test_what_is_written_as_toml_is_read_back(tables: dict) -> None:
    import tomllib

    assert tomllib.loads(toml.write(tables)) == tables


def test_a_folder_of_its_name_does_not_hide_a_shipped_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What `gyrostat run wheel2_degraded --out wheel2_degraded` leaves."""
    (tmp_path / "wheel2_degraded").mkdir()
    monkeypatch.chdir(tmp_path)
    assert gs.Scenario.load("wheel2_degraded").name == "wheel2_degraded"
