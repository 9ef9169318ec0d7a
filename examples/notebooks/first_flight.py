# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% [markdown]
# # First flight
#
# A spacecraft turns to rest, a wheel loses most of its torque, and the spacecraft keeps pointing. Two minutes, nothing to write.
#
# Every block of these pages runs in the tests, in this order. The same page as a notebook:
# [first_flight.py](first_flight.py).
#
# ## Take a scenario
#
# A *scenario* is all that happens in one flight: the vehicle, the flight software on board, what goes wrong, and for how long.
# Some come with the package.

# %%
import gyrostat as gs

scenario = gs.scenarios["wheel2_degraded"]
scenario

# %% [markdown]
# Four reaction wheels in a pyramid, a small disturbance, and wheel 2 (they count from 0) at 40 % from 20 s on. Nobody on board is told.
# The flight stack is an *observer*, which finds out what torque is missing, and a *controller* that makes up for it.
#
# ## Fly it

# %%
result = scenario.run()
print(f"{result['omega_BN_B'].shape[0]} samples, time first")
print(f"settled to 0.1 deg {result.metrics.settling_time:.1f} s after the fault")

# %% [markdown]
# `result` holds *channels*, arrays by name. A short name finds the truth first: `omega_BN_B` is `truth.omega_BN_B`. Everything is SI and
# radians, quaternions are scalar first; [conventions](../../docs/conventions.md) has the frames in the names.

# %%
result.plot("error.angle", "allocation.u", "estimate.d_B")

# %% [markdown]
# At 20 s the commands move to other wheels, and the estimated torque takes a step: that is the torque that wheel 2 no longer gives.
#
# ## Make it worse
#
# `replace` gives a copy with other values. A dotted key reaches inside, and a list is entered by position:
# `replace(**{"faults.0.remaining": 0.2})`. Here the whole fault is another one: the wheel pushes all the time, whatever it is told.

# %%
for torque in (0.02, 0.1, 0.15):
    stuck = gs.faults.Stuck(actuator=2, t_on=60.0, torque=torque)
    worse = scenario.replace(faults=[stuck]).run(channels=["error.angle"])
    print(
        f"wheel 2 stuck at {torque:.2f} N m: {worse.metrics.peak_error_after_fault * 57.3:.2g} deg at worst, "
        f"{worse.metrics.pointing_error * 57.3:.2g} deg at the end"
    )

# %% [markdown]
# And with a law that does not look for what is missing:

# %%
plain = scenario.replace(observer="passthrough", controller="mrp_feedback").run()
print(f"plain law: {plain.metrics.pointing_error * 57.3:.2g} deg at the end")
print(f"with the observer: {result.metrics.pointing_error * 57.3:.2g} deg")

# %% [markdown]
# The plain law keeps an offset: something must push against the disturbance, and only an error makes it push.
# [What an observer can see](../../docs/explanation/observers.md) and [laws of feedback alone](../../docs/explanation/feedback.md) say why.
#
# ## Look at it

# %%
page = result.to_html("flight")
print(page)

# %% [markdown]
# The page re-plays the flight in a browser, from the file: drag the body, press space. `result.show()` opens it. From a shell it is
#
# ```sh
# gyrostat run wheel2_degraded --out shell_flight
# gyrostat run wheel2_degraded --set faults.0.remaining=0.2
# ```
#
# ## Next
#
# - [Your own spacecraft](../../docs/tutorials/your_own_spacecraft.md): your inertia, your wheels, your sensors.
# - [A fault from scratch](../../docs/tutorials/a_fault_from_scratch.md): kinds of fault, and how to know whether a flight can be saved at all.
# - [Which stack do I take?](../../docs/recommended.md) if you want the answer and not the tour.
