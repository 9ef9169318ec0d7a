# SPDX-License-Identifier: MIT
"""The page of ``gyrostat check``: torques within reach as a solid, margins as bars, figures of the design checks."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat._core import __version__
from gyrostat.allocation import AttainableSet
from gyrostat.design import attainable_after_faults
from gyrostat.design.finding import Finding
from gyrostat.files import writable_folder, write_text
from gyrostat.page.picture import height, script
from gyrostat.page.tables import table
from gyrostat.page.writer import GENERATOR, asset, filled, page_path
from gyrostat.plots import Figure
from gyrostat.scenario import Scenario

_verdicts = {True: ("good", "ok"), False: ("bad", "fails"), None: ("none", "to know")}


def write_check_page(
    path: str | Path,
    scenario: Scenario,
    checks: Sequence[Mapping[str, Any]],
    findings: Sequence[Finding],
    figures: Mapping[str, Figure],
    *,
    torque_B: Sequence[float] | None = None,
) -> Path:
    """Write what a check of a scenario found as a page.

    Parameters
    ----------
    path
        A folder for ``index.html``, or a file that ends in ``.html``.
    scenario
        What was checked.
    checks
        `Scenario.check`.
    findings
        `gyrostat.design.findings`.
    figures
        By name.
    torque_B
        (3,) N m, a demand to draw.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        Something else is there, or nothing can be written.
    """
    target = page_path(path)
    parts = [
        ("torque", "Torque within reach", _solid(scenario, torque_B)),
        ("margins", "Margins", _bars(findings)),
        ("figures", "Figures", _figures(figures)),
        ("findings", "Everything that was looked at", _table(checks, findings, scenario.remarks())),
        ("scenario", "Scenario", f"<pre>{escape(scenario.to_toml())}</pre>"),
    ]
    body = "\n".join(f'<section id="{id_}"><h2>{title}</h2>{text}</section>' for id_, title, text in parts if text)
    drawn = "\n".join(script(name, figure) for name, figure in figures.items())
    text = filled(
        asset("plain.html"),
        {
            "generator": f"{GENERATOR} {__version__}",
            "version": escape(__version__),
            "title": escape(scenario.name or "Checked"),
            "description": escape(scenario.description or "What can be said before it flies."),
            "style": "".join(asset(f"{name}.css") for name in ("page", "plain", "figure", "check")),
            "chips": _chips(checks, findings),
            "blocks": body,
            "script": "".join(asset(f"{name}.js") for name in ("theme", "figure", "solid")) + drawn + asset("plain.js"),
        },
    )
    writable_folder(target.parent)
    write_text(target, text)
    return target


def _chips(checks: Sequence[Mapping[str, Any]], findings: Sequence[Finding]) -> str:
    verdicts = [bool(r["ok"]) for r in checks] + [f.ok for f in findings if f.ok is not None]
    failed = sum(not ok for ok in verdicts)
    chips = [("bad", str(failed), "fail")] if failed else []
    chips.append(("" if failed else "good", f"{len(verdicts) - failed} of {len(verdicts)}", "conditions hold"))
    return "".join(f'<span class="chip {c}"><b>{n}</b> {w}</span>' for c, n, w in chips)


def _bars(findings: Sequence[Finding]) -> str:
    """A bar a number that has a limit: from zero to the number, with a mark at the limit."""
    bars = "".join(_bar(f) for f in findings if _has_limit(f))
    return f'<div id="bars">{bars}</div>' if bars else ""


def _has_limit(f: Finding) -> bool:
    return all(x is not None and np.isfinite(x) for x in (f.value, f.limit)) and f.value != f.limit


def _bar(f: Finding) -> str:
    assert f.value is not None  # only these have a bar
    assert f.limit is not None
    low, high = min(0.0, f.value, f.limit), max(0.0, f.value, f.limit)
    color, word = _verdicts[f.ok]

    def at(x: float) -> float:
        return 100.0 * (x - low) / (high - low)

    start, end = sorted((at(0.0), at(f.value)))
    return (
        f'<div class="margin {color}" title="{escape(f.text)}"><span class="what">{escape(f.where)} '
        f"<b>{escape(f.name)}</b></span>"
        f'<span class="track"><i class="{color}" style="left:{start:.4g}%;width:{end - start:.4g}%"></i>'
        f'<u style="left:{at(f.limit):.4g}%"></u></span>'
        f'<span class="value"><b>{f.value:.4g}</b> limit {f.limit:.4g}</span><span class="word">{word}</span></div>'
    )


def _solid(scenario: Scenario, torque_B: Sequence[float] | None) -> str:
    """The attainable set healthy and after the faults; nothing where a limit is infinite."""
    sets = attainable_after_faults(scenario.standing())
    if sets is None:
        return ""
    healthy, left = sets
    same = np.array_equal(healthy.generators, left.generators) and np.array_equal(healthy.centre, left.centre)
    named = {"healthy": healthy} if same else {"healthy": healthy, "after the faults": left}
    hues = {"healthy": 0 if same else 7, "after the faults": 0}
    data = {
        "sets": [_set(name, one, hues[name]) for name, one in named.items()],
        "demand": None if torque_B is None else list(torque_B),
    }
    axes = {
        f"{sign}{axis}": (1.0 if sign == "+" else -1.0) * np.eye(3)[k] for k, axis in enumerate("xyz") for sign in "+−"
    }
    rows = [[f"along {name}", *(_torque(one.radius(v)) for one in named.values())] for name, v in axes.items()]
    rows.insert(0, ["in every direction (ring)", *(_torque(one.in_every_direction) for one in named.values())])
    rows.append(["volume", *(f"{one.volume:.4g} (N m)³" for one in named.values())])
    keys = "".join(f'<span><i style="background:var(--hue{hues[name]})"></i>{name}</span>' for name in named)
    note = (
        "All torques that commands inside their limits produce, N m in body axes: healthy as glass, and when the "
        "faults leave it least, filled. The ring is the torque to be had in every direction. Drag to turn, double "
        "click to go back."
    )
    json_ = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return (
        f'<div id="torques"><div><div class="keys">{keys}</div><div id="solid"></div><p class="dim">{note}</p></div>'
        f"<div>{table(('torque', *named), rows)}</div></div>"
        f'<script type="application/json" id="solid-data">{json_}</script>'
    )


def _torque(value: Any) -> str:
    return f"{float(np.nan_to_num(value)):.4g} N m"


def _set(name: str, one: AttainableSet, hue: int) -> dict[str, Any]:
    """Faces that are polygons; of a flat set, its two sides."""
    faces = [(face, normal) for face, normal in zip(one.faces(), one.normals, strict=True) if len(face) > 2]
    return {
        "name": name,
        "hue": hue,
        "ball": max(one.in_every_direction, 0.0),
        "faces": [[[round(float(x), 9) for x in corner] for corner in face] for face, _ in faces],
        "normals": [[round(float(x), 9) for x in normal] for _, normal in faces],
    }


def _figures(figures: Mapping[str, Figure]) -> str:
    drawn = "".join(
        f'<figure data-name="{escape(name)}"><figcaption>{escape(figure.canvas.get_suptitle())} '
        f'<a href="{escape(name)}.png">picture</a> <a href="{escape(name)}.npz">data</a> <span class="at dim"></span>'
        f'</figcaption><div class="drawing" style="min-height:{height(len(figure.axes))}px"></div></figure>'
        for name, figure in figures.items()
    )
    return f'<div class="figures">{drawn}</div>' if drawn else ""


def _table(checks: Sequence[Mapping[str, Any]], findings: Sequence[Finding], remarks: Sequence[str]) -> str:
    rows: list[tuple[str, str, bool | None, str]] = [(r["where"], r["name"], bool(r["ok"]), _said(r)) for r in checks]
    rows += [(f.where, f.name, f.ok, f.text) for f in findings]
    rows += [("scenario", "remark", None, text) for text in remarks]
    cells = "".join(
        f'<tr class="{_verdicts[ok][0]}"><td>{escape(where)}</td><td>{escape(name)}</td>'
        f'<td><span class="tag {_verdicts[ok][0]}">{_verdicts[ok][1]}</span></td>'
        f'<td class="text">{escape(text)}</td></tr>'
        for where, name, ok, text in rows
    )
    head = "".join(f"<th>{name}</th>" for name in ("of", "what", "", "found"))
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{cells}</tbody></table></div>'


def _said(row: Mapping[str, Any]) -> str:
    if row["ok"]:
        return "parameters fit vehicle and period"
    return f"{row['code']}: {row['quantity']} = {row['value']:g}, must be {row['relation']} {row['limit']:g}"


__all__ = ["write_check_page"]
