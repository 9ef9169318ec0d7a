# SPDX-License-Identifier: MIT
"""``python -m gyrostat`` is the command ``gyrostat``."""

from gyrostat.cli import main

main()
