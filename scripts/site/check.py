# SPDX-License-Identifier: MIT
"""check.py SITE: every link and anchor of the built site leads somewhere, and nothing is fetched from elsewhere."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote


class _Page(HTMLParser):
    """Anchors, links and what a browser would load."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = {key: value or "" for key, value in attrs}
        self.anchors |= {named[key] for key in ("id", "name") if key in named}
        if tag == "a" and "href" in named:
            self.links.append(named["href"])
        if tag in ("script", "img", "iframe", "source") and "src" in named:
            self.loaded.append(named["src"])
        if tag == "link" and named.get("rel") in ("stylesheet", "icon", "preload", "preconnect"):
            self.loaded.append(named["href"])


def trouble(site: Path) -> Iterator[str]:
    """What is wrong, a line each."""
    pages = {p: _Page(p.read_text(encoding="utf-8")) for p in sorted(site.rglob("*.html"))}
    if not pages:
        yield f"{site} holds no page"
    for path, page in pages.items():
        here = path.relative_to(site)
        if here.name == "404.html":
            continue
        for link in page.loaded:
            if re.match(r"(\w+:)?//", link):
                yield f"{here} fetches {link}"
        for link in page.links + page.loaded:
            if re.match(r"\w+:", link) or link.startswith("//"):
                continue
            file, _, anchor = unquote(link).partition("#")
            target = Path(os.path.normpath(path.parent / file.partition("?")[0])) if file else path
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                yield f"{here} links to {link}, which is not there"
            elif anchor and target in pages and anchor not in pages[target].anchors:
                yield f"{here} links to {link}, which has no such anchor"


if __name__ == "__main__":
    found = list(trouble(Path(sys.argv[1])))
    print(*found, sep="\n")
    sys.exit(1 if found else 0)
