# %% [markdown]
# # A limit on releases in the type test
#
# What does `[controller] release_max` cost in stops without a fault that it is made for?
#
# The limit ends the release of a group that lasts too long, whatever the law demands:
# [Limit releases](../trains.md#limit-releases). Each case of a validation set of version 2 of the
# [type test](../type_test.md), which no law was tuned on, is stopped with and without it; the last column has the
# longest release of a group, at more than walking pace, without a limit.

# %%
from release_stops import stop_row

import railgrip as rg
from railgrip.studies.type_test.case_set import VERSIONS

# %% tags=["parameters"]
quick = False

# %%
laws, limits = ["slip_two_state", "slope_seeking", "two_maxima"], [3.0, 7.0]
design = VERSIONS[2].design(12, VERSIONS[2].validation)
names = [case.name for case in design][: 1 if quick else None]
cases = [{"case": case, "law": law, "limit": limit} for case in names for law in laws for limit in (0.0, *limits)]
stops = rg.evaluate(stop_row, cases, "release_limit.csv")
free = stops[stops["limit"] == 0.0].set_index(["case", "law"])
limited = stops[stops["limit"] > 0.0].join(free.add_suffix(" without"), on=["case", "law"])
both = limited[limited["standstill"] & limited["standstill without"]].copy()
both["change"] = both["distance"] - both["distance without"]
both["ratio"] = both["distance"] / both["distance without"]
both["acts"] = both["longest without"] > both["limit"]
both["changed"] = both["change"] != 0.0
columns = {"acts": "sum", "changed": "sum", "change": ["min", "max"], "longest without": "max"}
table = both.groupby(["law", "limit"], sort=False).agg({"ratio": "size"} | columns).reset_index()
changes = ["most shortened", "most lengthened"]
table.columns = ["law", "limit", "stops", "limit acts", "distance changes", *changes, "longest release"]
forms = {"limit": "{:.0f} s", "longest release": "{:.1f} s"} | dict.fromkeys(changes, "{:+.1f} m")
rg.table(table, forms, left=["law"])

# %%
seven, ended = both[both["limit"] == 7.0], limited[limited["standstill"] != limited["standstill without"]]
print(
    f"A limit of 7 s acts in {seven['acts'].sum()} of {len(seven)} stops; the largest change of a distance is "
    f"{seven['change'].abs().max():.1f} m. Limits decide {len(ended)} times whether a stop comes to a standstill."
)

# %% [markdown]
# Where the limit acts and the distance does not change, the valve of the group is held by a fault of the case, so that
# the demand has no effect. What the limit gains with a dead speed sensor depends on how long the sensor is dead; a test
# (`tests/stops/test_any_formation.py`) has such stops.
