# SPDX-License-Identifier: MIT
"""The folder of a campaign: parts that a kill at any time leaves whole, and a manifest that says whose they are.

``manifest.json``, ``parts/part-<first>-<end>.parquet`` (rows), ``counts/part-<first>-<end>.json`` (counts of all runs),
``trajectories/``, and ``log.jsonl`` (times and hosts, which are in no table). Each file is written under another name,
synchronised and renamed; its counts before a part, so that a part is there exactly when all of it is. Writing a part
twice gives the same bytes: two processes that do so do no harm. A part that is not what was written, by its SHA-256
beside its counts, is refused where it is read, and flown again where the folder is. Nothing here is ever unpickled.
"""

from __future__ import annotations

import errno
import json
import os
import re
import socket
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from gyrostat.campaign import chunks
from gyrostat.campaign.chunks import Chunk
from gyrostat.campaign.identity import identity
from gyrostat.campaign.limits import whole
from gyrostat.errors import FileError, InputError, input_errors
from gyrostat.files import file_errors, replacing, writable_folder
from gyrostat.text import shown

FORMAT = 1
_keys = {"format": int, "identity": str, "resolved": dict, "campaign": dict | None, "chunk": int, "runs": int}
_again = "the command that flew the folder flies it again"
_name = re.compile(r"part-(\d{1,18})-(\d{1,18})\.parquet")


class DamagedError(InputError):
    """A part, or its counts, is not what was written."""


@dataclass(frozen=True)
class Part:
    """Runs [first, end), as far as a file is named so."""

    path: Path
    first: int
    end: int


class Store:
    """A folder, whether or not it is there already."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def existing(cls, folder: str | Path) -> Store:
        """A folder that holds a campaign.

        Raises
        ------
        InputError
            It holds none.
        """
        store = cls(Path(folder))
        if store.manifest() is None:
            raise InputError(f"{folder}: holds no campaign; there is no manifest.json in it")
        return store

    def manifest(self) -> dict[str, Any] | None:
        """Whose parts these are; None where there is none yet."""
        path = self.folder / "manifest.json"
        try:
            with file_errors(path, "cannot be read"):
                text = path.read_text(encoding="utf-8")
        except FileError:
            if path.exists():
                raise
            return None
        try:
            read = json.loads(text)
        except ValueError:
            read = None
        if not isinstance(read, dict) or not all(k in read and isinstance(read[k], kind) for k, kind in _keys.items()):
            raise InputError(f"{path}: is no manifest of a campaign")
        if read["format"] != FORMAT:
            raise InputError(f"{path}: is of format {shown(read['format'])}; {FORMAT} is read")
        if identity(read["resolved"]) != read["identity"]:
            raise InputError(f"{path}: is not what was written: its campaign is not the one of its identity")
        for key in ("chunk", "runs"):
            with input_errors(str(path)):
                whole(key, read[key], least=1)
        return read

    def begin(self, manifest: dict[str, Any]) -> None:
        """Write the manifest, or say that more runs are wanted than before."""
        known = self.manifest()
        if known is not None and known["runs"] >= manifest["runs"]:
            return
        for name in ("", "parts", "counts"):
            writable_folder(self.folder / name)
        self._write(self.folder / "manifest.json", json.dumps(manifest, indent=1).encode())

    def write(self, chunk: Chunk) -> None:
        """Write a chunk."""
        name = f"part-{chunk.first}-{chunk.end}"
        sink = pa.BufferOutputStream()
        pq.write_table(
            chunk.table,
            sink,
            compression="zstd",
            row_group_size=max(1, chunk.table.num_rows),
            write_page_checksum=True,
        )
        data = sink.getvalue()
        told = {"first": chunk.first, "end": chunk.end, "part": sha256(data).hexdigest(), "cells": chunk.counts}
        self._write(self.folder / "counts" / f"{name}.json", json.dumps(told | {"digest": _digest(told)}).encode())
        self._write(self.folder / "parts" / f"{name}.parquet", data)

    def log(self, **entry: Any) -> None:
        """Add a line to ``log.jsonl``."""
        line = json.dumps({"time": time.time(), "host": socket.gethostname(), "process": os.getpid()} | entry)
        with file_errors(self.folder / "log.jsonl", "cannot be written"), (self.folder / "log.jsonl").open("a") as file:
            file.write(line + "\n")

    def parts(self, without: Collection[Part] = ()) -> list[Part]:
        """A cover of the runs that are there, in their order, none twice; some parts may be left out."""
        found: dict[int, Part] = {}
        try:
            names = sorted(path.name for path in (self.folder / "parts").iterdir())
        except OSError:
            return []
        for name in names:
            if (match := _name.fullmatch(name)) is None:
                continue
            part = Part(self.folder / "parts" / name, int(match[1]), int(match[2]))
            longest = found.get(part.first)
            if part.end > part.first and (longest is None or longest.end < part.end) and part not in without:
                found[part.first] = part
        cover: list[Part] = []
        for first in sorted(found):
            if not cover or first >= cover[-1].end:
                cover.append(found[first])
        return cover

    def damaged(self, first: int, end: int) -> list[Part]:
        """Parts with runs of [first, end) that are not what was written.

        Raises
        ------
        FileError
            One that cannot be read: whether it is damaged nobody knows.
        """
        found: list[Part] = []
        seen: set[Part] = set()
        while new := [p for p in self.parts(found) if p not in seen and p.first < end and first < p.end]:
            seen.update(new)  # a shorter part may stand behind a damaged one
            for part in new:
                try:
                    self.data(part)
                except DamagedError:
                    found.append(part)
        return found

    def remove(self, part: Part) -> None:
        """Take a damaged part away."""
        with file_errors(part.path, "cannot be removed"):
            part.path.unlink(missing_ok=True)

    def missing(self, first: int, end: int, chunk: int, without: Collection[Part] = ()) -> list[tuple[int, int]]:
        """Runs of [first, end) that are not there, cut at multiples of the chunk size."""
        gaps, at = [], first
        for part in [*self.parts(without), Part(self.folder, end, end)]:
            if part.end <= at:
                continue
            gaps += list(_cut(at, min(part.first, end), chunk))
            at = max(at, part.end)
        return gaps

    def tables(self, columns: Sequence[str] | None = None) -> Iterator[Any]:
        """The rows that are kept, part by part, in order of run.

        Raises
        ------
        InputError
            A part that cannot be read, or whose checksums do not fit.
        """
        for part in self.parts():
            yield self.read(part, columns)

    def counts(self) -> tuple[list[Part], dict[str, Any]]:
        """Counts of all runs that are there, and the parts that they are of."""
        parts = self.parts()
        return parts, chunks.merged([self._counts(part) for part in parts])

    def failures(self, first: int, end: int, without: Collection[Part] = ()) -> int:
        """Failed flights among runs of [first, end) that are there."""
        inside = [p for p in self.parts(without) if first <= p.first and p.end <= end]
        return sum(c["failures"] for part in inside for c in self._counts(part).values())

    def table_hash(self) -> str:
        """SHA-256 of the kept rows, column by column in order of run: where parts begin and end does not matter."""
        hashes: dict[str, Any] = {}
        for table in self.tables():
            for name in table.column_names:
                hashes.setdefault(name, sha256()).update(_bytes(table.column(name)))
        told = {name: column.hexdigest() for name, column in hashes.items()}
        return sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()

    def copy_part(self, part: Part) -> None:
        """Take a part of another folder over, with its counts."""
        counts = part.path.parent.parent / "counts" / f"{part.path.stem}.json"
        for path, folder in ((counts, "counts"), (part.path, "parts")):
            target = self.folder / folder / path.name
            with file_errors(path, "cannot be read"):
                data = path.read_bytes()
            self._write(target, data)

    def read(self, part: Part, columns: Sequence[str] | None = None) -> Any:
        """The rows of a part."""
        with pq.ParquetFile(pa.BufferReader(self.data(part)), page_checksum_verification=True) as file:
            if columns is not None and (unknown := set(columns) - set(file.schema_arrow.names)):
                raise InputError(f"{part.path}: has no column '{min(unknown)}'")
            return file.read(columns=None if columns is None else list(columns))

    def data(self, part: Part) -> bytes:
        """The file of a part, as it was written.

        Raises
        ------
        DamagedError
            It is not.
        """
        with file_errors(part.path, "cannot be read"):
            data = part.path.read_bytes()
        if sha256(data).hexdigest() != self._told(part)["part"]:
            raise DamagedError(f"{part.path}: is not what was written; {_again}")
        return data

    def _counts(self, part: Part) -> dict[str, Any]:
        return dict(self._told(part)["cells"])

    def _told(self, part: Part) -> dict[str, Any]:
        path = self.folder / "counts" / f"{part.path.stem}.json"
        try:
            with file_errors(path, "cannot be read"):
                text = path.read_bytes()
            told = dict(json.loads(text))
            if told.pop("digest") == _digest(told):
                return told
        except FileError as error:
            if error.errno != errno.ENOENT:
                raise
        except (ValueError, KeyError, TypeError):
            pass
        raise DamagedError(f"{path}: is not what was written; {_again}")

    @staticmethod
    def _write(path: Path, data: Any) -> None:
        with replacing(path) as temporary, temporary.open("wb") as file:
            file.write(data)
        with file_errors(path, "cannot be written"):
            handle = os.open(path.parent, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


def _digest(told: dict[str, Any]) -> str:
    return sha256(json.dumps(told).encode()).hexdigest()


def _cut(first: int, end: int, chunk: int) -> Iterator[tuple[int, int]]:
    while first < end:
        stop = min(end, (first // chunk + 1) * chunk)
        yield first, stop
        first = stop


def _bytes(column: Any) -> bytes:
    """What of a column is hashed: numbers as they are stored, texts with their length before them."""
    if pa.types.is_dictionary(column.type):
        column = pc.cast(column, column.type.value_type)
    if pa.types.is_string(column.type):
        coded = [None if text is None else text.encode() for text in column.to_pylist()]
        return b"".join(b"\xff" * 8 if c is None else len(c).to_bytes(8, "little") + c for c in coded)
    numbers = column.to_numpy(zero_copy_only=False)
    if numbers.dtype == np.float64:
        numbers = np.where(np.isnan(numbers), np.nan, numbers)  # all of one pattern
    return bytes(np.ascontiguousarray(numbers).tobytes())


def first_difference(there: Any, here: Any, path: str = "") -> str | None:
    """The first key at which two tables differ, with both values: ``seed: 1 there, 2 here``."""
    if isinstance(there, dict) and isinstance(here, dict):
        for key in [*here, *(k for k in there if k not in here)]:
            if (found := first_difference(there.get(key), here.get(key), f"{path}.{key}" if path else key)) is not None:
                return found
        return None
    if isinstance(there, list) and isinstance(here, list) and len(there) == len(here):
        for i, (a, b) in enumerate(zip(there, here, strict=True)):
            if (found := first_difference(a, b, f"{path}.{i}")) is not None:
                return found
        return None
    return None if there == here else f"{path}: {_brief(there)} there, {_brief(here)} here"


def _brief(value: Any) -> str:
    text = shown(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


__all__ = ["FORMAT", "Part", "Store", "first_difference"]
