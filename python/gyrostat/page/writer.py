# SPDX-License-Identifier: MIT
"""Writes a page: one HTML file that needs no network, and plotly's script beside it or in it."""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import webbrowser
from collections.abc import Mapping
from functools import cache
from html import escape
from importlib.metadata import version
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from gyrostat._core import __version__
from gyrostat.errors import InputError
from gyrostat.files import replacing, writable_folder, write_text
from gyrostat.page import panels, tables
from gyrostat.page.content import Content, content
from gyrostat.results import Result

MOST_RUNS = 40
"""Runs that one page lays over each other."""

GENERATOR = "gyrostat page"
"""By which a page is known as ours."""
_scripts = ("theme.js", "data.js", "body.js", "panels.js", "player.js")


def write_page(
    path: str | Path, runs: Result | Mapping[str, Result], *, title: str = "", single_file: bool = False
) -> Path:
    """Write a page that re-plays a run, or lays several over each other.

    Parameters
    ----------
    path
        A file that ends in ``.html``, or a folder for ``index.html``.
    runs
        A run, or several by the name that they have on the page.
    title
        Heading; the scenario's name if not given.
    single_file
        Put plotly's script (5 MB) into the page instead of beside it.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        Nothing to draw was recorded, too many runs, or a place where something else is or nothing can be written.
    """
    target = page_path(path)
    named = {"": runs} if isinstance(runs, Result) else dict(runs)
    text = _page(named, title, single_file=single_file)
    writable_folder(target.parent)
    if not single_file:
        script = target.parent / _script_name()
        if not script.exists() or script.stat().st_size != len(_plotly()):
            with replacing(script) as temporary:
                temporary.write_bytes(_plotly())
    write_text(target, text)
    return target


def page_path(path: str | Path) -> Path:
    """The file of a page; whoever has a file of that name that is no page of ours keeps it.

    Raises
    ------
    InputError
        Something else is there.
    """
    given = Path(path)
    target = given if given.suffix in (".html", ".htm") else given / "index.html"
    if target.is_dir():
        raise InputError(f"{target}: is a folder")
    if target.exists():
        with target.open(encoding="utf-8", errors="replace") as file:
            start = file.read(2000)
        if f'content="{GENERATOR}' not in start:
            raise InputError(f"{target}: is there already and is not a page of gyrostat; choose another folder")
    return target


def show(runs: Result | Mapping[str, Result]) -> Path:
    """Open a page in the browser; where there is none, print where it is.

    Returns
    -------
    Path
        The page, in a new folder for temporary files.
    """
    page = write_page(Path(tempfile.mkdtemp(prefix="gyrostat-")), runs)
    if not (_has_display() and _opened(page)):
        print(page)
    return page


def _has_display() -> bool:
    """Whether a window can open: a browser of text in the terminal would take it over."""
    return sys.platform in ("win32", "darwin") or any(os.environ.get(k) for k in ("DISPLAY", "WAYLAND_DISPLAY"))


def _opened(page: Path) -> bool:
    try:
        return webbrowser.open(page.resolve().as_uri())
    except webbrowser.Error:
        return False


def _page(runs: Mapping[str, Result], title: str, *, single_file: bool) -> str:
    if not runs:
        raise InputError("a page needs at least one run")
    if len(runs) > MOST_RUNS:
        raise InputError(f"a page shows at most {MOST_RUNS} runs, not {len(runs)}")
    made = content(runs)
    results = list(runs.values())
    if not made.data["panels"] and not any("truth.q_NB" in r.channels for r in results):
        wanted = ", ".join(["truth.q_NB", *panels.missing(results)])
        raise InputError(f"nothing that a page shows was recorded; record some of: {wanted}")
    first = results[0]
    alone = len(results) == 1
    name = title or (str(first.description.get("name") or "run") if alone else "Runs compared")
    about = str(first.description.get("description", "")) if alone else "A colour a run; click a name to hide it."
    script = "\n".join(asset(part) for part in _scripts).replace("{{plotly_file}}", _script_name())
    data = json.dumps(made.data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    plotly = f"<script>{_plotly().decode()}</script>" if single_file else f'<script src="{_script_name()}"></script>'
    return filled(
        asset("page.html"),
        {
            "generator": f"{GENERATOR} {__version__}",
            "version": escape(__version__),
            "title": escape(name),
            "description": escape(about),
            "style": asset("page.css"),
            "chips": tables.chips(first) if alone else "",
            "tables": tables.of_run(first) if alone else tables.of_runs(runs),
            "data_note": escape(_said(made, results)),
            "notes": _notes(results),
            "data": data,
            "plotly": plotly,
            "script": script,
        },
    )


def _said(made: Content, results: list[Result]) -> str:
    """How much of the runs the page holds."""
    samples = max(len(r) for r in results)
    lines = (
        f"Lines are drawn from every one of {samples} samples."
        if made.stretch < 2
        else f"Lines are thinned: of every {made.stretch} of {samples} samples the smallest and the largest are drawn."
    )
    body = "" if made.frames >= samples else f" The body has {made.frames} attitudes and turns evenly between them."
    return f"{lines}{body} All values have seven digits; the saved result has all."


def _notes(results: list[Result]) -> str:
    """What is not drawn, and what to record for it."""
    absent = panels.missing(results) | (
        {} if all("truth.q_NB" in r.channels for r in results) else {"truth.q_NB": "body"}
    )
    if not absent:
        return ""
    said = ", ".join(f"<code>{escape(channel)}</code> ({what})" for channel, what in absent.items())
    whose = "" if len(results) == 1 else " of every run"
    return f'<p class="dim" id="missing">Not recorded{whose}: {said}. Name them in <code>[record] channels</code>.</p>'


def filled(template: str, values: Mapping[str, str]) -> str:
    """A template with its ``{{names}}`` filled in."""
    return re.sub(r"\{\{(\w+)\}\}", lambda found: values[found[1]], template)


def asset(name: str) -> str:
    """The text of a file of ``assets``."""
    return (files("gyrostat.page") / "assets" / name).read_text(encoding="utf-8")


def _script_name() -> str:
    return f"plotly-{version('plotly')}.min.js"


@cache
def _plotly() -> bytes:
    """The script of plotly; its Python side stays unloaded."""
    found = find_spec("plotly")
    if found is None or found.origin is None:
        raise InputError("a page needs plotly, which is not installed: pip install plotly")
    return (Path(found.origin).parent / "package_data" / "plotly.min.js").read_bytes()
