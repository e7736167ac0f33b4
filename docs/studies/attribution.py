# %% [markdown]
# # What limits slope seeking and the law of two maxima
#
# How much of the loss of slope seeking over the ideal bound is one of information, of actuation and of the law, and
# what would knowledge of the rail gain?
#
# Slope seeking with the numbers of [the type test](../type_test.md) was given the truth piece by piece: the true state
# in place of sensors and estimates, a pressure that follows the demand in place of valves, and both. Faults of sensors
# and valves are left out with them. The loss is the distance over that of the ideal bound, relative to the bound, in
# training cases of version 2 in which slip does not clean the rail and the mechanics are simple. Each loss is the mean
# of two differences, without and with the other piece. The rest is the loss of the law itself: the search for the
# maximum and the reaction to a rail that it does not know in advance. Cases in which a stop does not end are left out.

# %%
from given_truth import DECISIONS, LAWS, PIECES, gain_rows, loss_rows

import railgrip as rg
from railgrip.report.table import share

# %% tags=["parameters"]
quick = False

# %%
# Each function runs its stops on workers itself, and keeps the distance of each.
losses = rg.evaluate(loss_rows, [{"training": 1 if quick else 32}], "attribution.csv", workers=0)
print(f"{losses['stopped'][0]} of {losses['of'][0]} training cases of version 2:")
rg.table(losses.iloc[:, 3:], dict.fromkeys(losses.columns[4:], share))

# %% [markdown]
# Actuation and the law itself cause most of the loss, in about equal parts. Better estimates gain little, except in the
# case with a dead sensor of wheel speed.
#
# ## What knowledge of the rail would gain
#
# Each law was given one piece of the truth at a time:
#
# - *slip of the peak* of the creep curve in place of the search, as a perfect knowledge of the family of curves would
#   give it, before slip cleans the rail;
# - *adhesion ahead*: the ratio of the adhesion that a command will meet to the present one, as a perfect memory of the
#   place would give it;
# - the *true state* in place of sensors and estimates, *valves without dead time*, and a *pressure without valves*,
#   which follows the demand;
# - *deep slip, or not*: whether deep slip pays, from the start of the stop, or only from the time on at which the law
#   compares groups for the first time. Before that, the train has no evidence of cleaning.
#
# Values are mean changes of the distance. *Cleaned* are rails that slip cleans strongly, or by their creep curve.

# %%
gains = rg.evaluate(gain_rows, [{"training": 1 if quick else 16}], "attribution_gains.csv", workers=0)
gains["column"] = gains["law"] + ", " + gains["cases"].astype(str) + " " + gains["rails"] + " rails"
gains["change"] *= 100
columns = [name for law in LAWS for name in gains.loc[gains["law"] == law, "column"].unique()]
pieces = [*PIECES[1:], *(f"{piece}, or not" for piece in DECISIONS)]
print(f"{gains.drop_duplicates('rails')['cases'].sum()} training cases of version 2:")
mean = gains.pivot(index="given", columns="column", values="change").loc[pieces, columns]
rg.table(mean.reset_index(), dict.fromkeys(columns, "{:+.1f} %"))

# %% [markdown]
# - *Decision.* On cleaned rails the decision for deep slip is the largest loss of both laws. For the law of two maxima
#   more than half of it could be gained by a decision as soon as groups are compared; at that time the comparison is
#   still small. The rest needs a decision before the train has any evidence. The trial of the first group costs time
#   there, and distance where slip does not clean the rail.
# - *Curve.* The slip of the peak does not shorten the stop, because creep curves are flat near the peak. On cleaned
#   rails the law of two maxima becomes longer with it.
# - *Place.* The adhesion ahead gains little, although it was given to the first group, too. A memory of the place,
#   which only the groups behind have, gains at most that.
# - *Delay.* The law's valve logic already predicts over the dead time. A part of the loss remains that only faster
#   valves would avoid. Without valves at all, the pressure at the start of braking also builds up at once, and faults
#   of valves and the hysteresis of the rigging have no effect.
