# SPDX-License-Identifier: MIT
"""A component that was renamed still comes by its old name, with a warning, wherever names of components are read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from commands import gyrostat

import gyrostat as gs
from gyrostat import _core
from gyrostat.campaign import Campaign
from gyrostat.components import Component
from gyrostat.dataset import _pairs
from gyrostat.old_names import RENAMED


def flown(observer: str | Component) -> gs.Scenario:
    return gs.Scenario.load("ftc_4rw").replace(observer=observer, duration=0.1)


def by_function(old: str, folder: Path) -> gs.Scenario:
    del folder
    return flown(gs.observer(old))


def by_word(old: str, folder: Path) -> gs.Scenario:
    del folder
    return flown(old)


def by_file(old: str, folder: Path) -> gs.Scenario:
    (folder / "old.toml").write_text(flown(RENAMED[old]).to_toml().replace(f'"{RENAMED[old]}"', f'"{old}"'))
    return gs.Scenario.load(folder / "old.toml")


def by_shadow(old: str, folder: Path) -> gs.Scenario:
    del folder
    pair = flown(RENAMED[old]).replace(shadows=[{"observer": old, "detector": "none"}])
    assert pair.shadows[0].observer == gs.observer(RENAMED[old])
    return pair


def by_saved_result(old: str, folder: Path) -> gs.Scenario:
    path = flown(RENAMED[old]).run().save(folder / "old")
    with np.load(path) as data:
        arrays = {name: data[name] for name in data.files}
    arrays["facts"] = np.array(str(arrays["facts"]).replace(f'"{RENAMED[old]}"', f'"{old}"'))
    assert f'"{old}"' in str(arrays["facts"])
    np.savez(path, **arrays)  # type: ignore[arg-type]
    scenario = gs.Result.load(path).scenario
    assert isinstance(scenario, gs.Scenario)
    return scenario


def by_campaign(old: str, folder: Path) -> gs.Scenario:
    (folder / "old.toml").write_text(f'base = "ftc_4rw"\nset = {{ observer = "{old}", duration = 0.1 }}\n')
    return Campaign.load(folder / "old.toml").base


WAYS = (by_function, by_word, by_file, by_shadow, by_saved_result, by_campaign)


@pytest.mark.parametrize("old", RENAMED)
@pytest.mark.parametrize("way", WAYS)
def test_an_old_name_flies_what_it_became(way: Callable[[str, Path], gs.Scenario], old: str, tmp_path: Path) -> None:
    with pytest.warns(FutureWarning, match=f"'{old}' is called '{RENAMED[old]}' now.* until version") as told:
        scenario = way(old, tmp_path)
    assert {Path(w.filename) for w in told} == {Path(__file__)}, "the line that is to be changed"
    assert scenario.observer == gs.observer(RENAMED[old])
    assert (scenario.run()["allocation.u"] == flown(RENAMED[old]).run()["allocation.u"]).all()


@pytest.mark.parametrize("old", RENAMED)
def test_the_command_line_takes_an_old_name_and_says_so_in_one_line(old: str) -> None:
    for arguments in (("describe", "observer"), ("describe",)):
        new = gyrostat(*arguments, RENAMED[old])
        done = gyrostat(*arguments, old)
        assert done.stdout == new.stdout
        assert done.stderr.count("\n") == 1
        assert f"warning: '{old}' is called '{RENAMED[old]}' now" in done.stderr
        assert not new.stderr
    done = gyrostat("check", "ftc_4rw", "--set", f"observer={old}")
    assert done.stderr.count(f"'{old}' is called") == 1
    assert done.stdout == gyrostat("check", "ftc_4rw", "--set", f"observer={RENAMED[old]}").stdout


@pytest.mark.parametrize("old", RENAMED)
def test_scores_of_a_data_set_take_an_old_name(old: str) -> None:
    with pytest.warns(FutureWarning, match=old):
        assert list(_pairs([old], ["threshold"]).values()) == [(RENAMED[old], "threshold")]


def test_an_old_name_is_nobody_else_s() -> None:
    names = [name for family in _core.catalogue().values() for name in family]
    assert not set(RENAMED) & set(names)
    assert set(RENAMED.values()) <= set(names)
