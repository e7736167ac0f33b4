# %% [markdown]
# # Shortest stops on known rails
#
# How short can a stop be, where the slip of leading wheelsets cleans the rail for those behind?
#
# <!-- constants: docs/studies/maxima_stops.py -->
# The shortest possible distance is between that of the ideal bound, which no stop is below, and that of held slips,
# which a controller that knows the true state can reach; [Models of the rail](../rail_models.md#what-the-bounds-are)
# has the proof. The two-part train stops from the speed of the scenario `plain`, with exact sensors, cylinders that
# follow the demand, and no limit of adhesion by the operator. *Slips held* are those of the groups, lead to trail; at
# 100 % wheels are locked. The dry rails have `mu0 = 0.05`, and the second the recovery of a clean rail; the others are
# those of [Two maxima of adhesion over slip](two_maxima.md). [Wheel flats](../wheel_flats.md) and the heat of the tread
# are not a cost.

# %%
from maxima_stops import KNOWN, SLIPS, in_service, shortest_row

import railgrip as rg
from railgrip.base.registry import ANALYSES
from railgrip.studies.type_test.entrants import entrants

# %% tags=["parameters"]
quick = False

# %%
cases = [{"rail": "dry", "held": 2}] if quick else [{"rail": rail, "held": len(SLIPS)} for rail in KNOWN]
shortest = rg.evaluate(shortest_row, cases, "optimum.csv").drop(columns="held")
rg.table(shortest, dict.fromkeys(shortest.columns[1:], "{:.1f} m"), left=["rail"])

# %% [markdown]
# ## Laws in service on the rail that slip cleans
#
# The dry rail that slip cleans, with the valves, sensors and numbers of the laws of version 2 of the type test.

# %%
laws = [name for name, law in entrants(2).items() if law.role in ("entrant", "baseline")]
laws = [name for name in laws if name not in (*ANALYSES, "full_brake")][: 2 if quick else None]
service = rg.evaluate(in_service, [{"law": law} for law in laws], "optimum_in_service.csv").sort_values("distance")
service["over the shortest"] = service["distance"] / service["distance"].iloc[0]

# %%
distance = service.set_index("law")["distance"]
if "two_maxima" in distance:
    other = distance.drop("two_maxima").idxmin()
    own, share = distance["two_maxima"], distance["two_maxima"] / distance[other]
    print(f"two_maxima stops in {own:.1f} m, {share:.3f} of the shortest of the other laws, {other}.")

# %%
rg.table(service, {"distance": "{:.1f} m", "over the shortest": "{:.3f}"})
