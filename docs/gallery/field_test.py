"""Friction from a field test

A train is driven and braked over a slippery place, as in the field test of Schwarz, Lüdicke and Heckmann. The
recording has GNSS, speeds and accelerations; the filter estimates the adhesion of each group from it.
"""

from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt

import railgrip as rg

stop = rg.run("field")
with TemporaryDirectory() as folder:
    stop.write(folder)
    estimates = rg.estimate(f"{folder}/trace.nc", "field")

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for group in (1, 4):
    mean, deviation = (estimates[name].sel(state=f"group_adhesion[{group}]") for name in ("mean", "sd"))
    axes.plot(estimates["time"], mean, label=f"group {group}, estimated")
    axes.fill_between(estimates["time"], mean - 2 * deviation, mean + 2 * deviation, alpha=0.3)
    axes.plot(stop.trace["time"], stop.trace["group_adhesion"].sel(group=group), "k--", lw=1)
axes.plot([], [], "k--", lw=1, label="true")
axes.set(xlabel="time [s]", ylabel="adhesion [1]", xlim=(estimates["time"][0], estimates["time"][-1]))
axes.legend()
plt.show()
