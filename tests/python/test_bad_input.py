# SPDX-License-Identifier: MIT
"""Bad input: one line that names the place, the key, the value and what is allowed, before anything runs."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import pytest

import gyrostat as gs


class Silent:
    """Forgets its return statement."""

    def step(self, *_: object) -> None: ...


def circle() -> list[Any]:
    inside: list[Any] = []
    inside.append(inside)
    return inside


def circle_of_tables() -> dict[str, Any]:
    inside: dict[str, Any] = {"type": "hold"}
    inside["euler"] = inside
    return inside


def levels(number: int) -> list[Any]:
    inside: list[Any] = []
    for _ in range(number):
        inside = [inside]
    return inside


# what is changed -> what the message must say
CASES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "wrong type of a number": ({"dt": "fast"}, ["dt = 'fast'", "number"]),
    "wrong type of a parameter": (
        {"observer": {"type": "finite_time_disturbance", "lambda1": "high"}},
        ["observer 'finite_time_disturbance'", "lambda1", "high", "number"],
    ),
    "a switch is no number": ({"duration": True}, ["duration", "True", "number"]),
    "unknown key": ({"durration": 3.0}, ["durration", "did you mean 'duration'"]),
    "unknown key of the vehicle": ({"vehicle.umax": 0.1}, ["vehicle", "umax", "did you mean 'u_max'"]),
    "misspelt component": (
        {"observer": "finite_time_disturbanc"},
        ["observer", "finite_time_disturbanc", "did you mean 'finite_time_disturbance'"],
    ),
    "misspelt parameter": (
        {"observer": {"type": "finite_time_disturbance", "lamda1": 1.0}},
        ["observer 'finite_time_disturbance'", "lamda1", "did you mean 'lambda1'"],
    ),
    "value out of range": (
        {"observer": {"type": "finite_time_disturbance", "lambda1": -1.0}},
        ["observer 'finite_time_disturbance'", "lambda1 = -1", "["],
    ),
    "value that is not a number": (
        {"observer": {"type": "finite_time_disturbance", "lambda1": math.nan}},
        ["lambda1 = nan", "not a number"],
    ),
    "infinite value": ({"initial.omega_BN_B": [math.inf, 0.0, 0.0]}, ["initial", "omega_BN_B", "inf", "finite"]),
    "infinite duration": ({"duration": math.inf}, ["duration", "inf", "finite"]),
    "non-symmetric inertia": (
        {"vehicle.J_B": [[20.0, 1.0, 0.0], [0.0, 17.0, 0.0], [0.0, 0.0, 15.0]]},
        ["vehicle", "J_B", "not symmetric", "1"],
    ),
    "non-positive inertia": ({"vehicle.J_B": [20.0, -17.0, 15.0]}, ["vehicle", "J_B", "-17", "> 0"]),
    "no body has this inertia": ({"vehicle.J_B": [40.0, 17.0, 15.0]}, ["vehicle", "J_B", "17", "40", "triangle"]),
    "zero quaternion": ({"initial": {"q_NB": [0.0, 0.0, 0.0, 0.0]}}, ["initial", "q_NB", "zero"]),
    "non-unit quaternion": ({"initial": {"q_NB": [1.0, 1.0, 0.0, 0.0]}}, ["initial", "q_NB", "norm 1.41", "unit"]),
    "two attitudes at once": (
        {"initial": {"mrp": [0.0, 0.0, 0.1], "euler": [0.0, 0.0, 0.1]}},
        ["initial", "q_NB, mrp and euler"],
    ),
    "rank-deficient actuators": (
        {"vehicle": {"J_B": [20.0, 17.0, 15.0], "D_B": [[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 0.0]]}},
        ["vehicle", "D_B", "rank", "three independent"],
    ),
    "negative sample time": ({"dt": -0.01}, ["dt = -0.01", "["]),
    "zero sample time": ({"dt": 0.0}, ["dt = 0", "["]),
    "fault on an actuator that is not there": ({"faults.0.actuator": 7}, ["faults[0]", "actuator = 7", "0 to 3"]),
    "contradictory faults": (
        {
            "faults": [
                {"type": "stuck", "actuator": 1, "t_on": 5.0, "torque": 0.1},
                {"type": "dead", "actuator": 1, "t_on": 10.0},
            ]
        },
        ["stuck", "dead", "1"],
    ),
    "duration not a multiple of dt": ({"duration": 30.005}, ["duration = 30.005", "dt = 0.01", "30 ", "30.01"]),
    "component without a type": ({"observer": {"lambda1": 2.0}}, ["observer", "type"]),
    "list where one component belongs": ({"faults": {"type": "dead", "actuator": 1}}, ["faults", "list"]),
    "position that is not in the list": ({"faults.3.t_on": 1.0}, ["faults.3", "0 to 0"]),
    "missing vehicle part": ({"vehicle": {"J_B": [1.0, 1.0, 1.0]}}, ["vehicle", "D_B is missing"]),
    "unknown key of a shadow": ({"shadows": [{"obs": "passthrough"}]}, ["shadows[0]", "obs", "observer"]),
    "seed that is no whole number": ({"seed": 1.5}, ["seed = 1.5", "integer"]),
    "an object that cannot fly": ({"controller": object()}, ["controller", "object"]),
    "a class instead of an object": ({"controller": Silent}, ["controller", "Silent is a class", "Silent(...)"]),
    "a disturbance in Python": (
        {"disturbances": [Silent()]},
        ["disturbances", "Silent is a Python object without torque_B(...)", "constant, periodic", "gyrostat.waveforms"],
    ),
    "a fault in Python": ({"faults": [Silent()]}, ["faults", "Silent", "loss_of_effectiveness", "dead_zone"]),
    "a sensor in Python": ({"sensors": [Silent]}, ["sensors", "Silent", "gyro, attitude"]),
    "a reference in Python": ({"reference": Silent()}, ["reference", "Silent", "hold, steps, slew"]),
    "a shadow in Python": ({"shadows": [{"observer": Silent()}]}, ["shadows[0]", "observer", "Silent", "passthrough"]),
    "channels that are one text": ({"record.channels": "error.angle"}, ["record: channels", "['error.angle']"]),
    "a channel that is no text": ({"record.channels": [3]}, ["record: channels", "3 is no text"]),
    "no sample between two": ({"record.every": 0}, ["record: every", "0", "1 to 1000000000"]),
    "per cent": ({"faults.0.remaining": 40}, ["remaining = 40", "[-2, 2]", "looks like per cent"]),
    "per cent in a waveform": (
        {"faults.0.remaining": {"type": "sum", "terms": [40, {"type": "sine", "amplitude": 5.0}]}},
        ["remaining = {type = 'sum', ...}", "looks like per cent"],
    ),
    "degrees": ({"initial": {"euler": [10.0, 20.0, 30.0]}}, ["initial: euler", "looks like degrees"]),
    "degrees of a slew": (
        {"reference": {"type": "slew", "to_euler": [0.0, 0.0, 90.0], "duration": 9.0}},
        ["reference 'slew'", "to_euler", "looks like degrees"],
    ),
    "degrees in rows": (
        {"reference": {"type": "steps", "times": [0.0], "euler": [[0.0, 0.0, 90.0]]}},
        ["reference 'steps'", "euler", "looks like degrees"],
    ),
    "a digit that is no position": ({"faults.².t_on": 1.0}, ["'faults.²'", "0 to 0"]),
    "a key with the name of our own argument": ({"self": 1}, ["unknown key 'self'"]),
    "a table whose keys are no texts": ({"vehicle": {0: 1.0}}, ["{0: 1.0}", "texts"]),
    "an integer beyond all numbers": ({"seed": 10**400}, ["seed", "integer beyond", "1.8e308"]),
    "an integer that Python itself does not write": ({"initial": {"mrp": 10**6000}}, ["initial", "mrp", "6001 digits"]),
    "half of a surrogate pair": ({"name": "\ud800"}, ["name", "surrogate"]),
    "a value that holds itself": ({"initial": {"mrp": circle()}}, ["initial", "mrp", "64", "holds itself"]),
    "a table that holds itself": ({"reference": circle_of_tables()}, ["reference", "64", "holds itself"]),
    "two thousand levels": ({"initial": {"mrp": levels(2000)}}, ["initial", "mrp", "64"]),
    "a line break in a name": ({"observer": "a\nb"}, ["no observer 'a b'"]),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_values_are_refused_in_one_telling_line(scenario: gs.Scenario, case: str) -> None:
    changes, words = CASES[case]
    with pytest.raises(gs.InputError) as caught:
        scenario.replace(**changes)
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message, message


def test_missing_duration_is_named(scenario: gs.Scenario) -> None:
    with pytest.raises(gs.InputError, match=r"^dt is missing$"):
        gs.Scenario(vehicle=scenario.vehicle, duration=1.0)  # type: ignore[call-arg]


def test_a_component_is_checked_when_it_is_written_down() -> None:
    with pytest.raises(gs.InputError, match=r"no parameter 'lamda1', did you mean 'lambda1'\?$"):
        gs.observer("finite_time_disturbance", lamda1=1.0)
    with pytest.raises(gs.InputError, match="actuator is missing"):
        gs.faults.LossOfEffectiveness(remaining=0.4)  # type: ignore[call-arg]


def test_an_unknown_channel_names_a_near_one(scenario: gs.Scenario, result: gs.Result) -> None:
    with pytest.raises(KeyError, match="did you mean 'omega_BN_B'"):
        result["omega_BNB"]
    with pytest.raises(gs.InputError, match=r"no channel 'truth.omga_BN_B', did you mean 'truth.omega_BN_B'"):
        scenario.run(channels=["truth.omga_BN_B"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("duration = 60\ndt 0.01\n", ["line 2"]),
        ("duration = 60\n[vehicle]\nJ_B = [[20, 0,", ["line 3 (end of file)"]),
        ("duration = 60\nduration = 61\n", ["line 2"]),
        ("duration = 60\ndt = 0.01\n", ["vehicle is missing"]),
        ("[vehicle]\nJ_B = 1\n", ["duration is missing"]),
    ],
)
def test_a_broken_file_is_named_with_the_line(tmp_path: Path, text: str, words: list[str]) -> None:
    path = tmp_path / "broken.toml"
    path.write_text(text)
    with pytest.raises(gs.InputError) as caught:
        gs.Scenario.from_toml(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    for word in words:
        assert word in message, message


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "binary.toml"
    path.write_bytes(b"name = '\xff'\n")
    with pytest.raises(gs.InputError, match=r"binary\.toml: byte 8 is not UTF-8 text$"):
        gs.Scenario.from_toml(path)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(gs.InputError, match=r"nowhere\.toml: cannot be read: no such file or directory$"):
        gs.Scenario.load(tmp_path / "nowhere.toml")


def test_an_unknown_shipped_scenario_names_a_near_one() -> None:
    with pytest.raises(gs.InputError, match=r"^no scenario 'wheel2_degrade', did you mean 'wheel2_degraded'\?$"):
        gs.Scenario.load("wheel2_degrade")


def test_a_failed_save_leaves_nothing_behind(
    result: gs.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr("gyrostat.results.np.savez_compressed", broken)
    with pytest.raises(gs.InputError, match=r"run\.npz: cannot be written: no space left"):
        result.save(tmp_path / "run.npz")
    assert list(tmp_path.iterdir()) == []


def test_a_python_component_cannot_be_written_as_toml(scenario: gs.Scenario) -> None:
    class Idle:
        def step(self, *_: object) -> list[float]:
            return [0.0, 0.0, 0.0]

    with pytest.raises(gs.InputError, match="controller is a Python object"):
        scenario.replace(controller=Idle()).to_toml()


def test_a_file_that_is_no_result_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    path.write_bytes(b"no archive")
    with pytest.raises(gs.InputError, match=r"run\.npz: is not a saved result$"):
        gs.Result.load(path)
