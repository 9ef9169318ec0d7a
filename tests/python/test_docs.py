# SPDX-License-Identifier: MIT
"""The documentation says what the program says: tables, pages, links, printed output, and every example runs."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import gyrostat as gs

ROOT = Path(__file__).parents[2]


def _load(path: str) -> ModuleType:
    name = path.replace("/", "_")
    spec = importlib.util.spec_from_loader(name, SourceFileLoader(name, str(ROOT / path)))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


docs = _load("scripts/docs")
PAGES = docs.pages()


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def prose(page: Path) -> str:
    """The text without its blocks of code."""
    fenced = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
    return re.sub(r"^    .*$", "", fenced.sub("", page.read_text(encoding="utf-8")), flags=re.MULTILINE)


def heading_anchors(page: Path) -> set[str]:
    """Anchors as GitHub makes them."""
    heads = re.findall(r"^#+ (.*)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in heads}


def test_every_member_of_the_catalogue_has_a_page_with_its_parameters() -> None:
    assert not docs.missing_pages()


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_what_comes_from_the_program_is_current(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert docs.filled(text, page) == text, "run scripts/docs --write"


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_quoted_code_stands_in_its_file(page: Path) -> None:
    assert not list(docs.misquoted(page.read_text(encoding="utf-8"), page))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{name(page)} links to {link}"
        if anchor:
            assert anchor in heading_anchors(target), f"{name(page)} links to {link}"


def test_pages_that_the_code_names_exist() -> None:
    sources = [p for layer in ("cpp", "bindings", "python", "examples") for p in (ROOT / layer).rglob("*.[chpt]*")]
    for source in sources:
        for named in re.findall(r"docs/[\w/]+\.md", source.read_text(encoding="utf-8", errors="ignore")):
            assert (ROOT / named).exists(), f"{name(source)} names {named}"


def test_the_figure_shows_what_the_scenario_does() -> None:
    drawn = _load("docs/figures/wheel2_degraded.py").draw().data
    with np.load(ROOT / "docs" / "figures" / "wheel2_degraded.npz") as saved:
        for signal, values in drawn.items():
            # 1e-3 of the largest value: nothing the eye could see; another compiler moves far less
            np.testing.assert_allclose(saved[signal], values, rtol=0, atol=1e-3 * np.abs(values).max(), err_msg=signal)


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "python")], ids=name)
def test_python_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of a page are one program."""
    monkeypatch.chdir(tmp_path)
    program = "\n".join(blocks(page, "python"))
    exec(compile(program, str(page), "exec"), {"__name__": "example"})


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "toml")], ids=name)
def test_toml_examples_are_valid(page: Path) -> None:
    """A whole scenario stands alone; a part is put into the reference scenario."""
    for text in blocks(page, "toml"):
        tables = tomllib.loads(text)
        whole = {"vehicle", "duration", "dt"} <= set(tables)
        gs.Scenario.from_dict(tables if whole else merged(gs.Scenario.load("ftc_4rw").to_dict(), tables))


def merged(base: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """Keys of `part` win; a block without a type keeps what it does not name."""
    out = dict(base)
    for key, value in part.items():
        keeps = isinstance(value, dict) and "type" not in value and isinstance(base.get(key), dict)
        out[key] = {**base[key], **value} if keeps else value
    return out


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "toml")], ids=name)
def test_one_line_python_forms_are_valid(page: Path) -> None:
    for form in re.findall(r"The same in Python: `(.*)`\.", page.read_text(encoding="utf-8")):
        assert isinstance(eval(form, {"gs": gs}), gs.Component)


def test_a_stale_table_is_noticed() -> None:
    page = docs.page_of("integrator", "rk4")
    text = page.read_text(encoding="utf-8")
    changed = text.replace("steps a sample |", "steps a second |")
    assert changed != text
    assert docs.filled(changed, page) == text


def test_only_last_digits_of_printed_decimals_may_differ() -> None:
    assert docs.same("settled 64.8 s", "settled 64.9 s")
    assert not docs.same("settled 64.8 s", "settled 74.8 s")
    assert not docs.same("wheel 2", "wheel 3")
    assert not docs.same("a 1.0", "b 1.0")


def test_a_quotation_that_is_not_there_is_noticed() -> None:
    page = ROOT / "docs" / "extending.md"
    text = "<!-- code: examples/01_first_run.py -->\n```python\nimport nothing\n```"
    assert list(docs.misquoted(text, page))
