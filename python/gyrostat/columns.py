# SPDX-License-Identifier: MIT
"""The channels of a run as columns of one flat table: for data frames, Parquet and CSV.

A column is named by its channel and, where that has several, by axis or number: ``truth.omega_BN_B.x``,
``truth.q_NB.w``, ``allocation.u.0``. The first column is ``time``, s.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyrostat.errors import InputError
from gyrostat.files import file_errors, replacing

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from gyrostat.results import Result


def labels(dimension: str, size: int) -> list[str] | list[int]:
    """Labels of the columns of a channel; none when they are no dimension that channels share."""
    if dimension == "actuator":
        return list(range(size))
    named = list({"axis": "xyz", "quaternion": "wxyz"}.get(dimension, ""))
    return named if len(named) == size else []


def columns(result: Result, channels: Iterable[str] | None = None) -> dict[str, tuple[str, NDArray[np.float64]]]:
    """Unit and values of every column by name, without time.

    Parameters
    ----------
    result
        The run.
    channels
        Names of channels, short or full; all that were recorded when not given.

    Raises
    ------
    InputError
        A single text instead of a list of names.
    KeyError
        Nothing of that name was recorded.
    """
    if isinstance(channels, str):
        raise InputError(f"'{channels}' is no list of names; write ['{channels}']")
    found: dict[str, tuple[str, NDArray[np.float64]]] = {}
    for name in result if channels is None else map(result.full_name, channels):
        x, unit = result[name], result.unit(name)
        if x.ndim == 1:
            found[name] = unit, x
            continue
        dimension = str(result.meta.get(name, {}).get("dimension", ""))
        for label, column in zip(labels(dimension, x.shape[1]) or range(x.shape[1]), x.T, strict=True):
            found[f"{name}.{label}"] = unit, column
    return found


def data_frame(result: Result, channels: Iterable[str] | None = None) -> pd.DataFrame:
    """A pandas table, a row an instant."""
    import pandas as pd

    values = {name: x for name, (_, x) in columns(result, channels).items()}
    return pd.DataFrame(values, index=pd.Index(result.t, name="time"))


def write(result: Result, path: str | Path, ending: str, channels: Iterable[str] | None = None) -> Path:
    """Write the table as ``.parquet`` (with the unit of each column, and the scenario) or ``.csv``.

    Returns
    -------
    Path
        The file; a name without ending gets it.

    Raises
    ------
    InputError
        Another ending, or a file that cannot be written.
    """
    import pyarrow.csv
    import pyarrow.parquet

    target = Path(path)
    if target.suffix not in ("", ending):
        raise InputError(f"{path}: this table is written as {ending}; write that ending, or none")
    with file_errors(path, "cannot be written"):
        target = target.with_suffix(ending)
    table = _arrow(result, channels)
    with replacing(target) as temporary:
        if ending == ".csv":
            pyarrow.csv.write_csv(table, str(temporary))
        else:
            pyarrow.parquet.write_table(table, str(temporary))
    return target


def _arrow(result: Result, channels: Iterable[str] | None) -> pa.Table:
    import pyarrow as pa

    found = {"time": ("s", result.t), **columns(result, channels)}
    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, (unit, _) in found.items()]
    about = {"status": result.status, "cause": result.cause, "scenario": json.dumps(result.description)}
    arrays = [np.ascontiguousarray(x) for _, x in found.values()]
    return pa.table(arrays, schema=pa.schema(fields, metadata=about))
