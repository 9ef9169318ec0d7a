# SPDX-License-Identifier: MIT
"""Numbers as a page carries them: binary, in base64."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.thinning import Array, Indices


def cost(samples: int, kept: Indices) -> int:
    """Characters of the kept samples of a run of so many: index and value, and what stands around them."""
    return len(kept) * (4 + _index_type(samples).itemsize) * 4 // 3 + 90


def _index_type(samples: int) -> np.dtype[Any]:
    return np.dtype("<u2" if samples <= 1 << 16 else "<u4")


def pack_indices(kept: Indices, samples: int) -> str:
    """Indices of a run of so many samples: two bytes each if that is enough, else four."""
    return _packed(kept.astype(_index_type(samples)))


def pack(x: NDArray[Any]) -> str:
    """Values in single precision, seven digits; an infinity is not drawn and stands as not a number."""
    with np.errstate(over="ignore"):
        single = np.asarray(x, dtype="<f4")
    return _packed(np.where(np.isfinite(single), single, np.float32(np.nan)).astype("<f4"))


def pack_times(t: Array) -> str:
    """Instants in double precision."""
    return _packed(np.asarray(t, dtype="<f8"))


def _packed(x: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(x).tobytes()).decode()


def clock(t: Array) -> dict[str, Any]:
    """How the page counts time: start, step, number and end when the samples are evenly spaced, else all instants.

    A recording keeps the last sample always, so the last step may be shorter.
    """
    n = len(t)
    step = float(t[1] - t[0]) if n > 1 else 0.0
    regular = float(t[0]) + step * np.arange(n)
    if np.allclose(regular[:-1], t[:-1], rtol=1e-9, atol=1e-6 * step):
        return {"start": float(t[0]), "step": step, "count": n, "end": float(t[-1])}
    return {"count": n, "times": pack_times(t)}
