# SPDX-License-Identifier: MIT
"""The command ``gyrostat`` in a process of its own, without half a second of imports for each.

A process that has imported the command line, and done nothing else, is copied for every call: no call sees what another
one left, or anything of pytest. How the command starts, what it loads and how it answers to signals and locales is
tested with processes from nothing, in ``test_cli.py``, ``test_doors.py`` and ``test_package.py``.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import signal
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any


def gyrostat(*arguments: Any, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Exit status and what was printed; after ten minutes the process is ended."""
    server = _server()
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        call = {
            "arguments": ["gyrostat", *map(str, arguments)],
            "cwd": str(cwd or Path.cwd()),
            "files": [f"/proc/{os.getpid()}/fd/{file.fileno()}" for file in (out, err)],
        }
        assert server.stdin is not None
        assert server.stdout is not None
        server.stdin.write(json.dumps(call) + "\n")
        server.stdin.flush()
        status = int(server.stdout.readline())
        out.seek(0)
        err.seek(0)
        return subprocess.CompletedProcess(call["arguments"], status, out.read(), err.read())


@cache
def _server() -> subprocess.Popen[str]:
    """One a worker of pytest."""
    server = subprocess.Popen([sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    atexit.register(server.communicate)  # it ends with its standard input
    return server


def _serve() -> None:
    import matplotlib.figure  # noqa: F401
    import pyarrow.parquet  # noqa: F401
    import scipy.stats  # noqa: F401

    from gyrostat import cli

    gc.freeze()  # a copy that ends does not look through what it never made: 0.3 s
    for line in sys.stdin:
        call = json.loads(line)
        child = os.fork()
        if child == 0:
            _become(**call)
            _leave(cli.main)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def _become(arguments: list[str], cwd: str, files: list[str]) -> None:
    signal.alarm(600)
    os.chdir(cwd)
    sys.argv = arguments
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for descriptor, file in enumerate(files, 1):
        os.dup2(os.open(file, os.O_WRONLY | os.O_APPEND), descriptor)


def _leave(main: Callable[[], None]) -> None:
    """End with the status of `main`, at once.

    Libraries that were loaded before the copy had threads that the copy has not: to take them down would abort it.
    """
    status = 1
    try:
        main()
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


if __name__ == "__main__":
    _serve()
