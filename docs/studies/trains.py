# %% [markdown]
# # Trains against published stops
#
# Do the built-in trains stop in the distances of the hand calculation and of publications?
#
# <!-- constants: docs/studies/dry_stop.toml -->
# Stops are emergency stops on a dry, level track with friction 0.5. The hand calculation has instantaneous forces by
# steps of time (EN 14531-1), pads at nominal temperature and no slip. Data of the trains, each number with its source
# or marked as an estimate, are in their files: `railgrip train show NAME`.

# %%
from pathlib import Path

import pandas as pd
from train_stops import dry_row, sander_rows

import railgrip as rg
from railgrip.rolling_stock.schema import NAMED, load_train

# %% tags=["parameters"]
quick = False

# %%
named = [{"train": name} for name in NAMED if not quick or name != "loco_coaches"]
stops = rg.evaluate(dry_row, named, "trains.csv")
stops["from"] = 3.6 * stops["speed"]
stops["difference"] = 100 * (stops["simulated"] / stops["by hand"] - 1)
metres = dict.fromkeys(("simulated", "by hand"), "{:.1f} m") | {"from": "{:.0f} km/h", "difference": "{:+.1f} %"}
rg.table(stops[["train", "from", "simulated", "by hand", "difference"]], metres)

# %% [markdown]
# <!-- constants: Schwarz, Lüdicke and Heckmann (2019) -->
# Published stops and limits; limits have a ≤. `vt642` is not among them: the paper on its field test states that it
# stops from 85 km/h in 22 s on unspecified gradients, and gives no distance.

# %%
published = pd.DataFrame(
    {
        "train": stop.train,
        "from": 3.6 * stop.speed,
        "published": f"{'≤ ' if reference.limit else ''}{reference.distance:g} m",
        "simulated": stop.simulated,
        "source": reference.source,
    }
    for stop in stops.itertuples()
    for reference in load_train(Path(stop.train)).reference[:1]
)
rg.table(published, metres, left=["train", "source"])

# %% [markdown]
# ## Forces in couplers
#
# The largest force in a coupler is compared with the quasi-static one of the hand calculation, with that of a chain of
# rigid cars on the springs and dampers of their couplers, and with the strength of the weakest coupler:

# %%
forces = ["in a coupler", "quasi-static", "chain", "strength"]
rg.table(stops[["train", *forces]].dropna(), dict.fromkeys(forces, "{:.1f} kN"))

# %% [markdown]
# Couplers of `loco_coaches` carry about twice the quasi-static force of the hand calculation. The difference is an
# oscillation of the chain of cars: while the front brakes and the rear does not yet, the couplers are compressed; when
# all cars brake, the coaches pull at the locomotive, which brakes less than its share. The slowest mode is weakly
# damped and is still oscillating at that time. The chain shows the same effect. Stiffness and damping of the screw
# coupler are estimates; it is tightened and has no slack.
#
# ## The brake pipe
#
# <!-- constants: UIC 540 -->
# Filling of the cylinders to 95 % of the highest pressure, and speed of the front from the first car to the last, in
# the stop above. UIC 540 requires 3 to 5 s in position P, and a front of at least 250 m/s, of one vehicle whose pipe is
# vented at once. [The brake pipe and long trains](brake_pipe.md) has other grids, branches, accelerators and equipment.

# %%
pipes = stops.reindex(columns=["train", "filling from", "filling to", "front", "last car begins"]).dropna()
seconds = dict.fromkeys(("filling from", "filling to", "last car begins"), "{:.2f} s")
rg.table(pipes, seconds | {"front": "{:.0f} m/s"})

# %% [markdown]
# ## A trial of sanders
#
# <!-- constants: docs/studies/train_stops.py -->
# The trial RSSB T1107 used two units of Class 387, 55 mph, a demand of 0.9 m/s², friction 0.02 without sand. One number
# is fitted to one distance, the density of sand on the rail that closes all but 1/e of the gap to the friction with
# plenty of sand.

# %%
trial = rg.evaluate(sander_rows, [{"fitted": "one fixed"}], "trains_sanders.csv")
trial["difference"] = 100 * (trial["simulated"] / trial["measured"] - 1)
trial[""] = ["fitted" if is_fitted else "" for is_fitted in trial["sanders"] == trial["fitted"]]
trial.loc[trial["sanders"] == "none", "difference"] = None  # the trial only states that it was longer
measured = [f"{'> ' if row.sanders == 'none' else ''}{row.measured:.0f} m" for row in trial.itertuples()]
columns = ["sanders", "measured", "simulated", "difference", ""]
forms = {"simulated": "{:.0f} m", "difference": "{:+.1f} %"}
rg.table(trial.assign(measured=measured)[columns], forms, left=["sanders", ""])

# %%
print(f"The fitted density of sand is {1e3 * trial['density'].iloc[0]:.1f} g/m.")

# %% [markdown]
# <!-- constants: docs/studies/train_stops.py harness/report/reference.py -->
# Assumptions without a measurement: friction of 0.2 with plenty of sand; each wheelset leaves 0.9 of the sand; the
# second sander is in front of axle 7; 2 kg/min fixed, up to 5 kg/min at 7.5 g/m variable; three-state slip control at
# 10 and 15 % with immediate pressures and ideal sensors.
#
# <!-- constants: Rail Engineer (2018) -->
# The table is not a blind prediction. The place of the second sander, the largest variable rate and the share of sand
# that a wheelset leaves were chosen among several sets with all five distances known, and two of the published
# distances are approximate ("≈ 650 m", "≈ 600 m"). The comparison shows that one law with one fitted number is
# consistent with all five distances.
