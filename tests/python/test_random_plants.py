# SPDX-License-Identifier: MIT
"""Random vehicles with everything that the truth knows, against a rate form in numpy that shares no line with it.

Wheels in any directions with friction, dipoles on any orbit, gyros of any geometry, six or more thrusters off centre,
any number of modes, faults between samples, alone and together. Commands are played back. The rate form integrates

    J w' + delta' eta'' = torques - w x (J w + delta' eta' + D h + sum h_i s_i)
    eta'' + 2 xi omega eta' + omega^2 eta + delta w' = 0

piece by piece with a method of order eight; truth has the total momentum and other unknowns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import gyrostat as gs

Array = NDArray[np.float64]

MU, TURN, RADIUS, G0 = 3.986004418e14, 7.292115e-5, 6371200.0, 9.80665
DIPOLE = np.array([-1410.3, 4545.5, -29350.0]) * 1e-9  # T, g11, h11, g10 of IGRF-14


def unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def dcm(q: Array) -> Array:
    """C_NB."""
    w, v = q[0], q[1:]
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray((w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * cross)


class Played:
    """An allocator that plays commands back."""

    def __init__(self, u: Array) -> None:
        self.u = u

    def step(self, demand: gs.Demand, x: gs.Estimate, det: gs.Detection) -> Array:
        del demand, det
        return np.asarray(self.u[min(x.tick, len(self.u) - 1)])


@dataclass
class Drawn:
    """A vehicle with its commands and faults; what is not there has no rows."""

    rng: np.random.Generator
    kinds: tuple[str, ...]
    dt: float = 0.25
    samples: int = 24
    remaining: dict[int, tuple[float, float]] = field(default_factory=dict)
    """By actuator: from when on, and what is left."""

    def __post_init__(self) -> None:
        rng, kinds = self.rng, self.kinds
        a, b, c = 50.0 * rng.uniform(0.6, 1.0, 3)
        frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        self.J = frame @ np.diag([b + c, a + c, a + b]) @ frame.T
        self.J = 0.5 * (self.J + self.J.T)
        self.w0, self.d_B = 0.03 * rng.normal(size=3), 0.02 * rng.normal(size=3)
        self.wheels = unit(rng.normal(size=(int(rng.integers(3, 5)) if "wheels" in kinds else 0, 3)))
        nw = len(self.wheels)
        self.Js, self.h0, self.rub = rng.uniform(0.01, 0.1, nw), 2.0 * rng.normal(size=nw), rng.uniform(0, 1e-3, nw)
        self.coils = unit(rng.normal(size=(int(rng.integers(2, 4)) if "dipoles" in kinds else 0, 3)))
        ng = int(rng.integers(3, 6)) if "gyros" in kinds else 0
        self.g = unit(rng.normal(size=(ng, 3)))
        self.s = unit(np.cross(self.g, rng.normal(size=(ng, 3))))
        self.h, self.rate, self.angle = rng.uniform(5, 20, ng), rng.uniform(0.3, 1.0, ng), rng.uniform(-2, 2, ng)
        nt = int(rng.integers(6, 9)) if "thrusters" in kinds else 0
        self.at, self.push = rng.normal(size=(nt, 3)), rng.normal(size=(nt, 3))
        self.thrust, self.Isp = rng.uniform(0.3, 2.0, nt), rng.uniform(100.0, 300.0, nt)
        self.ticks, self.least, self.pause = 25, int(rng.integers(1, 4)), int(rng.integers(1, 3))
        self.align, self.mass_B = str(rng.choice(["start", "centre"])), 0.05 * rng.normal(size=3)
        m = int(rng.choice([1, 2, 3, 5, 8])) if "modes" in kinds else 0
        self.delta = rng.normal(size=(m, 3)) * math.sqrt(15.0 / max(m, 1))
        while np.linalg.eigvalsh(self.J - self.delta.T @ self.delta)[0] < 10.0:
            self.delta *= 0.8
        self.omega, self.xi = rng.uniform(0.5, 4.0, m), rng.uniform(0.0, 0.05, m)
        self.eta, self.eta_rate = 0.1 * rng.normal(size=m), 0.02 * rng.normal(size=m)
        self.orbit = self._orbit() if "dipoles" in kinds or "orbit" in kinds else None
        self.residual = 20.0 * rng.normal(size=3) if self.orbit else np.zeros(3)
        self.first_gyro = nw + len(self.coils)
        self.first_thruster = self.first_gyro + ng
        self.count = self.first_thruster + nt
        lever = np.cross(self.at - self.mass_B, unit(self.push)) if nt else np.zeros((0, 3))
        self.torque_B = lever * self.thrust[:, None]  # N m, of each while its valve is open
        top = np.concatenate(
            [
                np.full(nw, 0.6),
                np.full(len(self.coils), 500.0),
                self.h * self.rate,
                np.linalg.norm(self.torque_B, axis=1),
            ]
        )
        share = rng.uniform(-1.0, 1.0, (self.samples + 1, self.count))
        share[:, self.first_thruster :] = np.maximum(share[:, self.first_thruster :], 0.0)
        self.u = share * top
        end = self.dt * self.samples
        for i in rng.permutation(self.count)[:3]:
            self.remaining[int(i)] = (float(rng.uniform(0.0, 0.8 * end)), float(rng.choice([0.0, rng.uniform()])))

    def _orbit(self) -> dict[str, Any]:
        rng, e = self.rng, float(self.rng.choice([0.0, 0.1, 0.4]))
        ellipse = {"eccentricity": e, "perigee": float(rng.uniform(-3, 3))} if e else {}
        angles = {k: float(rng.uniform(-3, 3)) for k in ("raan", "argument_of_latitude", "earth_angle")}
        size = {"semi_major_axis": float(rng.uniform(7e6, 8e6) / (1.0 - e)), "inclination": float(rng.uniform(0, 3.1))}
        return size | angles | ellipse | {"sun_N": [0.0, 0.0, 1.0]}

    def scenario(self) -> gs.Scenario:
        nw, nc, ng = len(self.wheels), len(self.coils), len(self.g)
        pad = [0.0] * (nc + ng)
        vehicle: dict[str, Any] = {"J_B": self.J.tolist()}
        tables: dict[str, Any] = {
            "vehicle": vehicle,
            "initial": {"q_NB": [0.8, 0.2, -0.4, 0.4], "omega_BN_B": self.w0.tolist()},
            "disturbances": [{"type": "constant", "torque_B": self.d_B.tolist()}],
            "faults": [
                {"type": "loss_of_effectiveness", "actuator": i, "t_on": t_on, "remaining": left}
                for i, (t_on, left) in self.remaining.items()
            ],
            "integrator": {"type": "auto", "rtol": 1e-12},
            "controller": "open_loop",
            "duration": self.dt * self.samples,
            "dt": self.dt,
        }
        if nw + nc:
            vehicle |= {"D_B": np.vstack([self.wheels, self.coils]).T.tolist(), "wheel_inertia": [*self.Js, *pad]}
            vehicle |= {"magnetorquers": list(range(nw, nw + nc))} if nc else {}
        if nw:
            speed = self.h0 / self.Js - self.wheels @ self.w0
            tables["initial"]["wheel_speed"] = [*speed, *pad]
            tables["truth"] = {"viscous_friction": [*self.rub, *pad]}
        if self.orbit:
            residual = {"type": "residual_dipole", "dipole_B": self.residual.tolist()}
            tables["disturbances"] += [{"type": "gravity_gradient"}, residual]
            tables["orbit"] = self.orbit
        if ng:
            tables["cmg"] = {
                "gimbal_axes": self.g.tolist(), "spin_axes": self.s.tolist(), "rotor_momentum": self.h.tolist(),
                "rate_max": self.rate.tolist(), "angles": self.angle.tolist(),
            }  # fmt: skip
        if len(self.at):
            tables["thrusters"] = {
                "positions": self.at.tolist(), "directions": self.push.tolist(), "thrust": self.thrust.tolist(),
                "centre_of_mass": self.mass_B.tolist(), "tick": self.dt / self.ticks, "min_on": self.least,
                "min_off": self.pause, "align": self.align, "Isp": self.Isp.tolist(),
            }  # fmt: skip
        if len(self.omega):
            modes = {
                "delta": self.delta,
                "omega": self.omega,
                "xi": self.xi,
                "eta": self.eta,
                "eta_rate": self.eta_rate,
            }
            tables["flexible"] = {k: v.tolist() for k, v in modes.items()}
        return gs.Scenario.from_dict(tables).replace(allocator=Played(self.u))

    def left(self, i: int, t: float) -> float:
        t_on, left = self.remaining.get(i, (math.inf, 1.0))
        return left if t >= t_on else 1.0

    def pulses(self, k: int) -> list[tuple[float, float]]:
        """Opening and closing of each valve in a sample; an empty window where it stays closed."""
        found, tick = [], self.dt / self.ticks
        for i, top in enumerate(np.linalg.norm(self.torque_B, axis=1)):
            n = math.floor(self.u[k, self.first_thruster + i] / top * self.ticks + 0.5)
            n = 0 if n < self.least else self.ticks if self.ticks - n < self.pause else n
            begins = k * self.dt + (0.5 * (self.ticks - n) * tick if self.align == "centre" else 0.0)
            found.append((begins, begins + n * tick))
        return found

    def surroundings(self, t: float) -> tuple[Array, Array]:
        """Position (m) and field (T), in N."""
        o = self.orbit or {}
        a, e, perigee = o["semi_major_axis"], o.get("eccentricity", 0.0), o.get("perigee", 0.0)
        ratio = math.sqrt((1.0 - e) / (1.0 + e))
        E0 = 2.0 * math.atan(ratio * math.tan(0.5 * (o["argument_of_latitude"] - perigee)))
        M = E0 - e * math.sin(E0) + math.sqrt(MU / a**3) * t
        E = M
        for _ in range(50):
            E -= (E - e * math.sin(E) - M) / (1.0 - e * math.cos(E))
        u, r = perigee + 2.0 * math.atan2(math.sin(0.5 * E), ratio * math.cos(0.5 * E)), a * (1.0 - e * math.cos(E))
        c, s, ci, si = math.cos(o["raan"]), math.sin(o["raan"]), math.cos(o["inclination"]), math.sin(o["inclination"])
        up = math.cos(u) * np.array([c, s, 0.0]) + math.sin(u) * np.array([-s * ci, c * ci, si])
        th = o["earth_angle"] + TURN * t
        east, north = math.cos(th), math.sin(th)
        g = np.array([east * DIPOLE[0] - north * DIPOLE[1], north * DIPOLE[0] + east * DIPOLE[1], DIPOLE[2]])
        return r * up, (RADIUS / r) ** 3 * (3.0 * (g @ up) * up - g)

    def flown(self) -> tuple[Array, float]:
        """The state at the end (q, w, eta, eta', h, gimbal angles), and propellant used (kg)."""
        end = self.dt * self.samples
        edges = {t for t_on, _ in self.remaining.values() for t in (t_on,)} | {
            k * self.dt for k in range(self.samples + 1)
        }
        edges |= {t for k in range(self.samples) for window in self.pulses(k) for t in window}
        times = np.unique(np.round([t for t in edges if t <= end], 12))
        y = np.concatenate([[0.8, 0.2, -0.4, 0.4], self.w0, self.eta, self.eta_rate, self.h0, self.angle])
        used = 0.0
        for begins, ends in pairwise(times):
            middle = 0.5 * (begins + ends)
            k = min(int(middle / self.dt), self.samples - 1)
            given = np.array([self.u[k, i] * self.left(i, middle) for i in range(self.count)])
            torque_B = self.d_B.copy()
            for i, (opens, closes) in enumerate(self.pulses(k)):
                share = self.left(self.first_thruster + i, middle) if opens <= middle < closes else 0.0
                torque_B += share * self.torque_B[i]
                used += share * self.thrust[i] / (self.Isp[i] * G0) * (ends - begins)
            rates = partial(self.rates, given=given, held_B=torque_B)
            y = solve_ivp(rates, (begins, ends), y, method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
        return y, used

    def rates(self, t: float, y: Array, given: Array, held_B: Array) -> Array:
        """How the state moves under what each actuator is given and a torque (N m) that is held."""
        nw, nc, m = len(self.wheels), len(self.coils), len(self.omega)
        q, w, (eta, eta_rate, h, angle) = y[:4], y[4:7], np.split(y[7:], np.cumsum([m, m, nw]))
        torque = held_B.copy()
        if self.orbit:
            C = dcm(q)
            r_N, field_N = self.surroundings(t)
            down = C.T @ unit(r_N)
            torque += np.cross(self.residual + given[nw : nw + nc] @ self.coils, C.T @ field_N)
            torque += 3.0 * MU / np.linalg.norm(r_N) ** 3 * np.cross(down, self.J @ down)
        motor = given[:nw] + self.rub * (h / self.Js - self.wheels @ w)
        turning = given[self.first_gyro : self.first_thruster] / self.h
        across, cos, sin = np.cross(self.g, self.s), np.cos(angle)[:, None], np.sin(angle)[:, None]
        spin, swing = self.s * cos + across * sin, across * cos - self.s * sin
        torque += motor @ self.wheels - (self.h * turning) @ swing
        body = self.J - self.wheels.T @ np.diag(self.Js) @ self.wheels
        H = body @ w + eta_rate @ self.delta + h @ self.wheels + self.h @ spin
        bend = -2.0 * self.xi * self.omega * eta_rate - self.omega**2 * eta
        mass = np.block([[body, self.delta.T], [self.delta, np.eye(m)]])
        speed_up = np.linalg.solve(mass, np.concatenate([torque - np.cross(w, H), bend]))
        spun = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([spun, speed_up[:3], eta_rate, speed_up[3:], -motor, turning])


CASES = [
    ("wheels",), ("thrusters",), ("gyros",), ("dipoles", "wheels"), ("wheels", "modes"), ("thrusters", "modes"),
    ("wheels", "thrusters"), ("gyros", "modes"), ("gyros", "wheels"), ("gyros", "thrusters"), ("gyros", "dipoles"),
    ("wheels", "orbit", "modes"), ("dipoles", "wheels", "thrusters"), ("dipoles", "wheels", "gyros", "modes"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("seed", "kinds"), list(enumerate(CASES)), ids=lambda x: "-".join(x) if isinstance(x, tuple) else ""
)
def test_the_truth_ends_where_the_rate_form_does(seed: int, kinds: tuple[str, ...]) -> None:
    drawn = Drawn(np.random.default_rng(seed), kinds)
    names = ["truth.q_NB", "truth.omega_BN_B", "truth.h_w"]
    names += ["truth.eta"] if "modes" in kinds else []
    names += ["truth.gimbal"] if "gyros" in kinds else []
    names += ["truth.propellant"] if "thrusters" in kinds else []
    flown = drawn.scenario().run(channels=names)
    y, used = drawn.flown()
    nw, m = len(drawn.wheels), len(drawn.omega)
    q = flown["truth.q_NB"][-1]
    # two integrators at 1e-12 of a state of order one; modes add what their frequency makes of it
    np.testing.assert_allclose(np.sign(q @ y[:4]) * q, y[:4] / np.linalg.norm(y[:4]), rtol=0, atol=1e-10)
    np.testing.assert_allclose(flown["truth.omega_BN_B"][-1], y[4:7], rtol=0, atol=1e-10)
    np.testing.assert_allclose(flown["truth.h_w"][-1][:nw], y[7 + 2 * m : 7 + 2 * m + nw], rtol=0, atol=1e-10)
    if m:
        np.testing.assert_allclose(flown["truth.eta"][-1], y[7 : 7 + m], rtol=0, atol=1e-9)
    if "gyros" in kinds:
        angles = flown["truth.gimbal"][-1][drawn.first_gyro : drawn.first_thruster]
        np.testing.assert_allclose(angles, y[7 + 2 * m + nw :], rtol=0, atol=1e-10)
    if "thrusters" in kinds:
        assert flown["truth.propellant"].ravel()[-1] == pytest.approx(used, abs=1e-14)
