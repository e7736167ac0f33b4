"""Slip-based against adhesion-based control

Slip-based control (SBC) keeps slip between two thresholds; peak seeking, an adhesion-based law of railgrip, searches
for the slip with the greatest adhesion. The same stop with both, over distance.
"""

import matplotlib.pyplot as plt

import railgrip as rg

scenario = rg.Scenario.load("trapezoid", {"start.speed": "60 km/h"})

figure, (top, bottom) = plt.subplots(2, 1, sharex=True, layout="constrained", figsize=(7, 5))
for name, controller in {"SBC": "slip_two_state", "peak seeking": "adhesion_based"}.items():
    stop = rg.run(scenario, controller=controller)
    trace = stop.trace.where(stop.trace["speed"] > 1)
    top.plot(trace["distance"], 3.6 * trace["speed"], label=f"{name}: {stop.metrics.distance:.1f} m")
    bottom.plot(trace["distance"], 100 * trace["slip"][:, 0], lw=1)
top.set_ylabel("speed [km/h]")
top.legend()
bottom.set(xlabel="distance [m]", ylabel="slip of the leading group [%]", ylim=(0, 25))
plt.show()
