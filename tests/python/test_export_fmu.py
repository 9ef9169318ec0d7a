# SPDX-License-Identifier: MIT
"""The exported co-simulation unit under FMPy: valid, the recorded loop to 1e-12, parameters and steps as documented."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.validation import validate_fmu

import gyrostat as gs
from gyrostat.export import FlightCode, compiler, export
from gyrostat.export.model import INPUTS, OUTPUTS, flight_code, suffixes

ROLES = ("observer", "detector", "controller", "allocator")
# wheel2_degraded loses its wheel at 20 s = sample 2000; yang2023 has masks, and a detector that turns
# the spare on at sample 8434
CASES = {"wheel2_degraded": 3000, "yang2023/maneuver": 9000}
# s; attitude, rate and wheel momentum are not measured for a while, in both
DROPOUTS = [
    gs.sensors.AttitudeDropout(t_on=2.0, t_off=3.0),
    gs.sensors.RateDropout(t_on=4.0, t_off=4.5),
    gs.sensors.MomentumDropout(t_on=6.0, t_off=6.5),
]
Unit: TypeAlias = tuple[Path, FlightCode]


def built(case: str, folder: Path) -> tuple[Path, FlightCode]:
    scenario = gs.Scenario.load(case)
    scenario = scenario.replace(sensors=[*scenario.sensors, *DROPOUTS])
    code = export(scenario, "fmu", folder, samples=CASES[case])
    return folder / f"{code.name}.fmu", code


@pytest.fixture(scope="module")
def wheel2(tmp_path_factory: pytest.TempPathFactory) -> Unit:
    return built("wheel2_degraded", tmp_path_factory.mktemp("wheel2") / "out")


@pytest.fixture(scope="module")
def maneuver(tmp_path_factory: pytest.TempPathFactory) -> Unit:
    return built("yang2023/maneuver", tmp_path_factory.mktemp("maneuver") / "out")


@pytest.fixture(params=["wheel2", "maneuver"])
def unit(request: pytest.FixtureRequest) -> Unit:
    found: Unit = request.getfixturevalue(request.param)
    return found


class Slave:
    """A unit in the hands of a master, by the names of its variables."""

    def __init__(self, path: Path, folder: Path, messages: list[str]) -> None:
        self.description = fmpy.read_model_description(path)
        fmpy.extract(path, folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.messages = messages
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="flight",
        )

    def start(self, parameters: Mapping[str, Any]) -> None:
        self.fmu.setupExperiment(startTime=0.0)
        self.set(parameters)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            variable = self.variables[name]
            kind = "Integer" if variable.type == "Enumeration" else variable.type
            getattr(self.fmu, f"set{kind}")([variable.valueReference], [value])

    def fly(self, code: FlightCode, rows: int | None = None) -> np.ndarray:
        """Outputs of the recorded inputs, a row a sample."""
        inputs, outputs = (self._references(code, names) for names in (code.inputs, OUTPUTS))
        recorded = np.hstack([code.column(name) for name in code.inputs])
        found = np.empty((len(recorded[:rows]), sum(len(block) for _, block in outputs)))
        for k, row in enumerate(recorded[:rows]):
            at = 0
            for kind, block in inputs:
                values = row[at : at + len(block)].tolist()
                getattr(self.fmu, f"set{kind}")(block, values if kind == "Real" else [int(v) for v in values])
                at += len(block)
            self.fmu.doStep(currentCommunicationPoint=k * code.dt, communicationStepSize=code.dt)
            found[k] = [x for kind, block in outputs for x in getattr(self.fmu, f"get{kind}")(block)]
        return found

    def _references(self, code: FlightCode, names: tuple[str, ...]) -> list[tuple[str, list[int]]]:
        blocks = []
        for name in names:
            width = code.columns[name]
            elements = [self.variables[name + s] for s in suffixes((width,) if width > 1 else ())]
            blocks.append((elements[0].type, [v.valueReference for v in elements]))
        return blocks


@contextmanager
def slave(
    path: Path, folder: Path, parameters: Mapping[str, Any] | None = None, *, start: bool = True
) -> Iterator[Slave]:
    messages: list[str] = []
    one = Slave(path, folder, messages)
    one.fmu.instantiate(callbacks=_callbacks(messages))
    if start:
        one.start(parameters or {})
    yield one
    one.fmu.freeInstance()


def _callbacks(messages: list[str]) -> fmi2CallbackFunctions:
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(lambda *said: messages.append(said[4].decode()))
    return callbacks


def recorded_outputs(code: FlightCode) -> np.ndarray:
    return np.hstack([code.column(name) for name in OUTPUTS])


def assert_same(found: np.ndarray, code: FlightCode) -> None:
    # 1e-12 of each number, of 1 where it is smaller; infinite bounds are equal
    np.testing.assert_allclose(found, recorded_outputs(code)[: len(found)], rtol=1e-12, atol=1e-12)


def test_a_unit_repeats_the_recorded_loop(unit: Unit, tmp_path: Path) -> None:
    path, code = unit
    with slave(path, tmp_path) as one:
        assert_same(one.fly(code), code)


def test_a_unit_is_valid_and_fmpy_runs_it(unit: Unit) -> None:
    path, code = unit
    assert validate_fmu(str(path)) == []
    # at rest and on target nothing is commanded; measured to turn, it brakes
    for rate, commanded in ((0.0, False), (0.01, True)):
        result = fmpy.simulate_fmu(
            str(path), stop_time=1.0, start_values={"measurement.omega_BN_B[0]": rate}, output=["allocation.u[0]"]
        )
        assert len(result) == 1 + round(1.0 / code.dt)
        assert (np.abs(result["allocation.u[0]"]).max() > 1e-3) == commanded


def test_a_unit_has_the_names_of_the_catalogue(unit: Unit) -> None:
    path, code = unit
    described = fmpy.read_model_description(str(path))
    resolved = code.scenario.resolve()
    parameters = {v.name.partition("[")[0] for v in described.modelVariables if v.causality == "parameter"}
    assert parameters == {f"{role}.{key}" for role in ROLES for key in resolved[role] if key != "type"}
    channels = {c["name"] for c in code.scenario.channel_names()}
    signals = {v.name.partition("[")[0] for v in described.modelVariables if v.causality != "parameter"}
    assert signals == {*INPUTS, *OUTPUTS} <= channels
    assert described.defaultExperiment.stepSize == str(code.dt)
    with zipfile.ZipFile(path) as packed:
        assert {"sources/fmu.cpp", "sources/include/gyrostat/flight/stack.hpp"} <= set(packed.namelist())
        assert b"MIT License" in packed.read("documentation/licenses/gyrostat.txt")
        assert b"Mozilla Public License" in packed.read("documentation/licenses/eigen.txt")


def test_what_was_not_measured_is_a_switch_that_starts_true(wheel2: Unit, tmp_path: Path) -> None:
    path, code = wheel2
    with slave(path, tmp_path) as one:
        switches = [one.variables[f"measurement.{s}_valid"] for s in ("attitude", "rate", "momentum")]
        assert {(v.type, v.causality, v.start) for v in switches} == {("Boolean", "input", "true")}
        status = one.variables["allocation.status"].valueReference
        for k, (valid, rate, said) in enumerate([(False, 0.0, 1), (True, 0.0, 0), (False, float("nan"), 1)]):
            one.set({"measurement.rate_valid": valid, "measurement.omega_BN_B[0]": rate})
            one.fmu.doStep(currentCommunicationPoint=k * code.dt, communicationStepSize=code.dt)
            assert one.fmu.getInteger([status]) == [said]


def test_parameters_of_a_unit_are_those_of_the_scenario(wheel2: Unit, tmp_path: Path) -> None:
    path, _ = wheel2
    # One of each kind: number, vector, choice, switch and whole number; no other default depends on them.
    changes = {
        "observer.lambda1": 1.5,
        "observer.method": "explicit_euler",
        "observer.substeps": 3,
        "controller.K3": [3.0, 2.0, 1.0],
        "allocator.use_effectiveness": False,
    }
    scenario = gs.Scenario.load("wheel2_degraded").replace(allocator="pseudo_inverse").replace(**changes)
    flown = flight_code(scenario, scalar="double", samples=1000, name=None)
    settings = {
        "observer.lambda1": 1.5,
        "observer.method": 1,
        "observer.substeps": 3,
        **{f"controller.K3[{i}]": 3.0 - i for i in range(3)},
        "allocator.use_effectiveness": False,
    }
    with slave(path, tmp_path / "changed", settings) as one:
        assert_same(one.fly(flown), flown)
    with slave(path, tmp_path / "same") as one:
        unchanged = one.fly(flown)[:, : flown.actuators]
        assert np.abs(unchanged - flown.column("allocation.u")).max() > 1e-3


def test_a_mask_is_a_switch_for_each_actuator(maneuver: Unit, tmp_path: Path) -> None:
    path, code = maneuver
    assert code.column("detection.event").max() > 0  # the recording has a declaration
    scenario = code.scenario.replace(**{"observer.frozen": [0], "detector.unwatched": []})
    flown = flight_code(scenario, scalar="double", samples=2500, name=None)
    masks = {"observer.frozen[0]": True, "observer.frozen[3]": False, "detector.unwatched[3]": False}
    with slave(path, tmp_path / "changed", masks) as one:
        assert_same(one.fly(flown), flown)
    with slave(path, tmp_path / "same") as one, pytest.raises(AssertionError):
        assert_same(one.fly(flown), flown)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"observer.lambda1": -1.0}, "observer.lambda1 = -1 is outside its range"),
        ({"observer.method": 2}, "observer.method = 2 is outside its range"),
        # a tenth of the wheels' torque at 1e6: the component's own check
        ({f"controller.K3[{i}]": 1e6 for i in range(3)}, "(K3 + mu / eps) * dt = 10000"),
    ],
)
def test_a_unit_refuses_what_the_components_refuse(
    wheel2: Unit, tmp_path: Path, settings: dict[str, Any], said: str
) -> None:
    with slave(wheel2[0], tmp_path, start=False) as one:
        with pytest.raises(FMICallException):
            one.start(settings)
        assert said in one.messages[-1]


def test_a_unit_steps_whole_periods_one_after_the_other(wheel2: Unit, tmp_path: Path) -> None:
    path, code = wheel2
    with slave(path, tmp_path) as one:
        for time, step, said in (
            (0.0, 0.5 * code.dt, "not a whole number of periods"),
            (0.0, 1.5 * code.dt, "not a whole number of periods"),
            (0.0, 0.0, "not a whole number of periods"),
            (code.dt, code.dt, "the next sample is due at 0 s"),
        ):
            with pytest.raises(FMICallException):
                one.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=step)
            assert said in one.messages[-1]
        with pytest.raises(FMICallException):
            one.set({"observer.lambda1": 1.0})
        assert "cannot change once initialisation has ended" in one.messages[-1]
        assert_same(one.fly(code), code)  # none of that moved anything

        one.fmu.reset()
        one.start({})
        assert_same(one.fly(code), code)  # and it is as new
        one.fmu.doStep(currentCommunicationPoint=len(code.rows) * code.dt, communicationStepSize=3 * code.dt)


def turning() -> gs.Scenario:
    """Gimbals and torquers turn the axes of a vehicle on an orbit, and the torquers empty its gyros."""
    vehicle, gyros = gs.vehicle.cmg4(rotor_momentum=2.0)
    return gs.Scenario(
        name="turning",
        vehicle={
            **vehicle.to_dict(),
            "D_B": np.eye(3).tolist(),
            "u_max": [30.0] * 3 + [2.0] * 4,
            "magnetorquers": [0, 1, 2],
        },
        cmg=gyros.model_copy(update={"angles": (0.1, -0.2, 0.3, 0.05)}),
        orbit=gs.Orbit(semi_major_axis=6.9e6, inclination=0.9),
        desaturation=gs.Desaturation(gain=20.0),
        sensors=[gs.sensors.Magnetometer(noise=5e-8)],
        controller="mrp_feedback",
        initial=gs.Initial(mrp=(0.01, -0.02, 0.03)),
        integrator="rk4",
        duration=200.0,
        dt=0.5,
    )


def test_a_unit_takes_gimbals_and_field_and_what_the_desaturation_goes_by(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flags = tuple("-O0" if flag == "-O2" else flag for flag in compiler.FLAGS)
    monkeypatch.setattr(compiler, "FLAGS", flags)  # the others are compiled as users compile them
    code = export(turning(), "fmu", tmp_path / "out")
    path = tmp_path / "out" / "turning.fmu"
    assert validate_fmu(str(path)) == []
    with slave(path, tmp_path / "same") as one:
        facts = {v.name: (v.type, v.causality, v.unit, v.start) for v in one.description.modelVariables}
        assert facts["measurement.gimbal[3]"] == ("Real", "input", "rad", "0.0")
        assert facts["measurement.field_B[0]"] == ("Real", "input", "T", "0.0")
        assert facts["measurement.field_valid"] == ("Boolean", "input", None, "false")
        assert facts["desaturation.momentum"][:2] == ("Enumeration", "parameter")
        found = one.fly(code)
    assert_same(found, code)
    assert (np.abs(found[1:, : code.actuators]).max(axis=0) > 0).all()
    changed = turning().replace(**{"desaturation.gain": 5.0, "desaturation.momentum": "total"})
    flown = flight_code(changed, scalar="double", samples=50, name=None)
    with slave(path, tmp_path / "changed", {"desaturation.gain": 5.0, "desaturation.momentum": 1}) as one:
        assert_same(one.fly(flown), flown)
    with slave(path, tmp_path / "unchanged") as one, pytest.raises(AssertionError):
        assert_same(one.fly(flown), flown)


def test_a_unit_is_the_same_file_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gyrostat.export.fmu.compile_shared", lambda *a: Path(a[3]).write_bytes(b""))
    files = []
    for attempt in ("one", "two"):
        export(gs.Scenario.load("wheel2_degraded"), "fmu", tmp_path / attempt, samples=2)
        files.append((tmp_path / attempt / "wheel2_degraded.fmu").read_bytes())
    assert files[0] == files[1]
