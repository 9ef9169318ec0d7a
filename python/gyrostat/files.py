# SPDX-License-Identifier: MIT
"""Files that are never half-written: into a temporary name first, then renamed.

Temporary names begin with ``.gyrostat-`` and are locked as long as somebody writes. What a process leaves that was
killed is not locked any more, and the next one that writes into the same folder removes it.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from gyrostat.errors import FileError, InputError

_prefix = ".gyrostat-"
_unfinished: dict[Path, None] = {}
"""What the blocks below have made and will take away or rename, in this order."""


@contextmanager
def file_errors(path: str | Path, what: str) -> Iterator[None]:
    """Turn what the system says of a file into one line: ``<path>: cannot be written: no space left on device``."""
    try:
        yield
    except InputError:
        raise
    except OSError as error:
        failure = FileError(f"{path}: {what}: {(error.strerror or str(error)).lower()}")
        failure.errno = error.errno
        raise failure from None
    except UnicodeEncodeError as error:
        raise FileError(f"{path}: {what}: the name is not {error.encoding} text") from None
    except ValueError as error:  # a zero byte in the name
        raise FileError(f"{path}: {what}: {error}") from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary file beside `path` that takes its place when the block ends well, and vanishes when it does not.

    Raises
    ------
    FileError
        It cannot be written, or `path` is a folder or a device.
    """
    with file_errors(path, "cannot be written"):
        target = checked_target(path)
        handle, temporary = _locked(lambda: _new_file(target))
    _unfinished[temporary] = None
    try:
        yield temporary
        os.fsync(handle)
        temporary.chmod(0o644)
        temporary.replace(target)
    except OSError:  # a ValueError is a mistake in what is written, not of the file
        with file_errors(path, "cannot be written"):
            raise
    finally:
        temporary.unlink(missing_ok=True)
        del _unfinished[temporary]
        os.close(handle)


@contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """A temporary folder beside `path`, new or empty, that takes its name when the block ends well.

    Raises
    ------
    FileError
        It cannot be written.
    """
    with made_folder(path.absolute().parent) as parent:
        with file_errors(path, "cannot be written"):
            handle, temporary = _locked(lambda: _new_folder(parent))
        _unfinished[temporary] = None
        try:
            yield temporary
            temporary.chmod(0o755)
            temporary.replace(path)
        except OSError:
            with file_errors(path, "cannot be written"):
                raise
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
            del _unfinished[temporary]
            os.close(handle)


def write_text(path: Path, text: str) -> None:
    """Write a text file."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def checked_target(path: Path) -> Path:
    """The file that is to be written, a link followed. Nothing happens to it yet.

    Raises
    ------
    FileError
        It is a folder or a device, or cannot have this name.
    """
    with file_errors(path, "cannot be written"):
        target = Path(os.path.realpath(path))
        try:
            mode = target.lstat().st_mode
        except FileNotFoundError:
            return target
        if not stat.S_ISREG(mode):
            raise FileError(f"{path}: cannot be written: is {'a folder' if stat.S_ISDIR(mode) else 'no regular file'}")
        return target


@contextmanager
def made_folder(path: Path) -> Iterator[Path]:
    """The folder, made if it is not there; an error in the block takes back what was made and is still empty.

    Raises
    ------
    FileError
        It cannot be made, or nothing can be written in it.
    """
    made: list[Path] = []
    try:
        with file_errors(path, "cannot be written"):
            for folder in (*reversed(path.parents), path):
                if not folder.is_dir():
                    made.append(folder)  # before it is there: Ctrl-C may come between
                    _unfinished[folder] = None
                    folder.mkdir(exist_ok=True)
            with tempfile.TemporaryFile(dir=path):
                pass
        yield path
    except BaseException:
        for folder in reversed(made):
            with suppress(OSError):
                folder.rmdir()
        raise
    finally:
        for folder in made:
            del _unfinished[folder]


def abandon() -> None:
    """Take away what unfinished blocks have made: for a process that ends without leaving them."""
    for path in reversed(list(_unfinished)):
        with suppress(OSError):
            if not path.is_dir():
                path.unlink()
            elif path.name.startswith(_prefix):
                shutil.rmtree(path)
            else:
                path.rmdir()


def writable_folder(path: Path) -> Path:
    """The folder, made if it is not there.

    Raises
    ------
    FileError
        It cannot be made, or nothing can be written in it.
    """
    with made_folder(path):
        return path


def _new_file(target: Path) -> tuple[int, Path]:
    _sweep(target.parent)
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=_prefix, suffix=target.suffix)
    return handle, Path(name)


def _new_folder(parent: Path) -> tuple[int, Path]:
    _sweep(parent)
    name = tempfile.mkdtemp(dir=parent, prefix=_prefix)
    return os.open(name, os.O_RDONLY), Path(name)


def _locked(make: Callable[[], tuple[int, Path]]) -> tuple[int, Path]:
    """Lock what was made; somebody who sweeps may have been faster, then once more."""
    while True:
        handle, path = make()
        with suppress(OSError):  # a file system without locks: nobody sweeps there either
            fcntl.flock(handle, fcntl.LOCK_EX)
        if path.exists():
            return handle, path
        os.close(handle)


def _sweep(folder: Path) -> None:
    """Remove what killed processes left."""
    for path in folder.glob(f"{_prefix}*"):
        with suppress(OSError):
            handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if path.is_dir():
                    shutil.rmtree(path)
                else:
                    path.unlink()
            finally:
                os.close(handle)
