# SPDX-License-Identifier: MIT
"""Figures of the cao2023 study: the published ones (1-14), then what explains them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gyrostat import metrics
from gyrostat.design.learning_disturbance import LearningGains, region_figure, response_figure
from gyrostat.papers import PaperFigure
from gyrostat.papers.cao2023 import signals
from gyrostat.plots import Figure
from gyrostat.results import Result

Array = NDArray[np.float64]
Results = Mapping[str, Result]
Signal = Callable[[Result], Array]

_axes = ("roll", "pitch", "yaw")
_gains = LearningGains(M=18.0, k1=0.98, k2=15.0, k3=5.0, Tc=0.01)
_period = 0.001


def _channel(name: str) -> Signal:
    return lambda result: result[name]


def _estimate(number: int, case: str, title: str) -> PaperFigure:
    """The fault and its estimate, an axis a panel."""

    def draw(results: Results) -> Figure:
        result = results[case]
        figure = Figure(f"Fig. {number}: lumped acceleration and its estimate, {title}", rows=3)
        f, f_hat = signals.fault(result), result["observer.f_hat"]
        for i, axis in enumerate(_axes):
            figure.axes[i].set_ylabel(f"{axis} (rad/s²)", fontsize=9)
            figure.line(i, result.t, f[:, i], f"f, {axis}", labels=["f"])
            figure.line(i, result.t, f_hat[:, i], f"fhat, {axis}", labels=["estimate"])
        figure.window(0, 15)
        return figure

    return PaperFigure(f"fig{number}", f"Fig. {number}. Lumped acceleration f and its estimate, {title}.", [case], draw)


def _error(number: int, case: str, quantity: tuple[str, str], signal: Signal, title: str) -> PaperFigure:
    """An error of the observer, linear and on a logarithmic scale; `quantity` is its name and unit."""
    name, unit = quantity

    def draw(results: Results) -> Figure:
        result = results[case]
        figure = Figure(f"Fig. {number}: {name} ({unit}), {title}", rows=2)
        for row, log in enumerate((False, True)):
            figure.axes[row].set_ylabel(f"|{name}| ({unit})" if log else f"{name} ({unit})", fontsize=9)
            figure.line(row, result.t, signal(result), f"{name}{', logarithmic' if log else ''}", labels=_axes, log=log)
        figure.axes[1].set_ylim(bottom=1e-5)
        figure.window(0, 15)
        return figure

    return PaperFigure(f"fig{number}", f"Fig. {number}. {name} ({unit}), {title}.", [case], draw)


def _tracking(number: int, T: int, channel: str, name: str, unit: str) -> PaperFigure:
    """Tracking error: all of it, its size on a logarithmic scale, and the last seconds as the published inset."""

    def draw(results: Results) -> Figure:
        result = results[f"T{T}"]
        error = result[channel]
        figure = Figure(f"Fig. {number}: {name}, T = {T} s", rows=2)
        figure.line(0, result.t, error, name, unit, labels=_axes)
        figure.axes[1].set_ylabel(f"|{name}| ({unit})", fontsize=9)
        figure.line(1, result.t, error, f"{name}, logarithmic", labels=_axes, log=True)
        figure.axes[1].set_ylim(1e-7, 10)
        figure.mark([(float(T), f"T = {T} s")])
        figure.window(0, 15)
        return figure

    return PaperFigure(
        f"fig{number}",
        f"Fig. {number}. {name.capitalize()}, T = {T} s. The logarithmic panel shows what the published insets show.",
        [f"T{T}"],
        draw,
    )


def _response(_: Results) -> Figure:
    """Share of a sine that the estimate misses."""
    named = {
        "proposed (k2 = 15, k3 = 5)": _gains,
        "traditional, k2 = 20": replace(_gains, k2=20.0, k3=0.0),
        "traditional, k2 = 15": replace(_gains, k3=0.0),
    }
    return response_figure(named)


def _sampling(results: Results) -> Figure:
    """Stability of both forms against the period, and the late roll error that was measured."""
    figure = Figure("Period and form of the observer, learning interval 10 ms", rows=2, along="period", unit="ms")
    figure.axes[0].set_ylabel("spectral radius", fontsize=9)
    figure.axes[1].set_ylabel("late roll error (rad)", fontsize=9)
    for form, cases in _sampled.items():
        style = "o-" if form == "held" else "s--"
        periods = list(cases) if form == "held" else [10.0 / N for N in (20, 16, 12, 10, 8, 6, 5, 4, 3, 2)]
        radius = [_gains.spectral_radius(1e-3 * h, held=form == "held") for h in periods]
        figure.line(0, periods, radius, f"spectral radius, {form}", labels=[form], style=style)
        flown = [results[c] for c in cases.values()]
        late = [metrics.window_max(r.t, r["error.euler"][:, 0], 10.5, 15.0) for r in flown]
        figure.line(1, list(cases), late, f"late roll error, {form}", labels=[form], style=style)
    figure.level(0, 1.0, "stable below")
    figure.axes[1].set_ylim(2.1e-4, 2.2e-4)
    figure.axes[1].set_xscale("log")
    figure.axes[1].set_xticks(list(_sampled["held"]), [f"{h:g}" for h in _sampled["held"]], minor=False)
    figure.axes[1].set_xticks([], minor=True)
    return figure


def _sizes(title: str, cases: Mapping[str, str], rows: Sequence[tuple[str, Signal]]) -> Callable[[Results], Figure]:
    """Largest component of some signals, a case a line, on logarithmic scales."""

    def draw(results: Results) -> Figure:
        figure = Figure(title, rows=len(rows), size=(8.0, 1.2 + 2.4 * len(rows)))
        for row, (label, signal) in enumerate(rows):
            figure.axes[row].set_ylabel(label, fontsize=9)
            for case, name in cases.items():
                result = results[case]
                size = np.abs(signal(result)).max(axis=1)
                figure.line(row, result.t, size, f"{label}, {case}", labels=[name], log=True)
        return figure

    return draw


_sensor = {
    "T5": "healthy",
    "gyro_bias": "bias 1e-3 rad/s about x",
    "gyro_scale": "2 % too much",
    "gyro_freeze": "frozen for 0.1 s",
    "gyro_freeze_for_good": "frozen for good",
}
_limited = {
    "limited": "T = 2 s",
    "limited_short": "T = 1 s, kept",
    "limited_stretched": "T = 1 s, moves away",
}
_parts = {
    "T5": "proposed",
    "uncompensated": "no observer",
    "sign": "sign(s)",
    "k1_0p997": "k1 = 0.997",
}
_sampled = {
    "held": {0.5: "sampled_0p5ms", 1.0: "held_10ms", 2.0: "sampled_2ms", 5.0: "sampled_5ms", 10.0: "sampled_10ms"},
    "rolling": {0.5: "rolling_0p5ms", 1.0: "T10"},
}
_pitch = {"T10": "printed model", "rigid_T10": "rigid body"}


def _sensor_faults(results: Results) -> Figure:
    rows = [("|angle error| (rad)", _channel("error.euler")), ("|f - fhat| (rad/s²)", signals.estimation_error)]
    figure = _sizes("Faults of the rate sensor at 8 s, T = 5 s", _sensor, rows)(results)
    figure.axes[0].set_ylim(1e-5, 30)
    figure.axes[1].set_ylim(1e-3, 1e4)
    figure.mark([(8.0, "sensor fault")])
    figure.window(6, 13)
    return figure


def _input_limits(results: Results) -> Figure:
    figure = Figure("Commands limited to 8: the preassigned time moves away while they fall short", rows=3)
    figure.axes[0].set_ylabel("|angle error| (rad)", fontsize=9)
    figure.axes[1].set_ylabel("largest command", fontsize=9)
    figure.axes[2].set_ylabel("time left (s)", fontsize=9)
    for case, name in _limited.items():
        r = results[case]
        figure.line(0, r.t, np.abs(r["error.euler"]).max(axis=1), f"angle error, {case}", labels=[name], log=True)
        figure.line(1, r.t, np.abs(r["allocation.u"]).max(axis=1), f"command, {case}", labels=[name])
        figure.line(2, r.t, r["controller.T_left"], f"T left, {case}", labels=[name])
    figure.level(1, 8.0, "limit")
    figure.window(0, 6)
    return figure


def _singularity(results: Results) -> Figure:
    figure = Figure("T = 10 s: the path leads through pitch 90 deg", size=(8.0, 4.0))
    figure.axes[0].set_ylabel("pitch error (rad)", fontsize=9)
    for case, name in _pitch.items():
        result = results[case]
        figure.line(0, result.t, result["error.euler"][:, 1], f"pitch, {case}", labels=[name])
    figure.level(0, np.pi / 2, "90 deg")
    figure.mark([(results["rigid_T10"].end_time, "the body's run ends: singular")])
    return figure


FIGURES = [
    _estimate(1, "traditional", "traditional observer"),
    _estimate(2, "T10", "proposed observer"),
    _error(3, "traditional", ("f - fhat", "rad/s²"), signals.estimation_error, "traditional observer"),
    _error(4, "T10", ("f - fhat", "rad/s²"), signals.estimation_error, "proposed observer"),
    _error(5, "traditional", ("e", "rad/s"), _channel("observer.e"), "traditional observer"),
    _error(6, "T10", ("e", "rad/s"), _channel("observer.e"), "proposed observer"),
    _error(7, "interval_20ms", ("f - fhat", "rad/s²"), signals.estimation_error, "interval 20 ms"),
    _error(8, "interval_50ms", ("f - fhat", "rad/s²"), signals.estimation_error, "interval 50 ms"),
    _tracking(9, 10, "error.euler", "angle error", "rad"),
    _tracking(10, 10, "error.euler_rates", "rate error", "rad/s"),
    _tracking(11, 5, "error.euler", "angle error", "rad"),
    _tracking(12, 5, "error.euler_rates", "rate error", "rad/s"),
    _tracking(13, 2, "error.euler", "angle error", "rad"),
    _tracking(14, 2, "error.euler_rates", "rate error", "rad/s"),
    PaperFigure(
        "response",
        "Frequency response of the estimation error. The proposed law and the traditional one with the same sum of "
        "gains cannot be told apart where disturbances are; the peaks are the modes of the memory.",
        [],
        _response,
    ),
    PaperFigure(
        "region",
        "Largest stable k3 against k2: for every delay, sampled in both forms, and what the published theorem admits. "
        "The published gains lie inside all but the last.",
        [],
        lambda _: region_figure(_gains, _period),
    ),
    PaperFigure(
        "sampling",
        "The rolling form is unstable above 2 ms, until at 10 ms both are one; the held one does not depend on the "
        "period, neither in stability nor in what it leaves.",
        [c for cases in _sampled.values() for c in cases.values()],
        _sampling,
    ),
    PaperFigure(
        "parts",
        "What each part is worth: without the estimate the error is 240 times as large.",
        [*_parts],
        _sizes("What each part of the law is worth", _parts, [("|angle error| (rad)", _channel("error.euler"))]),
    ),
    PaperFigure(
        "singularity",
        "Pitch for T = 10 s. The printed model has no kinematics and flies through; on a body the run ends.",
        [*_pitch],
        _singularity,
    ),
    PaperFigure("limits", "Input limits, future work of the paper.", [*_limited], _input_limits),
    PaperFigure(
        "sensor_faults",
        "Faults of the rate sensor, future work of the paper. A bias moves the angles by little and disturbs the "
        "estimate only while it appears; a frozen sensor is taken for an acceleration and lost.",
        [*_sensor],
        _sensor_faults,
    ),
]
