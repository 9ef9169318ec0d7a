# SPDX-License-Identifier: MIT
"""Figures of the cao2022 study: the published ones (2-7), then what explains them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gyrostat.papers import EnsembleFigure, PaperFigure
from gyrostat.papers.campaigns import Ensemble
from gyrostat.papers.cao2022 import signals
from gyrostat.plots import Figure
from gyrostat.results import Result

Array = NDArray[np.float64]
Results = Mapping[str, Result]
Signal = Callable[[Result], Array]

_faults = [(5.0, "wheel 0"), (8.0, "1"), (10.0, "2")]
_observers = {"repaired": "case1_repaired", "as printed": "case1_literal", "adaptive sliding mode": "case1_repaired"}
_laws = {"predefined time": "case2_ptc", "terminal": "case2_tsmc"}
_smooth = {"predefined time": "case2_ptc_smooth", "terminal": "case2_tsmc_smooth"}


def _channel(name: str) -> Signal:
    return lambda result: result[name]


def _by_wheel(
    title: str, quantity: str, curves: Sequence[tuple[str, Result, Array]], end: float = 50.0, *, log: bool = False
) -> Figure:
    """A panel an axis or wheel, one line a curve."""
    figure = Figure(title, rows=3)
    for i in range(3):
        figure.axes[i].set_ylabel(f"{quantity}, {i}", fontsize=9)
        for name, result, x in curves:
            figure.line(i, result.t, x[:, i], f"{quantity} {i}, {name}", labels=[name], log=log)
    figure.mark([fault for fault in _faults if fault[0] < end])
    figure.window(0, end)
    return figure


def _case1(title: str, quantity: str, results: Results, *, own: Signal, shadow: Signal, log: bool = False) -> Figure:
    curves = [
        (name, results[case], (shadow if name.startswith("adaptive") else own)(results[case]))
        for name, case in _observers.items()
    ]
    return _by_wheel(title, quantity, curves, log=log)


def _figure_2(results: Results) -> Figure:
    own, shadow = _channel("estimate.effectiveness"), _channel("shadow0.estimate.effectiveness")
    figure = _case1("Fig. 2: effectiveness and its estimates", "effectiveness", results, own=own, shadow=shadow)
    result = results["case1_repaired"]
    for i in range(3):
        figure.line(
            i,
            result.t,
            signals.effectiveness_now(result)[:, i],
            f"effectiveness {i}, true",
            labels=["true"],
            style="--",
            color="black",
        )
    return figure


def _figure_3(results: Results) -> Figure:
    title = "Fig. 3: error of the estimated effectiveness"
    return _case1(title, "error", results, own=signals.effectiveness_error, shadow=signals.shadow_error)


def _figure_4(results: Results) -> Figure:
    own, shadow = _channel("observer.rate_error"), _channel("shadow0.observer.rate_error")
    return _case1(
        "Fig. 4: error of the predicted rate", "rate error (rad/s)", results, own=own, shadow=shadow, log=True
    )


def _case2(title: str, quantity: str, channel: str, results: Results, laws: Mapping[str, str]) -> Figure:
    return _by_wheel(title, quantity, [(n, results[c], results[c][channel]) for n, c in laws.items()], 20.0)


def _figure_5(results: Results) -> Figure:
    return _case2("Fig. 5: attitude", "MRP", "truth.mrp", results, _laws)


def _figure_6(results: Results) -> Figure:
    return _case2("Fig. 6: body rate", "rate (rad/s)", "truth.omega_BN_B", results, _laws)


def _figure_7(results: Results) -> Figure:
    laws = {f"{name}, layer": case for name, case in _smooth.items()} | {"predefined time, sign(s)": "case2_ptc"}
    laws = dict(reversed(laws.items()))  # the chatter behind the others
    return _case2("Fig. 7: torque command", "command (N m)", "allocation.u", results, laws)


def _unlimited_bound(result: Result) -> Array:
    """Half-width of the bound, nothing where there is none."""
    half = result["estimate.effectiveness_bound"] * result["estimate.effectiveness"]
    return np.where(np.isfinite(half), half, 0.5)


def _observability(results: Results) -> Figure:
    figure = Figure("What the wheels do not do cannot be seen", rows=3)
    for name, case in {"silent": "case1_repaired_smooth", "moving reference": "case1_repaired_tracking"}.items():
        result = results[case]
        error = np.abs(signals.effectiveness_error(result)).max(axis=1)
        figure.line(0, result.t, error, f"largest error, {name}", labels=[name])
        figure.line(1, result.t, _unlimited_bound(result).max(axis=1), f"half-width, {name}", labels=[name])
        figure.line(
            2,
            result.t,
            np.abs(result["allocation.u"]).max(axis=1),
            f"largest command, {name}",
            "N m",
            labels=[name],
            log=True,
        )
    figure.axes[0].set_ylabel("largest error", fontsize=9)
    figure.axes[1].set_ylabel("largest half-width (0.5: unknown)", fontsize=9)
    figure.axes[2].set_ylabel("largest command (N m)", fontsize=9)
    figure.level(2, 0.3, "excitation threshold")
    figure.mark(_faults)
    figure.window(0, 50)
    return figure


def _printed_alone(results: Results) -> Figure:
    figure = Figure("The printed observer under a constant command, no disturbance", rows=3)
    names = {
        "open_plus5": "+5 N m",
        "open_plus5_n0": "+5 N m, n = 0",
        "open_minus5": "-5 N m",
        "open_minus5_repaired": "-5 N m, repaired",
    }
    for i in range(3):
        figure.axes[i].set_ylabel(f"estimate, {i}", fontsize=9)
        for case, name in names.items():
            figure.line(
                i,
                results[case].t,
                results[case]["estimate.effectiveness"][:, i],
                f"estimate {i}, {name}",
                labels=[name],
            )
        truth = signals.effectiveness_now(results["open_plus5"])[:, i]
        figure.line(
            i, results["open_plus5"].t, truth, f"effectiveness {i}, true", labels=["true"], style="--", color="black"
        )
    figure.mark(_faults)
    figure.window(0, 20)
    return figure


def _singularity(results: Results) -> Figure:
    figure = Figure("h1 = 1/2 needs a floor", rows=2, size=(8.0, 6.0))
    names = {
        "ctrl_nofloor": "h1 = 1/2, no floor",
        "ctrl_healthy": "h1 = 1/2, floor at 11 deg",
        "ctrl_h1_quarter": "h1 = 1/4, no floor",
    }
    figure.axes[0].set_ylabel("|MRP|", fontsize=9)
    figure.axes[1].set_ylabel("largest command (N m)", fontsize=9)
    for case, name in names.items():
        result = results[case]
        figure.line(
            0, result.t, np.maximum(signals.attitude(result)[:, 0], 1e-12), f"|MRP|, {name}", labels=[name], log=True
        )
        figure.line(1, result.t, np.abs(result["allocation.u"]).max(axis=1), f"command, {name}", "N m", labels=[name])
    figure.level(0, 1e-3, "1e-3")
    figure.window(0, 50)
    return figure


def _four_wheels(results: Results) -> Figure:
    figure = Figure("Four wheels, wheel 3 dead from 15 s, moving reference", rows=2, size=(8.0, 6.0))
    figure.axes[0].set_ylabel("largest MRP error", fontsize=9)
    for case, name in {"future_four_wheels": "learning observer", "future_four_wheels_unaware": "no observer"}.items():
        result = results[case]
        figure.line(0, result.t, np.abs(result["error.mrp"]).max(axis=1), f"error, {name}", labels=[name], log=True)
    result = results["future_four_wheels"]
    figure.axes[1].set_ylabel("estimated effectiveness", fontsize=9)
    for i in range(4):
        figure.line(1, result.t, result["estimate.effectiveness"][:, i], f"estimate {i}", labels=[f"wheel {i}"])
    figure.mark([(5.0, "wheel 0"), (8.0, "wheel 1"), (15.0, "wheel 3 dead")])
    figure.window(0, 50)
    return figure


def _monte_carlo(ensembles: Mapping[str, Ensemble]) -> Figure:
    names = {
        "any_free": "any attitude, no limit",
        "any": "any attitude, 20 N m",
        "limit5": "any attitude, 5 N m",
        "long": "long way, 20 N m",
        "long_shadow": "long way, shadow set",
        "faults": "faults, repaired observer",
        "nofloor": "no floor, 20 N m",
    }
    figure = Figure(
        "Monte Carlo: share of the runs settled to 1e-3", rows=1, size=(8.0, 5.0), along="settling time", unit="s"
    )
    figure.axes[0].set_ylabel("share of the runs", fontsize=9)
    for key, name in names.items():
        times = np.sort(np.nan_to_num(ensembles[key].completed(ensembles[key]["settling"]), nan=np.inf))
        settled = times[np.isfinite(times)]
        share = np.arange(1, len(settled) + 1) / len(times)
        t = np.concatenate([[0.0], np.repeat(settled, 2), [40.0]])
        y = np.concatenate([[0.0, 0.0], np.repeat(share, 2)])[: len(t)]
        figure.line(0, t, y, f"share, {name}", labels=[name], style="--" if key == "nofloor" else "-")
    figure.mark([(20.0, "T1 + T2")])
    figure.window(0, 40)
    return figure


_both = ["case1_repaired", "case1_literal"]
FIGURES = [
    PaperFigure(
        "fig2",
        "Fig. 2. Effectiveness and estimates. The printed observer forgets, has no direction and "
        "hides 2.5 N m; the repaired one and a tuned adaptive sliding-mode observer find all three faults.",
        _both,
        _figure_2,
    ),
    PaperFigure("fig3", "Fig. 3. Errors of the estimates.", _both, _figure_3),
    PaperFigure("fig4", "Fig. 4. Rate errors of the observers.", _both, _figure_4),
    PaperFigure(
        "fig5", "Fig. 5. Attitude: settled before the first fault, with either law.", [*_laws.values()], _figure_5
    ),
    PaperFigure("fig6", "Fig. 6. Body rate.", [*_laws.values()], _figure_6),
    PaperFigure(
        "fig7",
        "Fig. 7. Torque commands, with sign(s) and with a boundary layer of 0.01.",
        [*_smooth.values(), "case2_ptc"],
        _figure_7,
    ),
    PaperFigure(
        "observability",
        "Without chatter the wheels rest after the manoeuvre: the faults stay unseen, and the "
        "bound says so. A moving reference shows them.",
        ["case1_repaired_smooth", "case1_repaired_tracking"],
        _observability,
    ),
    PaperFigure(
        "printed_alone",
        "The printed observer alone ends at (u e - n) / (u + M (1 - l) / (H1 + H2)), and at zero "
        "for negative commands.",
        ["open_plus5", "open_plus5_n0", "open_minus5", "open_minus5_repaired"],
        _printed_alone,
    ),
    PaperFigure(
        "singularity",
        "With h1 = 1/2 the sliding surface is discontinuous at the target.",
        ["ctrl_nofloor", "ctrl_healthy", "ctrl_h1_quarter"],
        _singularity,
    ),
    PaperFigure(
        "four_wheels",
        "More actuators than axes, one failing completely: the estimate takes it out of the allocation.",
        ["future_four_wheels", "future_four_wheels_unaware"],
        _four_wheels,
    ),
    EnsembleFigure(
        "monte_carlo",
        "Monte Carlo: settling times. Within 20 s from every attitude with 20 N m, not with "
        "5 N m, and not without a floor.",
        ["any_free", "any", "limit5", "long", "long_shadow", "faults", "nofloor"],
        _monte_carlo,
    ),
]
