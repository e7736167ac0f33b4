# %% [markdown]
# # Condition monitoring of a wandering wheelset
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# Mal, Hussain, Chowdhry and Memon, 3C Tecnología, special issue April 2020, 279: an extended Kalman filter estimates
# lateral velocity, yaw rate, creep and creep force of a wheelset from an accelerometer and a gyroscope, on four
# surfaces. This page repeats the five tests with three filters, at 25 m/s, over ten seeds: runs of 10 s at 50 µs.
#
# ## Reconstruction
#
# <!-- constants: Mal et al. (2020) -->
# The text of the paper that was available contains its words, tables and captions, but not the bodies of equations (1)
# to (36), and no curves. The wheelset and the filter called *reconstruction* are therefore our derivation from the
# words of the paper, its tables, and the literature that it cites: Polach (2005) for the creep force, Hussain and Mei
# (2009) for the equations of motion. Given in the paper are the five states, the two measured quantities, forward
# Euler, Q and R, the parameters of the wheelset, and friction, A and B of each surface. Not given are the speed, the
# spectrum of the track, the geometry of the contact, and the covariance at the start. The text has one coefficient of
# contact shear stiffness; we take it as Kalker's c11 in both directions. Figure 3 of the paper, the block diagram of
# the filter, was not available and is not redrawn: the filter is the usual predictor-corrector of its equations (25) to
# (34). The paper simulates the wheelset in Simulink with steps of 50 µs; our plant is an FMU, integrated by a stiff
# solver with control of its error, and our filter is C code with the paper's step. Where the reconstruction fails, the
# filter of the authors need not fail.
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# The paper gives no errors in numbers: it states that the filter "perfectly estimates" all conditions, with a spike of
# the error of the creep force at 2 s. All curves on this page are from railgrip.
#
# | filter | states | knows |
# |---|---|---|
# | reconstruction | the five that the paper names, forward Euler, Q and R as printed | track, condition |
# | well posed, track known | motion and friction | track |
# | well posed, track unknown | motion, friction and track | spectrum of the track |
#
# All three are given the speed.
#
# ## Published quantities next to ours
#
# *chosen*: our number was chosen after the published one, so that their difference is not a result.

# %%
import lateral_runs as runs
import numpy as np
import published

import railgrip as rg
from railgrip.estimation.lateral.run_measures import adhesion
from railgrip.estimation.lateral.wheelset import (
    ALL_PLANTS,
    CONDITIONS,
    PLANTS,
    ROLLING,
    SMOOTH_PLANTS,
    STIFFNESS_PLANTS,
    TESTS,
)
from railgrip.report import style
from railgrip.report.table import share

# %% tags=["parameters"]
quick = False

# %%
size = {"seeds": 2, "duration": 2.5} if quick else {"seeds": 10, "duration": 10.0}
tests = [test.name for test in TESTS]


def found(function, cases, name):
    """Return the rows of a function in each case, with the titles of plants."""
    # Each function runs the seeds on workers itself, and shares their results with the others.
    frame = rg.evaluate(function, [case | size for case in cases], f"lateral_{name}.csv", workers=0)
    titles = {name: plant.title for name, plant in ALL_PLANTS.items()}
    return frame.drop(columns=list(size)).replace({"plant": titles})


def digits(value):
    return f"{value:.2g}".replace("inf", "∞")


def with_intervals(frame, *names):
    for name in names:
        ends = zip(frame[name], frame.pop(f"{name} low"), frame.pop(f"{name} high"), strict=True)
        frame[name] = [f"{digits(middle)} [{digits(low)}, {digits(high)}]" for middle, low, high in ends]
    return frame


def picture(name, description):
    """Show the typical run of a test, which is drawn unless its file exists."""
    seeds = typical.set_index("test")["seed"]
    run = name, int(seeds[name if name in seeds else runs.TRANSITION]), size["duration"]
    print(style.picture(f"lateral_{name}.png", description, lambda: runs.typical_figure(*run)))


# %%
typical = found(runs.typical_row, [{"test": test} for test in tests], "typical")
last = {"seed": int(typical["seed"].iloc[-1]), "duration": size["duration"]}
run = rg.evaluate(runs.compared_row, [last], "lateral_compared.csv", workers=0)
rails, creeps = ", ".join(rail.name for rail in CONDITIONS), np.geomspace(1e-5, 0.1, 400)
peaks = [f"{adhesion(rail, creeps, runs.SPEED).max():.3f}" for rail in CONDITIONS]
frictions = ", ".join(f"{rail.mu0:g}" for rail in CONDITIONS)
instants, track, at = ", ".join(f"{at:g}" for at, _ in TESTS[-1].changes[1:]), run["track"][0], run["instant"][0]
compared = f"""
Table 3 | friction u0 at zero creep velocity: {rails} | 0.46, 0.3, 0.2, 0.1 | {frictions} | *chosen*
Fig. 2 | largest adhesion at {runs.SPEED:g} m/s: {rails} | not given | {", ".join(peaks)}
Fig. 4 to 23 | largest deviation of the track | 7.0 mm | {1e3 * track:.1f} mm | *chosen*
Fig. 20 to 23 | changes of the surface | 2, 4, 6 and 8 s | {instants} s | *chosen*
Fig. 23 | largest error of the creep force, reconstruction | at 2.0 s | at {at:.1f} s | {at - 2:+.1f} s
"""
published.compare(compared.strip().splitlines())

# %% [markdown]
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# - **Adhesion.** Table 3 gives the friction coefficient at zero creep velocity, which is an input here as well.
#   Friction falls as the creep velocity grows, so that the largest adhesion is lower. It depends on the speed, which
#   the paper does not state: 25 m/s here. The paper gives the largest adhesion in Figure 2 only, which was not
#   available.
# - **Track.** The paper specifies "random, ±7 mm" without a spectrum. Ours is white noise through a low-pass of second
#   order at 2 Hz, scaled to 7 mm.
# - **Creep force.** The row is the typical run of the transition, see below.
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# The paper reports that the error of the creep force has a spike at 2 s, when dry becomes wet. The largest errors just
# before and just after this change, medians over ten seeds with intervals that contain the true median with at least 95
# %:

# %%
spikes = with_intervals(
    found(runs.spike_rows, [{"test": runs.TRANSITION}], "spikes").drop(columns="test"), "before", "after"
)
spikes.columns = ["filter", "largest error in 0.1 s before [N]", "largest error in 0.1 s after [N]"]
rg.table(spikes, left=["filter"])

# %%
picture("spike", "Creep force and its error around the first change of the surface, typical run")

# %% [markdown]
# No filter has a spike at this instant that differs from the scatter over the seeds: the intervals before and after the
# change overlap. The reconstruction often has a large error of the creep force already on dry rail. In the typical run
# it leaves the true force shortly after the change, where the creep passes zero, and does not return to it; its
# friction does not follow the change at all. In the well-posed filters the change is visible in the friction, not in
# the creep force, because the lateral acceleration and yaw rate determine the force.
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# RMSE at 25 m/s over that of the best constant, which is the mean of the truth; medians over ten seeds. Below 1 the
# filter is better than that mean:

# %%
skill = found(runs.skill_rows, [{"test": test} for test in tests], "skill")
ratio = skill.pivot_table(index=["test", "quantity"], columns="filter", values="ratio", sort=False).reset_index()
rg.table(ratio, dict.fromkeys(skill["filter"], digits), left=["test", "quantity"])

# %% [markdown]
# ## Figure 2: creep curves
#

# %%
runs.creep_curves(runs.SPEED)

# %% [markdown]
# Diamonds are the friction coefficients at zero creep velocity of Table 3. The curves are the creep force by Polach's
# formula over the wheel load.
#
# ## The typical runs
#
# The figures of each test show one of the ten runs: the one whose RMSE of the creep force by the reconstruction is the
# median, of an even number the lower of the two in the middle. The code chooses it:

# %%
columns = {"error": "RMSE of the creep force, reconstruction [N]"}
rg.table(typical.rename(columns=columns), {columns["error"]: digits}, left=["test"])

# %% [markdown]
# ## Figures 4 to 7: dry
#

# %%
picture("dry", "Lateral velocity, yaw rate, creep and creep force, and their errors, on dry rail")

# %% [markdown]
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# Each row has the number of the paper's figure, which shows the estimate (here left) and the error over time on a
# linear axis (here in the middle). On the right, the rms error on a logarithmic axis shows all filters at once. Errors
# larger than 1.5 times the largest true value are cut off in the middle. The last row is the friction coefficient, a
# state of the paper's filter without a figure. The title has the seed. 25 m/s.
#
# ## Figures 8 to 11: wet
#

# %%
picture("wet", "The same on wet rail")

# %% [markdown]
# ## Figures 12 to 15: poor
#

# %%
picture("poor", "The same on poor rail")

# %% [markdown]
# ## Figures 16 to 19: worst
#

# %%
picture("worst", "The same on the worst rail")

# %% [markdown]
# ## Figures 20 to 23: transition
#

# %%
picture("transition", "The same while the surface changes")

# %% [markdown]
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# The surface changes from dry to wet, poor, worst and back to wet, every 2 s.
#
# ## Why our reconstruction loses creep and force
#
# On dry rail, and in the transition, which begins on dry rail, the reconstruction keeps lateral velocity and yaw rate
# and loses creep and force. On wet, poor and worst rail it loses all four in most runs, although it knows the
# condition. Whether the filter of the authors does the same cannot be known without its equations. In the
# reconstruction, the readings do not change if creep and force both change sign, and the derivative of the creep is
# singular at zero, so that each passage of the creep through zero may change the sign.
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# Information is not missing. The equations linearised along the true transition, between two passages through zero
# (windows of 0.02 s): share of windows in which all five states are determined, and the Cramér-Rao bound in per cent of
# the rms of the run, median and 90 % quantile:

# %%
observed = found(runs.observed_rows, [{}], "observed")
for name in ("creep", "friction", "force"):
    pairs = zip(observed.pop(name), observed.pop(f"{name} 90"), strict=True)
    observed[f"σ({name})"] = [f"{middle:.2g} % ({high:.2g} %)" for middle, high in pairs]
rg.table(observed.rename(columns={"determined": "all five determined"}), {"all five determined": "{:.0f} %"})

# %% [markdown]
# In the reconstruction, friction and force change only through their derivatives. A change of the surface changes both
# at once, by far more than the printed process noise allows. The filter then keeps a wrong force with a small
# covariance and gives no weight to its readings:

# %%
refused = found(runs.refused_rows, [{}], "refused")
refused["ratio"] = refused["jump"] / refused["allowed"]
columns = {"jump": "largest change with the surface", "allowed": "1σ of its process noise in 0.5 s",
           "ratio": "ratio", "determined": "determined by 0.5 s of readings"}  # fmt: skip
forms = dict(zip(columns.values(), ("{:.3g}", "{:.1e}", "{:.1e}", "±{:.1e}"), strict=True))
rg.table(refused[["state", *columns]].rename(columns=columns), forms)

# %% [markdown]
# ## Friction, and an inexact model
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# RMS error of μ0 in the transition at 25 m/s, from 0.5 s after each change on, medians over ten seeds:

# %%
plants = [{"plant": plant} for plant in (list(PLANTS)[:1] if quick else PLANTS)]
friction = found(runs.friction_rows, plants, "friction")
rg.table(friction, dict.fromkeys(friction.columns[2:], digits), left=["plant", "filter"])

# %% [markdown]
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# The transition at 25 m/s in full, changes included. Lost: innovations ten times as large as the filter claims, or a
# filter that diverged. Medians with intervals that contain the true median with at least 95 %:

# %%
innovations = found(runs.innovation_rows, plants, "innovations")
innovations["lost"] = [f"{lost} of {size['seeds']}" for lost in innovations["lost"]]
innovations = with_intervals(innovations, "NIS", "friction RMSE", "of the best constant")
names = {"lost": "lost, of runs", "first": "first [s]"}
rg.table(innovations.rename(columns=names), {"first [s]": digits}, left=["plant", "filter"])

# %% [markdown]
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# Below saturation, slope and friction both appear only in a small curvature of the creep curve. If the contact is 5 %
# softer than the filters assume, they therefore take a dry rail for a poor one, and the innovations hardly show it (NIS
# near 1).
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# Other deviations of the plant from the filters are not harmless either. The filter with known track diverges in most
# runs with a wheelset mass or yaw inertia 5 % larger, and in all runs with a conicity or axle load 10 % larger. The
# filter with unknown track diverges in none of them, but its friction is worse than the best constant with the larger
# mass and the larger load. With the larger yaw inertia and conicity its friction is as accurate as with the exact
# plant; presumably its estimate of the track absorbs the deviation. The reconstruction is lost in all runs with the
# larger conicity.
#
# ## Friction and creep stiffness together
#
# Two further predictions have the logarithm of the creep stiffness as a state, a factor on k_A and k_S of Polach's
# formula. At the start it is as uncertain as the largest error of the table, and it is nearly constant: the noise of
# its random walk was chosen from four values by the coverage in the first of the ten seeds. The tables of this section
# judge the transition some time after each change, as the table of friction above does. RMSE of μ0 is the median over
# ten seeds with its interval, that of the stiffness the median, and shares are means:


# %%
plants = [{"plant": plant} for plant in list(STIFFNESS_PLANTS)[: 1 if quick else None]]
stiffness = with_intervals(found(runs.stiffness_rows, plants, "stiffness"), "RMSE of μ0")
forms = dict.fromkeys(("coverage", "friction known", "its coverage"), share)
rg.table(stiffness, forms | {"RMSE of stiffness": lambda value: f"{100 * value:.2g} %"}, left=["plant", "filter"])

# %% [markdown]
# Without the state the smallest of these errors already makes friction wrong by as much as the difference between
# neighbouring conditions, and the claimed interval seldom contains it. With the state the error of friction hardly
# depends on the error of the stiffness: it is that of the exact model with known track, and somewhat larger with
# unknown track. The filter with unknown track claims too narrow intervals with or without the state, most of all of the
# stiffness, whose error is nevertheless small.
#
# Friction and stiffness are separated by the curvature of the creep curve. Where creepages are small, only the slope is
# visited, and the readings determine the stiffness alone. The filter then reports a wide interval. Friction is *known*
# while the deviation of its logarithm is so small that its claimed interval separates neighbouring conditions. The
# following runs have smaller irregularities, whose size the filters know, and a softer contact than the filters assume.
# *Force used* is a high quantile of the creep force over friction times load:

# %%
rails = [(test, plant) for test in ("dry", "worst") for plant in SMOOTH_PLANTS][: 1 if quick else None]
known = found(runs.known_rows, [{"rail": test, "plant": plant} for test, plant in rails], "known")
shares = ("force used", "friction known", "coverage while known", "while not")
forms = dict.fromkeys(shares, share) | {"σ(log μ0)": digits, "correlation": "{:.2f}"}
rg.table(known.rename(columns={"plant": "sensors and track"}), forms, left=["rail", "sensors and track", "filter"])

# %% [markdown]
# The rows show what decides. The larger the used part of the creep curve and the better the sensors, the longer
# friction is known; with service sensors and small irregularities it never is, and the interval is nearly that of the
# start. With known track the interval contains friction as often as it claims or nearly so, known or not. With unknown
# track it does not in some rows: on the worst rail with the sensors of the paper, and where the estimates of track,
# stiffness and friction all remain uncertain. An extended Kalman filter linearises at an estimate that may be far from
# the truth there. Correlation alone does not show that friction is unknown: it is small as well where the readings
# leave friction at its start.
#
# ## Traction and braking
#
# <!-- constants: Mal et al. (2020); harness/estimation/lateral/wheelset.py -->
# The paper leaves traction and braking to further research, and its simplified creepages exclude the rotation of the
# wheels, as do all three filters. Here the axle rotates and twists, and the torque of the motor over wheel radius and
# axle load is 0.05 in traction, and 0.05 and 0.08 in braking. Errors in the transition at 25 m/s relative to the rms of
# the true quantity, medians over ten seeds; below 1 the filter is better than an estimate of zero:

# %%
rolling = [{"plant": plant} for plant in ROLLING[: 1 if quick else None]]
longitudinal = found(runs.longitudinal_rows, rolling, "longitudinal")
longitudinal["lost"] = [f"{lost} of {size['seeds']}" for lost in longitudinal["lost"]]
forms = dict.fromkeys(longitudinal.columns[3:7], digits) | {"rms creep": "{:.2g} %"}
rg.table(longitudinal.rename(columns={"lost": "lost, of runs"}), forms, left=["plant", "filter"])

# %% [markdown]
# The filter with unknown track is the only one that works without torque on this axle. With torque it keeps the lateral
# velocity, but creep and creep force have large errors, because it has no longitudinal creep; the lower lateral
# stiffness of the contact appears as another friction, whose error in braking exceeds the friction itself. Its
# innovations reveal this in a few runs only. The other two filters are already lost on this axle without torque, so
# that their rows do not allow a statement about traction and braking. Estimation in traction and braking would require
# the rotation of the wheels in the filter.
