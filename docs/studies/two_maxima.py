# %% [markdown]
# # Two maxima of adhesion over slip
#
# Which slip stops a train earlier, where slip cleans and heats the contact?
#
# [Models of the rail](../rail_models.md) explains the creep curves `wet_two_maxima` and `leaves_two_maxima`. The
# two-part train stops from the speed of the scenario `plain` with exact sensors and cylinders that follow the demand,
# under a two-state law below the first maximum, one at the second, and without protection. Each row switches causes of
# the creep curve on: heat is `temperature_loss`, cleaning is `recovery`. The energy error is the largest deviation of
# kinetic energy, heat and work from the energy at the start, relative to it, in the three stops.

# %%
from itertools import product

import matplotlib.pyplot as plt
import pandas as pd
from maxima_stops import CAUSES, LAWS, PECLETS, RAILS, curve_rows, interpolated_rise, mean_rise, stop_row

import railgrip as rg

# %% tags=["parameters"]
quick = False

# %%
causes = ["film alone", "cleaning and heat"] if quick else CAUSES
cases = [{"rail": rail, "causes": each, "law": law} for rail, each, law in product(RAILS, causes, LAWS)]
stops = rg.evaluate(stop_row, cases, "two_maxima.csv")

# %%
rows = ["rail", "causes"]
by_cause = stops.pivot(index=rows, columns="law", values="distance")[list(LAWS)]
by_cause["maxima in the slide of wheelset 1"] = stops[stops["law"] == "full brake"].set_index(rows)["maxima"]
by_cause["energy error"] = stops.groupby(rows)["energy"].max()
forms = dict.fromkeys(LAWS, "{:.1f} m") | {"energy error": "{:.0e}"}
in_order = by_cause.reindex(pd.MultiIndex.from_frame(stops[rows].drop_duplicates())).reset_index()
rg.table(in_order.rename(columns={"causes": "switched on"}), forms, left=["rail", "switched on"])

# %% [markdown]
# With cleaning alone, full brake with locked wheels stops as early as the best law or earlier; with heat, a law that
# holds the second maximum stops earlier.

# %%
curves = rg.evaluate(curve_rows, [{"rail": rail} for rail in RAILS], "two_maxima_curves.csv")
figure, panel = plt.subplots(figsize=(8, 3.8), label="Adhesion over slip under a full brake, and at steady slip")
for (rail, kind), curve in curves.groupby(["rail", "kind"]):
    style = {"color": "C0" if rail == "wet" else "black", "linestyle": "-" if kind == "steady" else "--"}
    panel.plot(100 * curve["slip"], curve["adhesion"], label=f"{rail}, {kind}", **style)
panel.set(xlabel="slip [%]", ylabel="adhesion", xlim=(0, 100), ylim=(0, None))
panel.legend(frameon=False)
figure

# %% [markdown]
# ## Flash temperature
#
# Mean temperature rise under a moving circle of uniform heat, times k/(q a), over the Péclet number V a/(2 κ), by the
# formula of the contact and by quadrature of moving point sources:

# %%
rises = pd.DataFrame({"Péclet number": PECLETS})
rises["formula"] = rises["Péclet number"].map(interpolated_rise)
rises["quadrature"] = rises["Péclet number"].map(mean_rise)
rises["deviation"] = 100 * (rises["formula"] / rises["quadrature"] - 1)
forms = {"Péclet number": "{:g}", "formula": "{:.4f}", "quadrature": "{:.4f}", "deviation": "{:+.1f} %"}
rg.table(rises, forms, left=["Péclet number"])
