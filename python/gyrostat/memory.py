# SPDX-License-Identifier: MIT
"""How much memory a record may take."""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path


def available_memory() -> float:
    """Bytes that this process could still get; infinity where the system does not say."""
    least = math.inf
    with suppress(OSError, ValueError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                least = 1024.0 * int(line.split()[1])
    for limit in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):  # of a container
        with suppress(OSError, ValueError):
            least = min(least, float(Path(limit).read_text(encoding="ascii")))  # "max" is no number
    return least


__all__ = ["available_memory"]
