# SPDX-License-Identifier: MIT
"""The documentation site, as far as it can be held without its generator; `make docs` checks what that made."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
SITE = ROOT / "scripts" / "site"


def _load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, SITE / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


python_reference, cpp_reference, check = _load("python_reference"), _load("cpp_reference"), _load("check")
prepare = _load("prepare")
DOCS = ROOT / "docs"
PAGES = sorted({p.relative_to(DOCS).as_posix() for p in DOCS.rglob("*.md")} - set(prepare.ELSEWHERE))


def test_every_page_has_a_place_in_the_navigation() -> None:
    yaml = pytest.importorskip("yaml")
    made = {"source/CHANGELOG.md", "reference/python/index.md", "reference/cpp/index.md"}
    pages = sorted({*PAGES, *made})
    nav = yaml.safe_load(f"nav:\n{(SITE / 'mkdocs.yml').read_text(encoding='utf-8').partition(chr(10) + 'nav:')[2]}")[
        "nav"
    ]
    named = [entry for entry in prepare._entries(nav) if not entry.endswith("/") and entry != "*"]
    assert set(named) <= set(pages), "the navigation names a page that is not there"
    assert len(named) == len(set(named))
    whole = [prepare._expanded(entry, pages, set(named)) for entry in nav]
    assert sorted(prepare._entries(whole)) == pages


def _prose(page: str) -> str:
    return re.sub(prepare._code, "", (DOCS / page).read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", [p for p in PAGES if "$" in _prose(p)])
def test_formulas_become_mathml(page: str) -> None:
    pytest.importorskip("latex2mathml")
    done = prepare._with_math((DOCS / page).read_text(encoding="utf-8"))
    outside = re.sub(prepare._code, "", done)
    assert "$" not in outside, "a formula that was not understood"
    assert done.count("<math") == done.count("</math>") > 0
    assert "merror" not in done
    assert not re.search(r'^<math[^>]*display="inline"', done, re.MULTILINE), "Markdown would end the paragraph there"


def test_links_out_of_the_pages_lead_to_pages_made_of_the_files() -> None:
    page = DOCS / "validation.md"
    text = "[a](truth.md#effectors) [b](../tests/golden/bits.csv) [c](../benchmarks/README.md) `[d](../x)`"
    led = prepare._led(text, page, "validation.md")
    assert led == (
        "[a](truth.md#effectors) [b](source/tests/golden/bits.csv.md) [c](source/benchmarks/README.md) `[d](../x)`"
    )
    assert {ROOT / "benchmarks" / "README.md", ROOT / "CHANGELOG.md"} <= prepare._linked_outside()


def test_modules_and_headers_of_the_references_are_there() -> None:
    for module in python_reference.MODULES:
        path = ROOT / "python" / "gyrostat" / module.replace(".", "/")
        assert path.with_suffix(".py").is_file() or (path / "__init__.py").is_file(), module
    for layer, (_, names) in cpp_reference.LAYERS.items():
        for name in names:
            assert (ROOT / "cpp" / layer / "gyrostat" / layer / f"{name}.hpp").is_file(), name


def test_a_broken_site_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text('<a href="b.html#x">to b</a><a id="y"></a>')
    (tmp_path / "b.html").write_text('<p id="x"></p><a href="a.html#y">to a</a><a href="https://doi.org/1">out</a>')
    assert not list(check.trouble(tmp_path))
    (tmp_path / "c.html").write_text(
        '<a href="d.html"></a><a href="b.html#z"></a><script src="https://cdn.example/x.js"></script><img src="no.png">'
    )
    assert [line.partition("c.html ")[2] for line in check.trouble(tmp_path)] == [
        "fetches https://cdn.example/x.js",
        "links to d.html, which is not there",
        "links to b.html#z, which has no such anchor",
        "links to no.png, which is not there",
    ]
    assert list(check.trouble(tmp_path / "empty"))


def test_search_needs_no_network() -> None:
    settings = (SITE / "mkdocs.yml").read_text(encoding="utf-8")
    assert "polyfills: [assets/javascripts/iframe-worker.js]" in settings
    assert (SITE / "assets" / "javascripts" / "iframe-worker.js").is_file()
    assert "font: false" in settings
