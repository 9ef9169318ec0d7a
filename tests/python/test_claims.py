# SPDX-License-Identifier: MIT
"""What is offered has a row in docs/claims.csv, and the row names tests that exist."""

from __future__ import annotations

import re
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

import pytest

from gyrostat import _core, cli, design, papers
from gyrostat.campaign.catalogue import shipped as campaigns
from gyrostat.export import TARGETS
from gyrostat.scenario import shipped as scenarios

ROOT = Path(__file__).parents[2]
WORDS = ("independent", "publication", "own laws", "modelled")


def _docs() -> ModuleType:
    spec = spec_from_loader("docs_script", SourceFileLoader("docs_script", str(ROOT / "scripts" / "docs")))
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


docs = _docs()
CLAIMS = docs.claims()


def _listed(header: str, pattern: str) -> set[str]:
    """Names in a list of C++ types."""
    found = re.search(pattern, (ROOT / header).read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None, f"{header} has no list like {pattern}"
    return {word.rpartition("::")[2] for word in re.findall(r"[\w:]+", found[1])}


def offered() -> set[tuple[str, str]]:
    """Everything that pages and program say there is."""
    names = {kind: set(members) for kind, members in _core.catalogue().items() if kind not in docs.BLOCKS}
    names["effector"] = _listed("cpp/truth/gyrostat/truth/effectors/list.hpp", r"Effectors = EffectorList<(.*?)>")
    names["plant"] = _listed("cpp/host/gyrostat/host/assembly.hpp", r"AnyPlant = std::variant<(.*?)>")
    names["scenario"], names["campaign"] = set(scenarios()), set(campaigns())
    names["study"] = set(papers.available())
    names["design"], names["export"] = set(design.DESIGNS), set(TARGETS)
    names["command"] = {str(c.name or c.callback.__name__) for c in cli.app.registered_commands if c.callback}
    for group in cli.app.registered_groups:
        members = group.typer_instance.registered_commands if group.typer_instance else []
        names["command"] |= {f"{group.name} {c.name or c.callback.__name__}" for c in members if c.callback}
    return {(kind, name) for kind, members in names.items() for name in members}


def test_everything_offered_has_a_row_and_every_row_is_offered() -> None:
    rows = {(c["kind"], c["name"]) for c in CLAIMS if c["kind"] != "property"}
    missing, gone = sorted(offered() - rows), sorted(rows - offered())
    assert not missing, f"a row in docs/claims.csv is missing for {missing}; then scripts/docs --write"
    assert not gone, f"docs/claims.csv claims what is not offered: {gone}"


def test_no_row_stands_twice() -> None:
    rows = [(c["kind"], c["name"]) for c in CLAIMS]
    assert len(rows) == len(set(rows))


def missing_test(named: str) -> str:
    """What is wrong with the name of a test; "" when it is there. ``file::*`` or ``file`` alone is all of a file."""
    file, _, case = named.partition("::")
    path = docs.test_file(file)
    if path is None:
        return f"no test file {file}, or several"
    text = path.read_text(encoding="utf-8")
    if case in ("", "*"):
        return "" if re.search(r"\bTEST\w*\(|^def test_", text, re.MULTILINE) else f"{file} holds no test"
    here = rf"^def {case}\(" if file.endswith(".py") else rf"TEST\w*\(\w+, {case}\)"
    return "" if re.search(here, text, re.MULTILINE) else f"no test {case} in {file}"


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda c: f"{c['kind']}-{c['name']}")
def test_a_row_says_how_far_and_names_tests_that_exist(claim: dict[str, str]) -> None:
    assert claim["proven"] in WORDS
    assert claim["tests"]
    assert not [wrong for test in claim["tests"].split() if (wrong := missing_test(test))]
    assert not claim["page"] or (ROOT / claim["page"].partition("#")[0]).is_file()


def test_a_test_that_is_not_there_is_noticed() -> None:
    assert missing_test("test_integrator.cpp::NeverWritten")
    assert missing_test("test_nothing.py::test_it")
    assert missing_test("test_bits.py::test_bits")
    assert not missing_test("test_bits.py::test_bits_are_those_of_the_table")


@pytest.mark.parametrize("kind", sorted({c["kind"] for c in CLAIMS}))
def test_the_page_shows_every_kind(kind: str) -> None:
    page = (ROOT / "docs" / "claims.md").read_text(encoding="utf-8")
    assert kind in " ".join(re.findall(r"<!-- claims: (.*?) -->", page)).split()


def test_what_the_readme_says_it_does_has_rows() -> None:
    """Its table is made of them; nothing else in it is a table of claims."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert "<!-- claims: property -->" in readme
