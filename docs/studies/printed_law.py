# %% [markdown]
# # The law as printed: guards, limit and filter
#
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# Schwarz, Posielek and Goetjes (2021) print the law u = L sgn(ṡ α̇), state that it keeps a limit of adhesion of 0.15,
# and that its filter does not need the deflections of the primary suspension. What do its guards change, is the limit
# kept, and is the filter as good without deflections? [Adhesion-based control](adhesion_based.md) has their
# table and figures.
#
# ## Guards of the law

# %%
from itertools import product

import printed_stops as stops
from table1_stops import SCENARIOS

import railgrip as rg
from railgrip.report.reference import locked_text

# %% tags=["parameters"]
quick = False

# %%
variants = list(stops.GUARDS)[: 2 if quick else None]
equipment = ["ideal", "service"]
names, repeats = ("variant", "equipment", "scenario", "repeats"), [1 if quick else 3]
cases = [dict(zip(names, case, strict=True)) for case in product(variants, equipment, SCENARIOS, repeats)]
guards = rg.evaluate(stops.guard_row, cases, "printed_law_guards.csv")
guards["stop"] = guards["equipment"] + ": " + guards["scenario"].str.replace("_", " ")
first = guards[guards["variant"] == variants[0]].set_index("stop")["distance"]
changes = guards["distance"] - guards["stop"].map(first)
guards["text"] = [
    "no stop" if change != change else f"{change:+.1f} m".replace("-", "−") + locked_text(lock)
    for change, lock in zip(changes, guards["lock"], strict=True)
]
wide = guards.pivot(index="variant", columns="stop", values="text").loc[variants, list(first.index)]
wide.loc[variants[0]] = [stops.accepted(each, rail) for each in equipment for rail in SCENARIOS]
rg.table(wide.reset_index(names="ABC (paper)"), left=["ABC (paper)"])

# %% [markdown]
# <!-- constants: controllers/laws/adhesion_literal.py -->
# *ABC (paper)* (`controllers/laws/adhesion_literal.py`) is the law as printed. A brake cannot push with the pressure
# −L: +L is full pressure here, and −L is zero pressure. The law has three guards that the paper does not mention. A
# wheel that rolls, by its slip or its estimated adhesion, is braked fully; below 0.5 m/s the brake is applied; and
# while the product of the rates is zero, the last pressure is held (the sign of zero is zero, which would be half of
# the pressure). Its parameters were searched in the same way as those of the other laws; the last row has the
# parameters of peak seeking. The first row has the median and range of the repeats, and the longest lock in them if it
# lasts a second or more; the others have the change of the median of three stops with perturbed parameters, against the
# same three with all guards, and a lock. Changes within the range are not significant. The paper names α̇/ṡ as another
# switching function, with a similar proof and numerical problems for ṡ close to zero: it has the sign of ṡ α̇, and no
# value at zero. Its row has a dead zone there, in which the last pressure is held.
#
# ## The limit of adhesion
#
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# The paper claims strict adherence to a limit of adhesion of 0.15. These stops with laws that have this limit exceed
# it:

# %%
excesses = rg.evaluate(stops.excess_row, stops.limited(quick), "printed_law_limit.csv")
above = excesses[excesses["peak"] > stops.LIMIT].copy()
above.insert(5, "for brake and bearings", above["peak"] - above["inertia"])
names = ["law", "equipment", "scenario"]
above = above[[*names, *above.columns[3:]]].replace({name: {"_": " "} for name in names}, regex=True)
adhesions = ["greatest adhesion", "estimated then", "for brake and bearings", "for inertia"]
above.columns = ["law", "equipment", "rail", *adhesions, "train speed then", "above 0.15"]
forms = dict.fromkeys(adhesions, "{:.3f}") | {"train speed then": "{:.1f} m/s", "above 0.15": "{:.2f} s"}
rg.table(above, forms, left=["law", "equipment", "rail"])

# %% [markdown]
# - *Sliding wheels.* Adhesion exceeds the limit at low speed while a wheel slides, friction of the rail rises, and the
#   rail accelerates the wheel back to the speed of the train. The contact then carries the inertia of the wheelset in
#   addition to the brake. No brake pressure can prevent this: less of it accelerates the wheel more. With ABC (paper),
#   which releases the brake, nearly all of the greatest adhesion can be inertia. Only a wheel that does not slide keeps
#   the limit.
# - *Cap of the laws.* Peak seeking and slope-seeking control cap the brake torque at the limit, plus the torque that
#   slows down a wheel with the train. At the end of a stop, where a wheel may lock, they leave this addition out,
#   because the contact of a locked wheel carries all of the brake torque. So no excess in the table comes from the cap.
# - *Estimate and lag.* With exact sensors the estimate agrees with the true adhesion in the stops with peak seeking and
#   slope seeking. Without the lag of the cylinders peak seeking exceeds the limit, too. With service sensors the
#   estimate is too low while adhesion rises quickly.
#
# ## Equations 6 and 7: distances with and without deflections
#
# Deflections Δz of the primary suspension are readings (6) and states of the prediction (7). The paper says that only
# they need additional sensors, and that the estimator "would not necessarily need this information". The table tests
# this with ideal equipment. Without Δz the loads of the wheelsets are static. The second number of each cell is the rms
# error of the estimated adhesion:

# %%
laws = {"adhesion_based": "peak seeking (railgrip)", "slope_seeking": "slope-seeking control"}
axes = list(laws)[: 1 if quick else None], stops.FILTERS, SCENARIOS
cases = [dict(zip(("law", "filter", "scenario"), case, strict=True)) for case in product(*axes)]
filters = rg.evaluate(stops.filter_row, cases, "printed_law_filters.csv")
read = filters.groupby(["law", "scenario"])["distance"].transform("first")
changes = (filters["distance"] - read).map(" ({:+.1f} m)".format).str.replace("-", "−")
changes = changes.where(filters["filter"] != next(iter(stops.FILTERS)), "")
filters["text"] = filters["distance"].map("{:.1f} m".format) + changes + filters["error"].map(", {:.4f}".format)
filters["row"] = filters["law"].map(laws) + ": " + filters["filter"]
wide = filters.pivot(index="row", columns="scenario", values="text").loc[filters["row"].unique(), list(SCENARIOS)]
wide.columns = [rail.replace("_", " ") for rail in SCENARIOS]
rg.table(wide.reset_index(names="distance, rms error of adhesion"), left=["distance, rms error of adhesion"])

# %% [markdown]
# The sentence of the paper holds here: errors of the estimated adhesion grow severalfold, but no distance changes by a
# metre. Both laws use changes of adhesion, to which the error of a static load adds little.
