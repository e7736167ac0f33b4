# %% [markdown]
# # Errors and claims of the filters of a train
#
# Are the filters of the train as sure of adhesion as they are right, if the load is another one, or a part fails?
#
# <!-- constants: harness/trace/measures.py -->
# Stops of the two-part train on trapezoid, sine sweep and random rail have valves and service sensors under three-state
# slip control without estimates, so that all filters see the same stop. The load is the mass over the one that the
# filter assumes. `disturbed` takes the load as known, `disturbed, load ±10 %` includes its uncertainty in the claimed
# variance, `loaded` estimates it as a state. NEES is the squared error of adhesion above 10 km/h over its variance;
# quantiles are over the stops, and 1 is consistent. Two noises of `loaded` were chosen on six of the stops without a
# fault.

# %%
from itertools import product

from filter_errors import FILTERS, errors_of

import railgrip as rg
from railgrip.studies.type_test.design import FAULTS

# %% tags=["parameters"]
quick = False

# %%
RAILS = ("trapezoid", "sine_sweep", "random")


def cases(rails, loads, faults, seeds):
    names = ("scenario", "load", "fault", "seed", "filter")
    return [dict(zip(names, case, strict=True)) for case in product(rails, loads, faults, seeds, FILTERS)]


every = [
    *cases(RAILS[:1] if quick else RAILS, (0.8, 0.9, 1.0, 1.05, 1.12), ["none"], [1] if quick else [1, 2, 3]),
    *cases(RAILS[:1] if quick else RAILS, (0.8, 1.0, 1.05), list(FAULTS)[: 1 if quick else None], [1]),
]
# A case is in both parts.
stops = rg.evaluate(errors_of, {tuple(case.values()): case for case in every}.values(), "filter_consistency.csv")

# %% [markdown]
# ## By load


# %%
def root_mean_square(errors):
    return (errors**2).mean() ** 0.5


without_fault = stops[stops["fault"] == "none"].assign(load=100 * stops["load"])
groups, quantiles = without_fault.groupby(["load", "filter"], sort=False), [0.1, 0.5, 0.9]
by_load = groups.agg(stops=("nees", "size"), rmse=("rmse", root_mean_square), bias=("bias", "mean"))
by_load = by_load.join(groups["nees"].quantile(quantiles).unstack()).reset_index()
titles = ["load", "filter", "stops", "α RMSE", "α bias", "NEES 10 %", "NEES 50 %", "NEES 90 %"]
forms = ["{:.0f} %", "", "{}", "{:.4f}", "{:.4f}", "{:.2g}", "{:.2g}", "{:.2g}"]
rg.table(by_load.set_axis(titles, axis=1), dict(zip(titles, forms, strict=True)))

# %%
for name, of_filter in without_fault.groupby("filter", sort=False):
    nees, rmse = of_filter["nees"].median(), root_mean_square(of_filter["rmse"])
    print(f"- {name}: over all loads the median of the NEES is {nees:.2g}, the RMSE {rmse:.4f}.")

# %% [markdown]
# ## By fault
#
# With the faults of the type test, at its three loads, 10 % quantile, median and 90 % quantile of the NEES:

# %%
faults = stops[(stops["seed"] == 1) & stops["load"].isin((0.8, 1.0, 1.05))]
nees = faults.groupby(["fault", "filter"], sort=False)["nees"].quantile(quantiles)
by_fault = nees.map("{:.2g}".format).groupby(level=[0, 1], sort=False).agg(" / ".join).unstack(sort=False)
by_fault.insert(0, "stops", faults.groupby("fault").size() // len(FILTERS))
rg.table(by_fault.reset_index(), left=["fault"])

# %% [markdown]
# These filters do not notice a wheel speed that reads zero: their adhesion of that group is wrong and its variance
# small.
