"""Slip that cleans the rail

On a rail that slip cleans, large slip shortens the stop; on a rail that does not react it lengthens it. Two-state
slip control at five levels of slip on both rails.
"""

import matplotlib.pyplot as plt

import railgrip as rg

rail = {"kind": "constant", "polach": "low", "mu0": 0.06}
recovery = {"mu0": 0.3, "A": 0.4, "B": "0.6 s/m", "rate": "1.9e-4 m/J"}
levels = [0.02, 0.05, 0.10, 0.20, 0.30]

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for name, adhesion in {"without cleaning": rail, "with cleaning": rail | {"recovery": recovery}}.items():
    scenario = rg.Scenario.load("plain", {"start.speed": "30 km/h", "estimator.kind": "none", "adhesion": adhesion})
    laws = [{"kind": "slip_two_state", "parameters": {"low": 0.7 * s, "high": s}} for s in levels]
    distances = [rg.run(scenario, controller=law).metrics.distance for law in laws]
    axes.plot([100 * level for level in levels], distances, "o-", label=name)
axes.set(xlabel="slip at which the brake is released [%]", ylabel="braking distance [m]", ylim=(0, None))
axes.legend()
axes.grid(alpha=0.3)
plt.show()
