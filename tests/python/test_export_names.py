# SPDX-License-Identifier: MIT
"""What a scenario's author wrote goes into exported code as text: no name of a scenario changes what is compiled."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gyrostat as gs
from gyrostat.export import FlightCode, c, cpp, export, fmu, places
from gyrostat.export.compiler import find_compiler, find_eigen
from gyrostat.export.model import flight_code

HOSTILE = (
    'x\n#error INJECTED\n//\r#error INJECTED */ #include "/etc/passwd" /* \\\n#error INJECTED ??/\n#error INJECTED\\',
    "*/ #error INJECTED /*/ #error INJECTED //* \u2028#error INJECTED \x0b#error INJECTED \x85#error INJECTED",
    '"; #error INJECTED \u202e\u2066 R"( @name@ @title@ ${CMAKE_COMMAND} `x` ``` <script> [a](b) & \ufeff\x00\ufffe',
    "x\\",
    "x??/",
    "`",
)
_any_text = st.text(
    st.one_of(st.characters(exclude_categories=["Cs"]), st.sampled_from("*/\\?\"'`\n\r\u2028#@"))
).filter(lambda text: text != "")


@pytest.fixture(scope="module")
def code() -> FlightCode:
    return flight_code(gs.Scenario.load("ftc_4rw").replace(duration=0.02), scalar="double", samples=0, name="plain")


def tokens(text: str) -> str:
    """Code without comments, by the translation phases of C: trigraphs, spliced lines, comments."""
    spliced = re.sub(r"\\[ \t]*(\r\n|[\n\r])", "", text.replace("??/", "\\"))
    parts = re.findall(r'//[^\n\r]*|/\*.*?\*/|"(?:[^"\\\n\r]|\\.)*"|.', spliced, re.DOTALL)
    return "".join(" " if part.startswith(("//", "/*")) else part for part in parts)


def written(code: FlightCode, folder: Path, write: Callable[[FlightCode, Path], None]) -> dict[str, str]:
    write(code, folder)
    return {p.name: p.read_text() for p in folder.iterdir() if p.suffix in (".h", ".hpp", ".c", ".cpp", ".md")}


@pytest.fixture(scope="module")
def neutral(code: FlightCode, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return written(replace(code, title="neutral"), tmp_path_factory.mktemp("neutral"), c.write)


@settings(max_examples=25)
@given(title=_any_text)
def test_no_title_is_more_than_a_comment(
    code: FlightCode, neutral: dict[str, str], title: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    named = written(replace(code, title=title), tmp_path_factory.mktemp("named"), c.write)
    assert set(named) == set(neutral)
    for name, text in named.items():
        if name == "README.md":
            assert text.splitlines()[1:] == neutral[name].splitlines()[1:]
        else:
            assert tokens(text) == tokens(neutral[name]), name


@given(text=_any_text)
def test_places_leave_one_line_that_does_nothing(text: str) -> None:
    for place in (places.comment, places.markdown, places.xml):
        assert place(text).isprintable()
        assert place("wheel 2 at 40 %, α = 0.4 (a.b)").strip("`") == "wheel 2 at 40 %, α = 0.4 (a.b)"
    assert tokens(f"/* {places.comment(text)} */x // {places.comment(text)}\ny") == " x  \ny"
    span = places.markdown(text)
    fence = re.match("`+", span)
    assert fence is not None
    assert span.endswith(fence[0])
    assert fence[0] not in span.strip("`")
    ET.fromstring(f"<a>{ET.tostring(ET.Element('b', c=places.xml(text)), encoding='unicode')}</a>")


@given(description=_any_text)
def test_a_unit_describes_itself_in_well_formed_xml(
    code: FlightCode, description: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "modelDescription.xml"
    told = replace(code, scenario=code.scenario.replace(description=description))
    fmu._write_description(told, path, [], "{guid}")
    assert ET.parse(path).getroot().get("description") == places.xml(description)


@given(title=_any_text)
def test_a_title_makes_an_identifier_whatever_it_is(title: str) -> None:
    assert places.identifier(places.identifier_of(title)) == places.identifier_of(title)


@pytest.mark.parametrize(
    "word", ["flight", "wheel2_degraded", "safe_mode", "Aocs", "torque", "adcs", "mode64", "control"]
)
def test_an_ordinary_name_is_taken_as_it_is(word: str) -> None:
    assert places.identifier(word) == word


_words = (
    "export friend true constexpr noexcept xor not NULL EOF errno linux unix interface typeof co_await nullptr "
    "INFINITY sin sinf strtod_l size_t div_t pthread_mutex mtx index y0 std gyrostat math stdint Time test main "
    "measurement measurement_q_NB S"
)


@pytest.mark.parametrize("word", [*_words.split(), "a__b", "a_", "_a", "2a", "ä", "a b", "", "a" * 64, "a\n"])
def test_a_name_that_means_something_else_is_refused(word: str) -> None:
    with pytest.raises(gs.InputError, match=r"^name '"):
        places.identifier(word)


def compiled(command: Sequence[str], source: str) -> str:
    """What the compiler says of a text; "" when it takes it."""
    done = subprocess.run([*command, "-fsyntax-only", "-"], input=source, capture_output=True, text=True, check=False)
    assert (done.returncode == 0) == (done.stderr == ""), done.stderr
    return done.stderr


C_COMPILER = shlex.split(os.environ.get("CC", "cc"))
C_HEADERS = (
    "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdbool "
    "stddef stdint stdio stdlib string tgmath threads time wchar wctype"
)


@pytest.mark.parametrize("title", HOSTILE)
def test_a_hostile_title_compiles_without_a_warning(code: FlightCode, title: str, tmp_path: Path) -> None:
    c.write(replace(code, title=title), tmp_path)
    # -trigraphs: as C99 reads it
    options = ["-std=c99", "-trigraphs", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{tmp_path}", "-xc"]
    assert compiled([*C_COMPILER, *options], '#include "self_test.c"') == ""


def words_of(command: Sequence[str], source: str) -> list[str]:
    """Every word and macro that the compiler meets in what a text includes, as far as a stack may be called that."""
    done = subprocess.run([*command, "-E", "-dD", "-"], input=source, capture_output=True, text=True, check=True)
    words = set(re.findall(r"\b[A-Za-z]\w*", re.sub(r'"(?:[^"\\\n]|\\.)*"', "", done.stdout)))
    found = []
    for word in sorted(words):
        try:
            found.append(places.identifier(word))
        except gs.InputError:
            continue
    return found


def test_every_accepted_word_can_name_a_type_in_c() -> None:
    everything = "".join(f"#include <{header}.h>\n" for header in C_HEADERS.split())
    command = [*C_COMPILER, "-std=gnu17", "-w", "-xc"]
    types = [f"typedef struct {{ int a; }} {word};\n" for word in words_of(command, everything)]
    assert compiled(command, everything + "".join(types)) == ""


def test_every_accepted_word_can_name_a_namespace_beside_a_hostile_title(code: FlightCode, tmp_path: Path) -> None:
    cpp.write(replace(code, title="".join(HOSTILE)), tmp_path)
    include = ["-isystem", str(find_eigen()), f"-I{tmp_path}", f"-I{tmp_path / 'include'}"]
    command = [*find_compiler(), "-std=gnu++20", "-Wall", "-Wextra", "-Werror", *include, "-xc++"]
    test = '#include "self_test.cpp"\n'
    words = words_of(command, test)
    assert len(words) > 1000, "of the standard library alone"
    assert compiled(command, test + "".join(f"namespace {word} {{}}\n" for word in words)) == ""


def test_the_name_of_a_scenario_names_the_files(tmp_path: Path) -> None:
    scenario = gs.Scenario.load("ftc_4rw").replace(duration=0.02, name=HOSTILE[0])
    assert export(scenario, "cpp", tmp_path / "out").name == places.identifier_of(HOSTILE[0])
    assert "INJECTED" in (tmp_path / "out" / "README.md").read_text().splitlines()[0]
