# SPDX-License-Identifier: MIT
"""The shipped scenarios as a mapping, so that a notebook completes their names: ``gs.scenarios["wheel2_degraded"]``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from gyrostat.errors import suggestion
from gyrostat.scenario import Scenario, shipped


class Shelf(Mapping[str, Scenario]):
    """The scenarios that come with the package, by the names of ``gyrostat list scenario``."""

    def __getitem__(self, name: str) -> Scenario:
        known = shipped()
        if name not in known:
            raise KeyError(f"no scenario '{name}'{suggestion(str(name), known)}")
        return Scenario.from_toml(known[name])

    def __iter__(self) -> Iterator[str]:
        return iter(shipped())

    def __len__(self) -> int:
        return len(shipped())

    def __repr__(self) -> str:
        return f"<scenarios: {', '.join(self)}>"

    def about(self, name: str) -> str:
        """What a scenario says of itself."""
        return self[name].description

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def _repr_html_(self) -> str:
        from gyrostat import notebook

        return notebook.shelf(self)


scenarios = Shelf()

__all__ = ["Shelf", "scenarios"]
