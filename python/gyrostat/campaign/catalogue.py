# SPDX-License-Identifier: MIT
"""Campaigns that come with the package."""

from __future__ import annotations

from pathlib import Path

_folder = Path(__file__).parent.parent / "campaigns"


def shipped() -> dict[str, Path]:
    """Their files, by name."""
    return {p.stem: p for p in sorted(_folder.glob("*.toml"))}


__all__ = ["shipped"]
