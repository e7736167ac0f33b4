"""An estimate from a recording

A filter runs over the readings of a recorded stop, here a stop that railgrip has written to a folder. The estimated
pad friction is compared with the true one, which only a simulation knows.
"""

from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt

import railgrip as rg

stop = rg.run(rg.Scenario.load("trapezoid", {"start.speed": "50 km/h"}), controller="adhesion_based")
with TemporaryDirectory() as folder:
    stop.write(folder)
    estimates = rg.estimate(f"{folder}/trace.nc", "stop")

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for group in (1, 2):
    mean, deviation = (estimates[name].sel(state=f"pad_friction[{group}]") for name in ("mean", "sd"))
    axes.plot(estimates["time"], mean, label=f"group {group}, estimated")
    axes.fill_between(estimates["time"], mean - 2 * deviation, mean + 2 * deviation, alpha=0.3)
    axes.plot(stop.trace["time"], stop.trace["pad_friction"].sel(group=group), "k--", lw=1)
axes.plot([], [], "k--", lw=1, label="true")
axes.set(xlabel="time [s]", ylabel="pad friction [1]")
axes.legend()
plt.show()
