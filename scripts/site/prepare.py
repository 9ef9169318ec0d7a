# SPDX-License-Identifier: MIT
"""prepare.py FOLDER: FOLDER/pages and FOLDER/mkdocs.yml, the site as plain Markdown before a generator dresses it.

- Links of pages in docs/ may lead to any file of the repository. On the site such a file is a page under ``source/``.
- Formulas ``$...$`` become MathML here: nothing is fetched or computed by the reader's browser.
- ``reference/python`` comes from docstrings and stubs, ``reference/cpp`` from the comments of the headers.
- In the navigation a folder stands for its pages, and "*" for pages of docs/ that no other entry names.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cpp_reference import cpp_pages
from python_reference import python_pages

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
SHOWN = (".md", ".png", ".svg")
"""Endings of what is copied from docs/."""
ELSEWHERE = ("package.md",)
"""Pages of docs/ that the site leaves out: what a package index shows."""
LANGUAGES = {".cpp": "cpp", ".hpp": "cpp", ".py": "python", ".toml": "toml", ".c": "c", ".h": "c"}
_link = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")
_code = re.compile(r"(^(`{3,}).*?^\2`*$|`[^`\n]+`|^    .*?$)", re.DOTALL | re.MULTILINE)
_inline_at_line_start = re.compile(r"(?:(?<=[^\n])(\n)|^)(?=<math[^>]*display=\"inline\")", re.MULTILINE)
"""Markdown takes a line that begins so for a block of its own, and ends the paragraph before it."""
_formula = re.compile(r"\$\$(.+?)\$\$|(?<![\\$\w])\$(?! )([^$\n]+?)(?<! )\$(?!\w)", re.DOTALL)


def main(folder: Path) -> None:
    """Write everything anew."""
    shutil.rmtree(folder / "pages", ignore_errors=True)
    pages = {p.relative_to(DOCS).as_posix(): (p, p.read_text(encoding="utf-8")) for p in sorted(DOCS.rglob("*.md"))}
    pages = {name: page for name, page in pages.items() if name not in ELSEWHERE}
    pages |= {_source_page(p): (p, _shown(p)) for p in sorted(_linked_outside())}
    texts = {name: _with_math(_led(text, path, name)) for name, (path, text) in pages.items()}
    texts |= {**python_pages(), **cpp_pages(ROOT)}
    for name, text in texts.items():
        _write(folder / "pages" / name, text)
    for picture in sorted(p for p in DOCS.rglob("*") if p.suffix in SHOWN[1:]):
        target = folder / "pages" / picture.relative_to(DOCS)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(picture, target)
    shutil.copytree(Path(__file__).parent / "assets", folder / "pages" / "assets")
    (folder / "mkdocs.yml").write_text(_settings(list(texts)), encoding="utf-8")


def _settings(pages: list[str]) -> str:
    """The settings with the whole navigation."""
    import yaml

    text = (Path(__file__).parent / "mkdocs.yml").read_text(encoding="utf-8")
    head, _, nav = text.partition("\nnav:\n")
    entries = yaml.safe_load(f"nav:\n{nav}")["nav"]
    named = {entry for entry in _entries(entries) if not entry.endswith("/")}
    whole = [_expanded(entry, pages, named) for entry in entries]
    left = set(pages) - set(_entries(whole)) - {p for p in pages if p.startswith("source/")}
    if left:
        raise SystemExit(f"pages without a place in the navigation: {', '.join(sorted(left))}")
    return f"{head}\nnav: {json.dumps(whole)}\n"


def _entries(nav: Any) -> Iterator[str]:
    if isinstance(nav, str):
        yield nav
    for inner in nav.values() if isinstance(nav, dict) else nav if isinstance(nav, list) else ():
        yield from _entries(inner)


def _expanded(entry: Any, pages: list[str], named: set[str]) -> Any:
    if isinstance(entry, dict):
        return {title: _expanded(inner, pages, named) for title, inner in entry.items()}
    if isinstance(entry, list):
        return [part for inner in entry for part in _parts(inner, pages, named)]
    return _folder(entry, pages, named) if entry.endswith("/") else entry


def _parts(entry: Any, pages: list[str], named: set[str]) -> list[Any]:
    if entry == "*":
        return [p for p in pages if "/" not in p and p not in named]
    whole = _expanded(entry, pages, named)
    return whole if isinstance(whole, list) else [whole]


def _folder(folder: str, pages: list[str], named: set[str]) -> list[Any]:
    """Its pages, then its folders, each a section."""
    inside = [p.removeprefix(folder) for p in pages if p.startswith(folder) and p not in named]
    deeper = sorted({p.partition("/")[0] for p in inside if "/" in p})
    return [folder + p for p in inside if "/" not in p] + [{d: _folder(f"{folder}{d}/", pages, named)} for d in deeper]


def _led(text: str, path: Path, name: str) -> str:
    """Links of a page as they must read on the site."""

    def led(match: re.Match[str]) -> str:
        link, _, anchor = match[0].partition("#")
        target = Path(os.path.normpath(path.parent / link))
        if not link or re.match(r"[a-z]+:", link) or not target.is_file() or not target.is_relative_to(ROOT):
            return match[0]
        shown = target.is_relative_to(DOCS) and target.suffix in SHOWN
        page = target.relative_to(DOCS).as_posix() if shown else _source_page(target)
        return Path(os.path.relpath(page, Path(name).parent)).as_posix() + (f"#{anchor}" if anchor else "")

    return _outside_code(text, lambda part: _link.sub(led, part))


def _with_math(text: str) -> str:
    if not _formula.search(text):
        return text
    from latex2mathml.converter import convert

    def converted(match: re.Match[str]) -> str:
        mathml = convert((match[1] or match[2]).strip(), display="block" if match[1] else "inline")
        return str(mathml).replace("*", "&#42;").replace("_", "&#95;")

    done = _outside_code(text, lambda part: _formula.sub(converted, part))
    return _inline_at_line_start.sub(lambda match: " " if match[1] else "\u200b", done)


def _outside_code(text: str, change: Any) -> str:
    out, at = [], 0
    for piece in _code.finditer(text):
        out += [change(text[at : piece.start()]), piece[0]]
        at = piece.end()
    return "".join([*out, change(text[at:])])


def _linked_outside() -> set[Path]:
    """Files that pages link to and that are no pages or pictures of docs/; also what these link to."""
    found: set[Path] = {ROOT / "CHANGELOG.md"}
    waiting = [*DOCS.rglob("*.md"), *found]
    while waiting:
        page = waiting.pop()
        for link in _link.findall(page.read_text(encoding="utf-8")):
            path = link.partition("#")[0]
            target = Path(os.path.normpath(page.parent / path))
            if not path or not target.is_file() or not target.is_relative_to(ROOT) or target in found:
                continue
            if not (target.is_relative_to(DOCS) and target.suffix in SHOWN):
                found.add(target)
                waiting += [target] if target.suffix == ".md" else []
    return found


def _source_page(path: Path) -> str:
    name = path.relative_to(ROOT).as_posix()
    return f"source/{name}" if path.suffix == ".md" else f"source/{name}.md"


def _shown(path: Path) -> str:
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        return text
    name = path.relative_to(ROOT).as_posix()
    head = f"---\ntitle: {name}\nsearch:\n  exclude: true\nhide: [navigation, toc]\n---\n\n# `{name}`\n\n"
    return f"{head}``````{LANGUAGES.get(path.suffix, 'text')}\n{text.rstrip()}\n``````\n"


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
