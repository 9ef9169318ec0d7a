# SPDX-License-Identifier: MIT
"""A `gyrostat.plots.Figure` as data that a page draws itself: lines that can be zoomed, read and hidden.

``assets/figure.js`` draws it.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D

from gyrostat.page.packing import pack
from gyrostat.plots import COLORS, NO_SIGNAL, Figure
from gyrostat.thinning import min_max

POINTS = 4000
"""Of a figure, about; longer lines are thinned and keep their peaks."""

_hues = {color: i for i, color in enumerate(COLORS[:5])}
_grey = 7


def picture(figure: Figure) -> dict[str, Any]:
    """What a page needs to draw a figure: panels over a common axis.

    Raises
    ------
    ValueError
        Nothing is drawn in it.
    """
    lines = [[line for line in axis.lines if line.get_gid() != NO_SIGNAL] for axis in figure.axes]
    share = POINTS // max(sum(map(len, lines)), 1)
    panels = [_panel(axis, drawn, share) for axis, drawn in zip(figure.axes, lines, strict=True)]
    if not any(panel["lines"] for panel in panels):
        raise ValueError(f"figure '{figure.canvas.get_suptitle()}': nothing is drawn")
    for row, value, label in figure.levels:
        panels[row]["levels"].append([value, label])
    across = figure.axes[-1]
    chosen = None if across.get_autoscalex_on() else list(map(float, across.get_xlim()))
    return {
        "title": figure.canvas.get_suptitle(),
        "x": {"title": across.get_xlabel(), "log": across.get_xscale() == "log", "range": chosen},
        "panels": panels,
        "marks": [[t, label] for t, label in figure.marks],
    }


def script(name: str, figure: Figure) -> str:
    """A file that a page loads when the figure of that name comes into view; it works without a server."""
    data = json.dumps(picture(figure), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return f"gyrostat.draw({json.dumps(name)},{data});\n"


def height(panels: int) -> int:
    """Of the picture of a figure with so many panels, in pixels, about: kept free until it is drawn."""
    return 335 if panels == 1 else 162 * panels + 25


def _panel(axis: Axes, lines: list[Line2D], share: int) -> dict[str, Any]:
    chosen = None if axis.get_autoscaley_on() else list(map(float, axis.get_ylim()))
    drawn = [_line(line, share, log=axis.get_yscale() == "log") for line in lines]
    return {
        "title": axis.get_ylabel(),
        "log": axis.get_yscale() == "log",
        "range": chosen,
        "lines": [line for line in drawn if line],
        "levels": [],
    }


def _line(line: Line2D, share: int, *, log: bool) -> dict[str, Any]:
    x, y = (np.asarray(values, dtype=float) for values in (line.get_xdata(), line.get_ydata()))
    if log:
        y = np.where(y > 0.0, y, np.nan)
    if not np.isfinite(y).any():
        return {}
    kept = min_max(y, -(-2 * len(y) // max(share, 2)) if len(y) > share else 1)
    label, color, style = str(line.get_label()), to_hex(line.get_color()), line.get_linestyle()
    return {
        "name": "" if label.startswith("_") else label,
        "hue": _hues.get(color, _grey),
        "dash": style in ("--", ":", "-."),
        "dots": str(line.get_marker()) not in ("None", "", " "),
        "bare": style in ("None", "", " "),
        "x": pack(x[kept]),
        "y": pack(y[kept]),
    }


__all__ = ["POINTS", "height", "picture", "script"]
