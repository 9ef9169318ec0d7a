# SPDX-License-Identifier: MIT
"""A file that remembers the margins of flown batches, so that a search that was killed goes on where it was.

Searches are deterministic: the points of a batch follow from the margins of those before. Begun again, they ask for the
same batches, and get from the file what was flown. A record is written whole or, torn, is dropped when the file is next
opened.
"""

from __future__ import annotations

import hashlib
import os
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from gyrostat.errors import InputError
from gyrostat.files import file_errors

Floats = NDArray[np.float64]

_MAGIC = b"gyrostat margins 1\n"
_HEAD = struct.Struct("<Q16s16s")  # flights, digest of their points, digest of the margins


@contextmanager
def remembered(margin: Callable[..., Floats], path: Path, identity: str) -> Iterator[Callable[..., Floats]]:
    """The margin, whose batches are kept in a file: flown once, read ever after.

    Parameters
    ----------
    margin
        As `gyrostat.verification.rare.Margin`.
    path
        Of the file; made if it is not there.
    identity
        Of what is flown; a file of another one is refused.

    Raises
    ------
    InputError
        The file belongs to another search, or asks for other points than were flown.
    FileError
        It cannot be read or written.
    """
    with file_errors(path, "cannot be written"):
        file = path.open("r+b") if path.exists() else path.open("w+b")
    with file:
        known = _read(file, path, identity)
        number = 0

        def recalled(*points: NDArray[np.generic]) -> Floats:
            nonlocal number
            digest = _digest(*points)
            if number < len(known):
                then, margins = known[number]
                if then != digest:
                    raise InputError(f"{path}: batch {number} has other flights than those that are asked for now")
            else:
                margins = np.ascontiguousarray(margin(*points), np.float64)
                data = margins.tobytes()
                with file_errors(path, "cannot be written"):
                    file.write(_HEAD.pack(margins.size, digest, _digest(margins)) + data)
                    file.flush()
                    os.fsync(file.fileno())
            number += 1
            return margins

        yield recalled


def _read(file: BinaryIO, path: Path, identity: str) -> list[tuple[bytes, Floats]]:
    """Complete records; the file ends after the last of them."""
    head = _MAGIC + hashlib.blake2b(identity.encode(), digest_size=16).digest()
    with file_errors(path, "cannot be read"):
        start = file.read(len(head))
        if start != head:
            if len(start) == len(head) or not head.startswith(start):
                raise InputError(f"{path}: holds the margins of another search; name another folder, or remove it")
            file.seek(0)
            file.truncate()
            file.write(head)
        records, end = [], file.tell()
        while len(part := file.read(_HEAD.size)) == _HEAD.size:
            count, points, check = _HEAD.unpack(part)
            data = file.read(8 * count) if count < 2**32 else b""
            margins = np.frombuffer(data[: len(data) // 8 * 8], np.float64)
            if len(data) != 8 * count or _digest(margins) != check:
                break
            records.append((points, margins))
            end = file.tell()
        file.seek(end)
        file.truncate()
    return records


def _digest(*arrays: NDArray[np.generic]) -> bytes:
    hashed = hashlib.blake2b(digest_size=16)
    for array in arrays:
        hashed.update(repr((array.shape, array.dtype.str)).encode())
        hashed.update(np.ascontiguousarray(array).tobytes())
    return hashed.digest()


__all__ = ["remembered"]
