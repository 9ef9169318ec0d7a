# SPDX-License-Identifier: MIT
"""Figures of the wang2023 study: the published ones (1-10), then what explains them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from gyrostat.papers import PaperFigure
from gyrostat.papers.wang2023 import signals
from gyrostat.plots import Figure
from gyrostat.results import Result

Array = NDArray[np.float64]
Results = Mapping[str, Result]
Signal = Callable[[Result], Array]
Names = Mapping[str, str]
"""Case and its name in the legend."""
Curves = tuple[Results, Names, Signal]
"""A signal of several cases."""

_axes = ("x", "y", "z")
_faults = [(50.0, "fault x"), (100.0, "fault z")]
_observers = {
    "mlsmc": "mixed",
    "ilsmo_fair": "iterative, equal gains",
    "ilsmo_strong_sign": "iterative, theta1 = 0.02",
}
_laws = {"mlsmc": "mixed learning sliding mode", "smc": "sliding mode"}
_ablated = {
    "mlsmc": "both",
    "smc_mlo": "observer only",
    "smc_learn": "learning of s only",
    "smc": "neither",
    "smc_rbf": "neither, network",
    "smc_strong": "neither, 0.25 N m switching",
}
_limited = {
    "mlsmc": "cold start",
    "mlsmc_warm": "warm start",
    "mlsmc_clip": "warm start, learnt torque clamped",
    "mlsmc_umax": "cold start, 1 N m limit",
}
_future = {
    "mlsmc_clip": "linear surface",
    "linear_fast": "linear surface, twice the slope",
    "terminal_clip": "terminal surface",
}


def _seen(result: Result, x: Array, step: float = 0.02) -> tuple[Array, Array]:
    """One sample in `step` seconds: as much as a figure of 300 s shows."""
    every = max(1, round(step / float(result.description["dt"])))
    return result.t[::every], x[::every]


def _span(figure: Figure, start: float, end: float) -> Figure:
    figure.mark([fault for fault in _faults if start < fault[0] < end])
    figure.window(start, end)
    return figure


def _compare(figure: Figure, row: int, label: str, curves: Curves, *, log: bool = False) -> None:
    """One line a case in one panel."""
    results, names, signal = curves
    figure.axes[row].set_ylabel(label, fontsize=9)
    for case, name in names.items():
        t, x = _seen(results[case], signal(results[case]))
        figure.line(row, t, x, f"{label}, {case}", labels=[name], log=log)


def _column(name: str, i: int) -> Signal:
    return lambda result: result[name][:, i]


def _size(signal: Signal) -> Signal:
    return lambda result: np.abs(signal(result)).max(axis=1)


def _figure_1(results: Results) -> Figure:
    figure = Figure("Fig. 1: torque faults and what is learnt", rows=3)
    result = results["mlsmc"]
    for i, axis in enumerate(_axes):
        figure.axes[i].set_ylabel(f"{axis} (N m)", fontsize=9)
        for name, x in (("fault", result["truth.bias"]), ("learnt", result["estimate.d_B"])):
            t, y = _seen(result, x[:, i])
            figure.line(i, t, y, f"{name} {axis}", "N m", labels=[name])
        figure.axes[i].set_ylim(-0.1, 0.25)  # the cold start reaches 33 N m
    return _span(figure, 0.0, 300.0)


def _figure_2(results: Results) -> Figure:
    figure = Figure("Fig. 2: error of the learnt torque", rows=2)
    for row, case in enumerate(("mlsmc", "mlo_open")):
        result = results[case]
        t, x = _seen(result, signals.fault_error(result))
        how = "with control" if case == "mlsmc" else "without control"
        figure.line(row, t, x, f"error {how}", "N m", labels=_axes)
        figure.level(row, 5e-3, "published accuracy: 0.005 N m")
        figure.level(row, -5e-3, "")
        figure.axes[row].set_ylim(-0.03, 0.03)
    return _span(figure, 0.0, 300.0)


def _figure_3(results: Results) -> Figure:
    figure = Figure("Fig. 3: rate and its prediction, cold start", rows=3)
    result = results["mlsmc"]
    part = result.t <= 5.0
    for i, axis in enumerate(_axes):
        figure.axes[i].set_ylabel(f"{axis} (rad/s)", fontsize=9)
        figure.line(i, result.t[part], result["truth.omega_BN_B"][part, i], f"rate {axis}", "rad/s", labels=["true"])
        figure.line(
            i, result.t[part], result["observer.omega_hat"][part, i], f"predicted {axis}", "rad/s", labels=["predicted"]
        )
    figure.window(0.0, 5.0)
    return figure


def _figure_4(results: Results) -> Figure:
    figure = Figure("Fig. 4: error of the predicted rate", rows=2)
    result = results["mlsmc"]
    t, x = _seen(result, result["observer.error"])
    figure.line(0, t, x, "error", "rad/s", labels=_axes)
    figure.axes[0].set_ylim(-1e-3, 1e-3)
    figure.level(0, 5e-4, "published: 5e-4 rad/s")
    figure.level(0, -5e-4, "")
    figure.line(1, t, x, "size of the error", "rad/s", labels=_axes, log=True)
    return _span(figure, 0.0, 300.0)


def _reconstruction(i: int, number: int, results: Results) -> Figure:
    axis = _axes[i]
    figure = Figure(f"Fig. {number}: reconstruction of the fault about {axis}", rows=2)
    _compare(figure, 0, "learnt torque (N m)", (results, _observers, _column("estimate.d_B", i)))
    _compare(figure, 1, "error (N m)", (results, _observers, lambda r: signals.fault_error(r)[:, i]))
    figure.axes[0].set_ylim(-0.05, 0.25)
    figure.axes[1].set_ylim(-0.03, 0.03)
    return _span(figure, 40.0, 150.0)


def _figure_5(results: Results) -> Figure:
    return _reconstruction(0, 5, results)


def _figure_6(results: Results) -> Figure:
    return _reconstruction(2, 6, results)


def _by_axis(title: str, label: str, results: Results, signal: Signal) -> Figure:
    figure = Figure(title, rows=4)
    for i, axis in enumerate(_axes):
        _compare(figure, i, f"{axis}: {label}", (results, _laws, lambda r, i=i: signal(r)[:, i]))  # type: ignore[misc]
    _compare(figure, 3, f"largest: {label}", (results, _laws, _size(signal)), log=True)
    return _span(figure, 0.0, 300.0)


def _figure_7(results: Results) -> Figure:
    return _by_axis("Fig. 7: body rate", "rate (rad/s)", results, lambda r: r["truth.omega_BN_B"])


def _figure_8(results: Results) -> Figure:
    return _by_axis("Fig. 8: attitude", "quaternion", results, signals.vector)


def _figure_9(results: Results) -> Figure:
    return _by_axis("Fig. 9: sliding variable", "s (rad/s)", results, lambda r: r["controller.s"])


def _figure_10(results: Results) -> Figure:
    figure = Figure("Fig. 10: torque learnt from the sliding variable", rows=2)
    result = results["mlsmc"]
    t, x = _seen(result, result["controller.learnt"])
    figure.line(0, t, x, "learnt", "N m", labels=_axes)
    figure.axes[0].set_ylim(-0.015, 0.015)
    figure.line(1, t, x, "size", "N m", labels=_axes, log=True)
    return _span(figure, 0.0, 300.0)


def _ablations(results: Results) -> Figure:
    figure = Figure("What the two learnings do", rows=2)
    _compare(figure, 0, "largest |q|", (results, _ablated, _size(signals.vector)), log=True)
    _compare(figure, 1, "largest rate (rad/s)", (results, _ablated, _size(lambda r: r["truth.omega_BN_B"])), log=True)
    return _span(figure, 0.0, 300.0)


def _limits(results: Results) -> Figure:
    figure = Figure("Start and limits", rows=3)
    for case, name in _limited.items():
        result = results[case]
        part = result.t <= 10.0
        command = np.abs(result["allocation.u"]).max(axis=1)[part]
        figure.line(0, result.t[part], command, f"largest command, {case}", "N m", labels=[name], log=True)
        learnt = np.abs(result["estimate.d_B"]).max(axis=1)[part]
        figure.line(1, result.t[part], learnt, f"largest learnt torque, {case}", "N m", labels=[name], log=True)
        attitude = np.abs(signals.vector(result)).max(axis=1)[part]
        figure.line(2, result.t[part], attitude, f"largest |q|, {case}", labels=[name])
    for axis, label in zip(figure.axes, ("command (N m)", "learnt torque (N m)", "|q|"), strict=True):
        axis.set_ylabel(f"largest {label}", fontsize=9)
    figure.axes[1].set_ylim(1e-3, 1e2)
    figure.window(0.0, 10.0)
    return figure


def _shares(results: Results) -> Figure:
    figure = Figure("Noise of 1e-4 rad/s: learnt torque about the noise-free one, x", rows=3)
    cases = {"mixed": "mlsmc", "repetitive": "mlo_repetitive", "half": "mlo_half"}
    for row, (share, free) in enumerate(cases.items()):
        noisy, quiet = results[f"noise_{share}"], results[free]
        x = noisy["estimate.d_B"][:, 0] - quiet["estimate.d_B"][:, 0]
        part = (noisy.t >= 270.0) & (noisy.t <= 270.5)
        figure.line(row, noisy.t[part], x[part], share, "N m")
        figure.axes[row].set_ylim(-0.012, 0.012)
    figure.window(270.0, 270.5)
    return figure


def _terminal(results: Results) -> Figure:
    figure = Figure("Future work of the paper: the same learning on a terminal surface", rows=3)
    _compare(figure, 0, "largest |q|", (results, _future, _size(signals.vector)), log=True)
    _compare(figure, 1, "largest rate (rad/s)", (results, _future, _size(lambda r: r["truth.omega_BN_B"])), log=True)
    _compare(figure, 2, "largest command (N m)", (results, _future, _size(lambda r: r["allocation.u"])), log=True)
    return _span(figure, 0.0, 300.0)


FIGURES = [
    PaperFigure("fig1", "Fig. 1. Torque faults and what the observer learns; y has no fault.", ["mlsmc"], _figure_1),
    PaperFigure(
        "fig2",
        "Fig. 2. Error of the learnt torque. With control it is the bias by theta1 = 0.005; without, the unknown tenth "
        "of the inertia reads as a fault.",
        ["mlsmc", "mlo_open"],
        _figure_2,
    ),
    PaperFigure(
        "fig3",
        "Fig. 3. Rate and its prediction, which starts at zero: the first 5 s; later the two are one line.",
        ["mlsmc"],
        _figure_3,
    ),
    PaperFigure("fig4", "Fig. 4. Error of the predicted rate.", ["mlsmc"], _figure_4),
    PaperFigure(
        "fig5",
        "Fig. 5. Fault about x: mixed and iterative learning agree at equal gains, one curve covers the other; what "
        "differs is the sign gain.",
        [*_observers],
        _figure_5,
    ),
    PaperFigure("fig6", "Fig. 6. The same about z.", [*_observers], _figure_6),
    PaperFigure("fig7", "Fig. 7. Body rate with and without fault compensation.", [*_laws], _figure_7),
    PaperFigure("fig8", "Fig. 8. Attitude, vector part of the quaternion.", [*_laws], _figure_8),
    PaperFigure("fig9", "Fig. 9. Sliding variable.", [*_laws], _figure_9),
    PaperFigure(
        "fig10",
        "Fig. 10. Torque learnt from the sliding variable: next to nothing after the reaching phase, since the "
        "switching torque of 0.01 N m takes what the observer leaves, 0.005 N m.",
        ["mlsmc"],
        _figure_10,
    ),
    PaperFigure(
        "ablations",
        "The observer alone reaches the accuracy of both; a stronger switching gain or a network, without any fault "
        "estimate, reaches what the publication reports for its law.",
        [*_ablated],
        _ablations,
    ),
    PaperFigure(
        "limits",
        "The first 10 s: the cold start asks for 43 N m; a warm start with clamped learning for 1.3 N m.",
        [*_limited],
        _limits,
    ),
    PaperFigure(
        "noise",
        "Half a second with gyro noise: the past error smooths the steps, not the size of the error.",
        ["noise_mixed", "noise_repetitive", "noise_half", "mlsmc", "mlo_repetitive", "mlo_half"],
        _shares,
    ),
    PaperFigure(
        "terminal",
        "Terminal against linear surfaces, warm start, learnt torques clamped: half the time of the published slope "
        "for a fifth more energy; against twice that slope, which costs the same, the gain is in the last decades.",
        [*_future],
        _terminal,
    ),
]
