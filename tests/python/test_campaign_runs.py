# SPDX-License-Identifier: MIT
"""Flown campaigns: the same bits whoever flies them, in what order, and however often they are killed."""

from __future__ import annotations

import importlib.util
import json
import math
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from commands import gyrostat
from scipy import special, stats

import gyrostat as gs
from gyrostat.campaign import Chunk, Sketch, State, compare, dist, join
from gyrostat.campaign.printing import state_line
from gyrostat.verification.sequential import rate_interval

SET = {"duration": 6.0, "dt": 0.1, "integrator": "rk4", "faults": [], "sensors": [{"type": "gyro", "noise": 1e-6}]}
FAULTS = [
    {
        "name": "wheel",
        "count": {"dist": "poisson", "mean": 0.8, "most": 2},
        "actuator": {"dist": "choice", "of": [0, 1, 2, 3]},
        "t_on": {"dist": "uniform", "low": 1.0, "high": 4.0},
        "kind": [
            {"weight": 0.5, "type": "loss_of_effectiveness", "remaining": {"dist": "beta", "a": 2.0, "b": 3.0}},
            {"weight": 0.2, "type": "lock"},
            {"weight": 0.1, "type": "intermittent", "period": {"dist": "uniform", "low": 0.5, "high": 2.0}},
            {"weight": 0.2, "type": "stuck", "torque": {"dist": "uniform", "low": -0.1, "high": 0.1}},
        ],
    },
    {
        "name": "bus",
        "probability": 0.1,
        "actuators": [0, 1],
        "t_on": {"dist": "uniform", "low": 1.0, "high": 4.0},
        "delay": {"dist": "exponential", "mean": 0.5},
        "kind": [{"type": "dead"}],
    },
]
TABLES: dict[str, Any] = {
    "name": "short flights",
    "base": "wheel2_degraded",
    "set": SET,
    "seed": 7,
    "vary": {
        "initial.omega_BN_B": {"dist": "normal", "mean": 0.0, "std": 0.02, "each": 3},
        "initial.q_NB": {"dist": "attitude", "angle": {"dist": "uniform", "low": 0.1, "high": 1.2}},
        "truth.dJ_B": {"dist": "inertia", "spread": 0.05},
    },
    "fault": FAULTS,
    "measure": {
        "settling": {"metric": "settling_time", "signal": "error.angle", "band": 0.5, "after": "last_fault"},
        "final": {"metric": "window_max", "signal": "error.angle", "last": 1.0},
        "energy": {"metric": "energy", "signal": "allocation.u"},
    },
    "success": {"final": {"below": 0.5, "scale": "log"}},
}
GRID = [
    {
        "name": "stack",
        "of": {
            "li2018": {"observer": "finite_time_disturbance", "controller": "integral_sliding_mode"},
            "plain": {"observer": "passthrough", "controller": "mrp_feedback"},
        },
    },
    {"name": "allocator", "of": ["pseudo_inverse", "lexicographic"]},
]


def campaign(**changes: Any) -> gs.Campaign:
    return gs.Campaign.from_dict({**TABLES, **changes})


def same(a: Any, b: Any) -> bool:
    return a == b or (isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b))


def files(folder: Path) -> dict[str, bytes]:
    """What decides about a folder: names and contents of its parts and counts."""
    return {
        p.relative_to(folder).as_posix(): p.read_bytes() for d in ("parts", "counts") for p in (folder / d).iterdir()
    }


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> gs.CampaignResult:
    """300 runs in four cells."""
    return campaign(grid=GRID).run(300, out=tmp_path_factory.mktemp("flown") / "grid", jobs=2, chunk=100)


def test_every_row_is_the_plain_scenario_of_its_run_flown_alone(flown: gs.CampaignResult) -> None:
    """By `Experiment` and, every tenth, by `Scenario.run` with its record; draws are those of the row."""
    made = campaign(grid=GRID)
    table = flown.table()
    assert table.num_rows == 1200
    rng = random.Random(1)
    rows = table.to_pylist()
    for i, row in enumerate(rng.sample(rows, 80)):
        if row["status"] == "refused":
            with pytest.raises(gs.InputError) as refusal:
                made.scenario(row["run"], row["cell"])
            assert str(refusal.value) == row["cause"]
            continue
        scenario = made.scenario(row["run"], row["cell"])
        alone = gs.Experiment(scenario, measure=TABLES["measure"]).fly(runs=1, first=row["run"])
        for name in TABLES["measure"]:
            assert same(float(alone[name][0]), row[name]), (row["run"], row["cell"], name)
        for name, drawn in made.draws(row["run"], row["run"] + 1).items():
            assert same(drawn[0].item(), row[name]), name
        if i % 10 == 0:
            result = scenario.run(channels=["error.angle"])
            assert result["error.angle"][result.t > SET["duration"] - 1.0 - 1e-9].max() == row["final"]
    assert {(r["run"], r["cell"]) for r in rows} == {(i, c) for i in range(300) for c in made.cells}
    kinds = Counter(r["fault.wheel.0.kind"] for r in rows)
    assert set(kinds) == {"none", "loss_of_effectiveness", "lock", "intermittent", "stuck"}


def test_all_cells_see_equal_draws_and_the_same_noise(flown: gs.CampaignResult) -> None:
    made = campaign(grid=GRID)
    table = flown.table().to_pandas()
    inputs = list(made.draws(0, 1))
    cells = [table[table.cell == label].reset_index(drop=True) for label in made.cells]
    for other in cells[1:]:
        assert cells[0][inputs].equals(other[inputs])
    a, b = (
        made.scenario(5, label).replace(controller="mrp_feedback", observer=None, allocator=None)
        for label in (next(iter(made.cells)), list(made.cells)[-1])
    )
    assert a == b


def test_counts_are_those_of_the_rows(flown: gs.CampaignResult) -> None:
    table = flown.table().to_pandas()
    for label, counts in flown.counts.items():
        rows = table[table.cell == label]
        assert counts.runs == len(rows) == 300
        assert counts.failures == int((~rows.success).sum())
        assert counts.status == {str(k): int(n) for k, n in rows.status.value_counts().items() if n > 0}
        for name in TABLES["measure"]:
            assert counts.sums[name] == pytest.approx(rows[name].sum(), rel=1e-12)
        x = np.sort(rows["energy"].to_numpy())
        assert counts.sketches["energy"].quantile(0.5) == pytest.approx(x[149], rel=0.0051)


def test_cells_are_compared_run_by_run(flown: gs.CampaignResult) -> None:
    table = flown.table().to_pandas().pivot(index="run", columns="cell", values="success")
    base = "plain/lexicographic"
    for row in compare(flown, base):
        ok, other = table[row.cell].astype(bool), table[base].astype(bool)
        assert (row.runs, row.failures) == (300, int((~ok).sum()))
        assert (row.lost, row.saved) == (int((~ok & other).sum()), int((ok & ~other).sum()))
        discordant = row.lost + row.saved
        exact = (
            min(1.0, 2.0 * stats.binom(max(discordant, 1), 0.5).cdf(min(row.lost, row.saved))) if discordant else 1.0
        )
        assert row.p == pytest.approx(exact)
        assert row.interval[0] < row.failures / row.runs < row.interval[1]
    with pytest.raises(gs.InputError, match="no cell 'plan'"):
        compare(flown, "plan")


@pytest.mark.parametrize(("failures", "runs"), [(0, 20), (3, 20), (20, 20), (1, 10**6), (10**6, 10**9)])
def test_an_interval_ends_where_the_mixture_rejects(failures: int, runs: int) -> None:
    """At its ends the beta mixture is 20 times as likely as the rate; for small n, by numerical integration."""
    low, high = rate_interval(runs, failures)
    assert 0.0 <= low <= failures / runs <= high <= 1.0
    for p in (low, high):
        if 0.0 < p < 1.0:
            ratio = special.betaln(failures + 0.5, runs - failures + 0.5) - math.log(math.pi)
            ratio -= failures * math.log(p) + (runs - failures) * math.log1p(-p)
            assert ratio == pytest.approx(math.log(20.0), abs=1e-4)
    if runs == 20 and 0.0 < high < 1.0:
        density = stats.beta(0.5, 0.5)
        mixed = density.expect(lambda p: p**failures * (1.0 - p) ** (runs - failures))
        assert mixed / (high**failures * (1.0 - high) ** (runs - failures)) == pytest.approx(20.0, rel=1e-3)


def test_success_and_margin_say_what_the_measure_says(flown: gs.CampaignResult) -> None:
    rows = flown.table().to_pandas()
    ended = rows.status != "completed"
    assert np.allclose(rows.margin[~ended], np.log10(rows.final[~ended] / 0.5), atol=1e-13)
    assert np.array_equal(rows.success, ~ended & (rows.final < 0.5))
    assert np.array_equal(rows.margin < 0.0, rows.success)


@pytest.mark.parametrize(("jobs", "chunk"), [(1, 500), (2, 777), (1, 64)])
def test_threads_and_chunks_change_no_bit(flown: gs.CampaignResult, tmp_path: Path, jobs: int, chunk: int) -> None:
    again = campaign(grid=GRID).run(300, out=tmp_path / "again", jobs=jobs, chunk=chunk)
    assert again.table_hash == flown.table_hash
    assert again.identity == flown.identity
    assert {k: c.sketches for k, c in again.counts.items()} == {k: c.sketches for k, c in flown.counts.items()}


def test_a_folder_that_is_taken_up_again_is_the_one_flown_in_one_go(flown: gs.CampaignResult, tmp_path: Path) -> None:
    out = tmp_path / "parts"
    made = campaign(grid=GRID)
    made.run(130, out=out, chunk=100)
    made.run(300, out=out, only=(2, 3))
    assert gs.CampaignResult(out).missing == [(130, 200)]
    before = files(out)
    again = made.run(300, out=out, chunk=7)  # the folder's chunks stay
    assert again.table_hash == flown.table_hash
    assert {name: data for name, data in files(out).items() if name in before} == before
    (out / "parts" / "part-0-100.parquet").unlink()
    assert made.run(300, out=out).table_hash == flown.table_hash
    assert files(out)["parts/part-0-100.parquet"] == files(flown.folder)["parts/part-0-100.parquet"]


def test_folders_flown_apart_are_joined(flown: gs.CampaignResult, tmp_path: Path) -> None:
    made = campaign(grid=GRID)
    for i in range(3):
        made.run(300, out=tmp_path / str(i), chunk=100, only=(i, i + 1))
    with pytest.raises(gs.InputError, match="runs 100 to 199 are in none of the folders"):
        join([tmp_path / "0", tmp_path / "2"])
    joined = join([tmp_path / "2", tmp_path / "0", tmp_path / "1"], tmp_path / "all")
    assert joined is not None
    assert joined.table_hash == flown.table_hash
    assert joined.complete
    campaign(seed=8, grid=GRID).run(10, out=tmp_path / "other")
    with pytest.raises(gs.InputError, match=r"other: holds another campaign than .*seed: 7 there, 8 here"):
        join([tmp_path / "0", tmp_path / "other"])


def test_a_chunk_travels_as_bytes() -> None:
    chunk = campaign().fly(20, 31)
    again = Chunk.from_ipc(chunk.to_ipc())
    assert (again.first, again.end, again.counts) == (20, 31, chunk.counts)
    assert again.table.schema == chunk.table.schema
    assert again.table.to_pandas().equals(chunk.table.to_pandas())


def test_failures_alone_are_kept_and_all_are_counted(tmp_path: Path) -> None:
    every = campaign().run(400, out=tmp_path / "all").table().to_pandas()
    kept = campaign(keep={"rows": "failures", "every": 50}).run(400, out=tmp_path / "some", chunk=90)
    wanted = every[~every.success | (every.run % 50 == 0)]
    rows = kept.table().to_pandas()
    assert rows.run.tolist() == wanted.run.tolist()
    assert np.array_equal(rows.energy, wanted.energy, equal_nan=True)
    assert kept.counts[""].runs == 400
    assert kept.counts[""].failures == int((~every.success).sum())
    assert 0 < kept.counts[""].failures < 400


def test_trajectories_are_kept_by_policy(tmp_path: Path) -> None:
    keep = {"trajectories": {"failures": 2, "worst": {"measure": "final", "count": 2}, "every": 40}}
    kept = campaign(keep=keep).run(100, out=tmp_path / "kept")
    rows = kept.table().to_pandas()
    rows = rows[rows.status != "refused"]
    expected = set(rows.run[~rows.success][:2]) | set(rows.run[rows.run % 40 == 0])
    expected |= set(rows.sort_values("final", ascending=False).run[:2])
    found = {int(p.stem) for p in (kept.folder / "trajectories").iterdir()}
    assert found == expected
    worst = int(rows.loc[rows.final.idxmax()].run)
    result = gs.Result.load(kept.folder / "trajectories" / f"{worst}.npz")
    assert result["error.angle"][result.t > 5.0 - 1e-9].max() == rows.final.max()


def test_draws_that_fit_no_vehicle_are_rows_with_their_cause(tmp_path: Path) -> None:
    """Two faults that decide one output at once contradict; the campaign goes on."""
    fault = {
        "name": "stuck",
        "count": {"dist": "choice", "of": [0, 2]},
        "actuator": {"dist": "choice", "of": [0, 1, 2, 3]},
        "t_on": 1.0,
        "kind": [{"type": "stuck", "torque": 0.01}],
    }
    made = campaign(fault=[fault])
    found = made.run(200, out=tmp_path / "out")
    rows = found.table().to_pandas()
    twice = (rows["fault.stuck.0.actuator"] == rows["fault.stuck.1.actuator"]) & (rows["fault.stuck.0.kind"] != "none")
    assert 5 < twice.sum() < 50
    assert np.array_equal(rows.status == "refused", twice)
    assert all("contradict" in cause for cause in rows.cause[twice])
    assert rows.cause[~twice & (rows.status == "completed")].isna().all()
    assert not rows.success[twice].any()
    assert np.array_equal(rows.margin[twice], np.full(twice.sum(), 4.0))
    apart = campaign(fault=[{**fault, "distinct": True}]).fly(0, 200)
    assert apart.counts[""]["status"] == {"completed": 200}


def test_flights_that_are_mostly_refused_are_a_mistake(tmp_path: Path) -> None:
    vary = {"truth.dJ_B.0.0": {"dist": "uniform", "low": -40.0, "high": -5.0}}
    with pytest.raises(gs.InputError, match=r"of the first 50 flights are refused, run \d+ because: "):
        campaign(vary=vary).run(50, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


class Fragile:
    """Feedback that raises where the rate is high."""

    def step(self, x: Any, *_: Any) -> list[float]:
        if np.linalg.norm(x.omega_BN_B) > 0.05:
            raise RuntimeError("too fast for me")
        return (-2.0 * x.omega_BN_B).tolist()


def test_what_a_python_component_raises_is_a_row(tmp_path: Path) -> None:
    base = gs.Scenario.load("wheel2_degraded").replace(**SET, observer=None, controller=Fragile())
    made = gs.Campaign(
        base,
        vary={"initial.omega_BN_B": dist.normal(0.0, 0.03, each=3)},
        measure={"final": {"metric": "final", "signal": "error.angle"}},
    )
    found = made.run(40, out=tmp_path / "out", chunk=15)
    rows = found.table().to_pandas()
    raised = rows.status == "raised"
    assert 3 < raised.sum() < 37
    assert set(rows.cause[raised]) == {"RuntimeError: too fast for me"}
    assert rows.cause[~raised].isna().all()
    with pytest.raises(gs.InputError, match="Python components"):
        _ = found.campaign


def test_evaluating_the_points_of_runs_is_flying_them() -> None:
    made = campaign()
    outcome = made.evaluate(made.points(3, 40), first=3)
    rows = made.fly(3, 40).table.to_pandas()
    assert np.array_equal(outcome.measures["final"], rows.final, equal_nan=True)
    assert np.array_equal(outcome.margin, rows.margin)
    assert np.array_equal(outcome.success, rows.success)
    assert len(made.evaluate(np.empty((0, made.dimension))).success) == 0
    with pytest.raises(gs.InputError, match="both excluded"):
        made.evaluate(np.zeros((1, made.dimension)))
    with pytest.raises(gs.InputError, match=r"u of shape \(3, 2\)"):
        made.evaluate(np.full((3, 2), 0.5))


def test_python_and_toml_say_the_same(tmp_path: Path) -> None:
    made = gs.Campaign(
        "wheel2_degraded",
        set=SET,
        name="short flights",
        seed=7,
        vary={
            "initial.omega_BN_B": dist.normal(0.0, 0.02, each=3),
            "initial.q_NB": dist.attitude(dist.uniform(0.1, 1.2)),
            "truth.dJ_B": dist.inertia(0.05),
        },
        faults=FAULTS,
        measure=TABLES["measure"],
        success=TABLES["success"],
    )
    made.to_toml(tmp_path / "c.toml")
    read = gs.Campaign.load(tmp_path / "c.toml")
    hashes = {c.run(12, out=tmp_path / str(i)).identity for i, c in enumerate((made, read, campaign()))}
    assert len(hashes) == 1
    own = gs.Campaign(gs.Scenario.load("wheel2_degraded").replace(**SET), vary=made.spec.vary)
    assert gs.Campaign.from_dict(json.loads(json.dumps(own.to_dict()))).draws(0, 3).keys() == own.draws(0, 3).keys()


def test_replicates_fly_as_many_points_as_the_runs_make(tmp_path: Path) -> None:
    made = campaign(sampling="lhs", replicates=4)
    found = made.run(40, out=tmp_path / "out", chunk=7)
    assert found.campaign.spec.points == 10
    assert np.array_equal(
        found.table(["energy"])["energy"], campaign(sampling="lhs", replicates=4, points=10).fly(0, 40).table["energy"]
    )
    with pytest.raises(gs.InputError, match="must be a multiple of replicates = 4"):
        made.run(41, out=tmp_path / "odd")
    with pytest.raises(gs.InputError, match="points is missing"):
        made.draws(0, 1)
    with pytest.raises(gs.InputError, match="power of two"):
        campaign(sampling="sobol", replicates=4).run(40, out=tmp_path / "net")


def test_sketches_merge_in_any_order() -> None:
    rng = np.random.default_rng(2)
    x = np.concatenate([rng.lognormal(0.0, 3.0, 5000) * rng.choice([-1.0, 1.0], 5000), [0.0, np.nan, np.inf, -np.inf]])
    rng.shuffle(x)
    parts = [Sketch.of(part) for part in np.array_split(x, 7)]
    whole = Sketch.of(x)
    assert Sketch.merged(parts) == Sketch.merged(reversed(parts)) == whole
    assert whole.count == len(x)
    assert Sketch.from_dict(json.loads(json.dumps(whole.to_dict()))) == whole
    ordered = np.sort(x)  # NaN last
    for level in (0.01, 0.2, 0.5, 0.9, 0.99):
        exact = ordered[math.ceil(level * len(x)) - 1]
        assert whole.quantile(level) == pytest.approx(exact, rel=0.0051)
    assert whole.quantile(0.0) == -math.inf
    assert math.isnan(whole.quantile(1.0))
    assert math.isnan(Sketch().quantile(0.5))


def test_progress_says_how_far_it_is(tmp_path: Path) -> None:
    told: list[State] = []
    campaign().run(60, out=tmp_path / "out", chunk=20)
    campaign().run(200, out=tmp_path / "out", progress=told.append)
    assert told[0].done >= 60
    assert [s.done for s in told] == sorted(s.done for s in told)
    last = told[-1]
    assert (last.done, last.runs) == (200, 200)
    assert last.failures == gs.CampaignResult(tmp_path / "out").counts[""].failures
    assert state_line(State(1200, 10_000, 31, 480.0)) == "1200 of 10000 runs, 480 a second, 18 s left, 31 failures"
    assert state_line(State(0, 10, 0, 0.0)) == "0 of 10 runs, 0 a second, 0 failures"
    assert state_line(State(10, 10**6, 0, 10.0)).split(", ")[2] == "27.8 h left"


START = "from gyrostat.cli import main; main()"


def loaded(path: str) -> ModuleType:
    """A script of the repository."""
    name = path.replace("/", "_")
    spec = importlib.util.spec_from_loader(name, SourceFileLoader(name, str(Path(__file__).parents[2] / path)))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def toml_of(tmp_path: Path, **changes: Any) -> Path:
    path = tmp_path / "campaign.toml"
    campaign(**changes).to_toml(path)
    return path


def test_six_kills_lose_nothing_and_double_nothing(tmp_path: Path) -> None:
    """Killed while it flies and writes; then one more run of it gives the folder flown in one go.

    ``scripts/kill_campaign`` does so fifty times and more.
    """
    script = loaded("scripts/kill_campaign")
    file, out = toml_of(tmp_path), tmp_path / "killed"
    runs = script.killed(file, out, 6, seed=3)
    assert runs >= 6 * script.CHUNK
    assert script.differences(campaign(), out, runs, tmp_path / "in_one_go") == []


def test_ctrl_c_waits_for_no_chunk_and_leaves_a_folder_that_can_be_taken_up(tmp_path: Path) -> None:
    """The chunk that it interrupts has 120 million samples, minutes of flight."""
    file, out = toml_of(tmp_path, set={**SET, "duration": 600.0}), tmp_path / "out"
    command = [sys.executable, "-c", START, "campaign", str(file), "--runs", "20000", "--chunk", "20000"]
    with subprocess.Popen([*command, "--out", str(out)], stderr=subprocess.PIPE, text=True) as process:
        while not out.exists() and process.poll() is None:  # made before the first flight
            time.sleep(0.02)
        time.sleep(0.5)  # it flies by now
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60.0) == 130
        assert process.stderr is not None
        assert process.stderr.read() == "error: interrupted\n"
    assert gyrostat("campaign", file, "--runs", "2", "--out", out).returncode == 0


def test_a_full_disk_ends_with_status_5_and_leaves_what_is_there(tmp_path: Path) -> None:
    """The second run may write files of 3 kB at most, which is like a disk that is full for the parts."""
    file, out = toml_of(tmp_path), tmp_path / "out"
    assert gyrostat("campaign", file, "--runs", "100", "--chunk", "100", "--out", out).returncode == 0
    before = files(out)
    code = (
        "import errno, os, pathlib; real = pathlib.Path.open\n"
        "class Full:\n"
        "    def __init__(self, file): self.file = file\n"
        "    def __enter__(self): return self\n"
        "    def __exit__(self, *_): self.file.close()\n"
        "    def write(self, data):\n"
        "        if len(data) > 3000: raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))\n"
        "        return self.file.write(data)\n"
        "pathlib.Path.open = lambda self, mode='r', *a, **k: Full(real(self, mode, *a, **k)) if mode == 'wb' else "
        "real(self, mode, *a, **k)\n"
    )
    command = [sys.executable, "-c", code + START, "campaign", str(file), "--runs", "300", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 5, done.stderr
    assert "no space left on device; free some and call it again" in done.stderr
    assert done.stderr.count("\n") == 1
    assert {k: v for k, v in files(out).items() if k in before} == before
    assert [p.name for p in out.rglob(".*")] == []
    assert gyrostat("campaign", file, "--runs", "300", "--out", out).returncode == 0


def test_the_command_flies_shows_and_flies_again(tmp_path: Path) -> None:
    file, out = toml_of(tmp_path, grid=GRID), tmp_path / "out"
    done = gyrostat("campaign", file, "--runs", "30", "--jobs", "2", "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["runs"] == told["wanted"] == 30
    assert list(told["cells"]) == [f"{s}/{a}" for s in ("li2018", "plain") for a in ("pseudo_inverse", "lexicographic")]
    shown = gyrostat("campaign", "show", out)
    assert f"table    {told['table']}" in shown.stdout
    again = gyrostat("campaign", "rerun", out, "7", "--cell", "plain/lexicographic", "--out", tmp_path / "run7.toml")
    assert again.returncode == 0, again.stderr
    assert again.stdout.endswith("run 7: equal to the bit\n")
    scenario = gs.Scenario.load(tmp_path / "run7.toml")
    assert (scenario.seed, scenario.run_number) == (7, 7)
    row = gs.CampaignResult(out).row(7, "plain/lexicographic")
    assert row is not None
    result = scenario.run(channels=["error.angle"])
    assert result["error.angle"][result.t > 5.0 - 1e-9].max() == row["final"]
    assert gyrostat("campaign", "join", out, out).stdout == "2 folders hold one campaign, without gaps\n"


def test_torn_and_changed_parts_are_refused_where_they_are_read(tmp_path: Path) -> None:
    found = campaign().run(60, out=tmp_path / "out", chunk=60)
    path = found.parts()[0].path
    rng = random.Random(5)
    reference = found.table().to_pandas()
    for damaged in (path, path.parents[1] / "counts" / f"{path.stem}.json"):
        whole = damaged.read_bytes()
        for _ in range(60):
            changed = bytearray(whole)
            changed[rng.randrange(len(whole))] ^= 1 << rng.randrange(8)
            damaged.write_bytes(changed)
            with pytest.raises(gs.InputError, match=rf"{damaged.name}: is not what was written"):
                found.table()
        damaged.write_bytes(whole[: len(whole) // 2])
        with pytest.raises(gs.InputError, match=rf"{damaged.name}: is not what was written"):
            found.table()
        damaged.write_bytes(whole)
    assert found.table().to_pandas().equals(reference)


@pytest.mark.parametrize("what", ["parts/part-30-60.parquet", "counts/part-30-60.json"])
@pytest.mark.parametrize("runs", [70, 80])
def test_a_damaged_part_is_named_and_flown_again(tmp_path: Path, what: str, runs: int) -> None:
    """Torn or changed; also by a call that wants more runs."""
    out = tmp_path / "out"
    campaign().run(70, out=out, chunk=30)
    whole = files(out)
    for damaged in (whole[what][:100], whole[what][:-1] + b"!"):
        (out / what).write_bytes(damaged)
        with pytest.warns(UserWarning, match=r"part-30-60\.parquet: is not what was written, and is flown again"):
            again = campaign().run(runs, out=out)
        assert files(out).items() >= whole.items()
    assert again.complete
    assert again.table_hash == campaign().run(runs, out=tmp_path / "one").table_hash


def test_a_damaged_part_is_not_joined(tmp_path: Path) -> None:
    part = campaign().run(20, out=tmp_path / "out").parts()[0].path
    part.write_bytes(part.read_bytes()[:200])
    for new in (None, tmp_path / "new"):
        with pytest.raises(gs.InputError, match=r"part-0-20\.parquet: is not what was written"):
            join([tmp_path / "out"], new)
    assert not (tmp_path / "new").exists()


def test_behind_a_damaged_part_a_shorter_one_is_taken(tmp_path: Path) -> None:
    campaign().run(40, out=tmp_path / "short", chunk=20)
    found = campaign().run(40, out=tmp_path / "out", chunk=40)
    for folder, name in (("parts", "part-0-20.parquet"), ("counts", "part-0-20.json")):
        (tmp_path / "out" / folder / name).write_bytes((tmp_path / "short" / folder / name).read_bytes())
    (tmp_path / "out" / "parts" / "part-0-40.parquet").write_bytes(b"torn")
    with pytest.warns(UserWarning, match="part-0-40"):
        assert campaign().run(40, out=tmp_path / "out").table_hash == gs.CampaignResult(tmp_path / "short").table_hash
    assert [(p.first, p.end) for p in found.parts()] == [(0, 20), (20, 40)]


def test_the_command_names_a_damaged_part(tmp_path: Path) -> None:
    part = campaign().run(20, out=tmp_path / "out").parts()[0].path
    part.write_bytes(part.read_bytes()[:200])
    again = gyrostat("campaign", toml_of(tmp_path), "--runs", "20", "--out", tmp_path / "out")
    assert again.stderr == f"warning: {part}: is not what was written, and is flown again\n"
    assert again.returncode == 0


def test_memory_does_not_grow_with_the_number_of_runs(tmp_path: Path) -> None:
    """Highest memory of a process that flies 1000 runs, and of one that flies 10 000: less than a tenth apart."""
    file = toml_of(tmp_path)
    most = {}
    for runs in (1_000, 10_000):
        code = f"import resource, gyrostat as gs\ncampaign = gs.Campaign.load({str(file)!r})\n"
        code += f"campaign.run({runs}, out={str(tmp_path / str(runs))!r})\n"
        code += "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        most[runs] = int(done.stdout)
    assert most[10_000] < 1.1 * most[1_000]


def test_two_processes_in_one_folder_do_no_harm(tmp_path: Path) -> None:
    file, out = toml_of(tmp_path), tmp_path / "out"
    command = [sys.executable, "-c", START, "campaign", str(file), "--runs", "400", "--chunk", "20", "--jobs", "1"]
    two = [subprocess.Popen([*command, "--out", str(out)], stdout=subprocess.DEVNULL) for _ in range(2)]
    assert [process.wait(timeout=120) for process in two] == [0, 0]
    assert gs.CampaignResult(out).table_hash == campaign().run(400, out=tmp_path / "one").table_hash


def test_two_workers_of_a_cluster_fly_the_same_bits(tmp_path: Path) -> None:
    import distributed

    expected = campaign().run(90, out=tmp_path / "here").table_hash
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        there = campaign().run(90, out=tmp_path / "there", chunk=13, scheduler=cluster.scheduler_address)
    assert there.table_hash == expected
