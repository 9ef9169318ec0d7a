# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.
from collections.abc import Sequence

from gyrostat.components import Component, Vector

def Sine(
    *,
    offset: float | None = ...,
    amplitude: float | None = ...,
    omega: float | None = ...,
    phase: float | None = ...,
) -> Component:
    """The waveform 'sine'.

    Parameters
    ----------
    offset
        m; default 0.0
    amplitude
        m; default 1.0
    omega
        m; rad/s; default 1.0
    phase
        m; rad; default 0.0
    """

def Steps(
    *,
    times: Vector,
    values: Vector,
) -> Component:
    """The waveform 'steps'.

    Parameters
    ----------
    times
        m; s
    values
        m
    """

def Sum(
    *,
    terms: Sequence[float | Component],
) -> Component:
    """The waveform 'sum'.

    Parameters
    ----------
    terms
        m
    """
