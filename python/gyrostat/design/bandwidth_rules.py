# SPDX-License-Identifier: MIT
"""Parameters of each controller for a bandwidth and a damping, and what a law does near its reference.

That is a spring and a damper, ``tau = -kp theta - kd theta'`` about each principal axis. Sliding modes are one with two
real poles, the decay on the surface and the way to it. A power or a core has no one slope; what counts for a swing of a
certain size is its first harmonic, so that every gain here is one at an amplitude.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.design.linear_loop import Gains

Array = NDArray[np.float64]
Parameters = Mapping[str, Any]

_swing = np.sin((np.arange(64) + 0.5) * (math.pi / 64))  # half a period of a sine


@dataclass(frozen=True)
class Asked:
    """What gains are looked for, on which vehicle."""

    J: Array
    """(3,) kg m^2, principal."""
    dt: float
    """s."""
    torque: float
    """N m, usable in every direction."""
    bandwidth: float
    """rad/s, natural frequency about the axis of largest inertia."""
    damping: float
    amplitude: float
    """rad, of the error at which powers have these slopes."""

    @property
    def kp(self) -> float:
        """N m/rad."""
        return float(self.J.max()) * self.bandwidth**2

    @property
    def kd(self) -> float:
        """N m s/rad."""
        return 2.0 * self.damping * float(self.J.max()) * self.bandwidth

    @property
    def decays(self) -> tuple[float, float]:
        """1/s, of the slow and of the fast of two real poles; damping of 1 or more."""
        spread = math.sqrt(max(self.damping**2 - 1.0, 0.0))
        return self.bandwidth / (self.damping + spread), self.bandwidth * (self.damping + spread)


@dataclass(frozen=True)
class Rule:
    """How one controller gets its parameters."""

    parameters: Callable[[Asked], dict[str, Any]]
    """Those that the rule decides; all others keep their defaults."""
    gains: Callable[[Array, Parameters, float, float], Gains]
    """Of principal inertias, all parameters, an amplitude (rad) and the frequency (rad/s) of a swing."""
    sliding: bool = False
    """Two real poles: the damping is 1 or more."""


def harmonic(law: Callable[[Array], Array], amplitude: float) -> float:
    """Gain of the first harmonic that a static odd law makes of a sine of some amplitude."""
    return float(2.0 * np.mean(law(amplitude * _swing) * _swing) / amplitude)


def power(x: Array, a: float, core: float = 0.0) -> Array:
    """``|x|^a`` of what is not negative; below `core` the smooth polynomial of the terminal laws."""
    if core <= 0.0:
        return np.asarray(x**a)
    inside = (2.0 - a) * core ** (a - 1.0) * x + (a - 1.0) * core ** (a - 2.0) * x * x
    return np.where(x >= core, np.maximum(x, core) ** a, inside)


def _tan(x: Array) -> Array:
    return np.tan(0.25 * x)


# ---- a spring and a damper


def _mrp_feedback(o: Asked) -> dict[str, Any]:
    return {"K": 4.0 * o.kp, "P": o.kd}


def _mrp_feedback_gains(_J: Array, p: Parameters, _a: float, _w: float) -> Gains:
    return Gains(np.full(3, 0.25 * p["K"]), np.full(3, float(p["P"])))


def _saturated_pd(o: Asked) -> dict[str, Any]:
    return {"kp": 4.0 * o.kp, "kd": o.kd, "ws": 4.0 * o.kp / o.kd}


def _saturated_pd_gains(_J: Array, p: Parameters, _a: float, _w: float) -> Gains:
    return Gains(np.full(3, 0.25 * p["kp"]), np.full(3, float(p["kd"])))


# ---- homogeneous laws


def _attitude(x: Array, beta1: float) -> Array:
    sigma = _tan(x)
    return np.asarray(0.25 * (1.0 + sigma * sigma) * sigma**beta1)


def _rate(x: Array, beta1: float) -> Array:
    return np.where(x <= 1.0, power(x, 2.0 * beta1 / (1.0 + beta1)), 1.0)


def _nominal(o: Asked, beta1: float = 0.9) -> dict[str, Any]:
    return {
        "k1": o.kp / harmonic(lambda x: _attitude(x, beta1), o.amplitude),
        "k2": o.kd / harmonic(lambda x: _rate(x, beta1), o.amplitude * o.bandwidth),
        "beta1": beta1,
    }


def _nominal_gains(_J: Array, p: Parameters, a: float, w: float) -> Gains:
    kp = p["k1"] * harmonic(lambda x: _attitude(x, p["beta1"]), a)
    kd = p["k2"] * harmonic(lambda x: _rate(x, p["beta1"]), a * w)
    return Gains(np.full(3, kp), np.full(3, kd))


def _integral_gains(J: Array, p: Parameters, a: float, w: float) -> Gains:
    """The surface is left by little: the pull is that inside the layer, of K4 that at its edge."""
    nominal, eps = _nominal_gains(J, p, a, w), float(p["eps"])
    of_power = float(np.max(p["K4"])) * eps ** (p["gamma"] - 1.0)
    return Gains(nominal.kp, nominal.kd, float(np.max(p["K3"])) + of_power + float(np.max(p["gain_0"])) / eps)


# ---- sliding modes: a decay on the surface (1/s), a gain k (N m s) of the rate that is left, that inside a layer


def _on_surface(J: Array, decay: float, k: Array) -> Gains:
    return Gains(decay * k, k + J * decay)


def _left(a: float, w: float, decay: float) -> float:
    """Amplitude, rad/s, of the rate that a swing of the angle leaves off the surface."""
    return a * math.hypot(w, decay)


def _sliding_mode(o: Asked) -> dict[str, Any]:
    slow, fast = o.decays
    k_lin, k_sgn = 0.5 * float(o.J.max()) * fast, 0.05 * o.torque
    return {"delta": 2.0 * slow, "k_lin": k_lin, "k_sgn": k_sgn, "width": k_sgn / k_lin}


def _sliding_mode_gains(J: Array, p: Parameters, _a: float, _w: float) -> Gains:
    return _on_surface(J, 0.5 * p["delta"], np.full(3, p["k_lin"] + p["k_sgn"] / p["width"]))


def _fast_terminal(o: Asked, r: float = 0.6, core: float = 0.005) -> dict[str, Any]:
    slow, fast = o.decays
    k, s_core = float(o.J.max()) * fast, 0.05 * o.bandwidth
    b1 = 2.0 * slow / (1.0 + 0.1 * harmonic(lambda x: power(x, r, core), 0.5 * o.amplitude))
    of_power = harmonic(lambda x: power(x, r, s_core), _left(o.amplitude, o.bandwidth, slow))
    return {"b1": b1, "b2": 0.1 * b1, "r": r, "core": core, "b3": 0.9 * k, "b4": 0.1 * k / of_power, "s_core": s_core}


def _fast_terminal_gains(J: Array, p: Parameters, a: float, w: float) -> Gains:
    decay = 0.5 * (p["b1"] + p["b2"] * harmonic(lambda x: power(x, p["r"], p["core"]), 0.5 * a))
    k = p["b3"] + p["b4"] * harmonic(lambda x: power(x, p["r"], p["s_core"]), _left(a, w, decay))
    return _on_surface(J, decay, np.full(3, k))


def _terminal(o: Asked, g: float = 0.6, g2: float = 0.6) -> dict[str, Any]:
    """Of what leads to the surface a quarter is the layer's, an eighth the power's."""
    slow, fast = o.decays
    J, k_s = float(o.J.max()), 0.05 * o.torque
    eta = max(0.01, (0.5 * (2.0 - g) * slow * o.dt / 0.05) ** (1.0 / (1.0 - g)))
    a = slow / (1.0 + 0.5 * harmonic(lambda x: power(x, g, eta), 0.25 * o.amplitude))
    of_power = harmonic(lambda x: power(x, g2), 0.25 * _left(o.amplitude, o.bandwidth, slow))
    return {
        "a": a, "b": 0.5 * a, "g": g, "eta": eta, "k1": 0.625 * fast, "k2": 0.125 * fast / of_power, "g2": g2,
        "k_s": k_s, "phi": k_s / (J * fast),
    }  # fmt: skip


def _terminal_gains(J: Array, p: Parameters, a: float, w: float) -> Gains:
    decay = p["a"] + p["b"] * harmonic(lambda x: power(x, p["g"], p["eta"]), 0.25 * a)
    reach = p["k1"] + p["k2"] * harmonic(lambda x: power(x, p["g2"]), 0.25 * _left(a, w, decay))
    return _on_surface(J, decay, J * reach + 0.25 * p["k_s"] / p["phi"])


def _promise(h: float, floor: float) -> float:
    """Rate, 1/s, inside its floor of a law with a predefined time of 1 s."""
    inside = float(floor**h)
    return float(math.exp(inside) / (inside * 2.0 * h))


def _predefined(o: Asked, h: float = 0.25, floor1: float = 4.5e-4) -> dict[str, Any]:
    """Inside its floors the law is linear, and steepest. Half of what leads to the surface is the layer's."""
    slow, fast = o.decays
    k_s = 0.05 * o.torque
    phi = k_s / (2.0 * float(o.J.max()) * fast)
    floor2 = 0.5 * phi * phi
    return {
        "h1": h, "T1": _promise(h, floor1) / slow, "floor1": floor1,
        "h2": h, "T2": _promise(h, floor2) / (0.5 * fast), "floor2": floor2,
        "k_s": k_s, "phi": phi,
    }  # fmt: skip


def _predefined_gains(J: Array, p: Parameters, _a: float, _w: float) -> Gains:
    decay, reach = _promise(p["h1"], p["floor1"]) / p["T1"], _promise(p["h2"], p["floor2"]) / p["T2"]
    return _on_surface(J, decay, J * reach + 0.25 * p["k_s"] / p["phi"])


def _preassigned(o: Asked) -> dict[str, Any]:
    slow, fast = o.decays
    eta = 0.25 * o.torque / float(o.J.max())
    return {"c": slow, "b": 0.5 * fast, "eta": eta, "layer": 2.0 * eta / fast}


def _preassigned_gains(J: Array, p: Parameters, _a: float, _w: float) -> Gains:
    return _on_surface(J, float(p["c"]), J * (p["b"] + p["eta"] / p["layer"]))


RULES: dict[str, Rule] = {
    "mrp_feedback": Rule(_mrp_feedback, _mrp_feedback_gains),
    "saturated_pd": Rule(_saturated_pd, _saturated_pd_gains),
    "finite_time": Rule(_nominal, _nominal_gains),
    "integral_sliding_mode": Rule(_nominal, _integral_gains),
    "sliding_mode": Rule(_sliding_mode, _sliding_mode_gains, sliding=True),
    "fast_terminal_sliding_mode": Rule(_fast_terminal, _fast_terminal_gains, sliding=True),
    "terminal_sliding_mode": Rule(_terminal, _terminal_gains, sliding=True),
    "predefined_time": Rule(_predefined, _predefined_gains, sliding=True),
    "preassigned_time_sliding_mode": Rule(_preassigned, _preassigned_gains, sliding=True),
}
"""By the controller."""

WITHOUT_RULE: dict[str, str] = {
    "open_loop": "it closes no loop",
    "prescribed_performance": "its funnel says how fast it is: choose rho_inf and kappa",
    "mixed_learning_sliding_mode": "its gains follow from those of the learning: gyrostat design mixed_learning",
    "mixed_learning_terminal_sliding_mode": "its linear part follows from the learning: gyrostat design mixed_learning",
}
"""Why the others have none."""

__all__ = ["RULES", "WITHOUT_RULE", "Asked", "Rule", "harmonic"]
