# SPDX-License-Identifier: MIT
"""Gain designs of mixed learning: published gains rebuilt, margins, random designs, and what the command line says."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import numpy as np
import pytest
from commands import gyrostat
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import papers
from gyrostat.design import CHECKS, DESIGNS, DesignReport
from gyrostat.design.learning_loop import LearningLoop, settling
from gyrostat.design.mixed_learning import (
    best_case,
    conditions_hold,
    design_observer,
    design_sliding_mode,
    observer_margins,
    sliding_margins,
)

Array = NDArray[np.float64]

J = np.array([[18.73, 1.0, 0.090], [1.0, 20.77, 0.092], [0.090, 0.092, 23.63]])
K1 = np.array([[0.2159, 0.0062, 0.0006], [0.0062, 0.2285, 0.0006], [0.0006, 0.0006, 0.2462]])
K2 = np.array([[4.8176, -0.2319, -0.0174], [-0.2319, 4.3444, -0.0160], [-0.0174, -0.0160, 3.8088]])
DISTURBANCE = 2.4e-3


def table(K1: Array = K1, K2: Array = K2, **changes: float) -> LearningLoop:
    values: dict[str, Any] = {"now": 0.9, "before": 0.1, "keep": 0.99, "sign_gain": 0.005} | changes
    return LearningLoop(J, 1e-3, K1, K2, **values)


def command(*arguments: str) -> tuple[int, str, str]:
    done = gyrostat(*arguments)
    return done.returncode, done.stdout, done.stderr


def random_inertia(rng: np.random.Generator, size: float) -> Array:
    """Principal moments that satisfy the triangle inequality, in a random frame."""
    masses = rng.uniform(0.2, 1.0, 3)
    moments = masses.sum() - masses
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return np.asarray(size * frame @ np.diag(moments) @ frame.T)


def test_the_published_gains_are_rebuilt() -> None:
    loop = design_observer(J, 1e-3).loop
    assert np.abs(loop.K_lin - K1).max() < 5.1e-5, "half a unit of the printed digits"
    assert np.abs(loop.K - K2).max() < 5.1e-5
    np.testing.assert_allclose(design_sliding_mode(J, 1e-3).loop.K, np.eye(3) / 0.99, rtol=1e-14, atol=1e-16)


# set, P1, (m11, r12, m13, m14, m15), spectral radius: of an independent implementation
COMPLIANT = design_observer(J, 1e-3, P1=88.2, sigma2=0.98, sigma1=0.02, theta1=0.005, theta2=0.99).loop
PROPER = design_observer(J, 1e-3, P1=1.0, sigma1=0.1, theta1=0.005, theta2=0.99).loop
SETS = {
    "published, P1 = I": (table(), 1.0, (0.685, 80.0, 2.98e-4, -23.6, 2.6e-3), 0.994995),
    "published, P1 = 81 I": (table(), 81.0, (0.685, 1.33e-5, 2.98e-4, -23.6, 2.6e-3), 0.994995),
    "exchanged": (table(K2, K1), 1.0, (0.685, 3.31, 2.98e-4, 0.938, 2.6e-3), 0.998634),
    "P1 = I": (PROPER, 1.0, (8.46e-3, 0.0, 2.98e-4, 0.996, 2.6e-3), 0.999281),
    "compliant": (COMPLIANT, 88.2, (0.746, 0.0, 2.98e-4, 0.0154, 2.6e-3), 0.994985),
    "six steps": (design_observer(J, 1e-3).loop, 81.0, (0.685, 0.0, 3e-4, 3e-4, 2.4e-3), 0.994984),
}


@pytest.mark.parametrize("name", SETS)
def test_margins_and_radius_of_the_known_sets(name: str) -> None:
    loop, P1, expected, radius = SETS[name]
    margins = observer_margins(loop, P1, disturbance=DISTURBANCE)
    for value, wanted in zip(margins.values(), expected, strict=True):
        assert value == pytest.approx(wanted, rel=5e-3, abs=1e-12)
    assert loop.spectral_radius() == pytest.approx(radius, abs=1.1e-6)
    failing = {key for key, holds in conditions_hold(margins).items() if not holds}
    known = {"published, P1 = I": {"r12", "m14"}, "published, P1 = 81 I": {"m14"}, "exchanged": {"r12"}}
    assert failing == known.get(name, set())


def test_the_residual_of_the_published_gains_is_the_rounding_of_the_table() -> None:
    residual = observer_margins(table(), 81.0)["r12"]
    assert residual < 3 * 5e-5 * 0.9 / np.linalg.norm(81.0 * np.linalg.inv(J)), "half a unit in every of nine entries"


def test_the_design_values_of_the_defaults() -> None:
    loop = design_observer(J, 1e-3).loop
    assert (loop.keep, loop.before) == pytest.approx((0.98990, 0.02015), abs=1e-4)


def test_margins_of_the_sliding_mode() -> None:
    def printed(k_lin: float) -> dict[str, float]:
        return sliding_margins(LearningLoop(J, 1e-3, k_lin * np.eye(3), np.eye(3), 0.99, 0.01, 0.99), J)

    margins = printed(3.0)
    assert list(margins.values()) == pytest.approx([5.0, 0.01, 2.98e-4, 0.990], rel=5e-3)
    assert printed(0.01)["m33"] == pytest.approx(-0.98)
    assert printed(1.0)["m33"] == pytest.approx(1.0), "as printed, without the gain"
    assert design_sliding_mode(J, 1e-3, theta3=0.99).holds


def test_the_published_share_of_the_past_error_fails_for_every_choice_of_the_constants() -> None:
    margins, unit = best_case(table())
    assert margins["m14"] == pytest.approx(-6.19, abs=0.01)
    assert unit < 1.0
    rng = np.random.default_rng(1)
    for _ in range(300):
        eps = tuple(10.0 ** rng.uniform(-4, 2, 3))
        tried = observer_margins(table(), 81.0, eps=eps, eta=0.0, rate_unit=10.0 ** rng.uniform(-2, 1))
        assert min(tried["m11"], tried["m13"], tried["m14"]) < 0.0
    held, _ = best_case(table(before=0.02))
    assert all(conditions_hold(held | {"m15": 1.0}).values())


def test_300_random_designs_are_stable_when_every_condition_holds() -> None:
    rng = np.random.default_rng(2)
    held = 0
    for _ in range(300):
        size = 10.0 ** rng.uniform(0, 2.5)
        inertia = random_inertia(rng, size)
        design = design_observer(
            inertia,
            1e-3,
            P1=size**2 * 10.0 ** rng.uniform(-3, -0.5),
            sigma2=rng.uniform(0.3, 0.99),
            eta=rng.uniform(0.0, 0.2),
            K1_slack=10.0 ** rng.uniform(-3, 0),
            eps=(10.0 ** rng.uniform(-4, -1), 10.0 ** rng.uniform(-4, -1), rng.uniform(0.1, 2.0)),
            disturbance=1e-3,
        )
        if all(conditions_hold(design.margins).values()):
            held += 1
            assert design.loop.spectral_radius() < 1.0
    assert held > 250


def test_the_flight_check_computes_the_same_radius() -> None:
    """Repeated squaring in C++ against eigenvalues of numpy; the message carries the number."""
    scenario = papers.load("wang2023").cases["mlsmc"].scenario
    rng = np.random.default_rng(3)
    for delay in (1, 1, 1, 2, 5):
        gain = J @ (np.eye(3) + 0.1 * rng.normal(size=(3, 3))) * rng.uniform(2000.0, 3000.0)
        changed = {"observer.K1": gain.tolist(), "observer.delay": delay}
        (row,) = [r for r in scenario.replace(**changed).check() if not r["ok"]]
        loop = LearningLoop(J, 1e-3, gain, K2, 0.9, 0.1, 0.99, delay)
        assert row["code"] == "unstable"
        assert row["value"] == pytest.approx(loop.spectral_radius(), rel=1e-9 if delay == 1 else 1e-4)


def test_a_delay_keeps_the_gain_and_scales_the_decay() -> None:
    for delay in (2, 10):
        loop = table(delay=delay, before=0.0, now=1.0)
        assert loop.spectral_radius() == pytest.approx(1.0 - 0.01 / (2 * delay), abs=5e-5)
        np.testing.assert_allclose(
            loop.equilibrium(np.ones(3))[1], table(before=0.0, now=1.0).equilibrium(np.ones(3))[1]
        )


def test_the_closed_form_is_where_the_loop_ends() -> None:
    for torque in ([0.1, -0.05, 0.02], [0.1, 0.0, 0.0], [0.002, 0.001, -0.003]):
        push = np.array(torque)
        error, learnt = table().equilibrium(push)
        # the loop with its sign chatters about an axis that sticks, by dt theta1 / J times K2 / (1 - theta2)
        late = table().response(push, 6000)[-2000:]
        sticks = (np.abs(error) < 1e-12).any()
        np.testing.assert_allclose(late.mean(axis=0), learnt, atol=1.5e-4 if sticks else 2e-5)
        smooth = table(width=1e-5)
        np.testing.assert_allclose(smooth.response(push, 20000)[-1], smooth.equilibrium(push)[1], atol=1e-9)
        M = K2 / 0.01 + K1
        assert (np.abs(push - M @ error) <= 0.005 + 1e-12).all()


def test_the_flown_observer_ends_at_the_closed_form() -> None:
    """At rest with the body held: a constant bias on each torquer, no disturbance, no inertia error."""
    scenario = papers.load("wang2023").cases["mlsmc_warm"].scenario
    faults = [{"type": "bias", "actuator": i, "torque": x} for i, x in enumerate((0.1, -0.05, 0.02))]
    result = scenario.replace(
        truth={}, disturbances=[], faults=faults, duration=200.0, initial={"q_NB": [1, 0, 0, 0]}
    ).run(channels=["estimate.d_B"], every=100)
    _, learnt = table().equilibrium(np.array([0.1, -0.05, 0.02]))
    np.testing.assert_allclose(result["estimate.d_B"][-50:].mean(axis=0), learnt, atol=2e-5)


def test_an_outlier_reaches_the_learnt_torque_through_the_shares() -> None:
    """One sample of 0.01 rad/s: mixing takes less than a per cent off the peak."""

    def peak(loop: LearningLoop) -> float:
        state = np.zeros(6)
        A = loop.matrix()
        largest = 0.0
        for k in range(400):
            outlier = np.array([0.01, 0.0, 0.0]) if k == 0 else np.zeros(3)
            learnt = state[3:] + loop.now * loop.K @ (state[:3] + outlier)
            largest = max(largest, float(np.abs(learnt).max()))
            state = A @ state
            # an outlier is in the error that is learnt and corrected, not in the rate
            push = loop.dt * np.linalg.solve(J, (loop.K_lin + loop.now * loop.K) @ outlier)
            state[:3] -= push
            state[3:] += (loop.keep * loop.now + loop.before) * loop.K @ outlier
        return largest

    mixed, repetitive = peak(table()), peak(table(now=1.0, before=0.0))
    assert mixed == pytest.approx(0.0477, abs=5e-4)
    assert repetitive == pytest.approx(0.0482, abs=5e-4)
    assert 0.98 < mixed / repetitive < 1.0


def flown_settling(report: DesignReport, options: dict[str, Any]) -> float:
    """Settling time of the learnt torque in the simulator, over the wanted one.

    From rest, the fault on every axis and a constant disturbance at its bound from the start; the gains as they are
    pasted into a scenario. Settled: within 2 % of the fault of where the closed form says that it ends.
    """
    fault, disturbance, wanted, dt = (options[k] for k in ("fault", "disturbance", "settling_time", "dt"))
    signs = np.array([1.0, -1.0, 1.0])
    scenario = gs.Scenario(
        vehicle=gs.Vehicle(J_B=options["J_B"], D_B=np.eye(3).tolist()),
        observer=report.components["observer"],
        controller=report.components["controller"],
        allocator="pseudo_inverse",
        faults=[gs.faults.Bias(actuator=i, torque=fault) for i in range(3)],
        disturbances=[gs.disturbances.Constant(torque_B=(disturbance * signs).tolist())],
        integrator="rk4",
        duration=round(4.0 * wanted / dt) * dt,
        dt=dt,
    )
    result = scenario.run(channels=["estimate.d_B"])
    o = report.components["observer"]
    loop = LearningLoop(
        np.array(scenario.resolve()["vehicle"]["J_B"]), dt, np.array(o["K1"]), np.array(o["K2"]),
        o["sigma2"], o["sigma1"], o["theta2"], o["delay"], o["theta1"], o["width"],
    )  # fmt: skip
    _, final = loop.equilibrium(fault + disturbance * signs)
    assert np.abs(final - fault).max() <= 2.05 * disturbance + 0.01 * fault, "disturbance, theta1 and the leak"
    return settling(result["estimate.d_B"], final, 0.02 * fault, dt) / wanted


def assert_usable(report: DesignReport) -> None:
    """Every margin positive, Schur margin included, and the trial run in time."""
    assert report.ok, [f.text for f in report.findings if f.ok is False]
    named = [f for f in report.findings if f.name.startswith("m") or f.name == "schur"]
    assert len(named) >= 8
    assert all(f.value is not None and f.value > 0.0 for f in named)


@pytest.mark.parametrize(
    ("inertia", "dt", "wanted", "disturbance", "fault"),
    [
        (J.tolist(), 1e-3, 0.5, 2e-3, 0.1),
        ([[20.0, 0.0, 0.9], [0.0, 17.0, 0.0], [0.9, 0.0, 15.0]], 0.01, 5.0, 0.0, 0.05),
        ([0.01, 0.02, 0.015], 0.05, 6.0, 0.0, 1e-4),
        ([2000.0, 3000.0, 1500.0], 0.1, 20.0, 0.01, 1.0),
    ],
)
def test_a_designed_set_holds_everywhere_and_settles_when_flown(
    inertia: Any, dt: float, wanted: float, disturbance: float, fault: float
) -> None:
    options = {"J_B": inertia, "dt": dt, "settling_time": wanted, "disturbance": disturbance, "fault": fault}
    design = DESIGNS["mixed_learning"]
    report = design.run(design.options(**options))
    assert_usable(report)
    assert flown_settling(report, options) <= 1.0


def test_random_vehicles_get_gains_that_settle_when_flown_or_a_reason() -> None:
    """Vehicles of 10 g m^2 to 3000 kg m^2, periods of 1 to 200 ms, disturbances of up to 30 % of the fault."""
    rng = np.random.default_rng(5)
    design = DESIGNS["mixed_learning"]
    refused = 0
    for _ in range(60):
        size, dt = 10.0 ** rng.uniform(-2, 3.5), float(rng.choice([0.001, 0.005, 0.01, 0.05, 0.2]))
        fault = size * 10.0 ** rng.uniform(-4, -2)
        options = {
            "J_B": random_inertia(rng, size).tolist(),
            "dt": dt,
            "settling_time": dt * round(10.0 ** rng.uniform(np.log10(60), 3)),
            "fault": fault,
            "disturbance": fault * float(rng.choice([0.0, 0.02, 0.1, 0.3])),
        }
        report = design.run(design.options(**options))
        if not report.components:
            refused += 1
            assert [f.name for f in report.findings] == ["turn"]
            continue
        assert_usable(report)
        assert flown_settling(report, options) <= 1.0
    assert 0 < refused < 15


def test_the_printed_tables_fly_when_pasted_into_a_scenario() -> None:
    code, text, _ = command("design", "mixed_learning", "ftc_4rw", "--set", "settling_time=5", "--set", "fault=0.02")
    assert code == 0
    tables = tomllib.loads(text[text.index("[observer]") :])
    assert set(tables) == {"observer", "controller"}
    base = gs.Scenario.load("ftc_4rw")
    fault = gs.faults.Bias(actuator=1, torque=0.02, t_on=150.0)
    flown = base.replace(**tables, faults=[fault], duration=180.0).run(channels=["error.angle", "estimate.d_B"])
    angle = flown["error.angle"]
    # the default pointing time is 100 s, counted from when the surface is reached
    assert angle[flown.t >= 115.0].max() < 0.02 * angle[0]
    added = flown["estimate.d_B"][flown.t > 155.0] - flown["estimate.d_B"][flown.t < 150.0][-1]
    torque = 0.02 * np.array(base.resolve()["vehicle"]["D_B"])[:, 1]
    np.testing.assert_allclose(added, np.broadcast_to(torque, added.shape), atol=0.02 * 0.02)


def test_what_cannot_be_designed_is_said() -> None:
    design = DESIGNS["mixed_learning"]
    slow = design.run(design.options(J_B=[1.0, 1.0, 1.0], dt=0.1, settling_time=1.0))
    assert not slow.ok
    assert slow.components == {}
    assert "60 periods" in slow.findings[0].text
    far = design.run(design.options(J_B=[1.0, 1.0, 1.0], dt=0.1, settling_time=30.0, fault=0.1))
    assert not far.ok
    assert "turns the body by 3.7 rad before it is learnt" in far.findings[0].text
    loud = design.run(design.options(J_B=[1.0, 1.0, 1.0], dt=0.01, disturbance=0.06, fault=0.1))
    assert not loud.ok
    assert "cannot be told from" in loud.findings[0].text
    with pytest.raises(gs.InputError, match="positive definite"):
        design_observer([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 1e-3)
    with pytest.raises(gs.InputError, match="not 2 x 2"):
        design.run(design.options(J_B=[[1.0, 0.0], [0.0, 1.0]], dt=0.1))


def test_the_conditions_do_not_see_the_period_and_the_schur_margin_does() -> None:
    """The theorem is continuous: its conditions hold for gains that a sampled loop cannot bear."""
    design = design_observer(J, 1e-3, P1=2e6, disturbance=1e-3)
    assert all(conditions_hold(design.margins).values())
    assert design.loop.spectral_radius() > 1.0
    assert not design.holds


def test_check_prints_every_margin_and_flags_the_published_gains() -> None:
    scenario = papers.load("wang2023").cases["mlsmc"].scenario
    found = {(f.where.split()[0], f.name): f for look in CHECKS for f in look(scenario)}
    observer = {name: f.ok for (role, name), f in found.items() if role == "observer"}
    learning = {"m11": True, "r12": True, "m13": True, "m14": False, "m15": None, "unit": None, "schur": True}
    assert observer == learning | {"d_B": True}  # which is used
    controller = {name: f.ok for (role, name), f in found.items() if role == "controller"}
    assert controller == {"m33": True, "r34": True, "m35": True, "m36": True, "schur": True}
    compliant = papers.load("wang2023").cases["mlo_compliant"].scenario
    assert all(f.ok is not False for look in CHECKS for f in look(compliant))
    default = gs.Scenario.load("ftc_4rw").replace(
        observer="mixed_learning_disturbance", controller="mixed_learning_sliding_mode"
    )
    assert all(f.ok is not False for look in CHECKS for f in look(default))
    assert not [f for f in CHECKS[0](gs.Scenario.load("ftc_4rw")) if "mixed" in f.where]


def test_an_unstable_gain_set_is_refused_with_its_number_and_can_be_flown_on_request() -> None:
    case = papers.load("wang2023").cases["mlo_integral"].scenario
    refused = case.replace(allow_unstable=False)
    with pytest.raises(gs.InputError, match=r"spectral radius of the sampled learning loop = 1\.00001, must be < 1"):
        refused.run()
    assert table(keep=1.0).spectral_radius() == pytest.approx(1.0000075836, abs=1e-9)
    assert table(keep=1.0, now=1.0, before=0.0).spectral_radius() == pytest.approx(0.9999947910, abs=1e-9)
    assert table(keep=1.0, now=0.957, before=0.043).spectral_radius() < 1.0
    assert table(keep=1.0, now=0.956, before=0.044).spectral_radius() > 1.0
    assert case.replace(duration=0.1).run(channels=["truth.q_NB"]).completed


def test_the_command_line_designs() -> None:
    code, text, _ = command("design")
    assert code == 0
    assert "mixed_learning_six_steps" in text
    code, text, _ = command("design", "mixed_learning", "ftc_4rw", "--set", "settling_time=5", "--json")
    found = json.loads(text)
    assert (code, found["ok"]) == (0, True)
    assert found["components"]["observer"]["type"] == "mixed_learning_disturbance"
    code, text, _ = command("design", "mixed_learning_six_steps", "--set", f"J_B={J.tolist()}", "--set", "sigma1=0.1")
    assert code == 1
    assert "fails: (14)" in text
    assert "[observer]" in text
    code, _, error = command("design", "mixed_lerning")
    assert code == 2
    assert "did you mean 'mixed_learning'" in error
    code, _, error = command("design", "mixed_learning", "--set", "dt=0.01")
    assert code == 2
    assert "J_B is missing" in error
