# SPDX-License-Identifier: MIT
"""Figures with matplotlib. What is drawn is saved beside the picture; units stand on the axes, faults are marked."""

from __future__ import annotations

import io
import json
import warnings
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat import columns
from gyrostat.errors import InputError
from gyrostat.files import replacing
from gyrostat.text import printable
from gyrostat.thinning import min_max

if TYPE_CHECKING:
    from gyrostat.results import Result

COLORS = ("#0b6bcb", "#d9480f", "#2b8a3e", "#7048e8", "#c2255c", "#495057")
NO_SIGNAL = "level"
"""Of lines that are a limit or an instant."""
_max_drawn = 4000
"""Points drawn a line; longer signals are drawn by the smallest and largest value of each stretch."""


class Figure:
    """Panels over a common axis, of time unless said otherwise, which remembers what it draws.

    Parameters
    ----------
    title
        Above the panels.
    rows
        Number of panels.
    size
        Width and height, inches.
    along, unit
        Name and unit of the common axis.

    Examples
    --------
    >>> figure = Figure("Wheel 2 at 40 %", rows=2)
    >>> figure.line(0, result.t, result["error.angle"], "pointing error", "rad", log=True)
    >>> figure.mark([(30.0, "fault")])
    >>> figure.save("pointing.png")
    """

    def __init__(
        self,
        title: str,
        rows: int = 1,
        size: tuple[float, float] | None = None,
        *,
        along: str = "time",
        unit: str = "s",
    ) -> None:
        from matplotlib.figure import Figure as Canvas

        self.canvas = Canvas(figsize=size or (8.0, 1.0 + 1.9 * rows), layout="constrained")
        self.axes = self.canvas.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
        self.data: dict[str, NDArray[np.float64]] = {}
        self.units: dict[str, str] = {}
        self.levels: list[tuple[int, float, str]] = []
        """Panel, value and label of every horizontal line."""
        self.marks: list[tuple[float, str]] = []
        """Instants that are marked, with their labels."""
        self.canvas.suptitle(title, fontsize=11)
        self._clock, self._unit = ("t" if along == "time" else along), unit
        self.axes[-1].set_xlabel(f"{along} ({unit})" if unit else along)
        for axis in self.axes:
            axis.grid(visible=True, color="#e3e6ea", linewidth=0.6)
            axis.set_axisbelow(True)
            for side in ("top", "right"):
                axis.spines[side].set_visible(False)

    def line(
        self,
        row: int,
        t: ArrayLike,
        x: ArrayLike,
        name: str,
        unit: str = "",
        *,
        labels: Sequence[str] = (),
        log: bool = False,
        style: str = "-",
        color: str | None = None,
    ) -> None:
        """Draw a signal, one line a column.

        Parameters
        ----------
        row
            Panel, from 0.
        t, x
            Instants, s, or points of the common axis, shape (n,); signal, shape (n,) or (n, k).
        name, unit
            Name and unit for the axis (the first signal of a panel names it) and the saved data.
        labels
            Of the columns, for the legend.
        log
            Draw ``|x|`` on a logarithmic axis.
        style
            Line style of matplotlib; lines that are not solid take the colours of the first ones again.
        color
            Of all columns, instead of those.
        """
        times, values = np.asarray(t, dtype=float), np.asarray(x, dtype=float)
        self._remember(name, times, values, unit)
        axis = self.axes[row]
        columns = values.reshape(len(values), -1)
        for i, column in enumerate(columns.T):
            shown = np.where(column == 0.0, np.nan, np.abs(column)) if log else column
            usual = COLORS[(len(axis.lines) if style == "-" else i) % len(COLORS)]
            label = labels[i] if i < len(labels) else name if columns.shape[1] == 1 else f"{i}"
            axis.plot(*thin(times, shown), style, color=color or usual, linewidth=1.1, label=label)
        if log:
            axis.set_yscale("log")
        if not axis.get_ylabel():
            axis.set_ylabel(f"{name} ({unit})" if unit else name, fontsize=9)
        if len(axis.lines) > 1:
            axis.legend(loc="best", fontsize=8, frameon=False, ncols=2)

    def level(self, row: int, value: float, label: str) -> None:
        """Draw a horizontal line: a limit, a published number."""
        axis = self.axes[row]
        self.levels.append((row, value, label))
        axis.axhline(value, color="#868e96", linewidth=0.9, linestyle="--", gid=NO_SIGNAL)
        axis.annotate(
            label,
            (1.0, value),
            xycoords=("axes fraction", "data"),
            fontsize=7,
            color="#868e96",
            ha="right",
            va="bottom",
        )

    def mark(self, instants: Iterable[tuple[float, str]]) -> None:
        """Mark instants through all panels, with a label in the first."""
        for t, label in instants:
            self.marks.append((t, label))
            for axis in self.axes:
                axis.axvline(t, color="#e03131", linewidth=0.9, linestyle=":", gid=NO_SIGNAL)
            self.axes[0].annotate(
                label, (t, 1.0), xycoords=("data", "axes fraction"), fontsize=7, color="#e03131", ha="left", va="bottom"
            )

    def window(self, t0: float, t1: float) -> None:
        """Show a part of the time axis."""
        self.axes[-1].set_xlim(t0, t1)

    def save(self, path: str | Path) -> Path:
        """Write the picture (``.png``, ``.svg``, ``.pdf``) and, beside it, the data behind it (``.npz``).

        Returns
        -------
        Path
            The picture.

        Raises
        ------
        InputError
            An ending that is no picture's, a file that cannot be written, or one beside it that holds other data.
        """
        target, known = Path(path), set(self.canvas.canvas.get_supported_filetypes()) - {"pgf", "raw", "rgba"}
        if target.suffix[1:].lower() not in known:
            raise InputError(f"{path}: a figure is saved as one of: {', '.join(sorted(known))}")
        beside = target.with_suffix(".npz")
        if not _holds_figure(beside):
            raise InputError(f"{path}: {beside.name} is there and is no figure's data; choose another name")
        with replacing(target) as picture, replacing(beside) as data, _quiet():
            self.canvas.savefig(picture, dpi=130, metadata={"Date": None} if target.suffix == ".svg" else None)
            self._write_data(data)
        return target

    def save_data(self, path: Path) -> None:
        """Write the data alone (``.npz``).

        Raises
        ------
        InputError
            A file that cannot be written, or that holds other data.
        """
        if not _holds_figure(path):
            raise InputError(f"{path}: is there and is no figure's data; choose another folder")
        with replacing(path) as data:
            self._write_data(data)

    def _write_data(self, path: Path) -> None:
        np.savez_compressed(path, units=np.array(json.dumps(self.units)), **self.data)  # type: ignore[arg-type]

    def _repr_png_(self) -> bytes:
        """What a notebook shows."""
        picture = io.BytesIO()
        with _quiet():
            self.canvas.savefig(picture, format="png", dpi=100)
        return picture.getvalue()

    def _remember(self, name: str, t: NDArray[np.float64], x: NDArray[np.float64], unit: str) -> None:
        """Keep the full signal; equal instants are kept once."""
        key = name.replace("/", " per ")
        number = 2
        while key in self.data:
            key = f"{name} {number}"
            number += 1
        base = self._clock
        same = [k for k, v in self.data.items() if k.startswith(base) and np.array_equal(v, t)]
        clock = same[0] if same else base if base not in self.data else f"{base} of {key}"
        self.data.setdefault(clock, t)
        self.data[key] = x
        self.units |= {key: unit, clock: self._unit}


@contextmanager
def _quiet() -> Iterator[None]:
    """Without warnings of letters that the font has not: they are drawn as a box."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)
        yield


def _holds_figure(path: Path) -> bool:
    """Whether the data of a figure may take this place: nothing is there, or those of another figure."""
    try:
        with zipfile.ZipFile(path) as archive:
            return "units.npy" in archive.namelist()
    except OSError:  # not there; or what keeps it from being written is said by who writes
        return True
    except (ValueError, zipfile.BadZipFile):
        return False


def _plain(text: str) -> str:
    """A text as matplotlib shows it as it is: one line, dollars without mathematics."""
    line = printable(text)
    return (line if len(line) <= 120 else f"{line[:117]}...").replace("$", r"\$")


def thin(t: NDArray[np.float64], x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Few points that draw the same picture."""
    kept = min_max(x, 2 * len(t) // _max_drawn)
    return t[kept], x[kept]


def fault_marks(result: Result) -> list[tuple[float, str]]:
    """Onset and name of every fault of a run that starts after t = 0, one mark an instant."""
    marks: dict[float, list[str]] = {}
    for fault in result.known_faults:
        onset = float(fault.get("t_on", 0.0))
        if 0.0 < onset <= result.end_time:
            marks.setdefault(onset, []).append(f"{fault['type'].replace('_', ' ')}, actuator {fault['actuator']}")
    return [(t, "; ".join(names)) for t, names in sorted(marks.items())]


def overview(result: Result) -> Figure:
    """Pointing error, body rate, commands and effectiveness of a run, of what was recorded."""
    unit = "N m; magnetorquers A m^2" if result.description["vehicle"].get("magnetorquers") else "N m"
    panels = [
        ("error.angle", "pointing error", "deg", (), True),
        ("truth.omega_BN_B", "body rate", "rad/s", ("x", "y", "z"), False),
        ("allocation.u", "command", unit, (), False),
        ("truth.effectiveness", "effectiveness", "", (), False),
    ]
    shown = [p for p in panels if p[0] in result.channels]
    figure = Figure(_title(result), rows=max(len(shown), 1))
    for row, (channel, title, unit, labels, log) in enumerate(shown):
        x = np.degrees(result[channel]) if unit == "deg" else result[channel]
        columns = labels or tuple(f"actuator {i}" for i in range(x.shape[1] if x.ndim > 1 else 1))
        figure.line(row, result.t, x, title, unit, labels=columns if x.ndim > 1 else (), log=log)
    estimate = result.channels.get("estimate.effectiveness", np.ones(1))
    if "truth.effectiveness" in result.channels and np.any(estimate != 1.0):  # all 1: nobody estimates it
        labels = tuple(f"estimate {i}" for i in range(estimate.shape[1]))
        figure.line(len(shown) - 1, result.t, estimate, "estimate", labels=labels, style="--")
    figure.mark(fault_marks(result))
    return figure


def channels(result: Result, names: Sequence[str]) -> Figure:
    """Channels of a run by name, a panel each; angles and angular rates as they are recorded, in radians."""
    full = [result.full_name(name) for name in names]
    figure = Figure(_title(result), rows=len(full))
    for row, name in enumerate(full):
        x, dimension = result[name], str(result.meta.get(name, {}).get("dimension", ""))
        named = [str(label) for label in columns.labels(dimension, x.shape[1])] if x.ndim > 1 else []
        prefix = "actuator " if dimension == "actuator" else ""
        figure.line(row, result.t, x, name, result.unit(name), labels=[prefix + label for label in named])
    figure.mark(fault_marks(result))
    return figure


def _title(result: Result) -> str:
    return _plain(str(result.description.get("name") or result.description.get("description") or "run"))
