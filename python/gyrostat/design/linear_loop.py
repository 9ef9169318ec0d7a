# SPDX-License-Identifier: MIT
"""The sampled attitude loop near its reference: margins and poles of a proportional-derivative law on a vehicle.

About the principal axes of the inertia that flight knows, with a command that is held for a period,

    J theta'' + delta' eta'' = tau + f H         eta'' + 2 xi w eta' + w^2 eta + delta theta'' = 0
    H' = -tau - f H                              tau = -kp theta - kd theta' - ki (J theta' - what these two asked for)

H is what wheels store and `f` their viscous friction over their inertia, which takes a command away again; "asked for"
is an integral. Attitude and rate come some samples late. A loop is opened at the torque about one principal axis while
the others stay closed, so that what appendages couple is in the margins of every axis. Frequency responses are those of
the sampled loop, exact up to half the sample rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

from gyrostat.errors import InputError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

LONGEST_DELAY = 100
"""Samples, that a loop is computed with."""

_points = 1500  # of a frequency response
_around = 40  # points about each resonance


@dataclass(frozen=True)
class Body:
    """A vehicle near its reference."""

    J: Array
    """(3,) kg m^2, principal."""
    dt: float
    """s."""
    delta: Array
    """(m, 3) kg^(1/2) m, coupling of appendages about the principal axes."""
    omega: Array
    """(m,) rad/s, the body held."""
    xi: Array
    """(m,) damping ratios."""
    friction: float = 0.0
    """1/s, viscous friction of wheels over their inertia."""
    attitude_delay: int = 0
    """samples, from the attitude to the torque that it changes."""
    rate_delay: int = 0
    """samples."""

    @cached_property
    def sampled(self) -> tuple[Array, Array]:
        """State over a period: ``x -> A x + B tau / J``, x begins with the three angles and the three rates.

        Time counts in periods and torques over inertias, so that vehicles of every size have the same digits.
        """
        m, T = len(self.omega), self.dt
        scaled = self.delta / np.sqrt(self.J)  # of angles times sqrt(J): mass matrix with a unit diagonal
        mass = np.block([[np.eye(3), scaled.T], [scaled, np.eye(m)]])
        try:
            np.linalg.cholesky(mass)
        except np.linalg.LinAlgError:
            raise InputError("the appendages carry more inertia than the vehicle") from None
        w = self.omega * T
        inverse = np.linalg.inv(mass)
        to_angle = np.concatenate([1.0 / np.sqrt(self.J), np.ones(m)])
        stiff, damp = (np.diag(np.concatenate([np.zeros(3), x])) for x in (w * w, 2.0 * self.xi * w))

        def unscaled(M: Array) -> Array:
            return np.asarray(to_angle[:, None] * M / to_angle)

        stiff, damp = unscaled(inverse @ stiff), unscaled(inverse @ damp)
        push = to_angle[:, None] * inverse[:, :3] * np.sqrt(self.J)  # of tau / J
        n = 3 + m
        order = np.r_[0:3, n : n + 3, 3:n, n + 3 : 2 * n]
        A = np.zeros((2 * n, 2 * n))
        A[:n, n:], A[n:, :n], A[n:, n:] = np.eye(n), -stiff, -damp
        B = np.zeros((2 * n, 3))
        B[n:] = push
        A, B = A[np.ix_(order, order)], B[order]
        if self.friction > 0.0:
            lost = self.friction * T
            A = np.block([[A, lost * B], [np.zeros((3, 2 * n)), -lost * np.eye(3)]])
            B = np.vstack([B, -np.eye(3)])
        whole = expm(np.block([[A, B], [np.zeros((3, len(A) + 3))]]))
        return np.asarray(whole[:-3, :-3]), np.asarray(whole[:-3, -3:])


@dataclass(frozen=True)
class Gains:
    """What a law does near its reference, about each principal axis."""

    kp: Array
    """(3,) N m/rad."""
    kd: Array
    """(3,) N m s/rad."""
    ki: float = 0.0
    """1/s: pull back to the motion that `kp` and `kd` alone would make, per momentum."""


@dataclass(frozen=True)
class Axis:
    """The loop about one principal axis."""

    J: float
    """kg m^2."""
    frequency: float
    """rad/s, natural frequency ``sqrt(kp / J)`` without sampling and delay."""
    damping: float
    """``kd / (2 sqrt(kp J))``."""
    crossover: float
    """rad/s, the highest frequency at which the loop's gain is 1."""
    phase_margin: float
    """rad, the smallest angle to -1 at a gain of 1."""
    gain_up: float
    """By which all torque about the axis may grow; infinite without end."""
    gain_down: float
    """To which it may fall; 0 without end."""
    delay_margin: float
    """s, that may be added; infinite without end."""
    delay_samples: float
    """The same in periods."""
    mode_gain: float | None
    """Largest gain of the loop at a resonance of the appendages; None without any."""


@dataclass(frozen=True)
class Loop:
    """A law on a body."""

    body: Body
    gains: Gains

    @cached_property
    def closed(self) -> Array:
        """Closed loop over a period, of the body's state, what is on its way from the sensors, and the integral."""
        b, T, J = self.body, self.body.dt, self.body.J
        A, B = b.sampled
        n, (late, later) = len(A), (b.attitude_delay, b.rate_delay)
        if max(late, later) > LONGEST_DELAY:
            raise InputError(f"a delay of {max(late, later)} samples: at most {LONGEST_DELAY} are looked at")
        size = n + 3 * (late + later) + 3
        angle, rate, integral = np.zeros((3, size)), np.zeros((3, size)), np.zeros((3, size))
        angle[:, (0 if not late else n + 3 * (late - 1)) :][:, :3] = np.eye(3)
        rate[:, (3 if not later else n + 3 * (late + later - 1)) :][:, :3] = np.eye(3)
        integral[:, -3:] = np.eye(3)
        # per inertia and period: an angle's change of rate
        asked = -(self.gains.kp * T * T / J)[:, None] * angle - (self.gains.kd * T / J)[:, None] * rate
        pull = self.gains.ki * T
        command = asked - pull * (rate - integral)
        M = np.zeros((size, size))
        M[:n, :n] = A
        M[:n] += B @ command
        for first, delay, source in ((n, late, 0), (n + 3 * late, later, 3)):
            for k in range(delay):
                M[first + 3 * k : first + 3 * k + 3, (source if k == 0 else first + 3 * (k - 1)) :][:, :3] = np.eye(3)
        M[-3:] = integral + asked
        return M if pull > 0.0 else M[:-3, :-3]

    @cached_property
    def poles(self) -> Complex:
        """Eigenvalues of the sampled closed loop, without those of the total momentum, which no wheel changes."""
        z = np.asarray(np.linalg.eigvals(self.closed), dtype=complex)
        return z[np.argsort(np.abs(z - 1.0))[3:]] if self.body.friction > 0.0 else z

    @property
    def radius(self) -> float:
        """Largest modulus of the poles: below 1 is stable."""
        return float(np.abs(self.poles).max())

    def modes(self) -> list[tuple[float, float]]:
        """Natural frequency, rad/s, and damping ratio of each pole, the slowest first."""
        z = self.poles
        z = z[(z.imag >= 0.0) & (np.abs(z) > 1e-3)]
        s = np.log(z) / self.body.dt
        found = [(float(abs(x)), float(-x.real / abs(x))) for x in s]
        return sorted(found)

    def response(self, omega: ArrayLike) -> Complex:
        """Return ratio of the torque about each principal axis, the others closed, (k, 3), at frequencies in rad/s."""
        b, T, J = self.body, self.body.dt, self.body.J
        A, B = b.sampled
        z = np.exp(1j * np.atleast_1d(np.asarray(omega, dtype=float)) * T)
        X = np.linalg.solve(
            z[:, None, None] * np.eye(len(A)) - A, np.broadcast_to(B.astype(complex), (len(z), *B.shape))
        )
        pull = self.gains.ki * T
        kp, kd = self.gains.kp * T * T / J, self.gains.kd * T / J
        late, later = z ** (-b.attitude_delay), z ** (-b.rate_delay)
        angle, rate = X[:, :3] * late[:, None, None], X[:, 3:6] * later[:, None, None]
        asked = kp[:, None] * angle + kd[:, None] * rate
        L = asked * (1.0 + pull / (z - 1.0))[:, None, None] + pull * rate
        out = np.empty((len(z), 3), dtype=complex)
        for i in range(3):
            j = [k for k in range(3) if k != i]
            others = np.eye(2) + L[:, j][:, :, j]
            back = np.linalg.solve(others, L[:, j, i][:, :, None])[:, :, 0]
            out[:, i] = L[:, i, i] - np.sum(L[:, i][:, j] * back, axis=1)
        return out

    @cached_property
    def resonances(self) -> Array:
        """(k, 2): frequency, rad/s, at which a mode of the free vehicle shows once sampled, and its damping."""
        A, _ = self.body.sampled
        s = np.log(np.linalg.eigvals(A).astype(complex))
        s = s[(s.imag > 1e-9) & (np.abs(s) > 1e-6)]
        return np.array(sorted((abs(x.imag) / self.body.dt, -x.real / abs(x)) for x in s)).reshape(-1, 2)

    @cached_property
    def frequencies(self) -> Array:
        """rad/s, dense where something resonates, up to half the sample rate."""
        highest = math.pi / self.body.dt
        slow = float(np.sqrt(self.gains.kp / self.body.J).min())
        parts = [np.geomspace(min(1e-3 * slow, 1e-2 * highest), highest, _points)]
        closed = np.log(self.poles[np.abs(self.poles) > 1e-6].astype(complex)) / self.body.dt
        near = [(abs(x.imag), abs(x.real) / max(abs(x), 1e-300)) for x in closed if x.imag > 0.0]
        for w, xi in [*near, *self.resonances]:
            spread = np.linspace(-1.0, 1.0, _around)
            parts.append(w * (1.0 + 30.0 * max(xi, 1e-6) * spread**3))
        grid = np.unique(np.concatenate(parts))
        return np.asarray(grid[(grid > 0.0) & (grid <= highest)])

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The margins about each principal axis, the smallest inertia first; of a loop that is stable."""
        w = self.frequencies
        L = self.response(w)
        beside = 1.0 + 1e-9  # of an undamped resonance, where the response has no bound
        at = self.response(beside * self.resonances[:, 0]) if len(self.resonances) else None
        return tuple(self._axis(i, w, L[:, i], None if at is None else at[:, i]) for i in range(3))

    def _axis(self, i: int, w: Array, L: Complex, at: Complex | None) -> Axis:
        J, kp, kd = (float(x[i]) for x in (self.body.J, self.gains.kp, self.gains.kd))
        size = np.log(np.abs(L))
        crossings = [self._root(i, w[k], w[k + 1], lambda x: math.log(abs(x))) for k in _changes(size)]
        room = [float(np.angle(-self.response(x)[0, i]) % (2.0 * math.pi)) for x in crossings]  # to -1, by lag
        real = [self._root(i, w[k], w[k + 1], lambda x: x.imag) for k in _changes(L.imag) if L[k].real < 0.0]
        if L[-1].real < 0.0:
            real.append(float(w[-1]))  # half the sample rate, where the response is real
        gains = np.array([-self.response(x)[0, i].real for x in real])
        up, down = gains[(gains > 0.0) & (gains < 1.0)], gains[gains > 1.0]
        delay = min((r / x for r, x in zip(room, crossings, strict=True)), default=math.inf)
        return Axis(
            J=J,
            frequency=math.sqrt(kp / J),
            damping=kd / (2.0 * math.sqrt(kp * J)),
            crossover=max(crossings, default=0.0),
            phase_margin=min((min(r, 2.0 * math.pi - r) for r in room), default=math.pi),
            gain_up=float(1.0 / up.max()) if up.size else math.inf,
            gain_down=float(1.0 / down.min()) if down.size else 0.0,
            delay_margin=delay,
            delay_samples=delay / self.body.dt,
            mode_gain=None if at is None else float(np.abs(at).max()),
        )

    def _root(self, i: int, low: float, high: float, of: object) -> float:
        def value(x: float) -> float:
            return float(of(complex(self.response(x)[0, i])))  # type: ignore[operator]

        return float(brentq(value, low, high, xtol=1e-9 * low, rtol=1e-9))

    def step(self, angle: float, axis: int, samples: int) -> tuple[Array, Array, Array]:
        """Error, rate and torque about a principal axis after an error that was there at t = 0, the body at rest.

        Returns
        -------
        tuple
            (samples,) rad, rad/s and N m, at the samples.
        """
        M, b = self.closed, self.body
        x = np.zeros(len(M))
        n = len(b.sampled[0])
        x[axis] = angle
        for k in range(b.attitude_delay):
            x[n + 3 * k + axis] = angle
        states = np.empty((samples, len(M)))
        for k in range(samples):
            states[k] = x
            x = M @ x
        late, later = b.attitude_delay, b.rate_delay
        seen = states[:, axis if not late else n + 3 * (late - 1) + axis]
        turning = states[:, 3 + axis if not later else n + 3 * (late + later - 1) + axis] / b.dt
        torque = -self.gains.kp[axis] * seen - self.gains.kd[axis] * turning
        if self.gains.ki > 0.0:
            torque -= self.gains.ki * b.J[axis] * (turning - states[:, len(M) - 3 + axis] / b.dt)
        return states[:, axis], states[:, 3 + axis] / b.dt, torque


def _changes(x: Array) -> NDArray[np.intp]:
    """Where a sign changes before the next entry."""
    return np.flatnonzero(np.signbit(x[:-1]) != np.signbit(x[1:]))


__all__ = ["Axis", "Body", "Gains", "Loop"]
