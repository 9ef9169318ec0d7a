# SPDX-License-Identifier: MIT
"""Figures of the yang2023 study: the published ones (2-7), then what explains them. An error is shown in its funnel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gyrostat.papers import PaperFigure
from gyrostat.papers.yang2023 import signals
from gyrostat.plots import Figure
from gyrostat.results import Result

Array = NDArray[np.float64]
Results = Mapping[str, Result]

_axes = ("x", "y", "z")
_limit = 0.25
_marks = [(84.0, "actuator 0"), (164.0, "1"), (168.0, "2")]
_steps = [(80.0, "step"), (160.0, "step")]


def _seen(result: Result, x: Array, step: int = 5) -> tuple[Array, Array]:
    """One sample in 50 ms."""
    return result.t[::step], x[::step]


def _index(result: Result) -> Array:
    """The true index; before the first command, nothing."""
    return np.where(np.abs(signals.held(result)[:, :3]) > 0.0, signals.index(result), 1.0)


def _bench(
    title: str, case: str, estimates: Sequence[tuple[str, str]], results: Results, lowest: float = 1e-4
) -> Figure:
    """A panel an actuator: what each observer says, true index, true effectiveness; then the errors, same colours."""
    result = results[case]
    figure = Figure(title, rows=4, size=(8.5, 9.0))
    truth = result["truth.effectiveness"]
    for i in range(3):
        for role, label in estimates:
            e = result[f"{role}estimate.effectiveness"][:, i]
            figure.line(i, *_seen(result, e), f"actuator {i}: {label}", labels=[label])
        figure.line(i, *_seen(result, truth[:, i]), f"actuator {i}: effectiveness", labels=["true effectiveness"])
        figure.line(i, *_seen(result, _index(result)[:, i]), f"actuator {i}: index", labels=["true index"])
        figure.axes[i].set_ylabel(f"actuator {i}", fontsize=9)
        figure.axes[i].set_ylim(0.3, 1.2)  # room for the legend
        figure.axes[i].legend(loc="upper right", fontsize=8, frameon=False, ncols=4)
    for role, label in estimates:
        error = np.abs(result[f"{role}estimate.effectiveness"][:, :3] - _index(result)).max(axis=1)
        figure.line(3, *_seen(result, error, 1), f"largest error: {label}", labels=[label], log=True)
    figure.axes[3].set_ylabel("largest |estimate - index|", fontsize=9)
    figure.axes[3].set_ylim(lowest, 1.0)
    return figure


_both = [("shadow0.", "constant gains"), ("", "adaptive")]


def _figure_3(results: Results) -> Figure:
    return _bench("Fig. 3: abrupt faults, open loop", "fd_a", _both, results)


def _figure_3b(results: Results) -> Figure:
    return _bench("Fig. 3: time-varying faults, open loop", "fd_b", _both, results)


def _noise_free(results: Results) -> Figure:
    estimates = [("", "adaptive, fast gains"), ("shadow1.", "constant gains, dead beat")]
    return _bench("Abrupt faults without noise", "fd_a_nf", estimates, results, lowest=1e-9)


def _figure_2(results: Results) -> Figure:
    """Faults of the two benches and of the slews, and the commanded angles."""
    figure = Figure("Fig. 2: faults on the bench (a), (b) and in the slews; commanded angles", rows=4, size=(8.5, 9.0))
    for row, (case, name) in enumerate((("fd_a", "bench (a)"), ("fd_b", "bench (b)"), ("afppc", "slews"))):
        e = results[case]["truth.effectiveness"][:, :3]
        figure.line(row, *_seen(results[case], e), f"effectiveness, {name}", labels=["0", "1", "2"])
    result = results["afppc"]
    figure.line(
        3, *_seen(result, np.rad2deg(result["reference.euler"])), "commanded (deg)", labels=["roll", "pitch", "yaw"]
    )
    return figure


def _arms(results: Results) -> Figure:
    """The funnel as it is drawn."""
    result = results["afppc"]
    figure = Figure("A funnel drawn again at each step and fault", rows=3, size=(8.5, 7.0))
    _funnel(figure, 0, result, 0)
    figure.line(1, *_seen(result, np.abs(result["controller.z"]).max(axis=1)), "largest |z|")
    figure.level(1, 1.0, "edge of the funnel")
    for i, axis in enumerate(_axes):
        width = (result["controller.upper"] - result["controller.lower"])[:, i]
        figure.line(2, *_seen(result, width), f"width, {axis}", labels=[axis], log=True)
    figure.axes[2].set_ylabel("width of the funnel", fontsize=9)
    figure.mark(_marks)
    return figure


def _funnel(figure: Figure, row: int, result: Result, axis: int, name: str = "") -> None:
    """Error of an axis between its bounds."""
    label = f"q_e {_axes[axis]}{name}"
    figure.axes[row].set_ylabel(label, fontsize=9)
    figure.line(row, *_seen(result, result["controller.q_error"][:, axis]), label, labels=["error"])
    figure.line(
        row, *_seen(result, result["controller.lower"][:, axis]), f"{label}, lower", labels=["funnel"], style="--"
    )
    figure.line(row, *_seen(result, result["controller.upper"][:, axis]), f"{label}, upper", labels=[""], style="--")


def _figure_4(results: Results) -> Figure:
    figure = Figure("Fig. 4: attitude error in the adaptive funnel", rows=3, size=(8.5, 7.0))
    for i in range(3):
        _funnel(figure, i, results["afppc"], i)
        figure.line(
            i,
            *_seen(results["ftsmc"], results["ftsmc"]["controller.q_error"][:, i]),
            f"q_e {_axes[i]}, ftsmc",
            labels=["terminal sliding mode"],
        )
    figure.mark(_marks)
    return figure


def _figure_4_fixed(results: Results) -> Figure:
    figure = Figure("Fig. 4: a funnel armed once does not survive the next step", rows=3, size=(8.5, 7.0))
    for i in range(3):
        _funnel(figure, i, results["ppc_fixed"], i)
    figure.mark(_steps)
    return figure


def _figure_5(results: Results) -> Figure:
    result = results["afppc"]
    figure = Figure("Fig. 5: Euler angles and what was commanded", rows=3, size=(8.5, 7.0))
    for i, name in enumerate(("roll", "pitch", "yaw")):
        figure.line(i, *_seen(result, np.rad2deg(result["truth.euler"][:, i])), f"{name} (deg)", labels=["flown"])
        commanded = np.rad2deg(result["reference.euler"][:, i])
        figure.line(i, *_seen(result, commanded), f"{name}, commanded (deg)", labels=["commanded"], style="--")
    figure.mark(_marks)
    return figure


_weights = (("alloc_socp", "h = 1000"), ("alloc_socp_h10", "h = 10"))


def _figure_6(results: Results) -> Figure:
    figure = Figure("Fig. 6: commands under robust allocation", rows=5, size=(8.5, 10.0))
    for case, label in _weights:
        result = results[case]
        for i in range(4):
            figure.line(i, *_seen(result, result["allocation.u"][:, i]), f"command {i}, {case} (N m)", labels=[label])
            figure.axes[i].set_ylabel(f"command {i} (N m)", fontsize=9)
            figure.axes[i].set_ylim(-1.1 * _limit, 1.1 * _limit)
        demand = np.linalg.norm(result["demand.tau_B"], axis=1)
        figure.line(4, *_seen(result, demand), f"demand, {case} (N m)", labels=[label], log=True)
    figure.axes[4].set_ylabel("|demand| (N m)", fontsize=9)
    figure.mark(_marks)
    return figure


def _figure_7(results: Results) -> Figure:
    figure = Figure("Fig. 7: energy of the commands against that of the pseudo-inverse", rows=2, size=(8.5, 5.5))
    shown = {"alloc_socp": "robust, h = 1000", "alloc_socp_h10": "robust, h = 10", "afppc": "pseudo-inverse"}
    base = np.cumsum((results["afppc"]["allocation.u"] ** 2).sum(axis=1)) * 0.01
    for case, label in shown.items():
        energy = np.cumsum((results[case]["allocation.u"] ** 2).sum(axis=1)) * 0.01
        figure.line(0, *_seen(results[case], energy), f"energy, {case}", labels=[label])
        if case != "afppc":
            figure.line(
                1, *_seen(results[case], energy - base), f"more than the pseudo-inverse, {case}", labels=[label]
            )
    figure.axes[0].set_ylabel("integral of u'u (N²m²s)", fontsize=9)
    figure.axes[1].set_ylabel("less that of pseudo-inverse", fontsize=9)
    return figure


def _each_second(result: Result, x: Array) -> tuple[Array, Array]:
    """Largest value of every hundred samples."""
    whole = len(x) // 100 * 100
    return result.t[:whole:100], x[:whole].reshape(-1, 100).max(axis=1)


def _certificate(results: Results) -> Figure:
    figure = Figure("Robust allocation at 100 Hz: worst certificate of each second", rows=2, size=(8.5, 5.0))
    for case, label in _weights:
        result = results[case]
        gap = np.maximum(signals.relative_gap(result), 1e-17)
        figure.line(0, *_each_second(result, gap), f"relative gap, {case}", labels=[label], log=True)
        steps = _each_second(result, result["allocation.iterations"])
        figure.line(1, *steps, f"Newton steps, {case}", labels=[label])
    figure.level(0, 1e-8, "target: 1e-8")
    figure.axes[0].set_ylabel("gap / objective", fontsize=9)
    figure.axes[0].set_ylim(1e-17, 1e-6)
    figure.axes[1].set_ylabel("Newton steps", fontsize=9)
    return figure


def _severe(results: Results) -> Figure:
    figure = Figure("Severe fault at 2 s: the funnel drawn again (top) and kept (middle)", rows=3, size=(8.5, 7.0))
    for row, (case, name) in enumerate((("severe_afppc", ", adaptive"), ("severe_fixed", ", fixed"))):
        _funnel(figure, row, results[case], 0, name)
        z = np.abs(results[case]["controller.z"]).max(axis=1)
        figure.line(2, *_seen(results[case], z), f"largest |z|{name}", labels=[name[2:]])
    figure.axes[2].set_ylabel("largest |z|", fontsize=9)
    figure.level(2, 1.0, "edge of the funnel")
    figure.mark([(2.0, "actuator 0 at 15 %")])
    return figure


def _moving(results: Results) -> Figure:
    figure = Figure("Moving reference: error in its funnel, and the size of it", rows=2, size=(8.5, 5.5))
    _funnel(figure, 0, results["moving"], 1)
    for case, label in (("moving", "corrected torque"), ("moving_printed", "torque as printed")):
        angle = np.rad2deg(results[case]["error.angle"])
        figure.line(1, *_seen(results[case], angle), f"angle, {case} (deg)", labels=[label], log=True)
    figure.axes[1].set_ylabel("angle of the error (deg)", fontsize=9)
    return figure


def _rest(results: Results) -> Figure:
    figure = Figure("A fault at rest, with and without a probe that makes no torque", rows=3, size=(8.5, 7.0))
    for case, label in (("rest_dither", "with probe"), ("rest", "without")):
        result = results[case]
        e = result["estimate.effectiveness"][:, 0]
        figure.line(0, *_seen(result, e), f"estimate of actuator 0, {case}", labels=[label])
        angle = np.rad2deg(result["error.angle"])
        figure.line(1, *_seen(result, angle), f"angle, {case} (deg)", labels=[label], log=True)
    figure.axes[0].set_ylabel("estimate, actuator 0", fontsize=9)
    figure.axes[1].set_ylabel("angle of the error (deg)", fontsize=9)
    _funnel(figure, 2, results["rest_dither"], 0, ", with probe")
    figure.mark([(60.0, "actuator 0 at 50 %")])
    return figure


def _noise_and_gains(results: Results) -> Figure:
    figure = Figure("Gains of the adaptive observer on the bench: relaxing, and as printed", rows=2, size=(8.5, 5.0))
    for row, (column, name) in enumerate(((0, "k1 (1/s)"), (2, "k4 (1/s)"))):
        for case, label in (("fd_printed", "as printed"), ("fd_a", "relaxing below the dead zone")):
            gain = results[case]["observer.gains"][:, column]
            figure.line(row, *_seen(results[case], gain), f"{name}, {case}", labels=[label])
        figure.axes[row].set_ylabel(name, fontsize=9)
    return figure


FIGURES = [
    PaperFigure(
        "fig2",
        "Fig. 2. Faults and commands. The paper prints neither; these are chosen.",
        ["fd_a", "fd_b", "afppc"],
        _figure_2,
    ),
    PaperFigure(
        "funnel",
        "The adaptive funnel, roll: armed at 0, 80 and 160 s by the command and 0.3 s after each fault.",
        ["afppc"],
        _arms,
    ),
    PaperFigure(
        "fig3",
        "Fig. 3 and Table I, abrupt faults with gyro noise. A healthy actuator reads 0.92: the index carries the error "
        "of the inertia.",
        ["fd_a"],
        _figure_3,
    ),
    PaperFigure("fig3b", "Fig. 3 and Table I, time-varying faults with gyro noise.", ["fd_b"], _figure_3b),
    PaperFigure(
        "fig4",
        "Fig. 4. Vector part of the error quaternion inside its funnel; the terminal sliding mode has none.",
        ["afppc", "ftsmc"],
        _figure_4,
    ),
    PaperFigure(
        "fig4_fixed",
        "Fig. 4, the funnel armed once: the step at 80 s throws the error out of it.",
        ["ppc_fixed"],
        _figure_4_fixed,
    ),
    PaperFigure("fig5", "Fig. 5. Euler angles and commands.", ["afppc"], _figure_5),
    PaperFigure(
        "fig6", "Fig. 6. Actuator commands under robust allocation.", ["alloc_socp", "alloc_socp_h10"], _figure_6
    ),
    PaperFigure(
        "fig7",
        "Fig. 7. Energy: a large h completes saturated demands and costs more than the pseudo-inverse, a small one "
        "under-delivers and saves.",
        ["afppc", "alloc_socp", "alloc_socp_h10"],
        _figure_7,
    ),
    PaperFigure(
        "certificate", "Every solve in the loop comes with its gap.", ["alloc_socp", "alloc_socp_h10"], _certificate
    ),
    PaperFigure(
        "noise_free",
        "Without noise the constant-gain observer reaches the figures published for the adaptive one.",
        ["fd_a_nf"],
        _noise_free,
    ),
    PaperFigure(
        "gains", "As printed, noise ratchets the gains to their caps.", ["fd_a", "fd_printed"], _noise_and_gains
    ),
    PaperFigure(
        "severe",
        "A funnel kept after the fault is left at 18.8 s: the actuator cannot brake in time.",
        ["severe_afppc", "severe_fixed"],
        _severe,
    ),
    PaperFigure(
        "moving",
        "A turning reference shows the sign and the term that are printed wrong.",
        ["moving", "moving_printed"],
        _moving,
    ),
    PaperFigure(
        "rest",
        "Faults at rest are silent. A sine of 0.15 N m in the null space of the four actuators is heard 0.7 s after "
        "the fault.",
        ["rest", "rest_dither"],
        _rest,
    ),
]
