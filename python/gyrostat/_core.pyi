"""
C++ core of gyrostat.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "Allocation",
    "Axes",
    "Compiled",
    "Demand",
    "Detection",
    "Estimate",
    "EulerState",
    "Experiment",
    "Measurement",
    "NominalVehicle",
    "Reference",
    "Setup",
    "allocate",
    "catalogue",
    "check_params",
    "compiler",
    "critical_effectiveness",
    "dcm_from_quat",
    "default_rank_tolerance",
    "describe",
    "endings",
    "energy",
    "euler_from_quat",
    "final",
    "first_reach",
    "fraction_at_least",
    "mrp_from_quat",
    "mrp_shadow",
    "quat_from_euler",
    "quat_from_mrp",
    "quat_from_rotation_vector",
    "recovery",
    "rotation_angle",
    "rotation_vector_from_quat",
    "served_axes",
    "settling_time",
    "total_variation",
    "window_highest",
    "window_lowest",
    "window_max",
    "window_norm",
    "window_rms",
    "words",
]

class EulerState:
    """
    Roll, pitch, yaw (rad) and their rates (rad/s).
    """
    @property
    def angles(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad
        """
    @angles.setter
    def angles(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def rates(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad/s
        """
    @rates.setter
    def rates(self, arg1: numpy.typing.ArrayLike) -> None: ...

class NominalVehicle:
    """
    The nominal vehicle: all that flight knows of it.
    """
    @property
    def D_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        (3, n) actuator axes in columns
        """
    @property
    def J_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        (3, 3) kg m^2; with wheels: total less sum Js g g'
        """
    @property
    def h_max(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m s, momentum at which a wheel gives no more; infinite: not known
        """
    @h_max.setter
    def h_max(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def magnetorquers(self) -> list:
        """
        actuators that are a dipole (A m^2); their D_B is zero but in the axes of a sample
        """
    @magnetorquers.setter
    def magnetorquers(self, arg1: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None: ...
    @property
    def moving_axes(self) -> bool:
        """
        D_B is where they start; signals have `axes`
        """
    @property
    def orbit_rate(self) -> float:
        """
        rad/s
        """
    @property
    def spare(self) -> list:
        """
        actuators that are off until a detector enables them
        """
    @spare.setter
    def spare(self, arg1: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None: ...
    @property
    def u_dead(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m, smallest command of these that acts
        """
    @u_dead.setter
    def u_dead(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def u_gap(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m, smallest distance from u_up that they keep; what is nearer is u_up
        """
    @u_gap.setter
    def u_gap(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def u_lo(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m
        """
    @u_lo.setter
    def u_lo(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def u_quantum(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m, of on/off actuators one tick of the valve as a mean over the period; 0, or empty: continuous
        """
    @u_quantum.setter
    def u_quantum(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def u_rate(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m/s
        """
    @u_rate.setter
    def u_rate(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def u_up(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m
        """
    @u_up.setter
    def u_up(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def wheels(self) -> list:
        """
        actuators that store momentum
        """
    @wheels.setter
    def wheels(self, arg1: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None: ...

class Setup:
    """
    What a component is built for: the nominal vehicle and the period dt (s).
    """
    @property
    def dt(self) -> float: ...
    @property
    def vehicle(self) -> NominalVehicle: ...

class Axes:
    """
    Where actuators point at one sample; empty: as the vehicle says.
    """
    @property
    def D_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, n]"]:
        """
        (3, n) axes in columns; (3, 0)
        """
    @property
    def h_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) N m s, stored momentum
        """
    @property
    def revision(self) -> int:
        """
        another one wherever D_B is another one
        """

class Measurement:
    """
    Sensors to navigator and observer.
    """
    @property
    def attitude_valid(self) -> bool:
        """
        False: q_NB was not measured at this sample but carried on by the model
        """
    @attitude_valid.setter
    def attitude_valid(self, arg0: bool) -> None: ...
    @property
    def axes(self) -> Axes: ...
    @property
    def euler(self) -> EulerState: ...
    @property
    def event(self) -> int:
        """
        counts jumps that no motion explains
        """
    @property
    def field_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) T, magnetic field
        """
    @field_B.setter
    def field_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def field_N(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) T, the field as flight's model has it; zero: not known
        """
    @field_N.setter
    def field_N(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def field_valid(self) -> bool:
        """
        False: field_B was not measured at this sample
        """
    @field_valid.setter
    def field_valid(self, arg0: bool) -> None: ...
    @property
    def gimbal(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) rad; (0,) without control moment gyros
        """
    @gimbal.setter
    def gimbal(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def h_w(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m s
        """
    @h_w.setter
    def h_w(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def momentum_valid(self) -> bool:
        """
        False: h_w was not measured at this sample but carried on by the model
        """
    @momentum_valid.setter
    def momentum_valid(self, arg0: bool) -> None: ...
    @property
    def omega_BN_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad/s
        """
    @omega_BN_B.setter
    def omega_BN_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def q_NB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"]:
        """
        (4,) scalar first; sign continuous from the start
        """
    @q_NB.setter
    def q_NB(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def rate_step(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad/s, share of the change of omega_BN_B that is a navigator's knowledge, not motion
        """
    @rate_step.setter
    def rate_step(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def rate_valid(self) -> bool:
        """
        False: omega_BN_B was not measured at this sample but carried on by the model
        """
    @rate_valid.setter
    def rate_valid(self, arg0: bool) -> None: ...
    @property
    def sun_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) unit, direction to the sun
        """
    @sun_B.setter
    def sun_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def sun_N(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) unit, the sun as the almanac has it; zero: not known
        """
    @sun_N.setter
    def sun_N(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def sun_valid(self) -> bool:
        """
        False: sun_B was not measured at this sample
        """
    @sun_valid.setter
    def sun_valid(self, arg0: bool) -> None: ...
    @property
    def tick(self) -> int: ...

class Reference:
    """
    What the vehicle should do.
    """
    @property
    def euler(self) -> EulerState: ...
    @property
    def euler_accelerations(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad/s^2
        """
    @euler_accelerations.setter
    def euler_accelerations(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def event(self) -> int:
        """
        counts jumps
        """
    @property
    def omega_RN_R(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad/s
        """
    @omega_RN_R.setter
    def omega_RN_R(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def omegadot_RN_R(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad/s^2
        """
    @omegadot_RN_R.setter
    def omegadot_RN_R(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def q_NR(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"]:
        """
        (4,) scalar first
        """
    @q_NR.setter
    def q_NR(self, arg1: numpy.typing.ArrayLike) -> None: ...

class Estimate:
    """
    Observer to detector, controller and allocator.
    """

    euler: EulerState
    @staticmethod
    def healthy(y: Measurement) -> Estimate:
        """
        The measured state, healthy actuators of unknown certainty, no disturbance.
        """
    @property
    def axes(self) -> Axes: ...
    @property
    def d_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) N m, what effectiveness does not explain
        """
    @d_B.setter
    def d_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def effectiveness(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) delivered / commanded
        """
    @effectiveness.setter
    def effectiveness(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def effectiveness_bound(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) relative half-width; inf: never excited
        """
    @effectiveness_bound.setter
    def effectiveness_bound(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def event(self) -> int:
        """
        of the measurement: counts jumps that no motion explains
        """
    @property
    def field_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) T, magnetic field of the measurement
        """
    @field_B.setter
    def field_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def h_w(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m s
        """
    @h_w.setter
    def h_w(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def momentum_valid(self) -> bool:
        """
        False: h_w was not measured at this sample; the stack sets it
        """
    @property
    def omega_BN_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) rad/s
        """
    @omega_BN_B.setter
    def omega_BN_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def q_NB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"]:
        """
        (4,) scalar first
        """
    @q_NB.setter
    def q_NB(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def tick(self) -> int: ...

class Detection:
    """
    Detector to controller and allocator.
    """
    @staticmethod
    def none(vehicle: NominalVehicle) -> Detection:
        """
        Nothing detected; everything but the spares is enabled.
        """
    @property
    def bias(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m
        """
    @bias.setter
    def bias(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def changed(self) -> list:
        """
        actuators declared changed
        """
    @changed.setter
    def changed(self, arg1: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None: ...
    @property
    def classes(self) -> list:
        """
        of each of 16 actuators: healthy, gain, additive, stuck, intermittent or unclear
        """
    @classes.setter
    def classes(self, arg1: collections.abc.Sequence[str]) -> None: ...
    @property
    def enabled(self) -> list:
        """
        actuators that may be used
        """
    @enabled.setter
    def enabled(self, arg1: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None: ...
    @property
    def event(self) -> int:
        """
        counts declarations and recoveries
        """
    @event.setter
    def event(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def failed(self) -> list:
        """
        actuators declared useless
        """
    @failed.setter
    def failed(self, arg1: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None: ...
    @property
    def gain(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) delivered = gain u + bias as far as is known
        """
    @gain.setter
    def gain(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def u_probe(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m, dither; empty: none
        """
    @u_probe.setter
    def u_probe(self, arg1: numpy.typing.ArrayLike) -> None: ...

class Demand:
    """
    Controller to allocator.
    """
    def __init__(self, tau_B: numpy.typing.ArrayLike, u_pref: numpy.typing.ArrayLike | None = None) -> None: ...
    @property
    def tau_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) N m
        """
    @tau_B.setter
    def tau_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def u_pref(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m; empty: zero
        """
    @u_pref.setter
    def u_pref(self, arg1: numpy.typing.ArrayLike) -> None: ...

class Allocation:
    """
    Allocator to actuators, and to everyone as `last` at the next sample.
    """
    def __init__(self) -> None: ...
    @property
    def achieved_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) N m, D diag(effectiveness) u
        """
    @achieved_B.setter
    def achieved_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def demand_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) N m, what was asked
        """
    @demand_B.setter
    def demand_B(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def gap(self) -> float: ...
    @gap.setter
    def gap(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def iterations(self) -> int: ...
    @iterations.setter
    def iterations(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def saturated(self) -> list:
        """
        actuators at a limit, and not at rest
        """
    @saturated.setter
    def saturated(self, arg1: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None: ...
    @property
    def u(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) N m, issued command
        """
    @u.setter
    def u(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def worst_case(self) -> float:
        """
        N m
        """
    @worst_case.setter
    def worst_case(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class Compiled:
    """
    A scenario of plain tables, read and cross-checked once.
    """
    def __getstate__(self) -> dict: ...
    def __init__(self, scenario: dict) -> None: ...
    def __setstate__(self, arg0: dict) -> None: ...
    def channel_names(self, components: dict = {}) -> list:
        """
        Channels that a run of this scenario offers.
        """
    def check(self, components: dict = {}) -> list:
        """
        Builds everything without running; one row a component that has something to check.
        """
    def estimate_flow(self) -> dict:
        """
        By role, the estimates (d_B, effectiveness) that the observer makes and the others use; a Python component is left out.
        """
    def flight_model(self) -> dict:
        """
        The flight half of a scenario: nominal vehicle as flight has it, period, components with their C++ class and every parameter as `default`, size of the stack.
        """
    def free_frequencies(self) -> list[float]:
        """
        rad/s, ascending, of the modes of its appendages on the body that is free to turn.
        """
    def inner_rates(self) -> dict:
        """
        Rates of the truth's own motion at the start, 1/s, and what integrators allow for them.
        """
    def orbit_rate(self) -> float:
        """
        rad/s, of its orbit; 0 without one.
        """
    def resolve(self) -> dict:
        """
        The scenario with every default filled in.
        """
    def simulate(
        self,
        components: dict = {},
        channels: collections.abc.Sequence[str] | None = None,
        every: typing.SupportsInt | typing.SupportsIndex = 0,
        progress: typing.Any = None,
        memory: typing.SupportsFloat | typing.SupportsIndex = 1.7976931348623157e308,
        record: bool = True,
    ) -> dict:
        """
        Runs one closed loop. Releases the GIL; Python components take it back for their own step only.
        """

class Experiment:
    """
    A scenario flown many times with other numbers in it.
    """
    def __init__(
        self, scenario: dict, vary: collections.abc.Sequence[str], measures: dict, copies: typing.Any = None
    ) -> None: ...
    def fly(
        self,
        first: typing.SupportsInt | typing.SupportsIndex,
        values: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
        progress: typing.Any = None,
    ) -> dict:
        """
        Flies one row of `values` after the other, numbered from `first`. Releases the GIL.
        """
    def scenario(
        self,
        number: typing.SupportsInt | typing.SupportsIndex,
        values: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    ) -> dict:
        """
        The tables of the scenario that one flight is.
        """
    @property
    def columns(self) -> list[str]: ...
    @property
    def metrics(self) -> list[str]: ...

def allocate(
    D: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    row_weight: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    demand: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    effectiveness: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    lo: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    up: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    preferred: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    effort_weight: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    bound: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    priority: typing.Annotated[numpy.typing.ArrayLike, numpy.int32],
    mode: typing.SupportsInt | typing.SupportsIndex,
    worst_case: typing.SupportsInt | typing.SupportsIndex,
    residual_weight: typing.SupportsFloat | typing.SupportsIndex,
    margin: typing.SupportsFloat | typing.SupportsIndex,
    effectiveness_min: typing.SupportsFloat | typing.SupportsIndex,
    rank_tolerance: typing.SupportsFloat | typing.SupportsIndex,
    max_newton: typing.SupportsInt | typing.SupportsIndex,
    warm: bool,
) -> dict:
    """
    Solve a batch of allocation problems; use gyrostat.allocation.solve. Arrays have one row a problem; releases the GIL.
    """

def catalogue() -> dict:
    """
    Every family of the catalogue with its names.
    """

def check_params(family: str, name: str, params: dict, where: str) -> None:
    """
    Raises ValueError, one line, when a parameter is unknown, of the wrong type or out of range.
    """

def compiler() -> str:
    """
    Version of the compiler that made this module.
    """

def critical_effectiveness(
    lambda1: typing.SupportsFloat | typing.SupportsIndex, lambda2: typing.SupportsFloat | typing.SupportsIndex
) -> float:
    """
    Effectiveness above which feeding the estimate of a finite-time observer forward is stable.
    """

def dcm_from_quat(q: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Direction cosines C_BN (..., 3, 3) of quaternions q_NB (..., 4): v_B = C_BN v_N.
    """

def describe(family: str, name: str) -> dict:
    """
    Parameters of a component: name, kind, unit, range, default, meaning.
    """

def endings() -> list:
    """
    How a run can end: every status of a result.
    """

def energy(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> float:
    """
    integral of sum_i x_i^2 dt, x held from each sample to the next
    """

def euler_from_quat(q: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Roll, pitch, yaw (..., 3) in rad of quaternions (..., 4), scalar first; 3-2-1 sequence. Yaw is zero at pitch +-pi/2.
    """

def final(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> float:
    """
    largest |x_i| of the last sample
    """

def first_reach(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    level: typing.SupportsFloat | typing.SupportsIndex,
    after: typing.SupportsFloat | typing.SupportsIndex = 0.0,
) -> float:
    """
    first instant (s), not before `after`, with max_i |x_i| >= level
    """

def fraction_at_least(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    level: typing.SupportsFloat | typing.SupportsIndex,
    t0: typing.SupportsFloat | typing.SupportsIndex = ...,
    t1: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    share of the samples in [t0, t1] with max_i |x_i| >= level (1 - 1e-9): time at a limit, breaches
    """

def mrp_from_quat(q: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    MRP of quaternions (..., 4), scalar first -> (..., 3). The sign of q decides which of the two sets comes out; a full turn, infinite in its set, gives zero.
    """

def mrp_shadow(sigma: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    The other MRP (..., 3) of the same attitude; zero, whose other one is infinite, stays.
    """

def quat_from_euler(
    angles: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Quaternions (..., 4), scalar first, of roll, pitch, yaw (..., 3) in rad.
    """

def quat_from_mrp(
    sigma: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Quaternions (..., 4), scalar first, of MRP (..., 3).
    """

def quat_from_rotation_vector(
    phi: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Quaternions (..., 4) of rotation vectors (..., 3) in rad.
    """

def recovery(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    band: typing.SupportsFloat | typing.SupportsIndex,
    after: typing.SupportsFloat | typing.SupportsIndex,
    until: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    time (s) from a fault at `after`, whose sample is before it, to where max_i |x_i| < band until `until`
    """

def rotation_angle(q: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Rotation angles (...) in rad, 0 to pi, of quaternions (..., 4).
    """

def rotation_vector_from_quat(
    q: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Rotation vectors (..., 3) in rad, of length at most pi, of quaternions (..., 4).
    """

def served_axes(
    A: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    rank_tolerance: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Projector (3, 3) onto the axes of torque that allocators serve with A = D diag(effectiveness), (3, actuators).
    """

def settling_time(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    band: typing.SupportsFloat | typing.SupportsIndex,
    after: typing.SupportsFloat | typing.SupportsIndex = 0.0,
) -> float:
    """
    time (s) from `after` to the first instant from which max_i |x_i| < band to the end
    """

def total_variation(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    t0: typing.SupportsFloat | typing.SupportsIndex = ...,
    t1: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    sum over [t0, t1] of sum_i |change of x_i|, per second
    """

def window_highest(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    t0: typing.SupportsFloat | typing.SupportsIndex = ...,
    t1: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    largest value (signed) of any x_i in [t0, t1]
    """

def window_lowest(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    t0: typing.SupportsFloat | typing.SupportsIndex = ...,
    t1: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    smallest value (signed) of any x_i in [t0, t1]
    """

def window_max(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    t0: typing.SupportsFloat | typing.SupportsIndex = ...,
    t1: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    largest |x_i| of the samples in [t0, t1]
    """

def window_norm(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    t0: typing.SupportsFloat | typing.SupportsIndex = ...,
    t1: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    largest Euclidean norm of x in [t0, t1]
    """

def window_rms(
    t: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    t0: typing.SupportsFloat | typing.SupportsIndex = ...,
    t1: typing.SupportsFloat | typing.SupportsIndex = ...,
) -> float:
    """
    root of the mean over [t0, t1] of sum_i x_i^2
    """

def words(
    seed: typing.SupportsInt | typing.SupportsIndex,
    first: typing.SupportsInt | typing.SupportsIndex,
    last: typing.SupportsInt | typing.SupportsIndex,
    names: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
    counts: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
    domain: typing.SupportsInt | typing.SupportsIndex = 1,
    part: typing.SupportsInt | typing.SupportsIndex = 0,
) -> numpy.typing.NDArray[numpy.uint64]:
    """
    Random words of runs first to last - 1, shape (last - first, sum(counts)): of each stream, named by a hash, its count. Word j is Philox4x64-10 with key (seed, run) and counter (j div 4, name, part, domain), element j mod 4.
    """

__version__: str = "0.2.0"
default_rank_tolerance: float = 0.01
