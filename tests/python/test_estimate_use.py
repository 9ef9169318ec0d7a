# SPDX-License-Identifier: MIT
"""What is estimated is used once, and an actuator that comes back is used again."""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import gyrostat

import gyrostat as gs
from gyrostat import _core, design
from gyrostat.design import estimate_use
from gyrostat.export import export

NAMES = _core.catalogue()


def estimates(observer: str) -> list[str]:
    return list(_core.describe("observer", observer)["traits"]["estimates"])


LEARNING = [o for o in NAMES["observer"] if "effectiveness" in estimates(o)]


def turning(**changes: Any) -> gs.Scenario:
    """FTC-4RW follows a reference that asks for all of its wheels' torque now and then."""
    wave = {"type": "sine", "amplitude": [0.15, 0.1, -0.12], "frequency": [0.2, 0.16, 0.26]}
    base = gs.Scenario(
        vehicle=gs.vehicle.ftc_4rw(),
        controller="mrp_feedback",
        reference=wave,
        integrator="rk4",
        duration=120.0,
        dt=0.02,
    )
    return base.replace(**changes)


@pytest.mark.parametrize("observer", NAMES["observer"])
def test_an_observer_estimates_what_it_says(observer: str) -> None:
    fault = gs.faults.LossOfEffectiveness(actuator=2, t_on=5.0, remaining=0.4)
    flown = turning(observer=observer, faults=[fault], duration=20.0).run(channels=["estimate.*"])
    found = {
        "d_B": bool(flown["estimate.d_B"].any()),
        "effectiveness": bool((flown["estimate.effectiveness"] != 1.0).any()),
    }
    assert [name for name, moved in found.items() if moved] == estimates(observer)


class Claims:
    """An observer that claims something once a second has passed."""

    def __init__(self, d_B: float = 0.0, effectiveness: float = 1.0) -> None:
        self.d_B, self.effectiveness = d_B, effectiveness

    def step(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
        x = gs.Estimate.healthy(y)
        if y.tick > 50:
            x.d_B = np.full(3, self.d_B)
            x.effectiveness = np.full(len(y.h_w), self.effectiveness)
        return x


def uses(role: str, stack: dict[str, Any]) -> list[str]:
    return list(turning(**stack).compiled.estimate_flow()[role])


CONTROLLERS = [{"type": c} for c in NAMES["controller"]] + [
    {"type": c, "compensate": False}
    for c in NAMES["controller"]
    if any(p["name"] == "compensate" for p in _core.describe("controller", c)["params"])
]


@pytest.mark.parametrize("controller", CONTROLLERS, ids=lambda c: "-".join(map(str, c.values())))
def test_a_controller_subtracts_what_it_says(controller: dict[str, Any]) -> None:
    # The first demand after the claim comes from the same state with it and without.
    flown = [
        turning(observer=Claims(d_B=d), controller=controller, duration=1.04, initial={"mrp": [0.05, 0.0, 0.0]}).run(
            channels=["demand.tau_B"]
        )["demand.tau_B"][51]
        for d in (0.0, 1e-3)
    ]
    subtracts = "d_B" in uses("controller", {"controller": controller})
    # The preassigned-time law also takes d_B for planning; 1e-9: rounding of torques of a newton metre.
    assert flown[0] - flown[1] == pytest.approx(np.full(3, 1e-3 if subtracts else 0.0), abs=1e-9)


ALLOCATORS = [{"type": a} for a in NAMES["allocator"]] + [{"type": "pseudo_inverse", "use_effectiveness": False}]


@pytest.mark.parametrize("allocator", ALLOCATORS, ids=lambda a: "-".join(map(str, a.values())))
def test_an_allocator_divides_by_what_it_says(allocator: dict[str, Any]) -> None:
    small = turning(
        allocator=allocator, reference=None, initial={"mrp": [0.01, -0.01, 0.02]}, duration=1.04
    )  # no limits
    healthy, half = (
        small.replace(observer=Claims(effectiveness=e)).run(channels=["allocation.u"])["allocation.u"][51]
        for e in (1.0, 0.5)
    )
    divides = "effectiveness" in uses("allocator", {"allocator": allocator})
    # Those that weigh effort against what is missing command a little less than all of it.
    assert half == pytest.approx(healthy * (2.0 if divides else 1.0), rel=0.1, abs=1e-6)


def said(scenario: gs.Scenario) -> dict[str, tuple[bool | None, str]]:
    return {f.name: (f.ok, f.text) for f in estimate_use.findings(scenario)}


def test_check_says_who_uses_an_estimate() -> None:
    both = itertools.product([o for o in NAMES["observer"] if estimates(o)], NAMES["controller"])
    for observer, controller in both:
        found = said(turning(observer=observer, controller=controller))
        assert list(found) == estimates(observer)
        for estimate, (ok, _) in found.items():
            unused = estimate == "d_B" and controller == "open_loop"
            assert ok is (None if unused else True), (observer, controller, estimate)


def test_check_says_that_an_estimate_reaches_nobody() -> None:
    lumped = turning(observer="finite_time_disturbance", controller=gs.controller("saturated_pd", compensate=False))
    ok, text = said(lumped)["d_B"]
    assert ok is None
    assert "reaches no consumer" in text
    assert "compensate = true" in text
    assert "the detector alone" in said(lumped.replace(detector="threshold"))["d_B"][1]
    blind = turning(observer="iterative_learning", allocator=gs.allocator("pseudo_inverse", use_effectiveness=False))
    assert "use_effectiveness = true" in said(blind)["effectiveness"][1]
    assert said(turning()) == {}
    assert said(turning(observer=Claims())) == {}


class Pretending:
    """A compiled scenario whose estimates flow as a test wants."""

    def __init__(self, scenario: gs.Scenario, flow: dict[str, list[str]]) -> None:
        self.resolve = _core.Compiled(scenario.tables()).resolve
        self.check = lambda _: []
        self.estimate_flow = lambda: flow


def test_check_fails_where_two_make_up_for_one_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    # No two components of the catalogue do; an application's own may.
    flow = {
        "observer": ["effectiveness"],
        "detector": [],
        "controller": ["effectiveness"],
        "allocator": ["effectiveness"],
    }
    monkeypatch.setattr(gs.Scenario, "compiled", property(lambda s: Pretending(s, flow)))
    ok, text = said(turning(observer="iterative_learning"))["effectiveness"]
    assert ok is False
    assert "twice, by the controller and the allocator" in text


def test_the_default_law_points_with_what_its_observer_finds() -> None:
    # A wheel that pushes by itself, a quarter of its torque, bends the plain laws by degrees.
    fault = [gs.faults.Bias(actuator=2, t_on=10.0, torque=0.05)]
    for law in ("mrp_feedback", "saturated_pd", "sliding_mode"):
        base = turning(reference=None, controller=law, faults=fault, duration=100.0)
        alone, helped = (
            float(base.replace(observer=o).run(channels=["error.angle"])["error.angle"][-1])
            for o in ("passthrough", "finite_time_disturbance")
        )
        assert helped < 1e-4 * alone, law


# An actuator that comes back.


def test_observers_and_allocators_share_one_floor() -> None:
    floors = {
        (role, name): turning(**{role: name}).resolve()[role]["e_min"]
        for role, names in (("observer", LEARNING), ("allocator", NAMES["allocator"]))
        for name in names
    }
    assert set(floors.values()) == {0.05}


@pytest.mark.parametrize("allocator", ["pseudo_inverse", "lexicographic"])
def test_a_dead_wheel_that_comes_back_is_learnt_again(allocator: str) -> None:
    dead = gs.faults.Dead(actuator=2, t_on=10.0, t_off=50.0)

    def seen(observer: str) -> tuple[float, float]:
        run = turning(observer=observer, allocator=allocator, faults=[dead]).run(channels=["estimate.effectiveness"])
        wheel = run["estimate.effectiveness"][:, 2]
        return float(wheel[(run.t > 10.0) & (run.t < 50.0)].min()), float(wheel[-1])

    with ThreadPoolExecutor() as pool:
        for observer, (lowest, last) in zip(LEARNING, pool.map(seen, LEARNING), strict=True):
            assert lowest < 0.1, observer
            assert last > 0.9, observer


LOCKED = {"type": "learning_effectiveness", "e_min": 0.049}


def test_an_observer_whose_floor_is_below_the_allocators_is_refused_at_every_door(tmp_path: Path) -> None:
    scenario = turning(observer=LOCKED, dt=0.1)
    (row,) = [r for r in scenario.check() if r["where"] == "observer and allocator"]
    assert (row["ok"], row["value"], row["limit"], row["relation"]) == (False, 0.049, 0.05, ">=")
    with pytest.raises(gs.InputError, match=r"e_min of the observer.* = 0.049, must be >= 0.05"):
        scenario.run()
    with pytest.raises(gs.InputError, match="e_min of the observer"):
        export(scenario, "cpp", tmp_path / "code", samples=1)
    path = tmp_path / "locked.toml"
    scenario.to_toml(path)
    for verb in ("run", "check"):
        done = gyrostat(verb, path)
        assert done.returncode != 0
        assert "e_min of the observer" in done.stdout + done.stderr


def test_the_floors_agree_where_the_allocator_does_not_look_or_looks_lower() -> None:
    blind = {"type": "pseudo_inverse", "use_effectiveness": False}
    for allocator in (blind, {"type": "pseudo_inverse", "e_min": 0.01}, {"type": "lexicographic", "e_min": 0.049}):
        assert all(row["ok"] for row in turning(observer=LOCKED, allocator=allocator).check())
    assert all(row["ok"] for row in turning(observer="passthrough").check())


def test_what_is_refused_would_have_stayed_locked_out() -> None:
    # The same loop through an allocator that has no floor to compare: a Python one in front of the same rule.
    class Floor:
        def setup(self, setup: gs.Setup) -> None:
            self.D = np.asarray(setup.vehicle.D_B)

        def step(self, demand: gs.Demand, x: gs.Estimate, det: gs.Detection) -> Any:
            A = self.D * np.where(x.effectiveness >= 0.05, x.effectiveness, 0.0)
            return np.clip(np.linalg.pinv(A, rcond=1e-3) @ demand.tau_B, -0.2, 0.2)

    dead = gs.faults.Dead(actuator=2, t_on=10.0, t_off=50.0)
    ends = {}
    for floor in (0.049, 0.05):
        run = turning(observer={**LOCKED, "e_min": floor}, allocator=Floor(), faults=[dead], dt=0.05).run(
            channels=["estimate.effectiveness"]
        )
        ends[floor] = run["estimate.effectiveness"][-1, 2]
    assert 0.049 <= ends[0.049] < 0.05, "what it believes may be a little more, and stays below the floor for good"
    assert ends[0.05] > 0.9


def test_designs_findings_hold_both_questions() -> None:
    names = {(f.where, f.name) for f in design.findings(gs.Scenario.load("wheel2_degraded").replace(dt=0.1))}
    assert ("observer finite_time_disturbance", "d_B") in names
    assert ("sampled loop", "effectiveness") in names


# What is issued inside its limits leaves a rest.


@pytest.mark.parametrize(
    "observer",
    [
        "adaptive_iterative_learning",
        "adaptive_sliding_mode_effectiveness",
        "iterative_learning",
        "learning_effectiveness",
    ],
)
def test_what_the_issued_effectiveness_leaves_over_is_made_up_for(observer: str) -> None:
    # A body a tenth lighter than known answers a ninth more than told: e is 1.11, and 1 is issued. The law has no
    # integral. Two of them learn only while an actuator pushes hard, and gain less.
    light = -0.1 * np.asarray(gs.vehicle.ftc_4rw().J_B)
    wave = {"type": "sine", "amplitude": [0.15, 0.1, -0.12], "frequency": [0.05, 0.04, 0.06]}
    late = []
    for hand_on in (True, False):
        base = turning(
            reference=wave,
            truth=gs.Truth(dJ_B=light),
            controller="predefined_time",
            observer=gs.observer(observer, hand_on=hand_on),
            allow_unstable=True,
            dt=0.1,
        )
        flown = base.run(channels=["error.angle", "estimate.d_B"])
        late.append(float(np.sqrt(np.mean(flown["error.angle"][flown.t > 60.0] ** 2))))
        assert flown["estimate.d_B"].any() == hand_on
    assert late[0] < 0.7 * late[1], np.degrees(late)
