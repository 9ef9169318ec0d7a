# SPDX-License-Identifier: MIT
"""Pages of the Python reference: which modules there are; docstrings and stubs say the rest."""

from __future__ import annotations

MODULES = {
    "scenario": "Scenarios",
    "components": "Components by name",
    "vehicle": "Vehicles",
    "faults": "Faults",
    "disturbances": "Disturbances",
    "sensors": "Sensors",
    "waveforms": "Waveforms",
    "references": "References",
    "integrators": "Integrators",
    "stacks": "The recommended stack",
    "protocols": "Components of one's own",
    "results": "Results",
    "metrics": "Metrics",
    "plots": "Figures",
    "comparison": "Comparing runs",
    "experiment": "Experiments",
    "campaign.campaign": "Campaigns",
    "campaign.dist": "Distributions",
    "campaign.results": "Results of campaigns",
    "verification.flown": "Rare, worst, tuned",
    "verification.requirements": "Requirements",
    "survival": "Survival",
    "dataset": "Data sets",
    "allocation": "Allocation",
    "attitude": "Attitude",
    "detection": "Detection",
    "design": "Design",
    "papers": "Published studies",
    "export": "Export",
    "errors": "Errors",
}


def python_pages() -> dict[str, str]:
    """Text of each page by its place."""
    lines = "\n".join(f"- [{title}]({module}.md): `gyrostat.{module}`" for module, title in MODULES.items())
    pages = {f"reference/python/{module}.md": _page(title, module) for module, title in MODULES.items()}
    pages["reference/python/index.md"] = (
        "# Python\n\n`import gyrostat as gs`; the names in use every day stand in the package itself "
        "(`gs.Scenario`, `gs.observer`, ...). Components and their parameters: [components](../components.md).\n\n"
        f"{lines}\n"
    )
    return pages


def _page(title: str, module: str) -> str:
    return f"# {title}\n\n`gyrostat.{module}`\n\n::: gyrostat.{module}\n"
