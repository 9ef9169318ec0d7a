# SPDX-License-Identifier: MIT
"""A chunk of runs: the rows that are kept of it, and counts of all of it. The same bits wherever it is flown."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa

from gyrostat import _core
from gyrostat.campaign.flights import RAISED, Outcome
from gyrostat.campaign.inputs import Draws
from gyrostat.campaign.sampled_faults import NONE
from gyrostat.campaign.sketches import Sketch
from gyrostat.campaign.spec import Spec

_words = pa.dictionary(pa.int32(), pa.string())
_metadata = b"gyrostat.counts"


@dataclass(frozen=True)
class Chunk:
    """Runs [first, end).

    Attributes
    ----------
    table
        Rows of the runs, cells in order inside a run: ``run``, ``cell``, inputs as drawn, measures, ``success``,
        ``margin`` where there is one, ``status``, ``cause`` (null where completed), ``t_end``.
    counts
        By cell: runs, failures, statuses, and of each measure the sum of its finite values and a sketch.
    """

    first: int
    end: int
    table: Any
    counts: dict[str, Any]

    def to_ipc(self) -> bytes:
        """As an Arrow stream, counts in its metadata."""
        told = {"first": self.first, "end": self.end, "cells": self.counts}
        table = self.table.replace_schema_metadata({_metadata: json.dumps(told).encode()})
        sink = pa.BufferOutputStream()
        with pa.ipc.new_stream(sink, table.schema) as writer:
            writer.write_table(table)
        return bytes(sink.getvalue())

    @classmethod
    def from_ipc(cls, data: bytes) -> Chunk:
        """As written by `to_ipc`."""
        with pa.ipc.open_stream(data) as reader:
            table = reader.read_all()
        told = json.loads(table.schema.metadata[_metadata])
        return cls(told["first"], told["end"], table.replace_schema_metadata(None), told["cells"])


def made(spec: Spec, draws: Draws, outcomes: Mapping[str, Outcome], first: int) -> Chunk:
    """Of drawn runs and what became of them in each cell."""
    cells = list(outcomes)
    n = len(draws.values)
    columns: dict[str, Any] = {
        "run": pa.array(np.repeat(np.arange(first, first + n, dtype=np.int64), len(cells))),
        "cell": _dictionary(np.tile(np.arange(len(cells)), n), cells),
    }
    kinds = {f"fault.{f.name}.{k}.kind": [kind.type for kind in f.kind] for f in spec.fault for k in range(f.most)}
    for name, drawn in draws.columns.items():
        if name in kinds:
            known = [*kinds[name], NONE]
            codes = np.array([known.index(word) for word in drawn], dtype=np.int64)
            columns[name] = _dictionary(np.repeat(codes, len(cells)), known)
        else:
            columns[name] = pa.array(np.repeat(drawn, len(cells)))
    all_of = list(outcomes.values())
    for name in all_of[0].measures:
        columns[name] = pa.array(_woven([o.measures[name] for o in all_of]))
    success = _woven([o.success for o in all_of])
    columns["success"] = pa.array(success)
    if all_of[0].margin is not None:
        columns["margin"] = pa.array(_woven([o.margin for o in all_of]))
    statuses = [*_core.endings(), RAISED]
    codes = np.array([[statuses.index(s) for s in o.status] for o in all_of], dtype=np.int64).reshape(len(cells), n)
    columns["status"] = _dictionary(codes.T.ravel(), statuses)
    columns["cause"] = pa.array(
        [cause for row in zip(*[o.cause for o in all_of], strict=True) for cause in row], pa.string()
    )
    columns["t_end"] = pa.array(_woven([o.t_end for o in all_of]))
    table = pa.table(columns)
    if spec.keep.rows == "failures":
        kept = ~success
        if spec.keep.every is not None:
            kept |= columns["run"].to_numpy() % spec.keep.every == 0
        table = table.filter(pa.array(kept))
    return Chunk(first, first + n, table, {label: _counts(o) for label, o in outcomes.items()})


def columns_of(inputs: Sequence[str], measures: Sequence[str]) -> list[str]:
    """Names of all columns but margin; each must be another."""
    return ["run", "cell", *inputs, *measures, "success", "margin", "status", "cause", "t_end"]


def _counts(o: Outcome) -> dict[str, Any]:
    return {
        "runs": len(o.success),
        "failures": int(np.count_nonzero(~o.success)),
        "status": dict(sorted(Counter(map(str, o.status)).items())),
        "measures": {
            name: {"sum": math.fsum(x[np.isfinite(x)]), "bins": Sketch.of(x).to_dict()}
            for name, x in o.measures.items()
        },
    }


def merged(counts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Counts of several chunks, in order of run, as those of one."""
    out: dict[str, Any] = {}
    for label in counts[0] if counts else ():
        parts = [c[label] for c in counts]
        status: Counter[str] = Counter()
        for part in parts:
            status.update(part["status"])
        out[label] = {
            "runs": sum(p["runs"] for p in parts),
            "failures": sum(p["failures"] for p in parts),
            "status": dict(sorted(status.items())),
            "measures": {
                name: {
                    "sum": math.fsum(p["measures"][name]["sum"] for p in parts),
                    "bins": Sketch.merged(Sketch.from_dict(p["measures"][name]["bins"]) for p in parts).to_dict(),
                }
                for name in parts[0]["measures"]
            },
        }
    return out


def _woven(parts: Sequence[Any]) -> Any:
    """One array a cell to one of all rows, cells in order inside a run."""
    return np.ascontiguousarray(np.stack(parts, axis=1).ravel())


def _dictionary(codes: Any, words: Sequence[str]) -> Any:
    return pa.DictionaryArray.from_arrays(pa.array(codes.astype(np.int32)), pa.array(list(words), pa.string()))


Fly = Callable[[int, int], Chunk]

__all__ = ["Chunk", "Fly", "columns_of", "made", "merged"]
