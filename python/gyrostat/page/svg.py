# SPDX-License-Identifier: MIT
"""Figures as SVG text in the colours of the page, light or dark: lines, bands, bars and limits over two axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

POINTS = 300
"""Of a line, at most."""
_left, _right, _top, _bottom = 56, 12, 10, 40


@dataclass(frozen=True)
class Axis:
    """A stretch of numbers, straight or logarithmic.

    Attributes
    ----------
    low, high
        Its ends, ``low < high``; positive where logarithmic.
    title
        Name and unit.
    log
        Whether it is logarithmic.
    """

    low: float
    high: float
    title: str
    log: bool = False

    @classmethod
    def over(cls, values: ArrayLike, title: str) -> Axis:
        """Over finite values, some of them at least; logarithmic where they are positive and span two decades."""
        x = np.asarray(values, dtype=float)
        x = x[np.isfinite(x)]
        low, high = (float(x.min()), float(x.max())) if x.size else (0.0, 1.0)
        log = low > 0.0 and high / low > 100.0
        if low == high:
            low, high = low - max(abs(low), 1e-12) * 0.05, high + max(abs(high), 1e-12) * 0.05
        return cls(low, high, title, log)

    def place(self, x: ArrayLike) -> Array:
        """From 0 at the lower end to 1; what lies outside stays outside."""
        at = np.asarray(x, dtype=float)
        if not self.log:
            return np.asarray((at - self.low) / (self.high - self.low))
        logs = np.log(np.maximum(at, 1e-300))
        return np.asarray((logs - math.log(self.low)) / math.log(self.high / self.low))

    def ticks(self) -> list[float]:
        """Some round numbers between its ends."""
        if self.log:
            first, last = math.ceil(math.log10(self.low) - 1e-9), math.floor(math.log10(self.high) + 1e-9)
            step = max(1, -(-(last - first) // 6))
            return [10.0**k for k in range(first, last + 1, step)]
        raw = (self.high - self.low) / 6
        size = 10.0 ** math.floor(math.log10(raw))
        step_ = next(s * size for s in (1, 2, 5, 10) if s * size >= raw * (1 - 1e-9))
        first = math.ceil(self.low / step_ - 1e-9)
        return [k * step_ for k in range(first, math.floor(self.high / step_ + 1e-9) + 1)]


class Plot:
    """Two axes and what is drawn over them.

    Parameters
    ----------
    x, y
        The axes.
    size
        Width and height in units of the picture, which grows with the page.
    """

    def __init__(self, x: Axis, y: Axis, size: tuple[int, int] = (640, 270)) -> None:
        self._x, self._y, self._size = x, y, size
        self._drawn: list[str] = []

    def line(self, x: ArrayLike, y: ArrayLike, hue: int, *, step: bool = False) -> None:
        """A line of a colour of the palette; with `step` each value holds to the next point."""
        at = self._points(x, y)
        if step and len(at) > 1:
            at = np.concatenate(
                [np.stack([at[:-1], np.column_stack([at[1:, 0], at[:-1, 1]])], axis=1).reshape(-1, 2), at[-1:]]
            )
        if len(at):
            self._drawn.append(f'<polyline class="line" stroke="var(--hue{hue % 8})" points="{_pairs(at)}"/>')

    def band(self, x: ArrayLike, low: ArrayLike, high: ArrayLike, hue: int) -> None:
        """The stretch between two lines."""
        there, back = self._points(x, low), self._points(x, high)[::-1]
        points = _pairs(np.concatenate([there, back]))
        self._drawn.append(f'<polygon class="band" fill="var(--hue{hue % 8})" fill-opacity=".15" points="{points}"/>')

    def bars(self, edges: ArrayLike, heights: ArrayLike, low: ArrayLike, high: ArrayLike, hue: int) -> None:
        """Bars between edges, shape (k + 1,), each with its interval."""
        x, base = self._px(edges), float(self._py(max(self._y.low, 0.0)))
        tops = (self._py(heights), self._py(low), self._py(high))
        for a, b, top, bottom, upper in zip(x[:-1], x[1:], *tops, strict=True):
            self._drawn.append(
                f'<rect class="column" fill="var(--hue{hue % 8})" fill-opacity=".55" x="{a + 0.5:.1f}" y="{top:.1f}" '
                f'width="{max(b - a - 1, 0.5):.1f}" height="{max(base - top, 0):.1f}"/>'
                f'<path class="axis" style="stroke:var(--dim)" d="M{(a + b) / 2:.1f} {bottom:.1f}V{upper:.1f}"/>'
            )

    def level(self, *, x: float | None = None, y: float | None = None, label: str = "") -> None:
        """A limit, where it lies within the axes."""
        width, height = self._size
        if x is not None and 0.0 <= float(self._x.place(x)) <= 1.0:
            at = float(self._px(x))
            self._drawn.append(f'<path class="level" d="M{at:.1f} {_top}V{height - _bottom}"/>')
            anchor, text = ("start", at + 4) if at < 0.7 * width else ("end", at - 4)
            self._drawn.append(
                f'<text text-anchor="{anchor}" x="{text:.1f}" y="{height - _bottom - 6}">{escape(label)}</text>'
            )
        if y is not None and 0.0 <= float(self._y.place(y)) <= 1.0:
            at = float(self._py(y))
            self._drawn.append(f'<path class="level" d="M{_left} {at:.1f}H{width - _right}"/>')
            self._drawn.append(
                f'<text text-anchor="end" x="{width - _right - 2}" y="{at - 4:.1f}">{escape(label)}</text>'
            )

    def text(self) -> str:
        """The picture."""
        width, height = self._size
        parts = [f'<svg viewBox="0 0 {width} {height}" role="img">']
        for x in self._x.ticks():
            at = float(self._px(x))
            parts.append(f'<path class="grid" d="M{at:.1f} {_top}V{height - _bottom}"/>')
            parts.append(f'<text text-anchor="middle" x="{at:.1f}" y="{height - _bottom + 14}">{_short(x)}</text>')
        for y in self._y.ticks():
            at = float(self._py(y))
            parts.append(f'<path class="grid" d="M{_left} {at:.1f}H{width - _right}"/>')
            parts.append(f'<text text-anchor="end" x="{_left - 5}" y="{at + 4:.1f}">{_short(y)}</text>')
        middle = (_left + width - _right) / 2
        parts.append(f'<text text-anchor="middle" x="{middle:.0f}" y="{height - 8}">{escape(self._x.title)}</text>')
        across = (_top + height - _bottom) / 2
        parts.append(
            f'<text text-anchor="middle" transform="translate(12 {across:.0f}) rotate(-90)">'
            f"{escape(self._y.title)}</text>"
        )
        return "".join([*parts, *self._drawn, "</svg>"])

    def _points(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Pixels of finite points, thinned evenly, clipped to the frame."""
        at = np.column_stack([np.asarray(x, float), np.asarray(y, float)])
        at = at[np.isfinite(at).all(axis=1)]
        if len(at) > POINTS:
            at = at[np.unique(np.linspace(0, len(at) - 1, POINTS).round().astype(int))]
        return np.column_stack([self._px(at[:, 0]), self._py(at[:, 1])])

    def _px(self, x: ArrayLike) -> Array:
        return np.asarray(_left + np.clip(self._x.place(x), 0.0, 1.0) * (self._size[0] - _left - _right))

    def _py(self, y: ArrayLike) -> Array:
        height = self._size[1] - _top - _bottom
        return np.asarray(_top + (1.0 - np.clip(self._y.place(y), 0.0, 1.0)) * height)


def _pairs(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _short(x: float) -> str:
    if abs(x) < 1e-12:
        return "0"
    return f"{x:g}" if 1e-3 <= abs(x) < 1e5 else f"{x:.0e}".replace("e-0", "e-").replace("e+0", "e")


def keys(names: Sequence[str]) -> str:
    """The colours of lines, by name."""
    spans = (f'<span><i style="background:var(--hue{i % 8})"></i>{escape(name)}</span>' for i, name in enumerate(names))
    return f'<div class="keys">{"".join(spans)}</div>'


__all__ = ["Axis", "Plot", "keys"]
