# SPDX-License-Identifier: MIT
"""Every block of every tutorial runs and prints what the page says; the notebooks are these pages."""

from __future__ import annotations

import re
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


def _script() -> ModuleType:
    spec = spec_from_loader(
        "tutorials_script", SourceFileLoader("tutorials_script", str(ROOT / "scripts" / "tutorials"))
    )
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    import sys

    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


tutorials = _script()
TWINS = [p for p in tutorials.PAGES if tutorials.is_notebook(p.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("page", tutorials.PAGES, ids=lambda p: p.stem)
def test_every_block_runs_and_prints_what_the_page_says(page: Path, tmp_path: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert tutorials.ran(text, tmp_path) == text, "run scripts/tutorials --write"


@pytest.mark.parametrize("page", tutorials.PAGES, ids=lambda p: p.stem)
def test_no_block_is_left_out(page: Path) -> None:
    """C++ is a file that a command compiles; text is what the block before it prints."""
    blocks = tutorials.blocks(page.read_text(encoding="utf-8"))
    commands = " ".join(b.text for b in blocks if b.language == "sh")
    sources = " ".join(b.text for b in blocks if b.file)
    for before, block in zip([None, *blocks], blocks, strict=False):
        assert block.language in ("python", "text", "sh", "cpp")
        assert block.language != "cpp" or block.file in commands or f'#include "{block.file}"' in sources
        assert block.language != "text" or (before is not None and before.language == "python")


def test_there_are_four_notebooks_and_no_other() -> None:
    assert len(TWINS) == 4
    assert {tutorials.twin(p) for p in TWINS} == set(tutorials.NOTEBOOKS.glob("*"))


@pytest.mark.parametrize("page", TWINS, ids=lambda p: p.stem)
def test_a_notebook_is_its_tutorial(page: Path) -> None:
    """Its cells are the blocks that the test above runs, in the same order."""
    text = page.read_text(encoding="utf-8")
    notebook = tutorials.twin(page).read_text(encoding="utf-8")
    assert notebook == tutorials.notebook(text), "run scripts/tutorials --write"
    cells = [cell.strip() for cell in tutorials.cells(notebook)]
    assert cells == [b.text.strip() for b in tutorials.blocks(text) if b.language == "python"]


@pytest.mark.parametrize("page", TWINS, ids=lambda p: p.stem)
def test_links_of_a_notebook_lead_somewhere(page: Path) -> None:
    notebook = tutorials.twin(page)
    for link in re.findall(r"\]\(([^)\s]+)\)", notebook.read_text(encoding="utf-8")):
        assert (notebook.parent / link.partition("#")[0]).exists(), link


def test_a_block_that_prints_otherwise_is_noticed(tmp_path: Path) -> None:
    page = "```python\nprint(1.5)\n```\n\n```text\n2.5\n```\n"
    assert tutorials.ran(page, tmp_path) == page.replace("2.5", "1.5")
    settled = page.replace("2.5", "1.501")  # another compiler rounds differently
    assert tutorials.ran(settled, tmp_path) == settled


def test_a_block_that_fails_is_noticed(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        tutorials.ran("```python\n1 / 0\n```\n", tmp_path)
    with pytest.raises(RuntimeError, match="exit status"):
        tutorials.ran("```sh\ngyrostat run nothing\n```\n", tmp_path)
    with pytest.raises(RuntimeError, match="exit status"):
        tutorials.ran("<!-- file: a.cpp -->\n```cpp\nint main() { return x; }\n```\n```sh\nc++ a.cpp\n```\n", tmp_path)
