# SPDX-License-Identifier: MIT
"""Start of the command ``gyrostat`` and of ``python -m gyrostat``: Ctrl-C is one line from the first moment on."""

from __future__ import annotations

import os
import signal


def main() -> None:
    """Load the command line and run it."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # ignored in the background of a script
        signal.signal(signal.SIGINT, _leave)
    from gyrostat.cli import main as run

    run()


def _leave(*_: object) -> None:
    """Nothing has been written yet."""
    os.write(2, b"error: interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    main()
