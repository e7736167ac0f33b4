# %% [markdown]
# # What a fleet learns from many stops
#
# <!-- constants: docs/studies/fleet_stops.py -->
# After how many stops are the pads of each group known to 5 %, and at which cost in metres?
#
# Pads and wheel radii are estimated jointly from all stops of simulated trains. A stop gives a Gaussian estimate; the
# joint model has the mean of the lot, deviations of each train and group, scatter from stop to stop, and the offsets of
# pressure transducers. [Estimators of friction](../estimators.md#joint-estimation-over-stops) has its equations. Pads,
# loads, weather, wheel radii, offsets and the scale of the speed reading are drawn; all kinds of releases have the same
# trains. Errors are those of pad friction over the nominal one. "Without lot" is the standard deviation from readings
# alone, when the deviation of pads within their lot is not known; offsets of the transducers are included.

# %%
from fleet_stops import DESIGNS, FEW, design_row, needed_row, pad_rows, radius_rows

import railgrip as rg

# %% tags=["parameters"]
quick = False

# %%
kinds = [{"releases": name} for name in list(DESIGNS)[: 3 if quick else None]]
sizes = dict(zip(("trains", "stops"), FEW if quick else (20, 40), strict=True))
groups = [f"group {g}" for g in (1, 2, 3, 4)]


def table(frame, forms):
    return rg.table(frame.drop(columns=list(sizes)), {"longer stop": "{:.1f} m", **forms})


# Each function runs stops on workers itself, and keeps those of a train.
pads = rg.evaluate(pad_rows, [kind | sizes for kind in kinds], "fleet_pads.csv", workers=0)
pads["coverage of 95 %"] *= 100
numbers = ["RMSE", "claimed", *(f"{group} without lot" for group in groups)]
table(pads, dict.fromkeys(numbers, "{:.3f}") | {"coverage of 95 %": "{:.1f} %"})

# %% [markdown]
# Without releases, a stop determines only the sum of all groups, and the estimate of a single group is hardly better
# than the mean of the lot. The small pulses improve it, and reach the target by readings alone for the outer groups.
# For the inner ones they do not: their cylinders have the lower pressure, of which the offset of a transducer is a
# larger share, and offsets are the same in every stop, so that more stops hardly average them out.
#
# With releases, errors fall with every stop and the intervals hold, on trains on which no number of the model was
# chosen. This needs three things of the model. The filter of the monitor applies force and torque at the same instant:
# with the pressure in the middle of each of its periods and the adhesion at their start, a group is overestimated
# whenever its release meets the reapplication of another. The drag while coasting acts on the rotating masses, too. And
# the effect of a transducer's offset is that at nominal pad friction: with the estimated friction it follows the
# scatter of the stops, which offsets then seem to explain, and all pads of the fleet are underestimated.
#
# ## Wheel radii
#
# The radius of a wheel follows from speed and rotation while the train coasts. More stops average the scale of the
# speed reading, whose error all wheels of a train share:

# %%
radii = rg.evaluate(radius_rows, [sizes], "fleet_radii.csv", workers=0)
percent = ["RMSE", "claimed", "coverage of 95 %"]
radii[percent] *= 100
table(radii, dict.fromkeys(percent, "{:.3f} %") | {"coverage of 95 %": "{:.1f} %"})

# %% [markdown]
# ## Stops until pads are known
#
# Number of stops after which readings alone determine the pads of a group, and the extra distance of each of these
# stops:

# %%
needed = rg.evaluate(needed_row, [kind | sizes for kind in kinds], "fleet_needed.csv", workers=0)
never = f"more than {sizes['stops']}"
needed[groups] = needed[groups].map("{:.0f}".format).replace("nan", never)
rg.table(needed.drop(columns=list(sizes)), {"longer stop": "{:.1f} m"}, left=["releases"])

# %% [markdown]
# ## Releases designed for information
#
# The design chooses group, instant and depth of as many releases as are made by hand. It maximises the determinant of
# the Fisher information on the pads, with the Jacobians of the prediction along the stop, by a greedy choice and
# exchanges. The columns are the expected information of one stop, the expected deviation of the pads, and the geometric
# mean of the variances over that by hand:

# %%
designs = rg.evaluate(design_row, kinds, "fleet_designs.csv", workers=0)
forms = {"log det of the information": "{:.2f}", "variance over that by hand": "{:.3g}"}
rg.table(designs, forms | dict.fromkeys(groups, "{:.3f}"))
