"""One stop: speed, slip and adhesion

A stop on a rail whose friction falls and rises repeatedly. The lines of slip and adhesion are the groups of wheelsets
that turn together, the leading one first.
"""

import matplotlib.pyplot as plt

import railgrip as rg

scenario = rg.Scenario.load("trapezoid", {"start.speed": "60 km/h"})
trace = rg.run(scenario, controller="adhesion_based").trace

figure, (top, middle, bottom) = plt.subplots(3, 1, sharex=True, layout="constrained", figsize=(7, 6))
speed = 3.6 * trace["speed"]
top.plot(trace["time"], speed, "k")
moving = trace.where(speed > 3)
middle.plot(trace["time"], 100 * moving["slip"])
bottom.plot(trace["time"], moving["group_adhesion"])
bottom.plot(trace["time"], trace["mu0"][:, 0], "k--", lw=1)
top.set_ylabel("speed [km/h]")
middle.set(ylabel="slip [%]", ylim=(0, 6))
bottom.set(ylabel="adhesion [1]", xlabel="time [s]")
bottom.legend([*(f"group {group}" for group in trace["group"].values), "mu0, wheelset 1"], ncols=5, fontsize="small")
plt.show()
