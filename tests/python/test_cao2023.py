# SPDX-License-Identifier: MIT
"""Cao, Gong, Xue, Wen 2023, end to end: printed data, claims, both plants against numpy, law and observer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import gyrostat
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import gyrostat as gs
from gyrostat import papers
from gyrostat.design.learning_disturbance import LearningGains
from gyrostat.papers.cao2023 import signals

Array = NDArray[np.float64]

PAPER = "cao2023"
GAINS = LearningGains(M=18.0, k1=0.98, k2=15.0, k3=5.0, Tc=0.01)
B = np.array([[0.67, 0.67, 0.67, 0.67], [0.69, -0.69, -0.69, 0.69], [0.28, 0.28, -0.28, -0.28]])
J = np.array([200.0, 400.0, 200.0])


def case(name: str) -> gs.Scenario:
    return papers.load("cao2023").cases[name].scenario


# ---- the study ------------------------------------------------------------------------------------------------------


def test_every_claim_is_accepted(claims: dict[str, Any]) -> None:
    assert [c["id"] for c in claims["claims"] if not c["ok"]] == []
    assert claims["passed"] == len(claims["claims"]) > 130


def test_published_statements_that_do_not_hold_are_reported_as_such(claims: dict[str, Any]) -> None:
    verdicts = {c["id"]: c["verdict"] for c in claims["claims"]}
    for claim in ("T10.rate_after@T10", "estimate.better", "estimate.interval_50ms_worse", "estimate.time.traditional"):
        assert verdicts[claim] == "reproduces", claim
    for claim in (
        "T10.angle_at_T@T10",
        "T10.angle_after@T10",
        "T5.angle_after@T5_cvode",
        "T2.angle_at_T@T2",
        "T2.rate_at_T@T2",
        "T2.settling",
        "estimate.because_of_memory",
        "estimate.time.traditional_fair",
        "torque.T5",
    ):
        assert verdicts[claim] == "does not reproduce", claim


def test_the_report_has_every_figure_with_its_data(report: Path) -> None:
    names = {f.name for f in papers.load("cao2023").figures}
    assert {f"fig{i}" for i in range(1, 15)} | {"response", "region", "sampling", "limits", "sensor_faults"} <= names
    page = (report / "index.html").read_text()
    for name in names:
        assert f'id="cao2023-{name}"' in page
        assert (report / "cao2023" / f"{name}.js").stat().st_size > 400
        with np.load(report / "cao2023" / f"{name}.npz") as file:
            for key in set(file.files) - {"units"}:
                x = file[key]
                constant_by_nature = key in {"f, yaw", "spectral radius, held", "sampled, held"}
                assert (np.ptp(x[np.isfinite(x)], axis=0) > 0.0).all() or constant_by_nature, f"{name}: {key}"
                # The sampled limit ends where no k3 is stable, and the run with a sensor frozen for good overflows.
                assert np.isfinite(x).all() or "rolling" in key or "for_good" in key, f"{name}: {key}"


def test_the_figures_show_what_the_claims_say(report: Path) -> None:
    def data(name: str) -> dict[str, Array]:
        with np.load(report / "cao2023" / f"{name}.npz") as file:
            return {key: file[key] for key in file.files if key != "units"}

    estimate = data("fig2")
    late = estimate["t"] > 10.5
    np.testing.assert_allclose(estimate["f, roll"][late], 4.69 + 2.0 * np.sin(estimate["t"][late]), atol=1e-9)
    np.testing.assert_allclose(estimate["fhat, roll"][late], estimate["f, roll"][late], rtol=0.025)
    tracking = data("fig11")
    np.testing.assert_allclose(tracking["angle error"][0], [-2.7, -0.07, 1.0], rtol=1e-12)
    assert np.abs(tracking["angle error"][tracking["t"] >= 5.5]).max() == pytest.approx(2.145e-4, rel=5e-3)
    response = data("response")
    assert response["proposed (k2 = 15, k3 = 5)"][0] == pytest.approx(0.01768, abs=1e-5)
    assert response["traditional, k2 = 15"][0] == pytest.approx(0.02344, abs=1e-5)
    sampling = data("sampling")
    rolling, periods = sampling["spectral radius, rolling"], sampling["period of spectral radius, rolling"]
    np.testing.assert_array_equal(rolling < 1.0, periods < 2.01)


# ---- the printed data -----------------------------------------------------------------------------------------------


def test_faults_disturbance_and_reference_are_the_printed_functions_of_time() -> None:
    names = ["truth.bias", "truth.external_B", "truth.lumped_B", "truth.euler", "error.euler", "error.euler_rates"]
    result = case("T5").replace(duration=8.0).run(channels=[*names, "truth.omega_BN_B"])
    t = result.t
    np.testing.assert_array_equal(result["truth.bias"][1:], np.broadcast_to([2.0, 0.0, 5.0, 0.0], (len(t) - 1, 4)))
    d_e = np.column_stack([2.0 * np.sin(t), 2.0 * np.cos(0.5 * t), 2.0 + 0.0 * t])
    np.testing.assert_allclose(result["truth.external_B"], J * d_e, rtol=0, atol=1e-12)
    f = B @ [2.0, 0.0, 5.0, 0.0] + d_e
    np.testing.assert_allclose(signals.fault(result)[1:], f[1:], rtol=0, atol=1e-11)  # rounding of J g and D u
    chi_r = np.column_stack([2.0 + 0.0 * t, 0.0 * t, 0.5 * np.cos(2.0 * t)])
    np.testing.assert_allclose(result["truth.euler"] - result["error.euler"], chi_r, rtol=0, atol=1e-14)
    rates = result["truth.omega_BN_B"] - result["error.euler_rates"]
    np.testing.assert_allclose(rates[:, 2], -np.sin(2.0 * t), rtol=0, atol=1e-13)


def test_the_vehicles_have_the_printed_numbers() -> None:
    for name in ("T5", "rigid", "nozzles"):
        vehicle = case(name).resolve()["vehicle"]
        np.testing.assert_array_equal(vehicle["J_B"], np.diag(J) if np.ndim(vehicle["J_B"]) == 2 else J)
        D = np.array(vehicle["D_B"])
        np.testing.assert_allclose(D[:, :4], J[:, None] * B, rtol=1e-14)
        np.testing.assert_array_equal(D[:, 4:], -D[:, :4] if name == "nozzles" else np.empty((3, 0)))
    observer, law = case("T5").resolve()["observer"], case("T5").resolve()["controller"]
    assert [observer[k] for k in ("M", "k1", "k2", "k3", "interval")] == [18.0, 0.98, 15.0, 5.0, 0.01]
    assert [law[k] for k in ("T", "c", "b", "eta", "layer", "stretch")] == [5.0, 10.0, 2.0, 5.5, 0.1, 0.0]


def printed_g(angles: Array, rates: Array, w0: float, inertia: Array) -> Array:
    """The printed model term by term, with its misprints put right; in brackets what is missing in print."""
    (f, t, p), (fd, td, pd) = angles, rates
    sf, cf, st, ct, sp, cp = np.sin(f), np.cos(f), np.sin(t), np.cos(t), np.sin(p), np.cos(p)
    Ix, Iy, Iz = inertia
    w2 = w0 * w0
    s2f, s2t, s2p = np.sin(2 * f), np.sin(2 * t), np.sin(2 * p)
    g1 = (
        w0 * pd * cp * ct
        - w0 * td * sp * st
        + (Iy - Iz)
        / Ix
        * (
            td * pd
            + w0 * td * cf * sp * st
            + w0 * td * cp * sf
            + w0 * pd * cp * cf
            + 0.5 * w2 * s2p * cf**2 * st
            + 0.5 * w2 * cp**2 * s2f
            - w0 * pd * sp * st * sf
            - 0.5 * w2 * st**2 * sp**2 * s2f
            - 1.5 * w2 * ct**2 * s2f
            - 0.5 * w2 * s2p * st * sf**2
        )
    )
    g2 = (
        w0 * pd * sp * cf
        + w0 * fd * cp * sf
        + w0 * td * sp * ct * sf  # printed with the rate of roll
        + w0 * fd * sp * st * cf
        + w0 * pd * cp * st * sf  # [missing]
        + (Iz - Ix)
        / Iy
        * (
            fd * pd
            + w0 * fd * cf * sp * st
            + w0 * fd * cp * sf
            - w0 * pd * sp * ct
            - 0.5 * w2 * s2t * sp**2 * cf
            - 0.5 * w2 * ct * sf * s2p
            + 1.5 * w2 * s2t * cf
        )
    )
    g3 = (
        w0 * fd * sf * sp * st
        - w0 * fd * cp * cf
        - w0 * td * sp * ct * cf  # [missing]
        - w0 * pd * cp * st * cf  # [missing]
        + w0 * pd * sp * sf  # [missing]
        + (Ix - Iy)
        / Iz
        * (
            fd * td
            + w0 * fd * cp * cf
            - w0 * fd * sp * st * sf  # printed with 1 / w0
            - w0 * td * sp * ct  # [missing]
            - 0.5 * w2 * s2p * ct * cf  # [missing]
            + 0.5 * w2 * sp**2 * sf * s2t
            + 1.5 * w2 * s2t * sf  # printed - 1/3
        )
    )
    return np.array([g1, g2, g3])


def flown(rhs: Callable[[float, Array], Array], start: Array, t: Array) -> Array:
    return np.asarray(solve_ivp(rhs, (t[0], t[-1]), start, method="DOP853", t_eval=t, rtol=1e-12, atol=1e-13).y.T)


@pytest.mark.parametrize("integrator", ["rk4", "cvode"])
def test_the_printed_plant_is_the_printed_model(integrator: str) -> None:
    """Three different moments of inertia, so that no bracket loses its weight."""
    inertia, u = np.array([200.0, 400.0, 300.0]), np.array([0.05, -0.1, 0.2, 0.02])
    scenario = case("T5").replace(
        **{
            "vehicle.J_B": inertia.tolist(),
            "observer": "passthrough",
            "controller": {"type": "open_loop", "command": u.tolist()},
            "faults": [],
            "integrator": {"type": integrator},
            "duration": 4.0,
            "record": None,
        }
    )
    if integrator == "cvode":
        scenario = scenario.replace(**{"integrator.rtol": 1e-11, "integrator.atol": 1e-13})
    result = scenario.run(channels=["truth.euler", "truth.omega_BN_B"], every=50)
    D = np.array(scenario.resolve()["vehicle"]["D_B"])

    def rhs(t: float, y: Array) -> Array:
        d = J * [2.0 * np.sin(t), 2.0 * np.cos(0.5 * t), 2.0]
        return np.concatenate([y[3:], printed_g(y[:3], y[3:], 0.10312, inertia) + (D @ u + d) / inertia])

    expected = flown(rhs, np.array([-0.7, -0.07, 1.5, 0.5, 1.3, -0.2]), result.t)
    ours = np.hstack([result["truth.euler"], result["truth.omega_BN_B"]])
    # Angles reach some 10 rad. Two Runge-Kutta steps a millisecond err by 1e-12, CVODE by its tolerance.
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-10 if integrator == "rk4" else 1e-8)


def coordinate_turns(angles: Array) -> tuple[Array, Array, Array]:
    """R1, R2, R3 of the 3-2-1 sequence; their product takes orbital to body components."""
    (sf, st, sp), (cf, ct, cp) = np.sin(angles), np.cos(angles)
    return (
        np.array([[1.0, 0.0, 0.0], [0.0, cf, sf], [0.0, -sf, cf]]),
        np.array([[ct, 0.0, -st], [0.0, 1.0, 0.0], [st, 0.0, ct]]),
        np.array([[cp, sp, 0.0], [-sp, cp, 0.0], [0.0, 0.0, 1.0]]),
    )


def orbital_body(angles: Array, rates: Array, torque: Array, w0: float) -> Array:
    """Second derivative of the angles of a rigid body against its orbital frame, from first principles."""
    R1, R2, R3 = coordinate_turns(angles)
    R = R1 @ R2 @ R3
    (sf, st), (cf, ct) = np.sin(angles[:2]), np.cos(angles[:2])
    E = np.array([[1.0, 0.0, -st], [0.0, cf, ct * sf], [0.0, -sf, ct * cf]])
    fd, td = rates[:2]
    Edot = np.array(
        [
            [0.0, 0.0, -ct * td],
            [0.0, -sf * fd, -st * sf * td + ct * cf * fd],
            [0.0, -cf * fd, -st * cf * td - ct * sf * fd],
        ]
    )
    o, r = -w0 * R[:, 1], R[:, 2]
    w = E @ rates + o
    wdot = (-np.cross(w, J * w) + 3.0 * w0**2 * np.cross(r, J * r) + torque) / J
    return np.asarray(np.linalg.solve(E, wdot - Edot @ rates + np.cross(E @ rates, o)))


@pytest.mark.parametrize("integrator", ["rk4", "cvode"])
def test_a_body_with_gravity_gradient_on_a_circular_orbit_is_model_b(integrator: str) -> None:
    """A hundred times faster than a real orbit, so that the turn of the frame and the gradient weigh."""
    w0, angles, rates = 0.10312, np.array([-0.7, -0.07, 1.5]), np.array([0.05, 0.13, -0.02])
    torque = np.array([1.0, -2.0, 1.5])
    R1, R2, R3 = coordinate_turns(angles)
    E = np.column_stack([[1.0, 0.0, 0.0], R1[:, 1], (R1 @ R2)[:, 2]])
    omega = E @ rates - w0 * (R1 @ R2 @ R3)[:, 1]
    scenario = case("rigid").replace(
        **{
            "vehicle.orbit_rate": w0,
            "initial.omega_BN_B": omega.tolist(),
            "reference": {"type": "hold"},
            "observer": "passthrough",
            "controller": {"type": "open_loop", "command": [0.0] * 4},
            "faults": [],
            "disturbances": [{"type": "gravity_gradient"}, {"type": "constant", "torque_B": torque.tolist()}],
            "integrator": {"type": integrator},
            "duration": 20.0,
            "dt": 0.01,
            "record": None,
        }
    )
    if integrator == "cvode":
        scenario = scenario.replace(**{"integrator.rtol": 1e-11, "integrator.atol": 1e-13})
    result = scenario.run(channels=["truth.q_NB", "truth.omega_BN_B"], every=100)
    start = np.concatenate([angles, rates])
    expected = flown(lambda _, y: np.concatenate([y[3:], orbital_body(y[:3], y[3:], torque, w0)]), start, result.t)
    assert np.abs(expected[:, 1]).max() > 0.3, "a motion worth comparing"
    assert np.abs(np.cos(expected[:, 1])).min() > 0.1, "away from gimbal lock"
    for t, y, q, omega in zip(result.t, expected, result["truth.q_NB"], result["truth.omega_BN_B"], strict=True):
        R1, R2, R3 = coordinate_turns(y[:3])
        R = R1 @ R2 @ R3
        E = np.column_stack([[1.0, 0.0, 0.0], R1[:, 1], (R1 @ R2)[:, 2]])
        np.testing.assert_allclose(omega, E @ y[3:] - w0 * R[:, 1], rtol=0, atol=1e-8)
        orbit = coordinate_turns(np.array([0.0, -w0 * t, 0.0]))[1]  # takes inertial to orbital components
        w, v = q[0], q[1:]
        C_NB = (w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * np.cross(np.eye(3), v)
        np.testing.assert_allclose(C_NB.T, R @ orbit, rtol=0, atol=1e-8)


# ---- the controller -------------------------------------------------------------------------------------------------


def test_the_error_is_gone_at_t_from_a_hundred_starts() -> None:
    rng = np.random.default_rng(7)
    at_T = []
    for _ in range(100):
        initial = {"euler": rng.uniform(-1.5, 1.5, 3).tolist(), "omega_BN_B": rng.uniform(-1.0, 1.0, 3).tolist()}
        result = case("T2").replace(initial=initial, duration=2.6).run(channels=["error.euler"])
        error = np.abs(result["error.euler"]).max(axis=1)
        at_T.append(error[2000])
        assert error[2500:].max() < 2.4e-4
    # The observer's error decides what is left, not the start: 1.82e-4 rad with a tenth for the demand held for 1 ms.
    assert min(at_T) > 1.6e-4
    assert max(at_T) < 2.0e-4


def test_gimbal_lock_ends_the_run_of_a_body_and_keeps_what_was_flown() -> None:
    result = case("rigid_T10").run(channels=["truth.euler", "error.euler"])
    assert result.status == "singular"
    assert not result.completed
    assert result.end_time == pytest.approx(1.607, abs=5e-3)
    assert "pitch" in result.cause
    assert f"{np.degrees(result['truth.euler'][-1, 1]):.3f}"[:4] in result.cause
    assert len(result.t) == round(result.end_time / 0.001) + 1
    assert np.isfinite(result["error.euler"]).all()
    assert result["truth.euler"][-1, 1] == pytest.approx(np.pi / 2, abs=2e-3)
    done = gyrostat("run", "cao2023/rigid", "--set", "controller.T=10")
    assert done.returncode == 3
    assert "singular" in done.stdout + done.stderr


def test_the_printed_model_has_no_gimbal_lock() -> None:
    result = case("T10").run(channels=["truth.euler"])
    assert result.completed
    assert np.abs(result["truth.euler"][:, 1]).max() > 2.2


# ---- one-sided thrusters --------------------------------------------------------------------------------------------


def null_vectors(D: Array) -> Array:
    return np.asarray(np.linalg.svd(D)[2][3:])


def test_four_thrusters_of_one_sign_do_not_span_and_eight_nozzles_do() -> None:
    (null,) = null_vectors(J[:, None] * B)
    np.testing.assert_allclose(null / null[0], [1.0, -1.0, 1.0, -1.0], atol=1e-12)
    nozzles = np.array(case("nozzles").resolve()["vehicle"]["D_B"])
    np.testing.assert_allclose(nozzles @ np.ones(8), 0.0, atol=1e-12)  # a strictly positive null vector
    one_sided = [f for f in gs.design.torque_findings(case("one_sided")) if f.name == "every direction"]
    assert [f.ok for f in one_sided] == [False]
    assert gs.design.torque_findings(case("T5")) == [], "both signs, no limit: nothing to say"
    for scenario, ok in ((case("one_sided").replace(**{"vehicle.u_max": 20.0}), False), (case("nozzles"), True)):
        found = {f.name: f for f in gs.design.torque_findings(scenario)}
        assert found["every direction"].ok is ok


def test_eight_nozzles_give_what_two_signs_give() -> None:
    two_signs = case("T5").run(channels=["allocation.u", "demand.tau_B"])
    eight = case("nozzles").run(channels=["allocation.u", "demand.tau_B"])
    u = two_signs["allocation.u"]
    split = np.hstack([np.maximum(u, 0.0), np.maximum(-u, 0.0)])
    D = np.array(case("nozzles").resolve()["vehicle"]["D_B"])
    np.testing.assert_allclose(split @ D.T, two_signs["demand.tau_B"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(eight["demand.tau_B"], two_signs["demand.tau_B"], rtol=0, atol=1e-6)
    assert eight["allocation.u"].min() >= 0.0


# ---- the observer ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("omega", [0.5, 2.0, 10.0, 30.0, 60.0])
@pytest.mark.parametrize(("k2", "k3"), [(15.0, 5.0), (20.0, 0.0)])
def test_the_error_of_the_estimate_has_the_frequency_response_of_the_design(omega: float, k2: float, k3: float) -> None:
    wave = {"type": "sine", "amplitude": 200.0, "omega": omega}
    scenario = case("T5").replace(
        **{
            "observer.k2": k2,
            "observer.k3": k3,
            "observer.interval": 0.01,
            "dt": 0.00025,  # every half millisecond of it takes 2.3 % off the gain at 10 rad/s
            "faults": [],
            "disturbances": [{"type": "periodic", "torque_B": [wave, 0.0, 0.0]}],
            "duration": 24.5,
            "integrator": {"type": "rk4", "substeps": 1},
        }
    )
    result = scenario.run(channels=["truth.lumped_B", "observer.f_hat"])
    late = result.t > 12.0
    t, ft = result.t[late], signals.estimation_error(result)[late, 0]
    parts, *_ = np.linalg.lstsq(np.column_stack([np.sin(omega * t), np.cos(omega * t)]), ft, rcond=None)
    gains = LearningGains(18.0, 0.98, k2, k3, 0.01)
    assert np.hypot(*parts) == pytest.approx(float(gains.error_gain(omega)), rel=0.02)


def test_an_unstable_setting_is_refused_with_its_number_and_diverges_when_flown() -> None:
    with pytest.raises(gs.InputError, match=r"spectral radius .* 1\.0152"):
        case("T5").replace(dt=0.005).run()
    case("T5").replace(**{"dt": 0.005, "observer.form": "held", "duration": 0.1}).run()


def test_faults_of_the_rate_sensor_are_seen_in_the_measurement_and_in_the_estimate() -> None:
    def deception(name: str) -> tuple[Array, Array, Array]:
        names = ["measurement.omega_BN_B", "truth.omega_BN_B", "truth.lumped_B", "observer.f_hat"]
        result = case(name).replace(duration=8.2).run(channels=names)
        return result.t, signals.rate_deception(result), result["truth.omega_BN_B"]

    t, bias, _ = deception("gyro_bias")
    np.testing.assert_allclose(bias, np.outer(t > 8.0 - 1e-9, [1e-3, 0.0, 0.0]), rtol=0, atol=1e-15)
    t, scale, omega = deception("gyro_scale")
    np.testing.assert_allclose(scale, np.where((t > 8.0 - 1e-9)[:, None], 0.02 * omega, 0.0), rtol=0, atol=1e-15)
    t, freeze, omega = deception("gyro_freeze")
    frozen = (t > 8.0 - 1e-9) & (t < 8.1 - 1e-9)
    held = omega[np.flatnonzero(frozen)[0] - 1]
    np.testing.assert_allclose((freeze + omega)[frozen], np.broadcast_to(held, (frozen.sum(), 3)), atol=1e-15)
    np.testing.assert_array_equal(freeze[~frozen], 0.0)


def test_metrics_of_the_study_on_made_up_signals() -> None:
    t = np.linspace(0.0, 10.0, 1001)
    result = gs.Result({"duration": 10.0, "dt": 0.01}, t, {}, end_time=10.0)
    wave = np.column_stack([3.0 * np.ones_like(t), 4.0 * np.ones_like(t)])
    assert signals.rms_ratio(result, signal=wave, against=result, other=2.0 * wave, window=(0.0, 9.0)) == pytest.approx(
        0.5
    )
    assert signals.at(result, signal=np.column_stack([t, -2.0 * t]), instant=4.0) == pytest.approx(8.0)
    early = gs.Result({"duration": 10.0, "dt": 0.01}, t[:100], {}, status="singular", cause="pitch", end_time=0.99)
    with pytest.raises(ValueError, match=r"ended at 0\.99 s: pitch"):
        signals.at(early, signal=t[:100], instant=4.0)
    bump = np.where((t > 2.0 - 1e-9) & (t < 2.055), 1.0, 0.0)[:, None]
    assert signals.stays_below(result, signal=bump, band=0.5, after=2.0) == pytest.approx(0.06, abs=1e-9)
    assert signals.mean(result, signal=bump) == pytest.approx(6.0 / 1001.0)
