# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% [markdown]
# # A fault from scratch
#
# What can go wrong with an actuator, whether anybody on board notices, and whether the flight could be saved at all. The same page as a
# notebook: [a_fault_from_scratch.py](a_fault_from_scratch.py).
#
# ## Healthy first

# %%
import numpy as np

import gyrostat as gs

healthy = gs.Scenario(
    name="from scratch",
    vehicle=gs.vehicle.ftc_4rw(),
    initial=gs.Initial(mrp=(0.1, 0.2, -0.3)),
    **gs.recommended(),
    disturbances=[gs.disturbances.Constant(torque_B=(1e-3, -2e-3, 1.5e-3))],
    sensors=[gs.sensors.Gyro(noise=1e-5), gs.sensors.Attitude(noise=2e-5)],
    duration=160.0,
    dt=0.1,
    integrator="rk4",
    record=gs.Record(channels=["error.*", "truth.effectiveness", "estimate.*"]),
)
print(f"{healthy.run().metrics.pointing_error * 57.3:.2g} deg")

# %% [markdown]
# ## One fault
#
# A fault is data: which actuator, from when on, and its law. `list(gs.faults.__all__)` names the kinds; each has its signature and help.

# %%
fading = gs.faults.LossOfEffectiveness(
    actuator=1,
    t_on=60.0,
    remaining=gs.waveforms.Table(times=[0.0, 30.0, 50.0], values=[1.0, 1.0, 0.3]),  # fades over 20 s
)
result = healthy.replace(faults=[fading]).run()
late = result.t > 140.0
for name in ("truth.effectiveness", "estimate.effectiveness"):
    print(f"{name:24} {np.round(result[name][late].mean(axis=0), 2)}")

# %% [markdown]
# The observer of the recommended stack reads what each wheel really gives from its momentum, so that it knows which one is weak. Its
# bound says how sure it is:

# %%
result.plot("truth.effectiveness", "estimate.effectiveness", "estimate.effectiveness_bound", "error.angle")

# %% [markdown]
# ## Six kinds

# %%
kinds = {
    "half of it": gs.faults.LossOfEffectiveness(actuator=1, t_on=60.0, remaining=0.5),
    "a push of its own": gs.faults.Bias(actuator=1, t_on=60.0, torque=0.03),
    "stuck": gs.faults.Stuck(actuator=1, t_on=60.0, torque=0.02),
    "full blast": gs.faults.HardOver(actuator=1, t_on=60.0),
    "dead": gs.faults.Dead(actuator=1, t_on=60.0),
    "on and off": gs.faults.Intermittent(actuator=1, t_on=60.0, period=4.0, duty=0.5, remaining=0.0),
}
print(f"{'wheel 1 from 60 s on':22}{'worst (deg)':>12}{'end (deg)':>12}   declared")
for name, fault in kinds.items():
    flown = healthy.replace(faults=[fault]).run()
    said = [e.what for e in flown.events if e.what]
    m = flown.metrics
    print(
        f"{name:22}{m.peak_error_after_fault * 57.3:12.2g}{m.pointing_error * 57.3:12.2g}   {said[-1] if said else '-'}"
    )

# %% [markdown]
# Five of them are hardly felt. Full blast loses the flight: to hold against one wheel of this pyramid takes all that the three
# others have, and nothing is left to point with. The detector says what it can tell from the wheel's own momentum; a wheel that is
# hardly asked for anything hardly shows what it has left.
#
# [Faults](../../docs/faults.md) has the law of each, how several combine and where limits act.
#
# ## Could anybody save it?
#
# No law makes torque that is not there. What four wheels can give in the worst direction, before and after:

# %%
from gyrostat import allocation

D_B = healthy.vehicle.D_B
for name, left in (
    ("whole", (1, 1, 1, 1)),
    ("wheel 1 at half", (1, 0.5, 1, 1)),
    ("wheel 1 dead", (1, 0, 1, 1)),
    ("1 and 2 dead", (1, 0, 0, 1)),
):
    reach = allocation.attainable_set(D_B, 0.2, effectiveness=np.array(left, dtype=float))
    print(f"{name:16} {reach.in_every_direction:.3f} N m in every direction")

# %% [markdown]
# With two of four wheels dead, one direction is lost: the error about it is whatever the disturbance makes of it. `gyrostat survive`
# flies every actuator through every fault and holds each loss against what was possible:
#
# ```sh
# gyrostat survive wheel2_degraded --help
# ```
#
# ## Next
#
# [What an observer can see](../../docs/explanation/observers.md), and what it cannot. A kind of fault of your own is a header in C++:
# [extending](../../docs/extending.md#in-c-in-the-tree). Faults drawn at random: [a campaign](../../docs/tutorials/a_campaign.md).
