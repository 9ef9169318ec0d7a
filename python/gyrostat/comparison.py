# SPDX-License-Identifier: MIT
"""Several runs beside each other: scenarios, saved results, variants of one scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from gyrostat import toml
from gyrostat.errors import InputError, input_errors
from gyrostat.page import MOST_RUNS, channels, metric_rows
from gyrostat.results import Result
from gyrostat.scenario import Scenario


def variants(scenario: Scenario, vary: Mapping[str, Sequence[Any]]) -> dict[str, Scenario]:
    """A scenario with every combination of values, by what differs.

    Parameters
    ----------
    scenario
        What all have in common.
    vary
        Values by key, dotted as in `Scenario.replace`.

    Raises
    ------
    InputError
        A value that the scenario does not take; the message begins with the variant.

    Examples
    --------
    >>> list(variants(scenario, {"controller": ["mrp_feedback", "finite_time"]}))
    ['controller=mrp_feedback', 'controller=finite_time']
    """
    found = {}
    for values in product(*vary.values()):
        changes = dict(zip(vary, values, strict=True))
        label = ", ".join(f"{key}={_word(value)}" for key, value in changes.items())
        with input_errors(label):
            found[label] = scenario.replace(**changes)
    return found


def read_variation(text: str) -> tuple[str, list[Any]]:
    """Key and values of ``KEY=A,B,C``; commas inside brackets and quotes separate nothing."""
    key, equals, values = text.partition("=")
    parts = [part.strip() for part in _split(values)]
    if not equals or not key.strip() or not all(parts):
        raise InputError(f"--vary {text}: write KEY=A,B,..., for example --vary controller=mrp_feedback,finite_time")
    return key.strip(), [toml.value(part) for part in parts]


def _split(text: str) -> list[str]:
    parts, depth, quote = [""], 0, ""
    for character in text:
        if quote:
            quote = "" if character == quote else quote
        elif character in "\"'":
            quote = character
        else:
            depth += (character in "[{") - (character in "]}")
        if character == "," and depth == 0 and not quote:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def load(names: Iterable[str]) -> dict[str, Scenario | Result]:
    """Scenarios by file or shipped name, saved results by file or by the folder of ``gyrostat run --out``.

    Names that appear twice are numbered.
    """
    found: dict[str, Scenario | Result] = {}
    for name in names:
        path = Path(name)
        saved = path / "result.npz" if path.is_dir() else path
        label = path.name.removesuffix(".npz").removesuffix(".toml") if path.exists() else name
        number = sum(other == label or other.startswith(f"{label} #") for other in found)
        unique = f"{label} #{number + 1}" if number else label
        found[unique] = Result.load(saved) if saved.suffix == ".npz" else Scenario.load(name)
    return found


def fly(
    runs: Mapping[str, Scenario | Result],
    *,
    every: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Result]:
    """Fly what has not been flown, recording what a page shows.

    Raises
    ------
    InputError
        Fewer than two runs, or more than a page shows.
    """
    if not 2 <= len(runs) <= MOST_RUNS:
        raise InputError(f"{len(runs)} to compare; give 2 to {MOST_RUNS} scenarios or results, or vary one scenario")

    def part(done: int) -> Callable[[float], None] | None:
        return None if progress is None else lambda fraction: progress((done + fraction) / len(runs))

    return {
        label: run if isinstance(run, Result) else run.run(channels=channels(run), every=every, progress=part(k))
        for k, (label, run) in enumerate(runs.items())
    }


def _word(value: Any) -> str:
    if isinstance(value, Mapping):
        return str(value.get("type", value))
    return f"{value:g}" if isinstance(value, float) else str(value)


__all__ = ["fly", "load", "metric_rows", "read_variation", "variants"]
