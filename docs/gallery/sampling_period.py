"""Effect of the controller's period

How much distance a controller loses if it decides less often. The period of the controller is a multiple of the
communication period of 1 ms.
"""

import matplotlib.pyplot as plt

import railgrip as rg

scenario = rg.Scenario.load("trapezoid", {"start.speed": "30 km/h", "estimator.kind": "compiled"})
periods = [1, 5, 20, 50, 100]

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for law in ("slip_two_state", "adhesion_based"):
    axis = {"periods.controller": [f"{period} ms" for period in periods]}
    distances = rg.sweep(scenario, axis, controller=law).to_pandas()["distance"]
    axes.semilogx(periods, distances, "o-", label=law)
axes.set(xlabel="period of the controller [ms]", ylabel="braking distance [m]")
axes.set_xticks(periods, periods)
axes.minorticks_off()
axes.legend()
axes.grid(alpha=0.3)
plt.show()
