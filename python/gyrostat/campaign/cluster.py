# SPDX-License-Identifier: MIT
"""Chunks on the workers of a Dask cluster (``pip install gyrostat[cluster]``): the same function as here.

A worker gets the campaign as text and gives a chunk as bytes; one that is lost has its chunk flown again by another.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

from gyrostat.campaign.chunks import Chunk
from gyrostat.campaign.identity import canonical, identity, resolved
from gyrostat.errors import InputError

if TYPE_CHECKING:
    from gyrostat.campaign.campaign import Campaign

RETRIES = 3
PATIENCE = 20.0
"""s, for a scheduler that is still starting."""


def run_chunk(campaign: str, expected: str, first: int, end: int, threads: int | None = 1) -> bytes:
    """Fly runs [first, end).

    Parameters
    ----------
    campaign
        Its tables as JSON.
    expected
        Its identity where it was started: a worker with other versions would give other bits.
    first, end
        Runs.
    threads
        Of this chunk.

    Returns
    -------
    bytes
        The chunk as an Arrow stream.
    """
    known, told = _campaign(campaign)
    if told != expected:
        raise InputError("a worker has another version of gyrostat, numpy or scipy than the client")
    return known.fly(first, end, jobs=threads).to_ipc()


@lru_cache(maxsize=4)
def _campaign(text: str) -> tuple[Campaign, str]:
    from gyrostat.campaign.campaign import Campaign

    campaign = Campaign.from_dict(json.loads(text))
    return campaign, identity(resolved(campaign))


def flown(campaign: Campaign, missing: list[tuple[int, int]], scheduler: str) -> Iterator[Chunk]:
    """Chunks in the order in which they come back."""
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError("--scheduler needs Dask: pip install 'gyrostat[cluster]'") from None
    if campaign.base.python_components():
        raise InputError("--scheduler: Python components do not travel; they fly here alone")
    text, expected = canonical(campaign.standalone()), identity(resolved(campaign))
    try:
        client = Client(scheduler, timeout=PATIENCE)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {scheduler}: {error}") from None
    with client:
        ahead = 4 * max(1, len(client.scheduler_info()["workers"]))
        waiting = iter(missing)
        running = as_completed()  # type: ignore[no-untyped-call]

        def submit() -> None:
            for first, end in waiting:
                running.add(client.submit(run_chunk, text, expected, first, end, retries=RETRIES, pure=False))  # type: ignore[no-untyped-call]
                return

        for _ in range(min(ahead, len(missing))):
            submit()
        for future in running:
            data = future.result()
            future.release()
            submit()
            yield Chunk.from_ipc(data)


__all__ = ["RETRIES", "flown", "run_chunk"]
