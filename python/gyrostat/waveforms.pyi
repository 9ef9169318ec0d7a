# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.
from collections.abc import Sequence

from gyrostat.components import Component, Vector

def Constant(
    *,
    value: float | None = ...,
) -> Component:
    """The waveform 'constant'.

    Parameters
    ----------
    value
        the value at all times; default 0.0
    """

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
        mean value; default 0.0
    amplitude
        of the sine; default 1.0
    omega
        angular frequency; rad/s; default 1.0
    phase
        angle at t = 0; pi/2 makes a cosine; rad; default 0.0
    """

def Square(
    *,
    low: float | None = ...,
    high: float | None = ...,
    period: float | None = ...,
    duty: float | None = ...,
    phase: float | None = ...,
) -> Component:
    """The waveform 'square'.

    Parameters
    ----------
    low
        value in the second part of a period; default 0.0
    high
        value in the first part of a period; default 1.0
    period
        of the wave; s; [1e-06, inf]; default 1.0
    duty
        fraction of the period that is high; [0, 1]; default 0.5
    phase
        how far into a period the wave is at t = 0; s; default 0.0
    """

def Steps(
    *,
    times: Vector | None = ...,
    values: Vector | None = ...,
) -> Component:
    """The waveform 'steps'.

    Parameters
    ----------
    times
        increasing; when each value begins; s; default [0.0]
    values
        one a time; the first also holds before its time; default [0.0]
    """

def Table(
    *,
    times: Vector | None = ...,
    values: Vector | None = ...,
) -> Component:
    """The waveform 'table'.

    Parameters
    ----------
    times
        increasing; where the values are given; s; default [0.0]
    values
        one a time; linear between, constant outside; default [0.0]
    """

def Sum(
    *,
    terms: Sequence[float | Component] | None = ...,
) -> Component:
    """The waveform 'sum'.

    Parameters
    ----------
    terms
        waveforms that are added; default []
    """
