# SPDX-License-Identifier: MIT
"""What a notebook shows of a scenario, a run, its metrics, a component and a reproduction: small tables of HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gyrostat.components import Component
    from gyrostat.metrics import Metrics
    from gyrostat.papers.reproduction import Reproduction
    from gyrostat.results import Result
    from gyrostat.scenario import Scenario
    from gyrostat.shelf import Shelf

_longest = 80
"""Characters of a value."""
_most_claims = 40
"""Claims of a reproduction that are listed one by one, the ones outside their interval first."""


def scenario(shown: Scenario) -> str:
    """Name, vehicle, stack, faults: what differs from the defaults."""
    tables = shown.to_dict()
    name, description = tables.pop("name", ""), tables.pop("description", "")
    rows = []
    for key, value in tables.items():
        several = isinstance(value, list) and all(isinstance(v, dict) for v in value)
        for i, one in enumerate(value if several else [value]):
            rows.append((f"{key}.{i}" if several else key, _text(one)))
    return _block(f"Scenario {name}".rstrip(), description, table(("", ""), rows))


def result(shown: Result) -> str:
    """How the run went, its metrics, and its channels on demand."""
    from gyrostat.page.tables import chips

    rows = [
        (name, "x".join(map(str, x.shape[1:])) or "1", shown.unit(name), _meaning(shown, name))
        for name, x in shown.channels.items()
    ]
    channels = table(("channel", "columns", "unit", "meaning"), rows)
    events = table(
        ("t (s)", "event", "count", "of"), [(f"{e.t:.6g}", e.name, str(e.count), e.what) for e in shown.events[:100]]
    )
    name = str(shown.description.get("name") or "")
    return _block(
        f"Result {name}".rstrip(),
        "",
        f"<p>{chips(shown).replace('</span><span', '</span> · <span')}</p>",
        _folded("metrics", metrics(shown.metrics), opened=True),
        _folded(f"{len(rows)} channels", channels),
        _folded(f"{len(shown.events)} events", events) if shown.events else "",
    )


def metrics(shown: Metrics) -> str:
    """One row a metric; a dash where there is none."""
    from gyrostat.metrics import UNITS
    from gyrostat.page.tables import shown as value_text

    return table(
        ("metric", "value"),
        [(name.replace("_", " "), value_text(v, UNITS[name])) for name, v in shown.to_dict().items()],
    )


def component(shown: Component) -> str:
    """The type and the parameters that were given."""
    rows = [(key, _text(value)) for key, value in shown.to_dict().items() if key != "type"]
    return _block(shown.type, "", table(("parameter", "value"), rows))


def reproduction(shown: Reproduction) -> str:
    """How many claims hold, then the claims, those outside their interval first."""
    claims = sorted(shown.evaluations, key=lambda e: e.ok)
    rows = [
        (
            "ok" if e.ok else "outside",
            e.claim.id,
            e.claim.quantity,
            "" if e.claim.published is None else str(e.claim.published),
            "–" if e.measured is None else f"{e.measured:.4g}",
            e.verdict,
        )
        for e in claims
    ]
    more = f"{len(rows) - _most_claims} more, all as they must be" if len(rows) > _most_claims else ""
    head = f"{shown.paper.id}: {len(rows) - shown.failed} of {len(rows)} claims measured where they must be"
    return _block(
        head,
        "",
        table(
            ("", "claim", "quantity", "published", "measured", "the publication"),
            rows[: max(_most_claims, shown.failed)],
        ),
        f"<p>{escape(more)}</p>" if more else "",
    )


def shelf(shown: Shelf) -> str:
    """Names and descriptions of what is shipped."""
    return table(("scenario", ""), [(name, shown.about(name)) for name in shown])


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of text."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _block(title: str, text: str, *parts: str) -> str:
    about = f"<p>{escape(text)}</p>" if text else ""
    return f"<div><b>{escape(title)}</b>{about}{''.join(parts)}</div>"


def _folded(title: str, body: str, *, opened: bool = False) -> str:
    state = ' open=""' if opened else ""
    return f"<details{state}><summary>{escape(title)}</summary>{body}</details>"


def _meaning(shown: Result, name: str) -> str:
    return str(shown.meta.get(name, {}).get("meaning", ""))


def _number(value: Any) -> str:
    """Lists and numbers, of which four digits are enough to recognise them."""
    if isinstance(value, list):
        return f"[{', '.join(map(_number, value))}]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _text(value: Any) -> str:
    """A value in one line; a component leads with its type."""
    from gyrostat.text import printable

    if isinstance(value, dict):
        parts = [str(value["type"])] if "type" in value else []
        parts += [f"{k} = {_text(v)}" for k, v in value.items() if k != "type"]
        return printable(", ".join(parts))
    if not isinstance(value, bool | int | float | str | list):
        return f"{type(value).__name__}, a Python object"
    line = printable(_number(value))
    return line if len(line) <= _longest else f"{line[: _longest - 3]}..."
