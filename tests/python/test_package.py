# SPDX-License-Identifier: MIT
"""The package as a whole: stubs current, examples run, heavy libraries stay out of the import."""

from __future__ import annotations

import importlib.metadata
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
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


def test_the_import_takes_little_memory() -> None:
    """At most 60 MB, the scenarios and results that people import it for included."""
    program = (
        "import gyrostat; gyrostat.Scenario, gyrostat.Result;"
        # Its own peak, kB; what getrusage tells begins with the peak of whoever started the process.
        "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert int(done.stdout) <= 60_000


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'scenaro'"):
        _ = gs.scenaro


def test_the_package_carries_the_notices_of_what_is_compiled_in() -> None:
    """As the wheel holds them: what pip wrote down of it."""
    listed = [str(path) for path in importlib.metadata.files("gyrostat") or []]
    (notices,) = {
        path.rpartition("/licenses/")[0] for path in listed if "/licenses/LICENSE" in path and "dist-info" in path
    }
    for name, says in (
        ("LICENSE", "MIT License"),
        ("licenses/sundials.txt", "Lawrence Livermore National Security"),
        ("licenses/eigen.txt", "Mozilla Public License Version 2.0"),
        ("licenses/random123.txt", "D. E. Shaw Research"),
        ("licenses/pybind11.txt", "Wenzel Jakob"),
    ):
        path = f"{notices}/licenses/{name}"
        assert path in listed
        text = Path(str(importlib.metadata.distribution("gyrostat").locate_file(path))).read_text(encoding="utf-8")
        assert says in text
        assert text == (ROOT / name).read_text(encoding="utf-8")


def test_what_an_index_shows_of_it_stands_alone() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert not re.search(r"!\[|\]\((?!https?:)", (ROOT / project["readme"]).read_text(encoding="utf-8"))


def test_the_source_distribution_carries_them_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scikit_build_core.build import build_sdist

    checkout = (
        tmp_path / "checkout"
    )  # without the environment, which would take seconds to be walked through and left out
    shutil.copytree(ROOT, checkout, ignore=shutil.ignore_patterns(".venv", ".git", "build", "out", "*_cache"))
    monkeypatch.chdir(checkout)
    with tarfile.open(tmp_path / build_sdist(str(tmp_path))) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    assert {"LICENSE", *(f"licenses/{x}.txt" for x in ("sundials", "eigen", "random123", "pybind11"))} <= names
    assert {"CMakeLists.txt", "pyproject.toml", "docs/package.md", "cpp/flight/gyrostat/flight/stack.hpp"} <= names


def test_the_module_is_hardened() -> None:
    """Stack protector, checked calls of the C library, relocations read-only before anything runs."""

    def readelf(*options: str) -> str:
        command = ["readelf", "--wide", *options, _core.__file__]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    assert "GNU_RELRO" in readelf("--program-headers")
    assert re.search(r"\bBIND_NOW\b", readelf("--dynamic"))
    imported = readelf("--dyn-syms")
    assert "__stack_chk_fail" in imported
    assert re.search(r"__\w+_chk\b", imported.replace("__stack_chk_fail", ""))
    assert re.search(r"GNU_STACK\s.*\sRW\s", readelf("--program-headers"))


def _said(*arguments: str) -> str:
    command = [sys.executable, "-m", "gyrostat", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def test_config_says_where_the_headers_are() -> None:
    include, cmake = Path(_said("config", "--include")), Path(_said("config", "--cmake"))
    assert (include / "gyrostat" / "flight" / "stack.hpp").is_file()
    assert (cmake / "gyrostat-config.cmake").is_file()
    assert _said("config").split() == ["version", gs.__version__, "include", str(include), "cmake", str(cmake)]


def test_a_stack_compiles_against_the_installed_package(tmp_path: Path) -> None:
    """As somebody without a clone would do it: the consumer's flight half, found by ``-Dgyrostat_DIR``."""
    found = f"-Dgyrostat_DIR={_said('config', '--cmake')}"
    configure = [
        "cmake",
        "-S",
        str(ROOT / "tests" / "consumer"),
        "-B",
        str(tmp_path),
        found,
        "-DCMAKE_BUILD_TYPE=Debug",
    ]
    build = ["cmake", "--build", str(tmp_path), "--target", "fly_static"]
    for command in (configure, build, [str(tmp_path / "fly_static")]):
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=900)
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert "pointing error" in done.stdout


@pytest.mark.parametrize(("component", "status"), [("flight", 0), ("host", 1)])
def test_the_installed_package_says_what_it_does_not_bring(tmp_path: Path, component: str, status: int) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.24)\nproject(user LANGUAGES CXX)\n"
        f"find_package(gyrostat REQUIRED COMPONENTS {component})\n"
    )
    command = ["cmake", "-S", str(tmp_path), "-B", str(tmp_path / "b"), f"-Dgyrostat_DIR={_said('config', '--cmake')}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == status, done.stderr
    assert ("the Python package brings core and flight" in " ".join(done.stderr.split())) == bool(status)


def test_the_module_needs_no_library_of_its_own() -> None:
    """SUNDIALS is inside, and MPI, which Debian builds it with, is nowhere."""
    command = ["readelf", "--wide", "--dynamic", _core.__file__]
    dynamic = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    needed = re.findall(r"\(NEEDED\).*\[(.+?)\.so", dynamic)
    assert set(needed) <= {"libstdc++", "libm", "libgcc_s", "libc", "ld-linux-x86-64", "ld-linux-aarch64"}


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
