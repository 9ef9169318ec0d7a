# SPDX-License-Identifier: MIT
"""Figures of the li2018 study: the published ones (1-8), then what explains them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gyrostat import metrics
from gyrostat.papers import PaperFigure
from gyrostat.papers.li2018 import signals
from gyrostat.plots import Figure
from gyrostat.results import Result

Array = NDArray[np.float64]
Results = Mapping[str, Result]
Signal = Callable[[Result], Array]
Names = Mapping[str, str]
"""Case and its name in the legend."""
Curve = tuple[str, str, Array, Array]
"""Case, name, instants and values."""

_axes = ("x", "y", "z")
_faults = [(10.0, "wheels 0, 3"), (50.0, "wheel 1"), (100.0, "wheel 1")]
_table1 = {"table1": "proposed", "table1_spd_tuned": "PD, tuned", "table1_spd_soft": "PD, soft"}
_table2 = {
    "table2_command_limit": "proposed, command limited",
    "table2_output_limit": "proposed, output limited",
    "table2_command_limit_spd_tuned": "PD, tuned",
    "table2_command_limit_spd_soft": "PD, soft",
}
_table2_commands = {case: name for case, name in _table2.items() if not case.endswith("soft")}
_ablated = {
    "table1": "proposed",
    "table1_no_ftdo": "without observer",
    "table1_nominal_only": "nominal law alone",
    "table1_sign": "sign(s) as printed",
    "table1_no_floor": "no floor of the gain",
}
_saturated = {
    "large_printed": "Table 1 from a large angle, printed integral",
    "large_clamped": "the same, integral clamped",
    "wish_printed": "Table 2, limit unknown to flight, printed integral",
    "wish_clamped": "the same, integral clamped",
}
_limits = {
    "table2_command_limit": "0.25 N m",
    "table2_0p4": "0.4 N m",
    "table2_0p6": "0.6 N m",
    "table2_0p4_orthogonal": "0.4 N m, orthogonal and skew wheels",
}
_implicit = {
    0.5: "implicit_0p5ms",
    1.0: "table1",
    2.0: "implicit_2ms",
    5.0: "implicit_5ms",
    10.0: "table1_10ms",
    20.0: "implicit_20ms",
}
_euler = {h: f"euler_{f'{h:g}'.replace('.', 'p')}ms" for h in _implicit}
_uniform = {m: f"uniform_0p{round(100 * m):02d}" for m in (0.06, 0.10, 0.15, 0.19, 0.25, 0.30, 0.50)}


def _channel(name: str) -> Signal:
    return lambda result: result[name]


def _component(name: str, column: int) -> Signal:
    return lambda result: result[name][:, column]


def _size(name: str) -> Signal:
    """Largest component of a channel at each instant."""
    return lambda result: np.abs(result[name]).max(axis=1)


def _seen(result: Result, x: Array) -> tuple[Array, Array]:
    """One sample in 10 ms: as much as a figure of smooth curves shows."""
    step = max(1, round(0.01 / float(result.description["dt"])))
    return result.t[::step], x[::step]


def _envelope(result: Result, x: Array) -> tuple[Array, Array]:
    """Largest ``|x|`` of every 10 ms, for curves with short peaks."""
    step = max(1, round(0.01 / float(result.description["dt"])))
    whole = len(x) // step * step
    return result.t[:whole:step], np.abs(x[:whole]).reshape(-1, step, x.shape[1]).max(axis=1)


def _span(figure: Figure, end: float) -> Figure:
    """Show 0 ... `end` s with the faults in it marked."""
    figure.mark([fault for fault in _faults if fault[0] < end])
    figure.window(0, end)
    return figure


def _curves(figure: Figure, row: int, label: str, curves: Sequence[Curve], *, log: bool = False) -> None:
    """One line a case in one panel."""
    figure.axes[row].set_ylabel(label, fontsize=9)
    for case, name, t, x in curves:
        figure.line(row, t, x, f"{label}, {case}", labels=[name], log=log)


def _of(results: Results, names: Names, signal: Signal) -> list[Curve]:
    """A signal of several cases."""
    return [(case, name, *_seen(results[case], signal(results[case]))) for case, name in names.items()]


def _observation_error(title: str, name: str, unit: str, signal: Signal, results: Results) -> Figure:
    figure = Figure(title, rows=2)
    for row, (case, how) in enumerate([("table1", "implicit observer"), ("euler_1ms", "explicit Euler")]):
        result = results[case]
        figure.axes[row].set_ylabel(f"|{name}| ({unit}), {how}", fontsize=9)
        figure.line(row, *_envelope(result, signal(result)), f"{name}, {how}", unit, labels=_axes, log=True)
        figure.level(row, 2e-5, "published: 2e-5")
    _span(figure, 100)
    return figure


def _figure_1(results: Results) -> Figure:
    return _observation_error(
        "Fig. 1: rate error of the observer, Table 1", "z1", "rad/s", _channel("observer.z1"), results
    )


def _figure_2(results: Results) -> Figure:
    return _observation_error(
        "Fig. 2: acceleration error of the observer, Table 1", "z2", "rad/s²", signals.z2, results
    )


def _by_axis(title: str, quantity: str, channel: str, results: Results, names: Names) -> Figure:
    """A panel an axis, and the largest component on a logarithmic scale."""
    figure = Figure(title, rows=4)
    for i, axis in enumerate(_axes):
        _curves(figure, i, f"{axis}: {quantity}", _of(results, names, _component(channel, i)))
    _curves(figure, 3, f"largest: {quantity}", _of(results, names, _size(channel)), log=True)
    return figure


def _attitude(title: str, end: float, results: Results, names: Names) -> Figure:
    figure = _by_axis(title, "MRP", "truth.mrp", results, names)
    figure.level(3, 1e-4, "published accuracy: 1e-4")
    return _span(figure, end)


def _rate(title: str, end: float, results: Results, names: Names) -> Figure:
    return _span(_by_axis(title, "rate (rad/s)", "truth.omega_BN_B", results, names), end)


def _commands(title: str, end: float, results: Results, names: Names) -> Figure:
    """A panel a wheel."""
    figure = Figure(title, rows=4)
    for i in range(4):
        _curves(figure, i, f"command {i} (N m)", _of(results, names, _component("allocation.u", i)))
        figure.level(i, 0.25, "limit")
        figure.level(i, -0.25, "")
    return _span(figure, end)


def _figure_3(results: Results) -> Figure:
    return _attitude("Fig. 3: attitude, Table 1", 100, results, _table1)


def _figure_4(results: Results) -> Figure:
    return _rate("Fig. 4: body rate, Table 1", 100, results, _table1)


def _figure_5(results: Results) -> Figure:
    return _commands("Fig. 5: wheel commands, Table 1", 100, results, _table1)


def _figure_6(results: Results) -> Figure:
    return _attitude("Fig. 6: attitude, Table 2", 150, results, _table2)


def _figure_7(results: Results) -> Figure:
    return _rate("Fig. 7: body rate, Table 2", 150, results, _table2)


def _figure_8(results: Results) -> Figure:
    return _commands("Fig. 8: wheel commands, Table 2", 150, results, _table2_commands)


def _discretisation(results: Results) -> Figure:
    """Largest errors and command variation against the period."""
    figure = Figure("Period and method of the observer, Table 1", rows=3, along="period", unit="ms")
    panels: list[tuple[str, Callable[[Result], float]]] = [
        ("|z1| (rad/s)", lambda r: metrics.window_max(r.t, r["observer.z1"], 40, 50)),
        ("|z2| (rad/s²)", lambda r: metrics.window_max(r.t, signals.z2(r), 40, 50)),
        ("command variation (N m/s)", lambda r: metrics.total_variation(r.t, r["allocation.u"], 40, 150)),
    ]
    for row, (label, measure) in enumerate(panels):
        figure.axes[row].set_ylabel(label, fontsize=9)
        for method, cases in (("implicit", _implicit), ("explicit Euler", _euler)):
            values = [measure(results[case]) for case in cases.values()]
            figure.line(row, list(cases), values, f"{label}, {method}", labels=[method], log=True, style="o-")
        if row < 2:
            figure.level(row, 2e-5, "published: 2e-5")
    figure.axes[-1].set_xscale("log")
    figure.axes[-1].set_xticks(list(_implicit), [f"{h:g}" for h in _implicit], minor=False)
    figure.axes[-1].set_xticks([], minor=True)
    return figure


def _effectiveness(results: Results) -> Figure:
    """Last amplitude of the observer's error against the effectiveness of all wheels."""
    figure = Figure(
        "The observer's own loop through weakened wheels", rows=1, size=(8.0, 4.0), along="effectiveness", unit=""
    )
    values = [metrics.window_max(results[c].t, results[c]["observer.z1"], 140, 150) for c in _uniform.values()]
    figure.axes[0].set_ylabel("largest |z1| in the last 10 s (rad/s), at least 1e-16", fontsize=9)
    figure.line(0, list(_uniform), np.maximum(values, 1e-16), "z1", "rad/s", log=True, style="o-")
    figure.mark([(0.19, "critical: 0.19")])
    return figure


def _ablations(results: Results) -> Figure:
    figure = Figure("What each part of the law is worth, Table 1", rows=2, size=(8.0, 6.0))
    _curves(figure, 0, "largest MRP", _of(results, _ablated, _size("truth.mrp")), log=True)
    figure.level(0, 1e-4, "published accuracy: 1e-4")
    variation = [(case, name, *_variation(results[case])) for case, name in _ablated.items()]
    _curves(figure, 1, "variation (N m/s), each second", variation, log=True)
    return _span(figure, 150)


def _variation(result: Result) -> tuple[Array, Array]:
    """Sum of ``|change|`` of all commands in each second."""
    change = np.abs(np.diff(result["allocation.u"], axis=0)).sum(axis=1)
    each = round(1.0 / float(result.description["dt"]))
    by_second = change[: len(change) // each * each].reshape(-1, each).sum(axis=1)
    return np.arange(len(by_second), dtype=np.float64) + 0.5, by_second


def _integral(results: Results) -> Figure:
    figure = Figure("Saturation: the integral and what the observer sees", rows=2, size=(8.0, 6.0))
    _curves(figure, 0, "largest MRP", _of(results, _saturated, _size("truth.mrp")), log=True)
    _curves(figure, 1, "largest switching gain (N m)", _of(results, _saturated, _size("controller.gain")), log=True)
    return _span(figure, 150)


def _feasibility(results: Results) -> Figure:
    result = results["table2_command_limit"]
    figure = Figure("Table 2 with the command limited: wheel 2 cannot do its share", rows=3)
    figure.line(0, *_seen(result, signals.utilisation(result)), "needed / limit, wheel 2")
    figure.level(0, 1.0, "limit")
    figure.line(1, *_seen(result, result["allocation.u"][:, 2]), "command, wheel 2", "N m")
    _curves(figure, 2, "largest MRP", _of(results, _limits, _size("truth.mrp")), log=True)
    return _span(figure, 150)


FIGURES = [
    PaperFigure(
        "fig1",
        "Fig. 1. Rate error z1 of the observer, Table 1. The published bound holds for both discretisations at 1 ms.",
        ["table1", "euler_1ms"],
        _figure_1,
    ),
    PaperFigure(
        "fig2",
        "Fig. 2. Acceleration error z2 of the observer, Table 1. The faults at 10, 50 and 100 s break the bound, "
        "each for about 10 ms.",
        ["table1", "euler_1ms"],
        _figure_2,
    ),
    PaperFigure("fig3", "Fig. 3. Attitude, Table 1: proposed law and saturated PD.", [*_table1], _figure_3),
    PaperFigure("fig4", "Fig. 4. Body rate, Table 1.", [*_table1], _figure_4),
    PaperFigure("fig5", "Fig. 5. Wheel commands, Table 1.", [*_table1], _figure_5),
    PaperFigure("fig6", "Fig. 6. Attitude, Table 2, in both readings of the torque limit.", [*_table2], _figure_6),
    PaperFigure("fig7", "Fig. 7. Body rate, Table 2, in both readings of the torque limit.", [*_table2], _figure_7),
    PaperFigure(
        "fig8", "Fig. 8. Wheel commands, Table 2, in both readings of the torque limit.", [*_table2_commands], _figure_8
    ),
    PaperFigure(
        "discretisation",
        "Largest errors in 40-50 s and command variation in 40-150 s against the period. The implicit observer does "
        "not chatter; its z2 is the age of the estimate.",
        [*_implicit.values(), *_euler.values()],
        _discretisation,
    ),
    PaperFigure(
        "effectiveness",
        "All wheels weakened alike, no torque limit, no disturbance: below the critical effectiveness the compensation "
        "ends in a limit cycle.",
        [*_uniform.values()],
        _effectiveness,
    ),
    PaperFigure(
        "ablations",
        "Table 1 with parts of the law left out. The printed sign(s) settles as well and chatters four orders of "
        "magnitude more; the observer improves the late accuracy, not the settling.",
        [*_ablated],
        _ablations,
    ),
    PaperFigure(
        "saturation",
        "The printed integral winds up when the commands saturate; an observer that is fed the wish instead of the "
        "limited command runs away with or without the clamp.",
        [*_saturated],
        _integral,
    ),
    PaperFigure(
        "feasibility",
        "Table 2: after 10 s three wheels are left and their torques are unique. Wheel 2 would need up to 1.5 times "
        "its limit to hold the attitude.",
        [*_limits],
        _feasibility,
    ),
]
