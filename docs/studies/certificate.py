# %% [markdown]
# # Certificate of bounded slip
#
# In which states of a stop does a release of the brake keep the slip of a wheelset bounded?
#
# <!-- constants: docs/studies/bounded_slip.py, harness/trace/measures.py -->
# [Adhesion-based brake control](adhesion_based.md#when-slip-stays-bounded) has the theorem and its proof.
# Here it is evaluated in stops of the small set of [version 2 of the type test](../type_test.md#version-2), with the
# true rail of the next moments. Samples count for each group with a brake and more than 1 % slip, while the train is
# faster than 15 km/h. *Inside* is the share of them in which the certificate bounds the slip after a release of the
# brake. *Exceeded* counts those inside, with venting valves, whose slip later exceeded the bound. *Slope visible* is
# the share in which slip changes adhesion by more than changes of friction, speed and load do within the `dwell` of
# `adhesion_based`, *slope significant* that in which it does so by more than these and the deviation that the filter
# claims; both are those of stops under `adhesion_based`.

# %%
from itertools import product

import pandas as pd
from bounded_slip import FAMILIES, row

import railgrip as rg
from railgrip.report.table import share
from railgrip.studies.type_test.case_set import VERSIONS

# %% tags=["parameters"]
quick = False

# %%
LAWS = ("adhesion_based", "slope_seeking")
design = VERSIONS[2].draw(VERSIONS[2].small, VERSIONS[2].test)
names = [case.name for case in (design[:1] if quick else design)]
stops = rg.evaluate(row, [{"case": name, "law": law} for name, law in product(names, LAWS)], "certificate.csv")

# %%
print(
    f"Of {stops['released'].sum()} samples with a bound in which the brake was released, {stops['exceeded'].sum()} had "
    "more slip."
)

# %%
by_axis = [stops.assign(family=axis + ": " + stops[axis].astype(str)).sort_values(axis) for axis in FAMILIES]
samples = pd.concat([stops.assign(family="all cases"), *by_axis])
families = samples.groupby("family", sort=False)
sums = samples.groupby(["law", "family"], sort=False)[list(stops.columns[stops.columns.get_loc("sliding") :])].sum()
shares = sums.div(sums["sliding"].clip(lower=1), axis=0)
shown = families["case"].nunique().to_frame("cases")
for law in LAWS:
    of_law = sums.loc[law]
    shown[f"inside, {law}"] = shares.loc[law, "inside"]
    shown[f"exceeded, {law}"] = of_law["exceeded"].astype(str) + " of " + of_law["released"].astype(str)
    if law == LAWS[0]:
        shown[["slope visible", "slope significant"]] = shares.loc[law, ["slope visible", "slope significant"]]
percent = [name for name in shown if name.startswith(("inside", "slope"))]
rg.table(shown.reset_index(), dict.fromkeys(percent, share), left=["family"])
