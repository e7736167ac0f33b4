"""The brake pipe of ten coaches

An emergency brake of a locomotive with ten coaches: the pressure falls along the brake pipe, and the distributor of
each vehicle fills its brake cylinders.
"""

import matplotlib.pyplot as plt
import numpy as np

import railgrip as rg

changes = {"start.speed": "100 km/h", "adhesion.polach": "dry", "adhesion.mu0": 0.5, "limits.horizon": "7 s"}
scenario = rg.Scenario.load("plain", changes).with_plant({"train": "loco_coaches"})
trace = rg.run(scenario, controller="full_brake", estimator="none").trace

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
groups = np.linspace(0, trace.sizes["group"] - 1, 11).astype(int)
for group, colour in zip(groups, plt.cm.viridis(np.linspace(0, 0.9, groups.size)), strict=True):
    axes.plot(trace["time"], 1e-5 * trace["cylinder_pressure"][:, group], color=colour, label=f"group {group + 1}")
axes.set(xlabel="time since the demand [s]", ylabel="cylinder pressure [bar]")
axes.legend(fontsize="small", ncols=2)
plt.show()
