# SPDX-License-Identifier: MIT
"""On/off thrusters: states against two independent computations, impulses, propellant, limit cycles, every stack."""

from __future__ import annotations

from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core
from gyrostat.design import findings
from gyrostat.design import thrusters as check
from gyrostat.export import export
from gyrostat.vehicle import all_actuators, twelve_thrusters

ROOT = Path(__file__).resolve().parents[2]
J = [[120.0, 3.0, 4.0], [3.0, 100.0, 10.0], [4.0, 10.0, 120.0]]
W0 = [0.02, -0.03, 0.04]
OFF = [0.02, -0.01, 0.03]  # the centre of mass
THRUSTERS = twelve_thrusters()[1].model_copy(update={"centre_of_mass": tuple(OFF)})
G0 = 9.80665


class Levels:
    """An allocator that plays levels back, fractions of full thrust."""

    def __init__(self, levels: Callable[[float], np.ndarray], dt: float) -> None:
        self.levels, self.dt = levels, dt

    def setup(self, setup: gs.Setup) -> None:
        self.up = np.array(setup.vehicle.u_up)

    def step(self, demand: gs.Demand, x: gs.Estimate, *_: object) -> np.ndarray:
        return np.asarray(self.levels(x.tick * self.dt) * self.up)


def sines(t: float) -> np.ndarray:
    return np.maximum(0.0, 0.6 * np.sin(0.35 * t + 0.9 * np.arange(12)))


FAULTS = [
    gs.faults.SlowValve(actuator=2, delay_open=0.03, delay_close=0.05),
    gs.faults.LossOfEffectiveness(actuator=0, t_on=3.2, remaining=0.7),
    gs.faults.Leak(actuator=10, t_on=5.0, fraction=0.04),
    gs.faults.Dead(actuator=4, t_on=6.0),
    gs.faults.HardOver(actuator=7, t_on=8.3, t_off=9.9),
]


def driven(**changes: Any) -> gs.Scenario:
    """Twelve thrusters under levels that play back."""
    usual: dict[str, Any] = {
        "vehicle": gs.Vehicle(J_B=J),
        "thrusters": THRUSTERS,
        "initial": {"q_NB": [0.8, 0.2, -0.4, 0.4], "omega_BN_B": W0},
        "controller": "open_loop",
        "allocator": Levels(sines, 0.5),
        "integrator": "rk4",
        "duration": 20.0,
        "dt": 0.5,
    }
    return gs.Scenario(**(usual | changes))


CHANNELS = ["truth.q_NB", "truth.omega_BN_B", "truth.propellant", "truth.thruster_impulse_B", "allocation.u"]
# From rate form and momentum form in extended precision, which agree to 3e-17.
HEALTHY = {
    "q_NB": [1.4428509153895018e-01, 4.3962507606583323e-01, -5.1881360918157504e-01, 7.1884911058002641e-01],
    "omega_BN_B": [3.1391390702031161e-02, -3.7077731684376642e-02, 4.1462500435160064e-02],
    "propellant": 2.1524123472801157e-02,
    "thruster_impulse_B": [0.296875, -0.1875, -1.609375],
}
FAULTY = {
    "q_NB": [5.2569620385930139e-02, 5.0761896267237687e-01, -5.9622628915063647e-01, 6.1973674723511505e-01],
    "omega_BN_B": [2.2775499287056919e-02, -7.6904787353104748e-02, 4.1942917245299258e-02],
    "propellant": 2.0690534437902298e-02,
    "thruster_impulse_B": [-1.540625, -0.65125, -2.8740625],
}


@pytest.mark.parametrize(("faults", "wanted", "rk4"), [([], HEALTHY, 2.4e-11), (FAULTS, FAULTY, 3.5e-11)])
@pytest.mark.parametrize("integrator", ["rk4", "cvode", "auto"])
def test_the_state_is_that_of_two_independent_computations(
    faults: list[Any], wanted: dict[str, Any], rk4: float, integrator: str
) -> None:
    # 184 and 224 pieces: rk4 takes a step each; the history of cvode carries each kink on
    most = {"rk4": (1.1 * rk4, 3e-13), "cvode": (1e-8, 2e-10), "auto": (1e-13, 1e-14)}[integrator]
    result = driven(faults=faults, integrator=integrator).run(channels=CHANNELS)
    assert np.abs(result["truth.q_NB"][-1] - wanted["q_NB"]).max() < most[0]
    assert np.abs(result["truth.omega_BN_B"][-1] - wanted["omega_BN_B"]).max() < most[1]
    assert abs(result["truth.propellant"].ravel()[-1] - wanted["propellant"]) < 1e-15
    np.testing.assert_allclose(result["truth.thruster_impulse_B"][-1], wanted["thruster_impulse_B"], rtol=0, atol=1e-14)


def test_no_valve_edge_restarts_cvode() -> None:
    assert driven(faults=FAULTS, integrator="cvode").run(channels=CHANNELS).statistics["restarts"] == 1


def test_the_first_pulses_are_the_nearest_ticks() -> None:
    u = driven().run(channels=CHANNELS)["allocation.u"][:, 0] / THRUSTERS.torque[0]
    np.testing.assert_allclose(32.0 * u[:12], [0, 3, 7, 10, 12, 15, 17, 18, 19, 19, 19, 18], atol=1e-12)


def test_flight_rounds_as_the_valves_do() -> None:
    # whatever the level: what flight issues is what comes out, so rounding it again changes nothing
    rng = np.random.default_rng(4)
    levels = rng.random((200, 12)) ** 2
    levels[:, :4] = rng.choice([0.0, 0.5 / 32, 1.49 / 32, 1.51 / 32, 30.4 / 32, 30.6 / 32, 1.0], (200, 4))
    scenario = driven(allocator=Levels(lambda t: levels[round(2 * t) % 200], 0.5), duration=100.0)
    result = scenario.run(channels=["allocation.u", "allocation.achieved_B", "truth.delivered"])
    u = result["allocation.u"]
    np.testing.assert_allclose(result["truth.delivered"][1:], u[:-1], rtol=0, atol=1e-13)
    np.testing.assert_allclose(result["allocation.achieved_B"], u @ scenario.axes_B.T, atol=1e-14)
    ticks = 32.0 * u / THRUSTERS.torque
    np.testing.assert_allclose(ticks, ticks.round(), atol=1e-10)
    assert set(np.unique(ticks.round())) <= {0.0, *range(2, 31), 32.0}


def test_the_force_is_the_derivative_of_its_impulse_and_propellant_follows_from_thrust() -> None:
    channels = ["truth.thruster_force_B", "truth.thruster_impulse_B", "truth.delivered", "truth.propellant"]
    result = driven(faults=FAULTS).run(channels=channels)
    force, impulse = result["truth.thruster_force_B"], result["truth.thruster_impulse_B"]
    np.testing.assert_allclose(0.5 * np.cumsum(force[1:], axis=0), impulse[1:], atol=1e-13)
    thrust = result["truth.delivered"] * (np.asarray(THRUSTERS.thrust) / THRUSTERS.torque)
    np.testing.assert_allclose(force, thrust @ np.asarray(THRUSTERS.directions), atol=1e-13)
    used = 0.5 * np.cumsum(thrust[1:].sum(axis=1)) / (220.0 * G0)
    np.testing.assert_allclose(result["truth.propellant"].ravel()[1:], used, atol=1e-15)


def test_momentum_in_space_changes_by_thrust_alone() -> None:
    result = driven(allocator=Levels(lambda _: np.zeros(12), 0.5), integrator={"type": "cvode", "rtol": 1e-12}).run(
        channels=["truth.q_NB", "truth.omega_BN_B", "truth.propellant"]
    )
    H = result["truth.omega_BN_B"] @ np.array(J)
    np.testing.assert_allclose(np.linalg.norm(H, axis=1), np.linalg.norm(H[0]), rtol=1e-10)
    assert result["truth.propellant"].max() == 0.0


def test_propellant_that_runs_out_ends_all_thrust() -> None:
    full = driven().run(channels=CHANNELS)["truth.propellant"].ravel()
    mass = 0.5 * full[-1]
    result = driven(thrusters=THRUSTERS.model_copy(update={"propellant_mass": float(mass)})).run(channels=CHANNELS)
    used = result["truth.propellant"].ravel()
    before = full < mass
    np.testing.assert_allclose(used[before], full[before], atol=1e-16)
    np.testing.assert_allclose(used[~before], mass, rtol=1e-14)


def test_modulators_give_the_same_impulse_and_centred_pulses_turn_less() -> None:
    steady = Levels(lambda _: np.where(np.arange(12) < 2, 0.3, 0.0), 0.5)
    angle = {}
    for name, change in (
        ("ideal", {"modulator": "proportional"}),
        ("start", {"tick": 0.005}),
        ("centre", {"tick": 0.005, "align": "centre"}),
        ("pwpf", {"modulator": "pwpf"}),
    ):
        made = THRUSTERS.model_copy(update=change | {"centre_of_mass": None})
        rest = {"omega_BN_B": [0.0, 0.0, 0.0]}
        result = driven(thrusters=made, allocator=steady, initial=rest, integrator="cvode", duration=10.0).run(
            channels=["truth.q_NB", "truth.propellant"]
        )
        angle[name] = 2.0 * np.linalg.norm(result["truth.q_NB"][-1, 1:])
        # the pwpf modulator's mean thrust is no line: on and off times at this level are 13.05 and 43.15 ms
        mean = 0.0130517 / (0.0130517 + 0.0431523) if name == "pwpf" else 0.3
        used = 2 * mean * 10.0 / (220.0 * G0)
        assert result["truth.propellant"].ravel()[-1] == pytest.approx(used, rel=0.02 if name == "pwpf" else 1e-12)
    # each pulse acts (dt - on)/2 = 0.175 s early: as much more of the rate 1.6 * 0.3 / 120 * 10
    early = angle["start"] - angle["ideal"]
    assert early == pytest.approx(0.175 * 1.6 * 0.3 / 120 * 10, rel=0.02)
    assert abs(angle["centre"] - angle["ideal"]) < 0.01 * early


def test_wheels_and_thrusters_fly_together() -> None:
    wheels = gs.vehicle.pyramid4(J_B=J, u_max=0.2, wheel_inertia=0.05)
    scenario = gs.Scenario(
        vehicle=wheels,
        thrusters=THRUSTERS,
        initial={"mrp": [0.05, -0.02, 0.03], "wheel_speed": 10.0},
        truth={"viscous_friction": 1e-5, "coulomb_friction": 1e-4},
        controller="mrp_feedback",
        allocator=gs.allocator("weighted_least_squares"),
        faults=[gs.faults.Dead(actuator=1, t_on=20.0), gs.faults.Leak(actuator=5, t_on=30.0, fraction=0.01)],
        duration=300.0,
        dt=0.5,
        integrator="cvode",
    )
    assert scenario.axes_B.shape == (3, 16)
    result = scenario.run(channels=["error.angle", "truth.h_w", "allocation.u", "truth.delivered", "truth.propellant"])
    assert result.completed
    assert result["truth.h_w"].shape[1] == 16
    assert np.all(result["truth.h_w"][:, 4:] == 0.0)
    assert np.all(result["allocation.u"][:, 4:] >= 0.0)
    assert np.rad2deg(result["error.angle"][-1]) < 3.0  # the default law is soft
    setup = scenario.compiled.flight_model()["vehicle"]
    np.testing.assert_allclose(setup["D_B"], scenario.axes_B, atol=1e-15)
    assert setup["wheels"] == [0, 1, 2, 3]
    assert setup["u_quantum"][:4] == [0.0] * 4


def test_thrusters_bend_appendages_as_one_step_methods_say_too() -> None:
    modes = gs.Flexible(delta=[[3.0, 0.5, 1.0], [-0.5, 2.0, -1.0]], omega=(0.8, 1.7), xi=(0.005, 0.01))
    ends = []
    precise = {"rtol": 1e-12, "atol": 1e-15}
    for integrator in ({"type": "cvode", **precise}, {"type": "auto", **precise}, {"type": "rk4", "substeps": 8}):
        flown = driven(flexible=modes, faults=FAULTS, integrator=integrator).run(channels=["truth.q_NB", "truth.eta"])
        ends.append(np.concatenate([flown["truth.q_NB"][-1], flown["truth.eta"][-1]]))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(ends[2], ends[1], rtol=0, atol=3e-7)


def test_axes_and_limits_in_python_are_those_of_flight() -> None:
    for scenario in (
        driven(allocator="lexicographic"),
        gs.Scenario.load("geo_thrusters"),
        gs.Scenario.load("twelve_thrusters"),
    ):
        flown = scenario.compiled.flight_model()["vehicle"]
        ours = all_actuators(scenario.to_dict())
        np.testing.assert_allclose(scenario.axes_B, flown["D_B"], atol=1e-15)
        np.testing.assert_allclose(ours["u_max"], flown["u_up"], rtol=1e-15)
        np.testing.assert_array_equal(ours["u_min"], flown["u_lo"])


# ---- limit cycles ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def cycles() -> Any:
    loader = SourceFileLoader("thruster_limit_cycles", str(ROOT / "scripts" / "thruster_limit_cycles"))
    module = module_from_spec(spec_from_loader("thruster_limit_cycles", loader))  # type: ignore[arg-type]
    loader.exec_module(module)
    return module


def test_the_free_limit_cycle_is_that_of_the_textbook(cycles: Any) -> None:
    assert pytest.approx(4.1667e-4, rel=1e-4) == cycles.STEP
    assert pytest.approx(6.944e-3, rel=1e-3) == cycles.EDGE
    flown, edge, pulses = cycles.free(False, 3e-4)
    assert max(flown.high, -flown.low) < cycles.EDGE
    assert max(flown.high, -flown.low) == pytest.approx(edge, rel=0.03)
    assert flown.rates.sum() == pytest.approx(cycles.STEP, rel=1e-3)
    assert flown.pulses == pytest.approx(pulses, rel=0.03)
    assert flown.longest == pytest.approx(2.0)
    crippled, _, fewer = cycles.free(True, 1.1e-4)
    assert crippled.rates.sum() == pytest.approx(cycles.STEP / 2.0, rel=0.02)
    assert crippled.pulses == pytest.approx(fewer, rel=0.05)


@pytest.mark.parametrize(("stuck", "period"), [(False, 10.0), (True, 5.0)])
def test_the_cycle_against_a_torque_burns_what_holding_it_takes(cycles: Any, stuck: bool, period: float) -> None:
    flown, swing, textbook = cycles.held(stuck)
    assert textbook == pytest.approx(period, rel=1e-3)
    assert flown.period == pytest.approx(period, rel=0.02)
    assert flown.propellant == pytest.approx(2.8969e-3, rel=5e-3)
    assert flown.longest == pytest.approx(2.0)
    # a pulse waits for its sample: the swing is larger by at most a sample at the highest rate
    step = cycles.STEP / (2.0 if stuck else 1.0)
    assert swing < 1.01 * (flown.high - flown.low) < 1.05 * (swing + cycles.DT * step)


def test_a_remainder_that_is_carried_on_costs_more_than_it_is_worth(cycles: Any) -> None:
    """docs/thrusters.md: why the stack carries none; a law that wants it has all it needs."""

    class Carrying(cycles.Law):  # type: ignore[misc]
        def step(self, x: gs.Estimate, *others: Any) -> Any:
            last, smallest = others[-1], 2.0 * cycles.THRUST * cycles.LEVER * cycles.MIN_ON * cycles.TICK / cycles.DT
            return super().step(x) + np.clip(last.demand_B - last.achieved_B, -smallest, smallest)

    free, carried = cycles.fly(0.0, False, 3e-4), cycles.fly(0.0, False, 3e-4, law=Carrying())
    assert carried.high - carried.low < 0.2 * (free.high - free.low)
    assert carried.propellant > 10.0 * free.propellant
    held = cycles.fly(5e-3, False, 0.0, law=Carrying())
    assert held.propellant > 1.2 * cycles.burnt(5e-3)
    assert held.high - held.low > 7.2e-4, "that of the cycle without"


def test_the_table_of_limit_cycles_was_flown(cycles: Any) -> None:
    written = "\n".join(line for line in cycles.TABLE.read_text().splitlines() if not line.startswith("#"))
    for ours, theirs in zip(cycles.table().splitlines(), written.splitlines(), strict=True):
        for a, b in zip(ours.split(","), theirs.split(","), strict=True):
            number = a.split(" ")[0].replace(".", "").isdigit()
            assert float(a.split(" ")[0]) == pytest.approx(float(b.split(" ")[0]), rel=0.02) if number else a == b


# ---- closed loops ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["twelve_thrusters", "geo_thrusters"])
def test_the_shipped_vehicles_hold_through_a_stuck_valve(name: str) -> None:
    result = gs.Scenario.load(name).run(channels=["error.angle", "truth.propellant", "allocation.u"])
    assert result.completed
    late = result.t > 0.8 * result.t[-1]
    assert np.rad2deg(result["error.angle"][late]).max() < 1.0
    assert 0.0 < result["truth.propellant"].ravel()[-1] < 1.0


ONE_SIDED = ["weighted_least_squares", "lexicographic", "lexicographic_scaled", "robust_socp"]


@pytest.mark.parametrize("allocator", ONE_SIDED)
def test_allocators_that_know_bounds_hold_the_attitude(allocator: str) -> None:
    scenario = gs.Scenario.load("twelve_thrusters").replace(allocator=allocator)
    result = scenario.run(channels=["error.angle", "allocation.u"])
    assert result.completed
    assert np.rad2deg(result["error.angle"][result.t > 240.0]).max() < 1.0
    assert result["allocation.u"].min() >= 0.0


def test_check_says_that_the_pseudo_inverse_knows_no_bounds() -> None:
    scenario = gs.Scenario.load("twelve_thrusters")
    found = {f.name for f in check.findings(scenario.replace(allocator="pseudo_inverse"))}
    assert "one-sided limits" in found
    assert "one-sided limits" not in {f.name for f in check.findings(scenario)}
    assert check.findings(gs.Scenario.load("ftc_4rw")) == []
    smallest = {f.name: f for f in check.findings(scenario)}["smallest pulse"]
    assert smallest.value == pytest.approx(0.8 / 32 * 2)


def test_every_component_flies_on_thrusters_through_random_faults() -> None:
    """Nothing non-finite, no exception, no crash; whether it holds is another question."""
    rng = np.random.default_rng(11)
    roles = {
        role: [n for n in names if n != "open_loop"]
        for role, names in _core.catalogue().items()
        if role in ("observer", "detector", "controller", "allocator")
    }
    base = gs.Scenario.load("twelve_thrusters").replace(duration=40.0, allow_unstable=True, disturbances=[])
    for role, names in roles.items():
        for name in names:
            allocator = {} if role == "allocator" else {"allocator": rng.choice(ONE_SIDED[:2])}
            stack = {"observer": "finite_time_disturbance", **allocator, role: str(name)}
            stack = {k: str(v) for k, v in stack.items()}
            scenario = base.replace(faults=random_faults(rng), **stack)
            try:
                result = scenario.run(channels=["truth.omega_BN_B", "allocation.u", "estimate.*", "truth.propellant"])
            except gs.InputError as error:
                assert "\n" not in str(error), name  # noqa: PT017 - a component that does not fit says so in one line
                continue
            assert result.completed, (role, name, result.status)
            for channel in ("truth.omega_BN_B", "allocation.u", "estimate.d_B", "estimate.effectiveness"):
                assert np.isfinite(result[channel]).all(), (role, name, channel)


def test_an_experiment_varies_thrusters() -> None:
    scenario = gs.Scenario.load("twelve_thrusters").replace(duration=60.0)
    experiment = gs.Experiment(scenario, vary=["thrusters.thrust", "thrusters.propellant_mass", "faults.0.t_on"])
    values = [2.0, 1e-3, 20.0]
    alone = experiment.scenario(values).run(channels=["error.angle"])["error.angle"][-1]
    assert experiment.fly([values])["final_error"][0] == alone.item()


def test_exported_code_rounds_too(tmp_path: Path) -> None:
    export(gs.Scenario.load("twelve_thrusters"), "cpp", tmp_path / "out", samples=10)
    (header,) = (tmp_path / "out").glob("*.hpp")
    text = header.read_text()
    for name, value in (("u_quantum", "0.025"), ("u_dead", "0.05"), ("u_gap", "0.05")):
        assert f"v.{name} << " + ", ".join([f"S({value})"] * 12) in text
    export(gs.Scenario.load("ftc_4rw"), "cpp", tmp_path / "wheels", samples=10)
    assert "u_quantum" not in next((tmp_path / "wheels").glob("*.hpp")).read_text()


def random_faults(rng: np.random.Generator) -> list[Any]:
    """A few, of kinds that valves have, on different thrusters."""
    makers = [
        lambda i, t: gs.faults.Dead(actuator=i, t_on=t),
        lambda i, t: gs.faults.HardOver(actuator=i, t_on=t, t_off=t + 3.0),
        lambda i, t: gs.faults.LossOfEffectiveness(actuator=i, t_on=t, remaining=float(rng.random())),
        lambda i, t: gs.faults.Leak(actuator=i, t_on=t, fraction=float(0.1 * rng.random())),
        lambda i, t: gs.faults.SlowValve(
            actuator=i, t_on=t, delay_open=float(rng.random()), delay_close=float(rng.random())
        ),
        lambda i, t: gs.faults.Lock(actuator=i, t_on=t, t_off=t + 5.0),
        lambda i, t: gs.faults.Stuck(actuator=i, t_on=t, torque=float(0.2 * rng.random())),
        lambda i, t: gs.faults.Intermittent(actuator=i, t_on=t, period=float(0.3 + rng.random()), duty=0.4),
    ]
    which = rng.choice(12, size=3, replace=False)
    return [makers[rng.integers(len(makers))](int(i), float(30.0 * rng.random())) for i in which]


# ---- what does not fit ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"positions": [[0.02, -0.01, 1.0]] * 12, "directions": [[0, 0, 1]] * 12}, r"thruster 0 makes no torque"),
        ({"tick": 0.3}, r"thrusters: the period of 0\.5 s is not a whole number of ticks of 0\.3 s"),
        ({"thrust": -1.0}, r"thrusters: thrust = -1 is outside \[0, "),
        ({"thrust": [1.0] * 11 + [0.0]}, r"thrusters: thruster 11: thrust must be positive"),
        ({"thrust": [1.0] * 3}, r"thrusters: thrust"),
        ({"directions": [[0.0, 0.0, 1.0]] * 11}, r"thrusters: directions has 11 rows, positions 12; one each"),
        ({"directions": [[0.0, 0.0, 0.0]] * 12}, r"thrusters: thruster 0: its direction is no direction"),
        ({"positions": [[0.0, 0.8]] * 12}, r"thrusters: positions\[0\] has 2 numbers; three belong there"),
        ({"min_on": 40}, r"thrusters: min_on and min_off must not exceed the 32 ticks of a period"),
        ({"min_on": 0}, r"thrusters: min_on = 0 is outside \[1, "),
        ({"Isp": 0.0}, r"thrusters: thruster 0: Isp must be positive"),
        ({"propellant_mass": 0.0}, r"thrusters: propellant_mass must be positive"),
        ({"modulator": "pwm2"}, r"thrusters: modulator"),
        ({"modulator": "pwpf", "pwpf_off": 0.6}, r"thrusters: 0 < pwpf_off < pwpf_on belongs there"),
        ({"positions": [], "directions": []}, r"thrusters: positions are missing"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_one_line(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(gs.InputError, match=message) as error:
        _ = driven(thrusters={**THRUSTERS.to_dict(), **changes}).compiled
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (gs.faults.Bias(actuator=3, torque=0.1), r"bias: not of a thruster.*leak, stuck or hard_over"),
        (gs.faults.Drift(actuator=3, rate=0.1), r"drift: not of a thruster"),
        (gs.faults.DeadZone(actuator=3, width=0.1), r"dead_zone: not of a thruster.*slow_valve"),
    ],
)
def test_faults_that_valves_do_not_have_are_refused(fault: Any, message: str) -> None:
    with pytest.raises(gs.InputError, match=message):
        driven(faults=[fault]).run(channels=CHANNELS)
    with pytest.raises(gs.InputError, match=r"leak: actuator 1 has no valve"):
        gs.Scenario.load("ftc_4rw").replace(faults=[gs.faults.Leak(actuator=1)]).run(channels=["error.angle"])


def test_seventeen_actuators_and_a_vehicle_with_nothing_are_refused() -> None:
    with pytest.raises(gs.InputError, match=r"thrusters: 12 beside 5 other actuators; at most 16 in all"):
        driven(vehicle=gs.Vehicle(J_B=J, D_B=np.ones((3, 5)))).compiled  # noqa: B018
    with pytest.raises(gs.InputError, match=r"D_B is missing"):
        driven(thrusters=None).compiled  # noqa: B018


@pytest.mark.parametrize("case", ["twelve_thrusters", "geo_thrusters"])
def test_check_says_what_is_within_reach(case: str) -> None:
    """Pairs push both ways about every axis, also with one that sticks closed."""
    (found,) = (f for f in findings(gs.Scenario.load(case)) if f.name == "every direction")
    assert found.ok
    assert "after the faults" in found.text
