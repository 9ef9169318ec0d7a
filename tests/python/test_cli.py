# SPDX-License-Identifier: MIT
"""The command line, in processes of its own."""

from __future__ import annotations

import json
import os
import pty
import re
import subprocess
import sys
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from commands import gyrostat

import gyrostat as gs
from gyrostat import _core
from gyrostat.scenario import shipped
from gyrostat.schema import scenario_schema

SHORT = ["--set", "duration=3"]


def printed(*arguments: str) -> Any:
    done = gyrostat(*arguments)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_help_teaches_with_examples() -> None:
    assert "gyrostat run my.toml" in gyrostat("--help").stdout
    for command in ("list", "describe", "run", "compare", "reproduce", "check", "design", "export", "schema"):
        done = gyrostat(command, "--help")
        assert done.returncode == 0
        assert "Example" in done.stdout, command
    assert gyrostat().stdout == gyrostat("--help").stdout


def test_list_shows_the_catalogue_scenarios_and_papers() -> None:
    listed = printed("list", "--json")
    assert {k: listed[k] for k in _core.catalogue()} == _core.catalogue()
    assert "wheel2_degraded" in listed["scenario"]
    assert "paper" in listed
    assert gyrostat("list", "fault").stdout.startswith("fault")


def test_describe_shows_every_parameter_of_every_component() -> None:
    for family, names in _core.catalogue().items():
        for name in names:
            info = _core.describe(family, name)
            assert info["name"] == name
    text = gyrostat("describe", "finite_time_disturbance").stdout
    for param in _core.describe("observer", "finite_time_disturbance")["params"]:
        assert param["name"] in text
        assert param["meaning"] in text
    info = printed("describe", "integrator", "cvode", "--json")
    assert {p["name"] for p in info["params"]} >= {"rtol", "atol"}


def test_run_prints_the_same_metrics_as_python() -> None:
    done = printed("run", "wheel2_degraded", *SHORT, "--json")
    result = gs.Scenario.load("wheel2_degraded").replace(duration=3).run()
    assert done["status"] == "completed"
    assert done["samples"] == len(result)
    assert done["metrics"] == result.metrics.to_dict()


def test_run_says_in_one_line_how_it_went() -> None:
    done = gyrostat("run", "wheel2_degraded", *SHORT)
    assert done.returncode == 0
    assert done.stdout.count("\n") == 1
    assert "pointing error" in done.stdout


def test_run_saves_data_or_a_folder(tmp_path: Path) -> None:
    assert gyrostat("run", "ftc_4rw", *SHORT, "--out", str(tmp_path / "new" / "run.npz")).returncode == 0
    assert gs.Result.load(tmp_path / "new" / "run.npz").end_time == 3.0
    assert gyrostat("run", "ftc_4rw", *SHORT, "--out", str(tmp_path / "folder")).returncode == 0
    assert sorted(p.name for p in (tmp_path / "folder").iterdir()) == [
        "index.html",
        "overview.npz",
        "overview.png",
        f"plotly-{version('plotly')}.min.js",
        "result.npz",
        "scenario.toml",
    ]
    assert gs.Scenario.from_toml(tmp_path / "folder" / "scenario.toml").duration == 3.0


def test_a_folder_with_another_page_is_refused_before_the_run(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("mine")
    done = gyrostat("run", "ftc_4rw", *SHORT, "--out", str(tmp_path))
    assert done.returncode == 2
    assert "is not a page of gyrostat; choose another folder" in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["index.html"]


def test_the_module_runs_as_the_command() -> None:
    done = subprocess.run([sys.executable, "-m", "gyrostat", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"{_core.__version__}\n"


@pytest.mark.parametrize(("variables", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colour_is_for_terminals_that_want_it(variables: dict[str, str], coloured: bool) -> None:
    master, slave = pty.openpty()
    program = [sys.executable, "-m", "gyrostat", "run", "--help"]
    with subprocess.Popen(program, stdout=slave, env={**_plain, "TERM": "xterm-256color", **variables}):
        os.close(slave)
        shown = b""
        with suppress(OSError):  # how Linux says that the other end is closed
            while chunk := os.read(master, 65536):
                shown += chunk
    os.close(master)
    assert b"Fly a scenario" in shown
    assert bool(re.search(rb"\x1b\[[\d;]*3\d", shown)) == coloured  # a colour of the text
    assert "\x1b" not in gyrostat("run", "--help").stdout


_plain = {k: v for k, v in os.environ.items() if k not in {"NO_COLOR", "FORCE_COLOR", "PY_COLORS", "GITHUB_ACTIONS"}}


def test_set_takes_numbers_words_and_lists() -> None:
    settings = ["observer=finite_time_disturbance", "observer.method=explicit_euler", "faults.0.remaining=0.9"]
    arguments = [part for s in settings for part in ("--set", s)]
    done = printed("run", "wheel2_degraded", *SHORT, *arguments, "--json")
    assert done["status"] == "completed"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "wheel2_degrade"], ["no scenario 'wheel2_degrade'", "did you mean 'wheel2_degraded'"]),
        (["run", "nowhere.toml"], ["nowhere.toml: cannot be read"]),
        (["run", "ftc_4rw", "--set", "observer"], ["--set observer", "KEY=VALUE"]),
        (["run", "ftc_4rw", "--set", "observr.x=1"], ["observr", "did you mean 'observer'"]),
        (["run", "wheel2_degraded", "--set", "observer.lambda1=-1"], ["lambda1 = -1"]),
        (["run", "ftc_4rw", "--set", "duration=60.005"], ["duration = 60.005", "60.01"]),
        (["run", "ftc_4rw", "--out", "run.csv"], ["run.csv", ".npz"]),
        (["run", "ftc_4rw", "--every", "0"], ["--every"]),
        (["describe", "nothing_like_it"], ["no component 'nothing_like_it'"]),
        (["describe", "observer"], ["which observer?", "passthrough"]),
        (["describe", "observer", "passthru"], ["no observer 'passthru'", "did you mean 'passthrough'"]),
        (["list", "faults"], ["no family 'faults'", "did you mean 'fault'"]),
        (["reproduce", "nobody1900"], ["no paper 'nobody1900'"]),
        (["export", "ftc_4rw", "--target", "rust", "--out", "new"], ["no target 'rust'", "cpp"]),
        (["export", "ftc_4rw", "--target", "c"], ["Missing option", "--out"]),
        (["check", "ftc_4rw", "--torque", "0", "nan", "1"], ["--torque 0.0 nan 1.0", "finite"]),
        (["check", "ftc_4rw", "--effectiveness", "1", "0.5"], ["--effectiveness 1 0.5", "lower end"]),
        (["fly"], ["No such command 'fly'"]),
        (["run"], ["Missing argument"]),
    ],
)
def test_bad_input_is_one_line_and_status_2(arguments: list[str], words: list[str]) -> None:
    done = gyrostat(*arguments)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1, done.stderr
    for word in words:
        assert word in done.stderr


def test_a_broken_file_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "cut.toml"
    path.write_text("duration = 60\ndt = 0.01\n[vehicle]\nJ_B = [[20, 0")
    done = gyrostat("run", str(path))
    assert done.returncode == 2
    assert done.stderr.startswith(f"error: {path}: line 4 (end of file)")


def test_a_folder_that_cannot_be_written_is_said_before_the_run(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    for arguments in (
        ["run", "ftc_4rw", "--out", str(blocked / "run.npz")],
        ["run", "ftc_4rw", "--out", str(blocked / "folder")],
        ["reproduce", "all", "--out", str(blocked / "report")],
    ):
        done = gyrostat(*arguments)
        assert done.returncode == 2
        assert done.stderr.startswith("error: ")
        assert "cannot be written" in done.stderr
        assert done.stderr.count("\n") == 1
    assert blocked.read_text() == "not a folder"
    assert list(tmp_path.iterdir()) == [blocked]


def test_a_run_that_ends_early_is_saved_up_to_there_with_status_3(tmp_path: Path) -> None:
    out = tmp_path / "early.npz"
    # 1.7e3 rad/s: more than a thousand radians in a sample, which no integrator goes through.
    settings = ["--set", "initial.omega_BN_B=[1000,1000,1000]", "--set", "integrator={type='rk4'}", "--set", "dt=1"]
    done = gyrostat("run", "ftc_4rw", *settings, "--out", str(out), "--json")
    assert done.returncode == 3
    assert done.stderr.startswith("error: the run ended at ")
    summary = json.loads(done.stdout)
    assert summary["status"] == "integration_failed"
    result = gs.Result.load(out)
    assert result.status == "integration_failed"
    assert result.t[-1] <= result.end_time < 60.0
    assert np.isfinite(result["omega_BN_B"]).all()


def test_run_says_when_auto_would_have_cost_less_than_a_tenth() -> None:
    noisy = ["run", "ftc_4rw", "--set", "dt=0.1", "--set", 'sensors=[{type="gyro",noise=1e-2}]']
    done = gyrostat(*noisy)
    assert 'integrator = "auto" would have flown this in less than a tenth of the time' in done.stdout
    steps = float(done.stdout.split("cvode took ")[1].split()[0])
    assert steps > 4.0
    for quiet in ([*noisy, "--set", "integrator=auto"], ["run", "ftc_4rw"]):
        assert "would have flown" not in gyrostat(*quiet).stdout


def test_a_wheel_with_friction_rests_at_its_momentum_limit_for_a_step_a_sample() -> None:
    settings = ["duration=300", "initial={}", "truth={momentum_max=0.2,viscous_friction=1e-3}"]
    settings.append('disturbances=[{type="constant",torque_B=[2e-3,0,0]}]')  # the wheels are full at 231 s
    for integrator in ("cvode", "rk4", "auto"):
        options = [part for s in [*settings, f"integrator={integrator}"] for part in ("--set", s)]
        done = gyrostat("run", "ftc_4rw", *options, "--json")
        assert done.returncode == 0
        assert json.loads(done.stdout)["statistics"]["steps"] < 1.01 * 30_000


def test_check_says_whether_the_compensation_is_stable() -> None:
    def margin(*options: str, status: int = 0) -> dict[str, Any]:
        done = gyrostat("check", "wheel2_degraded", *options, "--json")
        assert done.returncode == status, done.stderr
        return next(f for f in json.loads(done.stdout)["design"] if f["name"] == "compensation")

    # wheel 2 of the pyramid at 40 %: smallest eigenvalue of D E D+ is 1 - 0.6 * 3 / 4
    assert margin()["value"] == pytest.approx(0.55, abs=1e-12)
    assert margin()["text"] in gyrostat("check", "wheel2_degraded").stdout
    gains = ["--set", "observer.lambda1=1", "--set", "observer.lambda2=0.6"]
    for span, ok, word in ((("0.3", "1"), True, "stable"), (("0.05", "1"), None, "unproven")):
        found = margin(*gains, "--effectiveness", *span)
        assert found["ok"] is ok
        assert found["text"].startswith(word)
        assert found["limit"] == pytest.approx(0.6 / (1 + 0.6**0.5) ** 2, rel=1e-12)
    assert margin(*gains, "--effectiveness", "0.05", "0.1", status=1)["ok"] is False


def test_the_schema_accepts_what_runs_and_refuses_typing_errors(tmp_path: Path) -> None:
    assert gyrostat("schema", "--out", str(tmp_path / "s.json")).returncode == 0
    schema = json.loads((tmp_path / "s.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    for path in shipped().values():
        tables = gs.Scenario.from_toml(path).to_dict()
        validator.validate(tables)
        for wrong in ({**tables, "durtion": 1}, {**tables, "observer": {"type": "passthrogh"}}, {**tables, "dt": "x"}):
            assert not validator.is_valid(wrong)


def test_the_schema_tells_a_mistake_of_the_type_that_was_meant() -> None:
    validator = jsonschema.Draft202012Validator(scenario_schema())
    tables = gs.Scenario.load("wheel2_degraded").to_dict()
    wave = {"type": "sine", "ampltude": 1.0}
    fault = tables["faults"][0]
    for wrong, said in (
        ({"observer": {"type": "passthrogh"}}, "'passthrogh' is not one of ['adaptive_iterative_learning'"),
        ({"observer": "passthrogh"}, "'passthrogh' is not one of ['adaptive_iterative_learning'"),
        ({"observer": {"type": "finite_time_disturbance", "lamda1": 1.0}}, "('lamda1' was unexpected)"),
        ({"observer": {"lambda1": 1.0}}, "'type' is a required property"),
        ({"observer": {"type": "finite_time_disturbance", "lambda1": -1.0}}, "-1.0 is less than the minimum"),
        ({"faults": [{"type": "dead"}]}, "'actuator' is a required property"),
        ({"faults": [{**fault, "remaining": wave}]}, "('ampltude' was unexpected)"),
        ({"initial": {"mrp": [0.0, 0.0]}}, "[0.0, 0.0] is too short"),
    ):
        error = jsonschema.exceptions.best_match(validator.iter_errors(tables | wrong))
        assert error is not None, wrong
        assert said in error.message
    for right in (
        {"observer": "passthrough"},
        {"faults": [{**fault, "remaining": {"type": "sine", "amplitude": 1.0}}]},
    ):
        validator.validate(tables | right)


def test_check_and_run_say_what_looks_like_a_mistake() -> None:
    late = "faults[0] 'loss_of_effectiveness' never begins: t_on = 20 s, and the run ends at 3 s"
    assert late in gyrostat("run", "wheel2_degraded", *SHORT).stdout
    assert late in gyrostat("check", "wheel2_degraded", *SHORT).stdout
    assert printed("run", "wheel2_degraded", *SHORT, "--json")["remarks"] == [late]


def test_the_schema_names_every_parameter() -> None:
    definitions = scenario_schema()["$defs"]
    for family in definitions:
        members = definitions[family].get("else", definitions[family])["allOf"]
        for name, member in zip(_core.catalogue()[family], members, strict=True):
            known = {p["name"] for p in _core.describe(family, name)["params"]}
            assert set(member["then"]["properties"]) == known | {"type"}
