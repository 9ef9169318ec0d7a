# SPDX-License-Identifier: MIT
"""FTC-4RW closed loop, gyrostat against peers: one process, one core, interleaved, CPU time.

Every peer flies the same sampled loop (100 Hz, zero-order hold, MRP feedback K = 1, P = 5, pseudo-inverse, clip at
0.2 N m, four wheels of 0.05 kg m^2, constant disturbance) unless its line says otherwise, and its state at 20 s is
compared with gyrostat's before its time counts. Absolute figures are those of one machine; the ratios travel.

    pip install '.[bench]'
    python benchmarks/peers.py [--rounds 5] [--only gyrostat,numba] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

J_TOTAL = np.array([[20.0, 0.0, 0.9], [0.0, 17.0, 0.0], [0.9, 0.0, 15.0]])
AXES = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3.0)
JS, U_MAX, K, P, DT, DURATION = 0.05, 0.2, 1.0, 5.0, 0.01, 200.0
COMPARED_AT = 20.0  # s
TORQUE = np.array([1e-3, -2e-3, 1.5e-3])
SIGMA_0, OMEGA_0 = np.array([0.1, 0.2, -0.3]), np.array([0.01, -0.02, 0.03])
J = J_TOTAL - JS * AXES @ AXES.T
J_INV = np.linalg.inv(J)
AXES_PINV = np.linalg.pinv(AXES)


@dataclass
class Peer:
    """One way to fly the loop."""

    name: str
    run: Callable[[float], np.ndarray]  # simulated seconds -> [sigma, omega] at the end
    seconds: float  # simulated in one timed run: long enough to time, short enough to wait for
    tolerance: float  # on the final state against gyrostat; wide where the peer flies another loop
    note: str = ""


def gyrostat_peer(integrator: str, *, record: bool) -> Callable[[float], np.ndarray]:
    """From Python, through the bindings."""
    import gyrostat as gs
    from gyrostat import _core

    scenario = gs.Scenario(
        vehicle=gs.Vehicle(J_B=J_TOTAL.tolist(), D_B=AXES.tolist(), u_max=U_MAX, wheel_inertia=JS),
        initial=gs.Initial(mrp=tuple(SIGMA_0), omega_BN_B=tuple(OMEGA_0)),
        controller=gs.controller("mrp_feedback", K=K, P=P),
        disturbances=[gs.disturbances.Constant(torque_B=tuple(TORQUE))],
        integrator=gs.integrators.Rk4() if integrator == "rk4" else gs.integrators.Cvode(rtol=1e-9),
        duration=DURATION,
        dt=DT,
    )

    def run(seconds: float) -> np.ndarray:
        s = scenario if seconds == DURATION else scenario.replace(duration=seconds)
        result = s.run() if record else s.run(channels=["truth.q_NB", "truth.omega_BN_B"], every=10**6)
        return np.concatenate([_core.mrp_from_quat(result["truth.q_NB"][-1]), result["truth.omega_BN_B"][-1]])

    return run


def derivative(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """State: sigma, omega, wheel momentum h = Js (Omega + g.omega)."""
    sigma, omega, h = x[:3], x[3:6], x[6:]
    sigma_dot = 0.25 * ((1 - sigma @ sigma) * omega + 2 * np.cross(sigma, omega) + 2 * sigma * (sigma @ omega))
    omega_dot = J_INV @ (AXES @ u + TORQUE - np.cross(omega, J @ omega + AXES @ h))
    return np.concatenate([sigma_dot, omega_dot, -u])


def command(x: np.ndarray) -> np.ndarray:
    return np.clip(AXES_PINV @ (-K * x[:3] - P * x[3:6]), -U_MAX, U_MAX)


def start() -> np.ndarray:
    return np.concatenate([SIGMA_0, OMEGA_0, JS * AXES.T @ OMEGA_0])


def numpy_rk4(seconds: float) -> np.ndarray:
    x = start()
    for _ in range(round(seconds / DT)):
        u = command(x)
        k1 = derivative(x, u)
        k2 = derivative(x + DT / 2 * k1, u)
        k3 = derivative(x + DT / 2 * k2, u)
        k4 = derivative(x + DT * k3, u)
        x = x + DT / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x[:6]


def numba_loop() -> Callable[[float], np.ndarray]:
    """The whole loop compiled: what the hardware gives to a hand-written program of this one case."""
    import numba

    jit = numba.njit(cache=False, fastmath=False)

    @jit
    def rhs(x, u, out, J, J_inv, axes, torque):  # type: ignore[no-untyped-def]
        s0, s1, s2, w0, w1, w2 = x[0], x[1], x[2], x[3], x[4], x[5]
        ss, sw = s0 * s0 + s1 * s1 + s2 * s2, s0 * w0 + s1 * w1 + s2 * w2
        out[0] = 0.25 * ((1 - ss) * w0 + 2 * (s1 * w2 - s2 * w1) + 2 * s0 * sw)
        out[1] = 0.25 * ((1 - ss) * w1 + 2 * (s2 * w0 - s0 * w2) + 2 * s1 * sw)
        out[2] = 0.25 * ((1 - ss) * w2 + 2 * (s0 * w1 - s1 * w0) + 2 * s2 * sw)
        L = np.empty(3)
        T = np.empty(3)
        for r in range(3):
            L[r] = J[r, 0] * w0 + J[r, 1] * w1 + J[r, 2] * w2
            T[r] = torque[r]
            for i in range(4):
                L[r] += axes[r, i] * x[6 + i]
                T[r] += axes[r, i] * u[i]
        T[0] -= w1 * L[2] - w2 * L[1]
        T[1] -= w2 * L[0] - w0 * L[2]
        T[2] -= w0 * L[1] - w1 * L[0]
        for r in range(3):
            out[3 + r] = J_inv[r, 0] * T[0] + J_inv[r, 1] * T[1] + J_inv[r, 2] * T[2]
        for i in range(4):
            out[6 + i] = -u[i]

    @jit
    def loop(x, steps, dt, J, J_inv, axes, axes_pinv, torque, K, P, u_max):  # type: ignore[no-untyped-def]
        u, z = np.empty(4), np.empty(10)
        k1, k2, k3, k4 = np.empty(10), np.empty(10), np.empty(10), np.empty(10)
        for _ in range(steps):
            for i in range(4):
                c = 0.0
                for r in range(3):
                    c += axes_pinv[i, r] * (-K * x[r] - P * x[3 + r])
                u[i] = min(max(c, -u_max), u_max)
            rhs(x, u, k1, J, J_inv, axes, torque)
            for i in range(10):
                z[i] = x[i] + 0.5 * dt * k1[i]
            rhs(z, u, k2, J, J_inv, axes, torque)
            for i in range(10):
                z[i] = x[i] + 0.5 * dt * k2[i]
            rhs(z, u, k3, J, J_inv, axes, torque)
            for i in range(10):
                z[i] = x[i] + dt * k3[i]
            rhs(z, u, k4, J, J_inv, axes, torque)
            for i in range(10):
                x[i] += dt / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i])
        return x

    def run(seconds: float) -> np.ndarray:
        return loop(start(), round(seconds / DT), DT, J, J_INV, AXES, AXES_PINV, TORQUE, K, P, U_MAX)[:6]

    run(1.0)  # compile
    return run


def scipy_loop() -> Callable[[float], np.ndarray]:
    from scipy.integrate import solve_ivp

    def run(seconds: float) -> np.ndarray:
        x = start()
        for _ in range(round(seconds / DT)):
            u = command(x)
            step = solve_ivp(lambda _, y, u=u: derivative(y, u), (0.0, DT), x, method="RK45", rtol=1e-9, atol=1e-12)
            x = step.y[:, -1]
        return x[:6]

    return run


def sundae_loop() -> Callable[[float], np.ndarray]:
    from sksundae.cvode import CVODE

    def rhs(_t: float, x: np.ndarray, xdot: np.ndarray) -> None:
        xdot[:] = derivative(x, command(x))

    def run(seconds: float) -> np.ndarray:
        solver = CVODE(rhs, rtol=1e-9, atol=1e-12, method="Adams")
        return solver.solve(np.array([0.0, seconds]), start()).y[-1, :6]

    return run


def basilisk_loop() -> Callable[[float], np.ndarray]:
    """Its own loop, built anew for each run."""
    from Basilisk.utilities import macros

    def run(seconds: float) -> np.ndarray:
        sim = basilisk_simulation()
        sim.InitializeSimulation()
        sim.ConfigureStopTime(macros.sec2nano(seconds))
        sim.ExecuteSimulation()
        end = sim.body.scStateOutMsg.read()
        return np.concatenate([end.sigma_BN, end.omega_BN_B])

    return run


def basilisk_simulation() -> Any:
    """Spacecraft + reactionWheelStateEffector (balanced) + extForceTorque + mrpFeedback + rwMotorTorque."""
    from Basilisk.architecture import messaging
    from Basilisk.fswAlgorithms import attTrackingError, inertial3D, mrpFeedback, rwMotorTorque
    from Basilisk.simulation import extForceTorque, reactionWheelStateEffector, simpleNav, spacecraft
    from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW

    sim = SimulationBaseClass.SimBaseClass()
    process = sim.CreateNewProcess("process")
    process.addTask(sim.CreateNewTask("task", macros.sec2nano(DT)))
    body = spacecraft.Spacecraft()
    body.hub.mHub = 100.0
    body.hub.IHubPntBc_B = (J_TOTAL - JS * AXES @ AXES.T).tolist()
    body.hub.sigma_BNInit = [[v] for v in SIGMA_0]
    body.hub.omega_BN_BInit = [[v] for v in OMEGA_0]
    factory = simIncludeRW.rwFactory()
    for i in range(4):
        axis = AXES[:, i].tolist()
        factory.create("custom", axis, Omega=0.0, Js=JS, u_max=U_MAX, useMaxTorque=True, Omega_max=1e6)
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, body)
    push = extForceTorque.ExtForceTorque()
    push.extTorquePntB_B = [[v] for v in TORQUE]
    body.addDynamicEffector(push)
    nav, target, error = simpleNav.SimpleNav(), inertial3D.inertial3D(), attTrackingError.attTrackingError()
    target.sigma_R0N = [0.0, 0.0, 0.0]
    law, motor = mrpFeedback.mrpFeedback(), rwMotorTorque.rwMotorTorque()
    law.K, law.P, law.Ki, law.integralLimit = K, P, -1.0, 0.1
    motor.controlAxes_B = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    config = messaging.VehicleConfigMsgPayload(ISCPntB_B=J_TOTAL.flatten().tolist())
    config_msg = messaging.VehicleConfigMsg().write(config)
    rw_params = factory.getConfigMessage()
    nav.scStateInMsg.subscribeTo(body.scStateOutMsg)
    error.attNavInMsg.subscribeTo(nav.attOutMsg)
    error.attRefInMsg.subscribeTo(target.attRefOutMsg)
    law.guidInMsg.subscribeTo(error.attGuidOutMsg)
    law.vehConfigInMsg.subscribeTo(config_msg)
    motor.rwParamsInMsg.subscribeTo(rw_params)
    motor.vehControlInMsg.subscribeTo(law.cmdTorqueOutMsg)
    wheels.rwMotorCmdInMsg.subscribeTo(motor.rwMotorTorqueOutMsg)
    for order, model in enumerate((body, wheels, push, nav, target, error, law, motor)):
        sim.AddModelToTask("task", model, 10 - order)
    sim.body = body
    sim.kept = wheels, push, nav, target, error, law, motor, config_msg, rw_params, factory
    return sim


def peers() -> list[Peer]:
    """Those that are installed; the others are named on stderr."""
    wanted: list[tuple[str, Callable[[], Callable[[float], np.ndarray]], float, float, str]] = [
        ("gyrostat rk4, arrays", lambda: gyrostat_peer("rk4", record=True), DURATION, 1e-12, "every sample recorded"),
        ("gyrostat rk4", lambda: gyrostat_peer("rk4", record=False), DURATION, 1e-12, "final state only"),
        ("gyrostat cvode 1e-9, arrays", lambda: gyrostat_peer("cvode", record=True), DURATION, 1e-7, ""),
        ("gyrostat cvode 1e-9", lambda: gyrostat_peer("cvode", record=False), DURATION, 1e-7, ""),
        ("numba RK4", numba_loop, DURATION, 1e-10, "whole loop compiled, nothing recorded"),
        ("NumPy RK4", lambda: numpy_rk4, 10.0, 1e-10, ""),
        ("solve_ivp RK45", scipy_loop, 2.0, 1e-7, "restarted at each sample"),
        ("scikit-sundae CVODE", sundae_loop, DURATION, 1e-2, "continuous law, Python right-hand side"),
        ("Basilisk", basilisk_loop, DURATION, 1e-2, "its loop: one sample of delay, wheels' drag off"),
    ]
    out = []
    for name, make, seconds, tolerance, note in wanted:
        try:
            out.append(Peer(name, make(), seconds, tolerance, note))
        except ImportError as error:
            print(f"{name}: not installed ({error})", file=sys.stderr)
    return out


def measure(rounds: int, only: list[str]) -> list[dict[str, object]]:
    """Median over rounds of simulated seconds a CPU second, peers in turn."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    flown = [p for p in peers() if not only or any(word.lower() in p.name.lower() for word in only)]
    truth = gyrostat_peer("rk4", record=False)
    errors = {}  # in the middle of the manoeuvre, where a different loop shows; this also warms up
    for p in flown:
        until = min(p.seconds, COMPARED_AT)
        errors[p.name] = float(np.abs(p.run(until) - truth(until)).max())
    for p in flown:
        if not errors[p.name] <= p.tolerance:
            raise SystemExit(f"{p.name} ends {errors[p.name]:.1e} away from gyrostat: not the same loop")
    times: dict[str, list[float]] = {p.name: [] for p in flown}
    for _ in range(rounds):
        for p in flown:
            begin = time.process_time()
            p.run(p.seconds)
            times[p.name].append(time.process_time() - begin)
    speed = {p.name: p.seconds / statistics.median(times[p.name]) for p in flown}
    bar = speed.get("numba RK4")
    return [
        {
            "peer": p.name,
            "simulated_s_per_cpu_s": speed[p.name],
            "ratio_to_numba": speed[p.name] / bar if bar else None,
            "difference_at_20_s": errors[p.name],
            "note": p.note,
        }
        for p in flown
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", default="", help="comma-separated parts of names")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    rows = measure(args.rounds, [w for w in args.only.split(",") if w])
    if args.json:
        print(json.dumps(rows, indent=1))
        return
    print(f"{'':29s} {'sim s / CPU s':>14s} {'/ numba':>9s} {'differs':>12s}")
    for r in rows:
        ratio = "" if r["ratio_to_numba"] is None else f"{r['ratio_to_numba']:.3g}"
        speed, difference = r["simulated_s_per_cpu_s"], r["difference_at_20_s"]
        print(f"{r['peer']:29s} {speed:14.0f} {ratio:>9s} {difference:12.1e}  {r['note']}")


if __name__ == "__main__":
    main()
