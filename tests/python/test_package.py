# SPDX-License-Identifier: MIT
"""The package as a whole: stubs current, examples run, heavy libraries stay out of the import."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import gyrostat as gs
from gyrostat import _core, stubs

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "gyrostat"
EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))


@pytest.mark.parametrize("module", stubs.MODULES)
def test_the_checked_in_stub_is_what_the_catalogue_says(module: str) -> None:
    assert (PACKAGE / f"{module}.pyi").read_text() == stubs.stub(module), "run python -m gyrostat.stubs"


@pytest.mark.parametrize("module", stubs.MODULES)
def test_a_module_offers_exactly_its_family(module: str) -> None:
    loaded = getattr(gs, module)
    assert len(loaded.__all__) == len(_core.catalogue()[stubs.MODULES[module]])
    for name in loaded.__all__:
        assert getattr(loaded, name).__doc__


@pytest.mark.parametrize("name", gs.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(gs, name) is not None


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'scenaro'"):
        _ = gs.scenaro


def test_importing_loads_no_heavy_library() -> None:
    program = "import sys, gyrostat; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert loaded.isdisjoint({"typer", "rich", "xarray", "pandas", "matplotlib", "scipy", "plotly"})


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_run(path: Path) -> None:
    done = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_a_docstring_example_is_true() -> None:
    import doctest

    from gyrostat import scenario

    found = doctest.DocTestFinder().find(scenario.Scenario, globs={"gs": gs})
    runner = doctest.DocTestRunner()
    for test in found:
        runner.run(test)
    assert runner.tries > 0
    assert runner.failures == 0
