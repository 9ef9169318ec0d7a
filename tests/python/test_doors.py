# SPDX-License-Identifier: MIT
"""Whatever comes through a door is taken or refused in one line, and what is written is whole or not there.

Doors: a TOML file, a change of a scenario (`--set`), a constructor, the arguments of a run, a saved result, a place to
save to, the standard output, Ctrl-C.
"""

from __future__ import annotations

import datetime as dt
import fcntl
import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import gyrostat as gs
from gyrostat import files, toml
from gyrostat.saved import Facts
from gyrostat.scenario import shipped
from gyrostat.text import LONGEST

Array = np.ndarray


class Law:
    def step(self, *_: object) -> list[float]:
        return [0.0, 0.0, 0.0]


def refused(act: Callable[[], Any]) -> str | None:
    """The message of an `InputError`, held to be one line that can be printed; None when the input was taken."""
    try:
        act()
    except gs.InputError as error:
        message = str(error)
        assert message.isprintable()
        assert 0 < len(message) <= LONGEST + len(" ... ")
        return message
    return None


# Values ------------------------------------------------------------------------------------------------------------

_any_character = st.characters(exclude_categories=())  # lone surrogates included
_text = st.text(_any_character, max_size=12)
_odd: dict[str, Callable[[], Any]] = {  # made anew for each use, and named: some of them have no repr
    "object": object,
    "class": lambda: Law,
    "component": Law,
    "function": lambda: refused,
    "module": lambda: json,
    "iterator": lambda: iter([1.0]),
    "set": lambda: {1, 2},
    "bytes": lambda: b"x",
    "complex": lambda: 1j,
    "date": lambda: dt.date(2020, 1, 1),
    "complex array": lambda: np.array([1 + 2j]),
    "array of objects": lambda: np.array([object()], dtype=object),
    "array of texts": lambda: np.array(["a"]),
    "cube": lambda: np.zeros((2, 3, 4)),
    "huge": lambda: 10**6000,
    "large": lambda: -(10**400),
    "long text": lambda: "x" * 100_000,
    "another scenario": lambda: gs.Scenario.load("ftc_4rw"),
    "a waveform": gs.waveforms.Sine,
}
_leaf = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), _text, st.sampled_from(sorted(_odd)).map(lambda k: _odd[k]())
)
_name = st.sampled_from(["passthrough", "mrp_feedback", "sine", "sum", "dead", "gyro", "python", "rk4", "slew"])
_key = st.one_of(st.sampled_from(["type", "actuator", "remaining", "t_on", "terms", "channels", "every", "K"]), _text)
_value = st.recursive(
    _leaf,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.one_of(_key, st.integers()), inner, max_size=3),
        st.builds(lambda name, table: {**table, "type": name}, _name, st.dictionaries(_key, inner, max_size=2)),
    ),
    max_leaves=6,
)
_places = st.one_of(
    st.sampled_from([*gs.Scenario.model_fields, "self", "cls", ".", "vehicle..x", "faults.²", ".".join("a" * 3000)]),
    st.sampled_from(["vehicle.J_B", "vehicle.D_B", "initial.euler", "faults.0", "faults.0.remaining", "faults.-1"]),
    st.sampled_from(["record.every", "record.channels", "truth.dJ_B", "sensors.0.delay", "observer.type", "shadows.0"]),
    _text,
)
_SETTINGS = settings(max_examples=100, suppress_health_check=[HealthCheck.too_slow])


@pytest.fixture(scope="module")
def small(scenario: gs.Scenario) -> gs.Scenario:
    return scenario.replace(duration=0.1)


@_SETTINGS
@given(changes=st.dictionaries(_places, _value, min_size=1, max_size=2))
def test_a_scenario_takes_a_change_or_refuses_it(small: gs.Scenario, changes: dict[str, Any]) -> None:
    refused(lambda: small.replace(**changes))
    refused(lambda: gs.Scenario(**changes))


@_SETTINGS
@given(
    make=st.sampled_from([gs.observer, gs.controller, gs.allocator, gs.reference, gs.integrator]),
    name=st.one_of(_name, _value),
    params=st.dictionaries(_key.filter(lambda key: key != "name"), _value, max_size=2),
    block=st.sampled_from([gs.Vehicle, gs.Initial, gs.Truth, gs.Record, gs.Shadow, gs.faults.Bias, gs.waveforms.Sum]),
)
def test_a_constructor_takes_its_arguments_or_refuses_them(
    make: Callable[..., Any], name: Any, params: dict[str, Any], block: Callable[..., Any]
) -> None:
    refused(lambda: make(name, **params))
    refused(lambda: block(**params))
    refused(lambda: gs.Scenario.from_dict(name))


@_SETTINGS
@given(
    channels=st.one_of(
        _value, st.lists(st.one_of(st.sampled_from(["truth.*", "error.angle", "*"]), _text), max_size=3)
    ),
    every=st.one_of(st.none(), _value),
)
def test_a_run_takes_its_arguments_or_refuses_them(small: gs.Scenario, channels: Any, every: Any) -> None:
    refused(lambda: small.run(channels=channels, every=every))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"channels": "error.angle"}, "channels: 'error.angle' is no list of names; write ['error.angle']"),
        ({"channels": 3}, "channels: 3 is no list of names; write ['truth.*']"),
        ({"every": -1}, "every: -1 is no whole number from 1 to 1000000000"),
        ({"every": 1.5}, "every: 1.5 is no whole number from 1 to 1000000000"),
        ({"every": 2**70}, "every: 1180591620717411303424 is no whole number from 1 to 1000000000"),
        ({"progress": 3}, "progress: 3 cannot be called"),
    ],
)
def test_a_wrong_argument_of_a_run_is_named(small: gs.Scenario, arguments: dict[str, Any], said: str) -> None:
    assert refused(lambda: small.run(**arguments)) == said


def test_the_arguments_of_a_run_win_over_its_record_block(small: gs.Scenario) -> None:
    sparse = small.replace(record={"channels": ["error.angle"], "every": 5})
    assert len(sparse.run()) == 3
    assert len(sparse.run(every=1)) == 11


def test_a_python_component_that_returns_nothing_is_told_so(small: gs.Scenario) -> None:
    class Silent:
        def step(self, *_: object) -> None: ...

    with pytest.raises(
        ValueError, match=r"^controller Silent\.step returned nothing \(None\); 3 numbers belong there$"
    ):
        small.replace(controller=Silent()).run()


def test_a_record_that_the_memory_cannot_hold_is_refused_with_its_size(small: gs.Scenario) -> None:
    long = small.replace(duration=1e9, dt=1e-6)
    message = refused(lambda: long.run(channels=["truth.mrp"]))
    # three components and the time, 8 bytes each
    assert message is not None
    assert message.startswith("record: 1e+15 samples of 4 numbers take 3.2e+07 GB, and ")
    assert "GB are free; record fewer channels, or every " in message
    assert "--every" in message


def test_a_fault_after_the_end_is_remarked(small: gs.Scenario) -> None:
    late = "faults[0] 'loss_of_effectiveness' never begins: t_on = 5 s, and the run ends at 0.1 s"
    assert small.remarks() == [late]
    assert small.replace(duration=5.0).remarks() != [], "the last interval ends there"
    assert small.replace(duration=5.01).remarks() == []


# TOML --------------------------------------------------------------------------------------------------------------

_shipped = sorted(path.read_text(encoding="utf-8") for path in shipped().values())
_fragment = st.one_of(
    st.sampled_from(
        ['"""', "'''", '"', "'", "[", "[[", "]", "{", "}", "=", ".", ",", "\n", "\r\n", "\\", "#", "\ufeff"]
    ),
    st.sampled_from(
        ["inf", "nan", "-1", "true", "1979-05-27", "0x" + "f" * 400, "9" * 400, "[vehicle]", "type = 'sum'"]
    ),
    st.text(max_size=5),
)


@st.composite
def _damaged(draw: st.DrawFn) -> str:
    """A shipped file with some pieces cut out, moved and put in."""
    text = draw(st.sampled_from(_shipped))
    for _ in range(draw(st.integers(1, 3))):
        at, length = draw(st.integers(0, len(text))), draw(st.integers(0, 40))
        text = text[:at] + draw(_fragment) + text[at + length :]
    return text


@_SETTINGS
@given(text=st.one_of(_damaged(), st.text(max_size=60)))
def test_a_file_is_read_or_refused_by_its_name(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.toml"
    path.write_text(text, encoding="utf-8")
    message = refused(lambda: gs.Scenario.from_toml(path))
    assert message is None or message.startswith(f"{path}: ")
    refused(lambda: toml.value(text))


DEEP = {
    "brackets": "a = " + "[" * 2000 + "]" * 2000,
    "tables in each other": "a = " + "{a = " * 2000,
    "a key of many parts": ".".join("a" * 50_000) + " = 1",
    "a header of many parts": "[" + " . ".join(["'a'"] * 50_000) + "]",
    "a number of many digits": "duration = " + "1" * 5000,
    "a negative number of many digits": "duration = -" + "1_" * 5000 + "1",
    "a text that does not end": 'name = """' + '""\\"' * 300_000,
    "a line of escaped quotes": 'name = "' + '\\"' * 300_000,
    "apostrophes": "'" * 500_000,
    "a word": "a" * 1_000_000,
    "many keys of a component": "[observer]\ntype = 'passthrough'\n" + "".join(f"k{i} = 1\n" for i in range(30_000)),
    "too much": "#" * (toml.MAX_BYTES + 1),
}


@pytest.mark.parametrize("what", DEEP)
def test_what_is_deep_or_long_is_refused_before_it_takes_time(what: str, tmp_path: Path) -> None:
    path = tmp_path / "deep.toml"
    path.write_text(DEEP[what])
    message = refused(lambda: gs.Scenario.from_toml(path))
    assert message is not None
    assert message.startswith(f"{path}: ")
    refused(lambda: toml.value(DEEP[what].partition(" = ")[2]))


def test_limits_are_said_with_the_line(tmp_path: Path) -> None:
    path = tmp_path / "deep.toml"
    limit = toml.MAX_DEPTH
    for text, said in (
        ('name = "[[["\n# [[[\na = ' + "[" * (limit + 1), f"line 3: more than {limit} brackets inside each other"),
        ("\n" + ".".join("a" * (limit + 1)) + " = 1", f"line 2: a key of more than {limit} parts"),
        ("a = " + "1" * 5000, "a number of thousands of digits"),
    ):
        path.write_text(text)
        assert refused(lambda: gs.Scenario.from_toml(path)) == f"{path}: {said}"
    assert toml.value("[" * limit + "]" * limit) != ""
    assert toml.value("1.5") == 1.5


def test_a_byte_order_mark_is_no_part_of_a_file(tmp_path: Path) -> None:
    text = gs.Scenario.load("ftc_4rw").to_toml()
    (tmp_path / "marked.toml").write_text(text, encoding="utf-8-sig")
    assert gs.Scenario.from_toml(tmp_path / "marked.toml") == gs.Scenario.load("ftc_4rw")


def test_a_file_without_end_is_not_read_to_its_end() -> None:
    assert refused(lambda: gs.Scenario.load("/dev/zero")) == "/dev/zero: is larger than 4 MiB, the most that is read"


@given(name=st.one_of(_text, st.sampled_from(["a" * 300, "a" * 300 + ".toml", "a\0.toml", "/dev/null/x.toml", ""])))
def test_a_name_that_no_file_has_is_refused(name: str) -> None:
    if name not in shipped():
        assert refused(lambda: gs.Scenario.load(name)) is not None
    assert refused(lambda: gs.Result.load(name)) is not None


# Saved results -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def saved(
    small: gs.Scenario, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, dict[str, Array], dict[str, Any]]:
    """A saved result with an event, its arrays and its facts."""
    flown = small.replace(
        duration=0.2, reference={"type": "steps", "times": [0.0, 0.1], "mrp": [[0.0] * 3, [0.0, 0.0, 0.1]]}
    )
    path = flown.run().save(tmp_path_factory.mktemp("saved") / "run.npz")
    with np.load(path) as data:
        arrays = {name: data[name] for name in data.files}
    return path, arrays, json.loads(str(arrays.pop("facts")))


def used(result: gs.Result) -> None:
    result.metrics.to_dict()
    result.to_xarray()


@_SETTINGS
@given(data=st.data())
def test_a_damaged_archive_is_refused_or_holds_what_was_saved(
    saved: tuple[Path, dict[str, Array], dict[str, Any]], data: st.DataObject
) -> None:
    path, arrays, _ = saved
    content = path.read_bytes()
    at = data.draw(st.integers(0, len(content) - 1))
    change = data.draw(st.one_of(st.binary(max_size=8), st.just(b""), st.integers(1, 255)))
    if isinstance(change, int):
        damaged = content[:at] + bytes([content[at] ^ change]) + content[at + 1 :]
    else:
        damaged = content[:at] + change + content[at + data.draw(st.integers(0, 600)) :]
    target = path.with_name("damaged.npz")
    target.write_bytes(damaged)
    loaded: list[gs.Result] = []
    message = refused(lambda: loaded.append(gs.Result.load(target)))
    assert (message is None) == bool(loaded)
    for result in loaded:
        assert {"t", *result.channels} == set(arrays)
        for name, x in {"t": result.t, **result.channels}.items():
            np.testing.assert_array_equal(x, arrays[name])


@st.composite
def _changed(draw: st.DrawFn, value: Any) -> Any:
    """The value with something in it replaced, dropped or added."""
    if isinstance(value, dict) and value and draw(st.booleans()):
        key = draw(st.sampled_from(sorted(value)))
        rest = {k: v for k, v in value.items() if k != key}
        return draw(st.sampled_from([rest, {**value, "more": 1}, {**rest, key: draw(_changed(value[key]))}]))
    if isinstance(value, list) and value and draw(st.booleans()):
        at = draw(st.integers(0, len(value) - 1))
        return draw(st.sampled_from([value[:at], [*value[:at], draw(_changed(value[at])), *value[at + 1 :]]]))
    return draw(st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3), st.just([[]])))


@_SETTINGS
@given(data=st.data())
def test_changed_facts_are_refused_or_make_a_whole_result(
    saved: tuple[Path, dict[str, Array], dict[str, Any]], data: st.DataObject
) -> None:
    path, arrays, facts = saved
    target = path.with_name("changed.npz")
    np.savez(target, facts=np.array(json.dumps(data.draw(_changed(facts)))), **arrays)  # type: ignore[arg-type]
    refused(lambda: used(gs.Result.load(target)))


@_SETTINGS
@given(data=st.data())
def test_changed_arrays_are_refused(saved: tuple[Path, dict[str, Array], dict[str, Any]], data: st.DataObject) -> None:
    path, arrays, facts = saved
    name = data.draw(st.sampled_from(["t", "truth.omega_BN_B", "error.angle", "allocation.u"]))
    x = arrays[name]
    changes: dict[str, Array | None] = {
        "shorter": x[:-1],
        "longer": np.concatenate([x, x[-1:]]),
        "deeper": x[..., None],
        "flat": x.ravel()[: x.size - 1],
        "single": x.astype(np.float32),
        "text": np.array("x"),
        "none": x[:0],
    }
    if name == "t":
        changes |= {"backwards": x[::-1], "twice": np.repeat(x[:1], len(x)), "not a number": x * np.nan, "absent": None}
    else:
        changes |= {"wider": np.hstack([x.reshape(len(x), -1)] * 2)}
    changed = changes[data.draw(st.sampled_from(sorted(changes)))]
    rest = {k: v for k, v in arrays.items() if k != name} | ({} if changed is None else {name: changed})
    target = path.with_name("arrays.npz")
    np.savez(target, facts=np.array(json.dumps(facts)), **rest)  # type: ignore[arg-type]
    message = refused(lambda: gs.Result.load(target))
    assert message is not None
    assert message.startswith(f"{target}: is not a saved result")


@pytest.mark.parametrize("fact", Facts.model_fields)
def test_no_fact_may_be_missing(saved: tuple[Path, dict[str, Array], dict[str, Any]], fact: str) -> None:
    path, arrays, facts = saved
    target = path.with_name("missing.npz")
    rest = {k: v for k, v in facts.items() if k != fact}
    np.savez(target, facts=np.array(json.dumps(rest)), **arrays)  # type: ignore[arg-type]
    assert refused(lambda: gs.Result.load(target)) == f"{target}: is not a saved result: {fact} is missing"


@pytest.mark.parametrize(
    ("fact", "value", "said"),
    [
        ("status", "done", "status: 'done' is no ending of a run; there are: completed, singular"),
        ("end_time", 0.1, "the run ended at 0.1 s"),
        ("end_time", float("nan"), "end_time = nan"),
        ("events", [{"t": 0.1, "name": "x"}], "events[0]: count is missing"),
        ("scenario", {}, "scenario: duration is missing"),
    ],
)
def test_a_wrong_fact_is_named(
    saved: tuple[Path, dict[str, Array], dict[str, Any]], fact: str, value: Any, said: str
) -> None:
    path, arrays, facts = saved
    target = path.with_name("wrong.npz")
    np.savez(target, facts=np.array(json.dumps({**facts, fact: value})), **arrays)  # type: ignore[arg-type]
    message = refused(lambda: gs.Result.load(target))
    assert message is not None
    assert said in message


def test_a_run_that_ended_early_and_was_recorded_now_and_then_reads_back(tmp_path: Path) -> None:
    early = gs.Scenario.load("ftc_4rw").replace(
        initial={"omega_BN_B": [1000.0] * 3}, integrator={"type": "rk4"}, dt=1.0
    )
    result = early.run(every=7)
    assert result.status in {"non_finite", "integration_failed"}
    again = gs.Result.load(result.save(tmp_path / "early"))
    assert (again.status, again.cause, again.end_time) == (result.status, result.cause, result.end_time)


def test_a_result_of_a_python_component_reads_back(small: gs.Scenario, tmp_path: Path) -> None:
    path = small.replace(controller=Law()).run().save(tmp_path / "python.npz")
    assert gs.Result.load(path).description["controller"] == {"type": "python", "class": "Law"}


# Places to save to -------------------------------------------------------------------------------------------------


def test_a_result_is_saved_under_the_name_that_was_given_or_not_at_all(result: gs.Result, tmp_path: Path) -> None:
    for name in ("a.csv", "run.v2"):
        assert refused(lambda name=name: result.save(tmp_path / name)) == (
            f"{tmp_path / name}: a result is saved as .npz; write that ending, or none"
        )
    assert list(tmp_path.iterdir()) == []
    assert result.save(tmp_path / "a") == tmp_path / "a.npz"
    (tmp_path / "link.npz").symlink_to(tmp_path / "far.npz")
    result.save(tmp_path / "link.npz")
    assert (tmp_path / "link.npz").is_symlink()
    assert len(gs.Result.load(tmp_path / "far.npz")) == len(result)


def test_a_place_that_cannot_be_written_is_named_as_it_was_given(result: gs.Result, tmp_path: Path) -> None:
    (tmp_path / "folder.npz").mkdir()
    figure = gs.plots.Figure("nothing")
    for save, name, said in (
        (result.save, "nowhere/run.npz", "no such file or directory"),
        (figure.save, "nowhere/run.png", "no such file or directory"),
        (result.scenario.to_toml, "nowhere/run.toml", "no such file or directory"),
        (result.save, "folder.npz", "is a folder"),
        (result.save, "a" * 300 + ".npz", "file name too long"),
        (result.save, "a\0b.npz", "embedded null"),
        (figure.save, "a" * 300 + ".png", "file name too long"),
    ):
        message = refused(lambda save=save, name=name: save(tmp_path / name))
        assert message is not None
        assert message.startswith(f"{tmp_path / name}: cannot be written: ".replace("\0", "{U+0000}")), message
        assert said in message
    assert [p.name for p in tmp_path.iterdir()] == ["folder.npz"]
    for name in ("run", "run.xyz", "run.npz"):
        message = refused(lambda name=name: figure.save(tmp_path / name))
        assert message is not None
        assert message.startswith(f"{tmp_path / name}: a figure is saved as one of: ")
    assert [p.name for p in tmp_path.iterdir()] == ["folder.npz"]


def test_what_is_no_file_is_not_replaced_by_one(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.json"  # /dev/null would be another; not to be tried here
    os.mkfifo(pipe)
    assert refused(lambda: files.write_text(pipe, "x")) == f"{pipe}: cannot be written: is no regular file"
    assert pipe.is_fifo()


def test_a_figure_does_not_take_the_place_of_a_result(result: gs.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.npz")
    message = refused(lambda: gs.plots.Figure("of it").save(tmp_path / "run.png"))
    assert message == f"{tmp_path / 'run.png'}: run.npz is there and is no figure's data; choose another name"
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]
    assert len(gs.Result.load(tmp_path / "run.npz")) == len(result)
    figure = gs.plots.Figure("twice")
    assert figure.save(tmp_path / "figure.svg") == figure.save(tmp_path / "figure.svg")


@pytest.mark.parametrize("name", ["$x_{$ \U0001f680\x07\n\u202e", "%s {} \\frac $$" + "x" * 5000])
def test_any_name_can_stand_above_a_figure(small: gs.Scenario, name: str, tmp_path: Path) -> None:
    small.replace(name=name).run(channels=["error.angle"]).plot().save(tmp_path / "named.png")


def test_what_a_killed_process_left_is_removed_by_the_next_one(result: gs.Result, tmp_path: Path) -> None:
    killed = f"""
import os, signal
from pathlib import Path
from gyrostat.files import replacing, replacing_folder
with replacing(Path({str(tmp_path / "a.npz")!r})) as one, replacing_folder(Path({str(tmp_path / "b")!r})) as other:
    one.write_text("half")
    (other / "file").write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
    assert subprocess.run([sys.executable, "-c", killed], check=False).returncode == -signal.SIGKILL
    (tmp_path / ".gyrostat").write_text("not ours")
    left = {p.name for p in tmp_path.iterdir()}
    assert len(left) == 3
    assert all(name.startswith(".gyrostat") for name in left)
    with files.replacing(tmp_path / "held") as held:  # somebody who is still at it is not disturbed
        assert {p.name for p in tmp_path.iterdir()} == {".gyrostat", held.name}
        result.save(tmp_path / "run.npz")
        assert held.exists()
    assert {p.name for p in tmp_path.iterdir()} == {".gyrostat", "held", "run.npz"}


def test_without_locks_files_are_written_and_nothing_is_removed(
    result: gs.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unsupported(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", unsupported)
    (tmp_path / ".gyrostat-left.npz").write_text("half")
    result.save(tmp_path / "run.npz")
    assert {p.name for p in tmp_path.iterdir()} == {".gyrostat-left.npz", "run.npz"}


# Processes ---------------------------------------------------------------------------------------------------------

COMMAND = [sys.executable, "-m", "gyrostat"]
SHORT = ["ftc_4rw", "--set", "duration=1"]


def said(*arguments: str, **options: Any) -> tuple[int, str]:
    """Exit status and standard error of the command."""
    done = subprocess.run([*COMMAND, *arguments], stderr=subprocess.PIPE, timeout=120, check=False, **options)
    return done.returncode, done.stderr.decode()


def small_files() -> None:
    """A disk that is full after four kilobytes, to the child."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))


def test_a_full_disk_is_one_line_and_leaves_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "run.npz").write_text("before")
    for out in ("run.npz", "new/folder"):
        status, message = said("run", *SHORT, "--out", str(tmp_path / out), preexec_fn=small_files)
        assert status == 2
        assert message.startswith(f"error: {tmp_path / out}")
        assert message.endswith(": cannot be written: file too large\n")
        assert message.count("\n") == 1
    assert (tmp_path / "run.npz").read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]


def test_a_full_output_is_one_line() -> None:
    with Path("/dev/full").open("wb") as full:
        assert said("list", stdout=full) == (2, "error: output: no space left on device\n")
    reader, writer = os.pipe()
    os.close(reader)
    assert said("list", stdout=writer) == (1, "")
    os.close(writer)


def test_letters_that_the_locale_does_not_know_are_read_and_written(tmp_path: Path) -> None:
    ascii_only = {**os.environ, "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    arguments = [*SHORT, "--set", "name=Prüfstand \U0001f680", "--out", str(tmp_path / "Prüfung")]
    assert said("run", *arguments, env=ascii_only, stdout=subprocess.DEVNULL) == (0, "")
    assert gs.Scenario.from_toml(tmp_path / "Prüfung" / "scenario.toml").name == "Prüfstand \U0001f680"
    status, message = said("run", "Prüfung.toml", env=ascii_only)
    assert (status, message.count("\n")) == (2, 1)


def test_an_interruption_does_not_wait_for_compiled_code(tmp_path: Path) -> None:
    # a computation of minutes that never looks for a signal, in place of one long sample
    busy = """
import hashlib
from gyrostat import cli, Scenario
Scenario.run = lambda *_, **__: print("busy", flush=True) or hashlib.pbkdf2_hmac("sha256", b"", b"", 10**9)
cli.main()
"""
    command = [sys.executable, "-c", busy, "run", "ftc_4rw", "--out", str(tmp_path / "out")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "busy\n"
    process.send_signal(signal.SIGINT)
    try:
        assert process.communicate(timeout=60) == ("", "error: interrupted\n")
        assert process.returncode == 130
        assert list(tmp_path.iterdir()) == []
    finally:
        process.kill()


def interrupted(arguments: list[str], folder: Path) -> tuple[int, str]:
    """Exit status and message after Ctrl-C while the command flies: it makes its folder before."""
    process = subprocess.Popen([*COMMAND, *arguments, "--out", str(folder)], stderr=subprocess.PIPE, text=True)
    while not folder.exists() and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    try:
        return process.wait(timeout=60), process.communicate()[1]
    finally:
        process.kill()


def test_an_interrupted_run_ends_in_one_line_and_leaves_nothing(tmp_path: Path) -> None:
    # ten hours of flight a case: they end within the timeout only if they are stopped
    hours = ["--set", "duration=36000", "--set", "record={channels=['error.angle']}"]
    assert interrupted(["run", "ftc_4rw", *hours], tmp_path / "out") == (130, "error: interrupted\n")
    study = tmp_path / "study"
    (study / "scenarios").mkdir(parents=True)
    hour = gs.Scenario.load("ftc_4rw").replace(duration=36000.0, record={"channels": ["error.angle"]})
    hour.to_toml(study / "scenarios" / "one.toml")
    changes = "".join(f'[cases.c{i}]\nlike = "one"\nset = {{ seed = {i} }}\n' for i in range(40))
    (study / "claims.toml").write_text(f'title = "t"\ncitation = "c"\nclaims = []\n[cases.one]\n{changes}')
    assert interrupted(["reproduce", str(study)], tmp_path / "out") == (130, "error: interrupted\n")
    assert [p.name for p in tmp_path.iterdir()] == ["study"]
