# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% [markdown]
# # Your own spacecraft
#
# From an inertia, a mounting plan of wheels and two data sheets to a flight. The same page as a notebook:
# [your_own_spacecraft.py](your_own_spacecraft.py).
#
# ## The vehicle
#
# A vehicle is what the flight software knows: the inertia of the whole, the axis of each actuator in a column, and its limits. Here a
# 6U cubesat of 8 kg with four small wheels, three along the axes and a spare one askew.

# %%
import numpy as np

import gyrostat as gs

J_B = [[0.087, 0.001, 0.0], [0.001, 0.115, 0.002], [0.0, 0.002, 0.046]]  # kg m^2
askew = np.ones(3) / np.sqrt(3.0)
vehicle = gs.Vehicle(
    J_B=J_B,
    D_B=np.column_stack([np.eye(3), askew]),  # axes in columns, body frame
    u_max=2e-3,  # N m
    wheel_inertia=2.0e-5,  # kg m^2, about the spin axis
    momentum_max=1.5e-2,  # N m s
)

# %% [markdown]
# An inertia that no body can have is refused on the spot, with the reason:

# %%
try:
    gs.Scenario(vehicle=vehicle.model_copy(update={"J_B": (0.1, 0.1, 0.3)}), duration=1.0, dt=0.1)
except gs.InputError as error:
    print(error)

# %% [markdown]
# ## What the wheels can do
#
# Before any law: which torques can four wheels of 2 mN m make, whole, and with one of them gone?

# %%
from gyrostat import allocation

for lost in (None, 3, 0):
    left = np.array([0.0 if i == lost else 1.0 for i in range(4)])
    reach = allocation.attainable_set(vehicle.D_B, 2e-3, effectiveness=left)
    print(
        f"without {'any' if lost is None else f'wheel {lost}':8}: {reach.in_every_direction * 1e3:.2f} mN m in every direction"
    )

# %% [markdown]
# ## What really flies
#
# The real body differs from the nominal one, wheels have friction, sensors have noise. That is *truth*; the flight software never sees it.

# %%
scenario = gs.Scenario(
    name="cubesat",
    vehicle=vehicle,
    truth=gs.Truth(dJ_B=(0.004, -0.005, 0.002), viscous_friction=1e-7),
    initial=gs.Initial(mrp=(0.1, -0.15, 0.2), omega_BN_B=(0.01, -0.02, 0.015)),
    **gs.recommended(),  # observer, detector, controller, allocator
    sensors=[
        gs.sensors.Gyro(angle_random_walk=5e-5, rate_random_walk=1e-6),
        gs.sensors.Attitude(noise=5e-5),
        gs.sensors.Tachometer(noise=1e-7),
    ],
    disturbances=[gs.disturbances.Constant(torque_B=(2e-6, -1e-6, 3e-6))],
    duration=120.0,
    dt=0.1,
    integrator="rk4",
)

# %% [markdown]
# Parameters that are not written are defaults, and those scale with your vehicle and period: the same stack flies a 6U cubesat and a
# geostationary satellite. What they came to, under the dotted keys that `replace` takes:

# %%
print(f"{scenario['controller.k1']:.3g}, {scenario['controller.k2']:.3g}")

# %% [markdown]
# ## Before it flies

# %%
print(
    *(f"{row['where']:10} {row['name']:22} {'ok' if row['ok'] else row['code']}" for row in scenario.check()), sep="\n"
)

# %% [markdown]
# `gyrostat check` prints more, such as how strong the loop is against its faults.
#
# ## It flies

# %%
result = scenario.run()
m = result.metrics
print(f"settled to 0.1 deg after {m.settling_time:.0f} s; {m.pointing_error * 57.3:.2g} deg rms at the end")
print(f"fastest wheel: {np.abs(result.scenario.run(channels=['truth.h_w'])['h_w']).max() * 1e3:.1f} mN m s of 15")

# %% [markdown]
# ## Keep it
#
# A scenario is also a file, and the file says the same:

# %%
scenario.to_toml("cubesat.toml")
assert gs.Scenario.load("cubesat.toml") == scenario

# %% [markdown]
# ```sh
# gyrostat run cubesat.toml
# gyrostat describe vehicle
# ```
#
# ## Next
#
# [A fault from scratch](../../docs/tutorials/a_fault_from_scratch.md). All keys: [scenario](../../docs/scenario.md). Panels that bend: [flexible](../../docs/flexible.md).
