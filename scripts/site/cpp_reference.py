# SPDX-License-Identifier: MIT
"""Pages of the C++ reference: Doxygen reads the comments of the headers that a user includes, this writes Markdown."""

from __future__ import annotations

import re
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

LAYERS = {
    "core": (
        "Vocabulary of all layers; needs Eigen.",
        ["signals", "types", "params", "set_parameter", "concepts", "attitude", "power"],
    ),
    "flight": (
        "What flies; `find_package(gyrostat COMPONENTS flight)`.",
        ["stack", "facade", "inputs", "axes", "navigation"],
    ),
    "host": (
        "Simulation and catalogue; `find_package(gyrostat COMPONENTS host)`.",
        ["value", "catalogue", "simulate", "experiment", "metrics"],
    ),
}


def cpp_pages(root: Path) -> dict[str, str]:
    """Text of each page by its place."""
    pages, index = (
        {},
        ["# C++", "", "Every header can be included alone; a component is described on [its page](../components.md)."],
    )
    with tempfile.TemporaryDirectory() as folder:
        xml = _doxygen(root, Path(folder))
        for layer, (about, names) in LAYERS.items():
            index += ["", f"## gyrostat::{layer}", "", about, ""]
            for name in names:
                header = _file(xml, f"gyrostat/{layer}/{name}.hpp")
                pages[f"reference/cpp/{layer}_{name}.md"] = _page(xml, header, f"gyrostat/{layer}/{name}.hpp")
                index.append(f"- [`gyrostat/{layer}/{name}.hpp`]({layer}_{name}.md): {_first(header)}")
    pages["reference/cpp/index.md"] = "\n".join(index) + "\n"
    return pages


def _doxygen(root: Path, folder: Path) -> Path:
    headers = " ".join(
        str(root / f"cpp/{layer}/gyrostat/{layer}/{n}.hpp") for layer, (_, names) in LAYERS.items() for n in names
    )
    settings = f"""
        INPUT = {headers}
        OUTPUT_DIRECTORY = {folder}
        STRIP_FROM_PATH = {" ".join(str(root / "cpp" / layer) for layer in LAYERS)}
        FULL_PATH_NAMES = YES
        GENERATE_HTML = NO
        GENERATE_LATEX = NO
        GENERATE_XML = YES
        XML_PROGRAMLISTING = NO
        EXTRACT_ALL = YES
        JAVADOC_AUTOBRIEF = YES
        AUTOLINK_SUPPORT = NO
        QUIET = YES
        WARNINGS = NO
        INPUT_FILTER = "sed -e 's#^/// @file  #/// @file\\n/// #' -e 's#<S>`#\\&lt;S\\&gt;`#'"
    """
    try:
        subprocess.run(["doxygen", "-"], input=settings, text=True, check=True, capture_output=True)
    except FileNotFoundError:
        raise SystemExit("the C++ reference needs doxygen: apt-get install doxygen") from None
    return folder / "xml"


def _file(xml: Path, name: str) -> ET.Element:
    for path in xml.glob("*_8hpp.xml"):
        found = ET.parse(path).getroot().find("compounddef")
        location = None if found is None else found.find("location")
        if found is not None and location is not None and location.get("file", "").endswith(name):
            return found
    raise SystemExit(f"doxygen says nothing of {name}")


def _page(xml: Path, header: ET.Element, name: str) -> str:
    lines = [f"# {name.rpartition('/')[2]}", "", "```cpp", f'#include "{name}"', "```", "", *_text(header), ""]
    for inner in header.findall("innerclass") + header.findall("innerconcept"):
        if "detail" in (inner.text or ""):
            continue
        compound = ET.parse(xml / f"{inner.get('refid')}.xml").getroot().find("compounddef")
        if compound is not None and compound.get("prot", "public") == "public":
            lines += list(_class(compound))
    free = [m for s in header.findall("sectiondef") for m in s.findall("memberdef")]
    for namespace in header.findall("innernamespace"):
        if "detail" in (namespace.text or ""):
            continue
        whole = ET.parse(xml / f"{namespace.get('refid')}.xml").getroot()
        members = [m for m in whole.iter("memberdef") if (m.find("location").get("file") or "").endswith(name)]  # type: ignore[union-attr]
        free += members
    seen: set[str] = set()
    unique = [m for m in free if not (m.get("id", "") in seen or seen.add(m.get("id", "")))]  # type: ignore[func-returns-value]
    lines += list(_members(unique, level=2))
    return "\n".join(lines) + "\n"


def _class(compound: ET.Element) -> Iterator[str]:
    name = (compound.findtext("compoundname") or "").removeprefix("gyrostat::")
    yield from (f"## {compound.get('kind')} {name}", "", *_text(compound), "")
    if compound.get("kind") == "concept":
        yield from ("```cpp", (compound.findtext("initializer") or "").strip(), "```", "")
    members = [m for s in compound.findall("sectiondef") for m in s.findall("memberdef") if m.get("prot") == "public"]
    yield from _members(members, level=3)


def _members(members: list[ET.Element], *, level: int) -> Iterator[str]:
    """Variables and enumerations as tables, functions one by one."""
    variables = [m for m in members if m.get("kind") in ("variable", "typedef")]
    if variables:
        yield from ("| name | is | meaning |", "| --- | --- | --- |")
        yield from (f"| `{m.findtext('name')}` | {_code(_type(m))} | {_cell(m)} |" for m in variables)
        yield ""
    for m in members:
        if m.get("kind") == "enum":
            yield from (
                f"{'#' * level} enum {m.findtext('name')}",
                "",
                *_text(m),
                "",
                "| value | meaning |",
                "| --- | --- |",
            )
            yield from (f"| `{v.findtext('name')}` | {_cell(v)} |" for v in m.findall("enumvalue"))
            yield ""
    for m in members:
        if m.get("kind") == "function" and not (m.findtext("name") or "").startswith(("~", "operator=")):
            described = list(_text(m))
            yield from ("```cpp", _signature(m), "```", "", *described, *([""] if described else []))


def _type(member: ET.Element) -> str:
    """Of a variable its type, of a name for a type what it stands for."""
    kind = "".join(t.itertext()) if (t := member.find("type")) is not None else ""
    if member.get("kind") == "typedef":
        return _close((member.findtext("definition") or kind).partition(" = ")[2] or kind)
    return _close(kind + (member.findtext("argsstring") or ""))


def _close(code: str) -> str:
    """``Mat3<S>& D`` as people write it, not ``Mat3< S > & D``."""
    closed = re.sub(r"\s+(?=[>&*])", "", code.removeprefix("typedef ").replace("< ", "<"))
    return re.sub(r"(?<=[\w>])([&*])(?=\w)", r"\1 ", closed).strip()


def _signature(member: ET.Element) -> str:
    template = member.find("templateparamlist")
    head = ""
    if template is not None:
        params = [
            " ".join(filter(None, ("".join(p.find("type").itertext()), p.findtext("declname"))))
            for p in template.findall("param")
        ]  # type: ignore[union-attr]
        head = f"template <{', '.join(params)}>\n"
    kind = "".join(member.find("type").itertext()) if member.find("type") is not None else ""  # type: ignore[union-attr]
    text = f"{kind} {member.findtext('name')}{member.findtext('argsstring') or ''}"
    return head + _close(text)


def _first(element: ET.Element) -> str:
    return "".join(_text(element)[:1])


def _cell(element: ET.Element) -> str:
    return " ".join(_text(element)).replace("|", "\\|").replace("\n", " ")


def _code(text: str) -> str:
    return f"`{text}`".replace("|", "\\|") if text.strip() else ""


def _text(element: ET.Element) -> list[str]:
    """Brief and detailed description as Markdown, a blank line between paragraphs."""
    paragraphs = _paragraphs(element.find("briefdescription")) + _paragraphs(element.find("detaileddescription"))
    text = re.sub(r"Page: docs/(\S+?)\.md", r"Page: [\1](../../\1.md)", "\n\n".join(paragraphs).replace("\\_", "_"))
    return text.splitlines()


def _paragraphs(description: ET.Element | None) -> list[str]:
    return [] if description is None else [t for para in description.findall("para") for t in _blocks(para)]


def _blocks(para: ET.Element) -> Iterator[str]:
    """Text, verbatim blocks and lists of a paragraph, in their order."""
    text = para.text or ""
    for inner in para:
        if inner.tag in ("verbatim", "preformatted", "programlisting"):
            yield from filter(None, [_tidy(text)])
            text = ""
            block = (
                "\n".join("".join(line.itertext()) for line in inner.findall("codeline"))
                if inner.tag == "programlisting"
                else "".join(inner.itertext())
            )
            yield f"```text\n{block.strip(chr(10))}\n```"
        elif inner.tag in ("itemizedlist", "orderedlist"):
            yield from filter(None, [_tidy(text)])
            text = ""
            yield "\n".join(
                "- " + " ".join(" ".join(_blocks(p)) for p in item.findall("para"))
                for item in inner.findall("listitem")
            )
        elif inner.tag == "computeroutput":
            text += f"`{''.join(inner.itertext())}`"
        elif inner.tag == "parameterlist":
            yield from filter(None, [_tidy(text)])
            text = ""
            yield "\n".join(
                f"- `{'`, `'.join(n.text or '' for n in item.iter('parametername'))}`: "
                + " ".join(" ".join(_blocks(p)) for p in item.find("parameterdescription").findall("para"))  # type: ignore[union-attr]
                for item in inner.findall("parameteritem")
            )
        elif inner.tag == "simplesect":
            yield from filter(None, [_tidy(text)])
            text = ""
            yield f"*{inner.get('kind')}*: " + " ".join(" ".join(_blocks(p)) for p in inner.findall("para"))
        else:
            text += "".join(inner.itertext())
        text += inner.tail or ""
    yield from filter(None, [_tidy(text)])


def _tidy(text: str) -> str:
    """One line; what Markdown would take for more than text is escaped."""
    spans = re.split(r"(`[^`]*`)", re.sub(r"\s+", " ", text).strip())
    return "".join(s if s.startswith("`") else re.sub(r"([*_<\[])", r"\\\1", s) for s in spans)
