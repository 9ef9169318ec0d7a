# SPDX-License-Identifier: MIT
"""The sampled error loop of a learning law: spectral radius, equilibrium, step response.

error[k+1] = error[k] + dt J^-1 (d - K_lin error[k] - sign_gain sat(error[k] / width) - learnt[k])
learnt[k]  = keep learnt[k-n] + K (before error[k-n] + now error[k])
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LearningLoop:
    """Inertia (kg m^2), period (s) and gains of one learning loop."""

    J: Array
    dt: float
    K_lin: Array
    """N m s, shape (3, 3)."""
    K: Array
    """N m s, shape (3, 3): torque learnt per error."""
    now: float
    before: float
    keep: float
    delay: int = 1
    sign_gain: float = 0.0
    """N m."""
    width: float = 0.0
    """rad/s; 0: a sign."""

    def matrix(self, slope: float = 0.0) -> Array:
        """Transition of (error, carried torques), shape (3 + 3 delay, 3 + 3 delay).

        Parameters
        ----------
        slope
            What the layer of the sign term adds to `K_lin`, N m s.
        """
        n = 3 + 3 * self.delay
        A = np.zeros((n, n))
        to_rate = self.dt * np.linalg.inv(self.J)
        A[:3, :3] = np.eye(3) - to_rate @ (self.K_lin + slope * np.eye(3) + self.now * self.K)
        A[:3, 3:6] = -to_rate
        A[3:-3, 6:] = np.eye(n - 6)
        A[-3:, 3:6] += self.keep * np.eye(3)
        A[-3:, :3] += (self.keep * self.now + self.before) * self.K
        return A

    def spectral_radius(self) -> float:
        """Largest modulus of the eigenvalues, inside the layer and out of it."""
        slopes = {0.0, self.sign_gain / self.width if self.width > 0.0 else 0.0}
        return max(float(np.abs(np.linalg.eigvals(self.matrix(s))).max()) for s in slopes)

    def equilibrium(self, torque_B: Array) -> tuple[Array, Array]:
        """Error (rad/s) and learnt torque (N m) under a constant torque, exactly, the sign term included.

        Every combination of pushing, sticking and, with a layer, sliding axes is tried; a definite loop has one.

        Raises
        ------
        InputError
            No combination is consistent: `keep` is 1, or the gains are not definite.
        """
        if self.keep >= 1.0:
            raise InputError(f"keep = {self.keep:g}: a perfect integral has no equilibrium with a sign term")
        gain = (self.now + self.before) / (1.0 - self.keep) * self.K
        M = gain + self.K_lin
        slope = self.sign_gain / self.width if self.width > 0.0 else 0.0
        for pattern in itertools.product((-1.0, 0.0, 1.0), repeat=3):
            free = np.array(pattern) == 0.0
            push = self.sign_gain * np.array(pattern)
            error = np.zeros(3)
            if slope > 0.0:
                error[:] = np.linalg.solve(M + np.diag(slope * free), torque_B - push)
                inside = np.abs(error) <= self.width * (1.0 + 1e-12)
            else:
                if not free.all():
                    error[~free] = np.linalg.solve(M[np.ix_(~free, ~free)], (torque_B - push)[~free])
                inside = np.abs(torque_B - M @ error) <= self.sign_gain * (1.0 + 1e-12) + 1e-300
            if (inside | ~free).all() and (np.sign(error) == pattern)[~free].all():
                return error, gain @ error
        raise InputError("the loop has no equilibrium: K is not definite")

    def response(self, torque_B: Array, samples: int) -> Array:
        """Learnt torque at every sample after a constant torque began, N m.

        Parameters
        ----------
        torque_B
            N m, shape (..., 3): one torque or many.

        Returns
        -------
        NDArray
            Shape (samples, ..., 3).
        """
        torque = np.asarray(torque_B, dtype=float)
        to_rate, K_lin, K = self.dt * np.linalg.inv(self.J).T, self.K_lin.T, self.K.T
        error, carried = np.zeros(torque.shape), [np.zeros(torque.shape)] * self.delay
        out = np.empty((samples, *torque.shape))
        for k in range(samples):
            fresh = error @ K
            learnt = carried[k % self.delay] + self.now * fresh
            carried[k % self.delay] = self.keep * learnt + self.before * fresh
            layer = np.clip(error / self.width, -1.0, 1.0) if self.width > 0.0 else np.sign(error)
            error = error + (torque - error @ K_lin - self.sign_gain * layer - learnt) @ to_rate
            out[k] = learnt
        return out


def settling(learnt: Array, final: Array, band: float, dt: float) -> float:
    """Time, s, until every axis stays within `band` (N m) of its final value; nan if it does not."""
    outside = np.flatnonzero((np.abs(learnt - final) > band).any(axis=1))
    if outside.size and outside[-1] == len(learnt) - 1:
        return float("nan")
    return float((outside[-1] + 1 if outside.size else 0) * dt)
