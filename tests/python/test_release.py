# SPDX-License-Identifier: MIT
"""``make release-check`` accepts a release and names what is not one."""

from __future__ import annotations

import importlib.util
import io
import re
import shutil
import tarfile
import zipfile
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def check() -> ModuleType:
    spec = importlib.util.spec_from_loader(
        "release_check", SourceFileLoader("release_check", str(ROOT / "scripts/release_check"))
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def release(tmp_path: Path, check: ModuleType) -> Path:
    """This checkout as a release would leave it: 7.8.9."""
    for name in (
        "CMakeLists.txt",
        "CHANGELOG.md",
        "CITATION.cff",
        "pyproject.toml",
        "LICENSE",
        check.STUB,
        *check.PAGES,
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, tmp_path / name)
    shutil.copytree(ROOT / "licenses", tmp_path / "licenses")
    change(tmp_path / "CMakeLists.txt", r"(project\(gyrostat VERSION )[0-9.]+", r"\g<1>7.8.9")
    change(tmp_path / "CHANGELOG.md", r"(?m)\A(?s:(.*?))^## .*$", r"\g<1>## [7.8.9] - 2030-01-02")
    change(tmp_path / check.STUB, r"(?m)^(__version__: str = )\"[0-9.]+\"", r'\g<1>"7.8.9"')
    change(tmp_path / "CITATION.cff", r"(?m)^version: .*$", "version: 7.8.9")
    change(tmp_path / "CITATION.cff", r"(?m)^date-released: .*$", "date-released: 2030-01-02")
    for name in check.PAGES:
        change(tmp_path / name, r"(find_package\(gyrostat )[0-9.]+", r"\g<1>7.8")
    dist = tmp_path / "dist"
    dist.mkdir()
    licences = ["LICENSE", *(f"licenses/{p.name}" for p in (ROOT / "licenses").iterdir())]
    with zipfile.ZipFile(dist / "gyrostat-7.8.9-cp311-cp311-manylinux_2_34_x86_64.whl", "w") as packed:
        packed.writestr("gyrostat-7.8.9.dist-info/METADATA", "Metadata-Version: 2.4\nName: gyrostat\nVersion: 7.8.9\n")
        for name in licences:
            packed.writestr(f"gyrostat-7.8.9.dist-info/licenses/{name}", "")
        for name in (
            "include/gyrostat/flight/stack.hpp",
            "cmake/gyrostat-config.cmake",
            "cmake/gyrostat-config-version.cmake",
            "py.typed",
        ):
            packed.writestr(f"gyrostat/{name}", "")
    with tarfile.open(dist / "gyrostat-7.8.9.tar.gz", "w:gz") as packed:
        for name in (*licences, "CMakeLists.txt", "pyproject.toml"):
            packed.addfile(tarfile.TarInfo(f"gyrostat-7.8.9/{name}"), io.BytesIO())
    return tmp_path


def change(path: Path, pattern: str, into: str) -> None:
    path.write_text(re.sub(pattern, into, path.read_text(), count=0 if "find_package" in pattern else 1))


def test_a_release_is_accepted(release: Path, check: ModuleType) -> None:
    assert check.problems(release) == []


@pytest.mark.parametrize(
    ("change_of", "says"),
    [
        (("CMakeLists.txt", "7.8.9", "7.8.10"), "CHANGELOG.md: its first heading"),
        (("CHANGELOG.md", " - 2030-01-02", " unreleased"), "CHANGELOG.md: its first heading"),
        (("CITATION.cff", "version: 7.8.9", "version: 7.8.8"), "CITATION.cff: no line 'version: 7.8.9'"),
        (("CITATION.cff", "date-released: 2030-01-02", ""), "CITATION.cff: no line 'date-released"),
        (("docs/extending.md", r"gyrostat 7\.8 ", "gyrostat 7.7 "), "docs/extending.md: find_package(gyrostat 7.7)"),
    ],
)
def test_what_states_another_version_is_named(
    release: Path, check: ModuleType, change_of: tuple[str, str, str], says: str
) -> None:
    file, pattern, into = change_of
    change(release / file, pattern, into)
    assert any(line.startswith(says) for line in check.problems(release))


def test_packages_that_are_missing_or_incomplete_are_named(release: Path, check: ModuleType) -> None:
    (release / "licenses" / "another.txt").write_text("of something linked in since")
    assert sum("licenses/another.txt" in line for line in check.problems(release)) == 2
    shutil.rmtree(release / "dist")
    assert any("make wheel" in line for line in check.problems(release))


def test_the_version_is_written_once() -> None:
    """CMake states it; Python, wheel and module take it from there."""
    import gyrostat

    stated = re.search(r"project\(gyrostat VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())
    assert stated is not None
    assert gyrostat.__version__ == stated[1]
    assert "version" not in (ROOT / "pyproject.toml").read_text().partition("[project]")[2].partition("\n[")[0].replace(
        'dynamic = ["version"]', ""
    )
