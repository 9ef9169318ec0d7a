# SPDX-License-Identifier: MIT
"""gyrostat: fault-tolerant spacecraft attitude control.

Describe a closed loop (`Scenario`), fly it (`Scenario.run`), look at what happened (`Result`)::

    import gyrostat as gs

    scenario = gs.scenarios["wheel2_degraded"]  # a shipped one; Scenario.load reads files too
    result = scenario.replace(**{"faults.0.remaining": 0.2}).run()
    result["truth.omega_BN_B"]  # channels by name, time first
    result.metrics.settling_time  # numbers that sum up the run
    result.plot("error.angle", "allocation.u")  # figures; result.show() re-plays the run in the browser
    result.to_dataframe()  # also to_xarray, to_parquet, to_csv, save

A scenario is made of

- a vehicle: `Vehicle`, or a ready-made one of `vehicle`; `Truth`, `Flexible`, `Initial` for what really flies;
- a flight stack of components by name: `navigator`, `observer`, `detector`, `controller`, `allocator`, or all of
  `recommended`; any Python object with ``step`` is one too (`protocols`);
- what happens: `faults`, `disturbances`, `sensors`, `references`, with `waveforms` in them; `integrators`.

Beside single runs: `Experiment` (many, on arrays), `Campaign` (drawn at random, on all cores), `verify`, `rare`,
`worst`, `tune`, `survive`, `comparison`; `allocation.solve` and `allocation.attainable_set` for torques alone; `design`
for gains; `papers` for published studies.

SI units and radians everywhere, quaternions scalar first, actuators counted from 0. What can be wrong with an input is
one line of an `InputError`. Components and their parameters: ``gyrostat list``, ``gyrostat describe``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gyrostat.lazy import loader

if TYPE_CHECKING:
    from gyrostat import (
        allocation,
        attitude,
        campaign,
        comparison,
        dataset,
        design,
        disturbances,
        experiment,
        faults,
        integrators,
        metrics,
        page,
        papers,
        plots,
        protocols,
        references,
        sensors,
        vehicle,
        verification,
        waveforms,
    )
    from gyrostat._core import Allocation, Demand, Detection, Estimate, Measurement, Reference, Setup, __version__
    from gyrostat.campaign import Campaign, CampaignResult
    from gyrostat.components import (
        Component,
        allocator,
        controller,
        detector,
        integrator,
        navigator,
        observer,
        reference,
    )
    from gyrostat.errors import InputError
    from gyrostat.experiment import Experiment, Flights
    from gyrostat.results import Event, Result
    from gyrostat.scenario import Record, Scenario, Shadow
    from gyrostat.shelf import scenarios
    from gyrostat.stacks import recommended
    from gyrostat.survival import survive
    from gyrostat.vehicle import ControlMomentGyros, Desaturation, Flexible, Initial, Orbit, Thrusters, Truth, Vehicle
    from gyrostat.verification.flown import rare, tune, worst
    from gyrostat.verification.requirements import verify

__all__ = [
    "Allocation",
    "Campaign",
    "CampaignResult",
    "Component",
    "ControlMomentGyros",
    "Demand",
    "Desaturation",
    "Detection",
    "Estimate",
    "Event",
    "Experiment",
    "Flexible",
    "Flights",
    "Initial",
    "InputError",
    "Measurement",
    "Orbit",
    "Record",
    "Reference",
    "Result",
    "Scenario",
    "Setup",
    "Shadow",
    "Thrusters",
    "Truth",
    "Vehicle",
    "__version__",
    "allocation",
    "allocator",
    "attitude",
    "campaign",
    "comparison",
    "controller",
    "dataset",
    "design",
    "detection",
    "detector",
    "disturbances",
    "experiment",
    "faults",
    "integrator",
    "integrators",
    "metrics",
    "navigator",
    "observer",
    "page",
    "papers",
    "plots",
    "protocols",
    "rare",
    "recommended",
    "reference",
    "references",
    "scenarios",
    "sensors",
    "survive",
    "tune",
    "vehicle",
    "verification",
    "verify",
    "waveforms",
    "worst",
]

_homes = {
    "_core": ["Allocation", "Demand", "Detection", "Estimate", "Measurement", "Reference", "Setup", "__version__"],
    "campaign": ["Campaign", "CampaignResult"],
    "components": [
        "Component",
        "allocator",
        "controller",
        "detector",
        "integrator",
        "navigator",
        "observer",
        "reference",
    ],
    "errors": ["InputError"],
    "experiment": ["Experiment", "Flights"],
    "results": ["Event", "Result"],
    "scenario": ["Record", "Scenario", "Shadow"],
    "shelf": ["scenarios"],
    "survival": ["survive"],
    "stacks": ["recommended"],
    "vehicle": ["ControlMomentGyros", "Desaturation", "Flexible", "Initial", "Orbit", "Thrusters", "Truth", "Vehicle"],
    "verification.flown": ["rare", "tune", "worst"],
    "verification.requirements": ["verify"],
}
_home_of = {name: home for home, names in _homes.items() for name in names}


__getattr__ = loader(__name__, __all__, _home_of, globals())


def __dir__() -> list[str]:
    return __all__
