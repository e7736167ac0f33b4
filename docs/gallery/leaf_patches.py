"""Patches of leaves

Patches with low friction lie on a wet rail. Each wheelset meets them when it gets there: adhesion falls at the first
wheelset, and later at the last one.
"""

import matplotlib.pyplot as plt

import railgrip as rg

patches = [{"begin": begin, "length": 10, "mu0": 0.03, "edge": 1} for begin in (20, 60, 100)]
rail = {"kind": "constant", "polach": "wet", "mu0": 0.15, "patch": patches}
scenario = rg.Scenario.load("plain", {"start.speed": "60 km/h", "adhesion": rail})
trace = rg.run(scenario, controller="slip_three_state").trace
trace = trace.where(trace["speed"] > 1)

figure, (top, bottom) = plt.subplots(2, 1, sharex=True, layout="constrained", figsize=(7, 5))
top.plot(trace["distance"], trace["mu0"][:, [0, -1]], label=["first wheelset", "last wheelset"])
bottom.plot(trace["distance"], trace["adhesion"][:, [0, -1]])
top.set_ylabel("friction mu0 [1]")
top.legend()
bottom.set(xlabel="distance of the first wheelset [m]", ylabel="adhesion [1]", ylim=(0, None))
plt.show()
