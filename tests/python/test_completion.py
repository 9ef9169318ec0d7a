# SPDX-License-Identifier: MIT
"""What shells complete, with the shells themselves where they are installed; the schema that editors find."""

from __future__ import annotations

import json
import os
import pty
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import completion, papers
from gyrostat.cli import app
from gyrostat.errors import InputError
from gyrostat.scenario import shipped


def completed(line: str, shell: str = "zsh") -> list[str]:
    return completion.answer(typer.main.get_command(app), shell, line)


def test_commands_options_and_names_are_completed() -> None:
    assert {"run", "check", "campaign", "completion"} <= set(completed("gyrostat "))
    assert completed("gyrostat ru") == ["run"]
    assert completed("gyrostat campaign f") == ["fly"]
    assert completed("gyrostat run x --se") == ["--set"]
    assert completed("gyrostat run ") == sorted(shipped())
    assert completed("cd there && NO_COLOR=1 gyrostat run whe") == ["wheel2_degraded"]
    assert completed("gyrostat run 'whe") == ["wheel2_degraded"]
    assert completed("gyrostat compare ftc_4rw whe") == ["wheel2_degraded"]
    assert completed("gyrostat reproduce ") == sorted([*papers.available(), "all"])
    assert completed("gyrostat describe observer fin") == ["finite_time_disturbance"]
    assert completed("gyrostat describe finite_time_d") == ["finite_time_disturbance"]
    assert completed("gyrostat new my.toml --like li2018/") == ["li2018/table1", "li2018/table2"]
    assert completed("gyrostat new my.toml --vehicle ft") == ["ftc_4rw"]
    assert completed("gyrostat campaign fly five_stacks_") == ["five_stacks_cubesat"]
    assert completed("gyrostat design mixed_learning --set settling") == ["settling_time="]
    assert completed("gyrostat reproduce li2018 --claim t1.s@table1_c") == ["t1.s@table1_cvode"]
    assert completed("gyrostat export ftc_4rw --target f") == ["fmu"]
    assert completed("gyrostat run x --every ") == []  # a number


def test_keys_and_values_of_set_are_those_of_the_scenario() -> None:
    start = "gyrostat run wheel2_degraded --set "
    keys = completed(start)
    assert {"observer=", "observer.lambda1=", "faults.0.remaining=", "vehicle.u_max=", "duration="} <= set(keys)
    scenario = gs.Scenario.load("wheel2_degraded")
    for key in keys:
        assert key.endswith("=")
        name = key[:-1]
        if name.count(".") == 1 and name.split(".")[0] in ("observer", "controller"):
            scenario.replace(**{name: scenario.resolve()[name.split(".")[0]][name.split(".")[1]]})
    assert completed(f"{start}observer.method=") == ["observer.method=explicit_euler", "observer.method=implicit"]
    assert completed(f"{start}observer=fi") == ["observer=finite_time_disturbance"]
    assert completed(f"{start}observer=fi", "bash") == ["finite_time_disturbance"]  # which has cut the word at "="
    assert completed(f"{start}allocator.use_effectiveness=") == [
        "allocator.use_effectiveness=false",
        "allocator.use_effectiveness=true",
    ]
    varied = completed("gyrostat compare wheel2_degraded --vary controller=mrp_feedback,predefined")
    assert varied == ["controller=mrp_feedback,predefined_time"]


def test_what_cannot_be_read_completes_nothing() -> None:
    for line in ("gyrostat run nothing.toml --set obs", "", "gyrostat nothing ", "'\"'"):
        done = CliRunner().invoke(app, ["completion", "zsh", "--line", line])
        assert (done.exit_code, done.exception) == (0, None)
    with pytest.raises(InputError, match="no completion for 'csh'; there is one for: bash, zsh, fish"):
        completion.script("csh")


_asked = {
    "bash": (
        ["bash", "--norc", "-c"],
        """
        eval "$(gyrostat completion bash)"
        COMP_LINE="gyrostat run wheel2_degraded --set observer=fi"; COMP_POINT=${#COMP_LINE}
        COMP_WORDS=(gyrostat run wheel2_degraded --set observer = fi); COMP_CWORD=6
        _gyrostat
        echo "${COMPREPLY[@]}"
        """,
        "finite_time_disturbance\n",
    ),
    "zsh": (
        ["zsh", "-f", "-c"],
        """
        compdef() { :; }; compadd() { print -r -- "$*"; }
        eval "$(gyrostat completion zsh)"
        LBUFFER="gyrostat run whe"; _gyrostat
        """,
        "-S  --\n-- wheel2_degraded\n",
    ),
    "fish": (
        ["fish", "--no-config", "-c"],
        """
        gyrostat completion fish | source
        complete -C "gyrostat run whe"
        """,
        "wheel2_degraded\n",
    ),
}


@pytest.mark.parametrize("shell", [s for s in completion.SCRIPTS if shutil.which(s)])
def test_the_shell_itself_completes(shell: str, tmp_path: Path) -> None:
    command = tmp_path / "gyrostat"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m gyrostat "$@"\n')
    command.chmod(0o755)
    call, asked, expected = _asked[shell]
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "HOME": str(tmp_path)}
    done = subprocess.run([*call, asked], capture_output=True, text=True, env=environment, timeout=60, check=False)
    assert done.stdout == expected, done.stderr


def test_the_schema_is_where_an_editor_looks(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    gs.Scenario.load("ftc_4rw").to_toml(file)
    before = file.read_text()
    for _ in range(2):  # again: nothing more is added
        done = CliRunner().invoke(app, ["schema", "--install", str(file)])
        assert done.exit_code == 0, done.output
        assert file.read_text() == f"#:schema ./gyrostat.schema.json\n{before}"
    assert json.loads((tmp_path / "gyrostat.schema.json").read_text())["title"] == "gyrostat scenario"
    assert gs.Scenario.load(str(file)) == gs.Scenario.load("ftc_4rw")


def test_a_schema_goes_beside_a_scenario_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "broken.toml").write_text("a = ")
    for name in ("notes.txt", "broken.toml", "absent.toml"):
        done = CliRunner().invoke(app, ["schema", "--install", str(tmp_path / name)])
        assert isinstance(done.exception, InputError)
        assert name in str(done.exception)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["broken.toml", "notes.txt"]


_slow = """
from gyrostat import printing
with printing.progress("waiting", patience=0.0) as told:
    told(0.1)
    told(0.9)
"""


def test_progress_is_for_terminals_that_can_move_their_cursor() -> None:
    done = subprocess.run([sys.executable, "-c", _slow], capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"", b"")
    for term, shown in (("xterm-256color", True), ("dumb", False)):
        master, slave = pty.openpty()
        environment = {**os.environ, "TERM": term}
        with subprocess.Popen([sys.executable, "-c", _slow], stderr=slave, env=environment) as running:
            os.close(slave)
            running.wait(60)
        seen = b""
        try:
            while chunk := os.read(master, 65536):
                seen += chunk
        except OSError:  # how Linux says that the other end is closed
            pass
        os.close(master)
        assert bool(seen) == shown, seen
