# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% [markdown]
# # A campaign
#
# One flight shows that something can work. How often it does is asked of many. The same page as a notebook:
# [a_campaign.py](a_campaign.py).
#
# ## What varies
#
# A campaign is a scenario and distributions for some of its numbers. Here a wheel of the reference vehicle fails in one of three ways,
# the body is not quite the nominal one, and the flight begins somewhere within 60 deg.

# %%
import gyrostat as gs
from gyrostat.campaign import dist

plain = {"observer": "passthrough", "detector": "none", "controller": "mrp_feedback", "allocator": "pseudo_inverse"}
campaign = gs.Campaign(
    "wheel2_degraded",
    set={
        **gs.recommended(),
        "duration": 120.0,
        "dt": 0.1,
        "integrator": "rk4",
        "faults": [],
        "sensors": [gs.sensors.Gyro(noise=1e-4), gs.sensors.Attitude(noise=2e-4)],
    },
    seed=3,
    vary={
        "initial.q_NB": dist.attitude(angle=dist.uniform(0.1, 1.0)),
        "truth.dJ_B": dist.inertia(0.1),
    },
    faults=[
        {
            "name": "wheel",
            "actuator": dist.choice([0, 1, 2, 3]),
            "t_on": dist.uniform(10.0, 60.0),
            "kind": [
                {"weight": 0.5, "type": "loss_of_effectiveness", "remaining": dist.beta(2.0, 3.0)},
                {"weight": 0.3, "type": "dead"},
                {"weight": 0.2, "type": "stuck", "torque": dist.uniform(-0.15, 0.15)},
            ],
        }
    ],
    grids=[{"name": "stack", "of": {"recommended": {}, "plain": plain}}],
    measure={"final": {"metric": "window_max", "signal": "error.angle", "last": 10.0}},
    success={"final": {"below": 1.7e-3, "scale": "log"}},  # 0.1 deg
)

# %% [markdown]
# The factor `stack` flies both stacks on the same draws and the same noise, so that they can be compared flight by flight.
#
# ## A few first

# %%
flights = campaign.fly(0, 60)
rows = flights.table.to_pandas()
for cell, of_cell in rows.groupby("cell"):
    print(f"{cell}: {of_cell.success.sum()} of {len(of_cell)} keep pointing")

# %% [markdown]
# ## The worst one
#
# Every run can be drawn, flown and looked at alone.

# %%
mine = rows[rows.cell == "recommended"]
worst = int(mine.loc[mine.final.idxmax()].run)
scenario = campaign.scenario(worst, mine.cell.iloc[0])
result = scenario.run()
print(f"run {worst}: {scenario.faults[0].type}, {mine.final.max() * 57.3:.2g} deg in its last 10 s")

# %% [markdown]
# ## Many, on all cores
#
# Into a folder, which can be taken up again after a kill and gives the same bits on one core or many:

# %%
flown = campaign.run(60, out="flown")
for cell, counts in flown.counts.items():
    print(f"{cell}: {counts.failures} of {counts.runs} lost")

# %% [markdown]
# ```sh
# gyrostat campaign show flown
# gyrostat report flown
# ```
#
# 60 flights prove little: with none lost, up to 5 % may still be. `gyrostat verify` says how many a requirement needs and stops
# when it is decided, whenever one looks ([verification](../../docs/verification.md)).
#
# ## Next
#
# All keys of the file: [campaigns](../../docs/campaigns.md). Rare failures without a million flights, the smallest fault that loses a flight, gains
# tuned on common flights: [verification](../../docs/verification.md).
