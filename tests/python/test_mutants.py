# SPDX-License-Identifier: MIT
"""The list of mutants fits the headers. `make mutants` runs them; this keeps the list from rotting in silence."""

from __future__ import annotations

import importlib.util
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


def _load() -> ModuleType:
    spec = importlib.util.spec_from_loader("mutants", SourceFileLoader("mutants", str(ROOT / "scripts" / "mutants")))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclass looks itself up
    spec.loader.exec_module(module)
    return module


mutants = _load()


def test_the_text_of_every_mutant_stands_in_its_header_once() -> None:
    found = mutants.load()
    assert list(mutants.misplaced(found)) == []
    assert len([m for m in found if not m.equivalent]) >= 150
    assert len({m.number for m in found}) == len(found)
    assert max(m.number for m in found) < 100 * 100


@pytest.mark.parametrize(
    ("text", "instead", "words"),
    [
        ("x + z", "x", "occurs 0 times"),
        ("x", "y", "occurs 2 times"),
        ("x\n  + y", "x  + y", "changes nothing"),
    ],
)
def test_a_mutant_that_does_not_fit_is_named(tmp_path: Path, text: str, instead: str, words: str) -> None:
    header = tmp_path / "cpp" / "core" / "gyrostat" / "core" / "sum.hpp"
    header.parent.mkdir(parents=True)
    header.write_text("return x + y - x;\n")
    (message,) = mutants.misplaced([mutants.Mutant(0, "core/sum.hpp", "lost", text, instead)], tmp_path)
    assert message.startswith("core/sum.hpp: lost")
    assert words in message


def test_texts_that_overlap_are_named_and_equal_ones_are_not(tmp_path: Path) -> None:
    header = tmp_path / "cpp" / "core" / "gyrostat" / "core" / "sum.hpp"
    header.parent.mkdir(parents=True)
    header.write_text("#pragma once\nreturn x + y;\n")
    one, other, third = (
        mutants.Mutant(i, "core/sum.hpp", name, text, instead)
        for i, (name, text, instead) in enumerate([("a", "x + y", "x"), ("b", "x + y", "y"), ("c", "y", "x")])
    )
    assert list(mutants.misplaced([one, other], tmp_path)) == []
    (message,) = mutants.misplaced([one, third], tmp_path)
    assert "overlaps" in message
    switched = mutants.switched_source(header.read_text(), [one, other])
    assert switched.count("mutant::either") == 2
    assert "mutant.hpp" in switched
