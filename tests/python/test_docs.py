# SPDX-License-Identifier: MIT
"""The documentation says what the program says: tables, pages, links, printed output, and every example runs."""

from __future__ import annotations

import csv
import importlib.util
import json
import re
import tomllib
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core, cli
from gyrostat.verification.requirements import RequirementFile

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
FOLDERS = ("benchmarks", "bindings", "cmake", "cpp", "docs", "examples", "python", "scripts", "sundials_cfg", "tests")
EVERY_PAGE = [*sorted(ROOT.glob("*.md")), *sorted(p for folder in FOLDERS for p in (ROOT / folder).rglob("*.md"))]


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def prose(page: Path) -> str:
    """The text without its blocks of code."""
    return without_code(page.read_text(encoding="utf-8"))


def without_code(text: str) -> str:
    fenced = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
    return re.sub(r"^    .*$", "", fenced.sub("", text), flags=re.MULTILINE)


def code(page: Path) -> list[str]:
    """Every piece of code of a page: spans in a line, and the lines of its blocks."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```.*?\n(.*?)^```", text, re.DOTALL | re.MULTILINE) + re.findall(
        r"^    (.*)$", text, re.MULTILINE
    )
    return re.findall(r"`([^`\n]+)`", without_code(text)) + [line for block in blocks for line in block.splitlines()]


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


def broken_links(text: str, page: Path) -> Iterator[str]:
    """Links of a page that lead to no file, or to no heading of it."""
    for link in re.findall(r"\]\(([^)\s]+)\)", without_code(text)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists() or (anchor and anchor not in heading_anchors(target)):
            yield f"{name(page)} links to {link}"


@pytest.mark.parametrize("page", EVERY_PAGE, ids=name)
def test_links_lead_somewhere(page: Path) -> None:
    assert not list(broken_links(page.read_text(encoding="utf-8"), page))


def crooked_tables(text: str) -> Iterator[str]:
    """Rows that do not belong to a table, or have more or fewer cells than its head.

    A bar ends a cell, also inside code; ``\\|`` does not.
    """
    width = 0
    lines = without_code(text).splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if not line.startswith("|"):
            width = 0
            continue
        cells = len(re.findall(r"(?<!\\)\|", line)) - 1
        if width == 0 and not re.fullmatch(r"(\| *:?-+:? *)+\|", following):
            yield f"a row without a head: {line}"
        elif width and cells != width:
            yield f"{cells} cells in a table of {width}: {line}"
        width = width or cells


def test_lines_are_wrapped() -> None:
    lines = [(name(page), line) for page in EVERY_PAGE for line in prose(page).splitlines()]
    assert not [where for where, line in lines if len(line) > 140 and not line.startswith(("|", "<!--", "!["))]


@pytest.mark.parametrize("page", EVERY_PAGE, ids=name)
def test_tables_are_whole(page: Path) -> None:
    assert not list(crooked_tables(page.read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("| a | b |\n| --- | --- |\n| 1 | 2 |\n\n| 3 | 4 |\n", "a row without a head: | 3 | 4 |"),
        ("| `|q|` | b |\n| --- | --- |\n| 1 | 2 |\n", "2 cells in a table of 4: | --- | --- |"),
        ("| a | b |\n| --- | --- |\n| `|q|` | 2 |\n", "4 cells in a table of 2: | `|q|` | 2 |"),
    ],
)
def test_a_crooked_table_is_noticed(text: str, says: str) -> None:
    assert says in crooked_tables(text)
    assert not list(crooked_tables("| `\\|q\\|` | b |\n| --- | --- |\n| 1 | 2 |\n\ntext\n"))


def test_a_link_to_nowhere_is_noticed() -> None:
    page = ROOT / "examples" / "embedded" / "README.md"
    assert list(broken_links("[a](../../docs/flight_software.md#on-an-emulated-microcontroller)", page))
    assert list(broken_links("[a](nowhere.md)", page))
    assert not list(broken_links("[a](../../docs/flight_software.md#on-a-microcontroller)", page))


MAKE_TARGETS = set(re.findall(r"^([a-z][\w-]*):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
PRESETS = {p["name"] for p in json.loads((ROOT / "CMakePresets.json").read_text(encoding="utf-8"))["configurePresets"]}
CPP_TESTS = (ROOT / "tests" / "cpp" / "CMakeLists.txt").read_text(encoding="utf-8")
BUILD_FILES = "\n".join(p.read_text(encoding="utf-8") for p in sorted((ROOT / "benchmarks").rglob("CMakeLists.txt")))
CPP_TARGETS = {
    f"test_{folder.replace('/', '_')}_{test}"
    for folder, test in re.findall(r"^gyrostat_test\(([\w/]+) (\w+)", CPP_TESTS, re.MULTILINE)
}
FILES = {
    path.relative_to(ROOT).as_posix()
    for folder in (*FOLDERS, ".")
    for path in ((ROOT / folder).rglob("*") if folder != "." else ROOT.glob("*"))
    if path.is_file()
}
SOURCES_OF_TESTS = "\n".join(
    (ROOT / path).read_text(encoding="utf-8") for path in sorted(FILES) if re.match(r"tests/.*\.(cpp|hpp|txt)$", path)
)


def unknown_names(piece: str) -> Iterator[str]:
    """Make targets, presets, test programs, tests and files that a piece of code names and that are not there."""
    yield from _unknown_targets(piece)
    yield from _unknown_files(piece)


def _unknown_targets(piece: str) -> Iterator[str]:
    for target in re.findall(r"^(?:[\w=]+ )?make ([a-z][\w-]*)", piece):
        if target not in MAKE_TARGETS:
            yield f"make target '{target}'"
    for preset in re.findall(r"--preset (\w[\w-]*)", piece):
        if preset not in PRESETS:
            yield f"preset '{preset}'"
    for target in re.findall(r"cmake .*--target (\w+)", piece):
        if target not in CPP_TARGETS and not re.search(rf"\b{target}\b", BUILD_FILES):
            yield f"target '{target}'"


def _unknown_files(piece: str) -> Iterator[str]:
    """``my_...`` is the reader's own."""
    for path in re.findall(rf"(?<![\w/.<>@*-])((?:{'|'.join(FOLDERS)})/[\w./-]+\.\w+)", piece):
        if path not in FILES and "my_" not in path:
            yield f"file '{path}'"
    for file in re.findall(r"(?<![\w/])((?:[\w]+/)*test_\w+(?:\.\w+)?)", piece):
        endings = (f"/{file}",) if "." in file else (f"/{file}.cpp", f"/{file}.py")
        known = file.rpartition("/")[2] in CPP_TARGETS or any(f"/{f}".endswith(endings) for f in FILES)
        if not known and "my_" not in file:
            yield f"test '{file}'"


@pytest.mark.parametrize("page", EVERY_PAGE, ids=name)
def test_named_targets_presets_tests_and_files_are_there(page: Path) -> None:
    assert not [missing for piece in code(page) for missing in unknown_names(piece)]


@pytest.mark.parametrize("page", EVERY_PAGE, ids=name)
def test_named_cpp_tests_are_there(page: Path) -> None:
    """``Suite.Test``, or a test's name alone; ``...`` stands for what is left out."""
    known = set(re.findall(r"TEST(?:_F|_P)?\((\w+), (\w+)\)", SOURCES_OF_TESTS))
    suites, tests = {suite for suite, _ in known}, {test for _, test in known}
    for piece in re.findall(r"`([^`\n]+)`", prose(page)):
        dotted = re.fullmatch(r"(?:\w+\.)?([A-Z]\w+)\.([A-Z]\w+)", piece)
        if dotted and dotted[1] in suites:
            assert (dotted[1], dotted[2]) in known, f"{name(page)} names {piece}"
        alone = re.fullmatch(r"(\.\.\.)?([A-Z][a-z]+(?:[A-Z0-9][a-z0-9]*){3,})(\.\.\.)?", piece)
        if alone and not _is_a_type(alone[2]):
            fits = re.compile(f"{'.*' if alone[1] else ''}{alone[2]}{'.*' if alone[3] else ''}")
            assert any(fits.fullmatch(test) for test in tests), f"{name(page)} names {piece}"


def _is_a_type(word: str) -> bool:
    return any(re.search(rf"(?:class|struct) {word}\b", (ROOT / f).read_text(encoding="utf-8")) for f in _HEADERS)


_HEADERS = [f for f in sorted(FILES) if f.startswith("cpp/") and f.endswith(".hpp")]


@pytest.mark.parametrize(
    "piece",
    [
        "make embeded",
        "cmake --preset debug",
        "cmake --build --preset dev --target test_flight_stack && build/dev/tests/cpp/test_flight_stack",
        "tests/cpp/flight/controllers/test_nominal_law.cpp",
        "docs/law.md",
        "test_nothing.py",
    ],
)
def test_a_name_of_nothing_is_noticed(piece: str) -> None:
    assert list(unknown_names(piece))


def test_subcommands_that_pages_name_are_there() -> None:
    known = {c.name or c.callback.__name__ for c in cli.app.registered_commands if c.callback}
    known |= {group.name for group in cli.app.registered_groups}
    for page in EVERY_PAGE:
        for piece in code(page):
            for command in re.findall(r"^(?:\$ )?gyrostat ([a-z]\w*)", piece):
                assert command in known, f"{name(page)} names gyrostat {command}"


def test_pages_and_tests_that_the_code_names_exist() -> None:
    for source in sorted(f for f in FILES if re.search(r"\.(cpp|hpp|h|c|py|pyi|toml|txt|cmake|in)$", f)):
        text = (ROOT / source).read_text(encoding="utf-8", errors="ignore")
        for named in re.findall(r"(?<![\w/])(?:docs/[\w/]+\.md|tests/[\w/]+\.(?:cpp|hpp|py|csv))", text):
            assert named in FILES or source == "tests/python/test_docs.py", f"{source} names {named}"


def test_the_figure_of_the_readme_shows_what_flies() -> None:
    flown = _load("docs/figures/wheel_lost.py").fly()
    with np.load(ROOT / "docs" / "figures" / "wheel_lost.npz") as saved:
        assert set(saved.files) == set(flown)
        for signal, values in flown.items():
            # 1e-2 of the largest value: nothing the eye could see; another compiler moves far less
            np.testing.assert_allclose(saved[signal], values, rtol=0, atol=1e-2 * np.abs(values).max(), err_msg=signal)
    late = flown["t"] > 60.0
    assert flown["plain_deg"][late].min() > 45.0
    assert flown["tolerant_deg"][late].max() < 0.01, "the wheel is lost and pointing is kept"


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "python") and p.parent.name != "tutorials"], ids=name)
def test_python_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of a page are one program."""
    monkeypatch.chdir(tmp_path)
    program = "\n".join(blocks(page, "python"))
    exec(compile(program, str(page), "exec"), {"__name__": "example"})


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "toml")], ids=name)
def test_toml_examples_are_valid(page: Path) -> None:
    """A whole scenario, a campaign and requirements stand alone; a part is put into a scenario that it fits."""
    for text in blocks(page, "toml"):
        tables = tomllib.loads(text)
        if "requirement" in tables:
            RequirementFile(**tables)
            continue
        if "base" in tables:
            gs.Campaign.from_dict(tables)
            continue
        whole = {"vehicle", "duration", "dt"} <= set(tables)
        if whole:
            gs.Scenario.from_dict(tables)
        else:
            put_somewhere(tables)


def put_somewhere(part: dict[str, Any]) -> None:
    """Into one of the vehicles that are there: parts of an orbit, of thrusters or of gyros need one that has them."""
    refused = []
    for case in ("ftc_4rw", "cubesat_6u", "twelve_thrusters", "agile_cmg"):
        try:
            gs.Scenario.from_dict(merged(gs.Scenario.load(case).to_dict(), part))
        except gs.InputError as error:
            refused.append(f"{case}: {error}")
        else:
            return
    pytest.fail("\n".join(refused))


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


def test_recovery_takes_the_slew_back_and_hardly_more() -> None:
    rows = csv.DictReader(
        line for line in (ROOT / "tests/golden/recovery.csv").read_text().splitlines() if not line.startswith("#")
    )
    for row in rows:
        # an observer that hands on has up to 0.15 of the command to unlearn in d_B, beside the effectiveness
        hands_on = any(p["name"] == "hand_on" for p in _core.describe(row["role"], row["component"])["params"])
        most = 1.15 if hands_on else 1.1
        assert int(row["slowest"]) <= most * int(row["slew"]) + 10, row["component"]
