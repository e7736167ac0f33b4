"""Wheels that are smaller than the controller believes

Wheels wear, and slip is computed with their nominal radius. A smaller wheel looks as if it slipped less, or turned
faster than the train. Control to a small slip suffers first.
"""

import matplotlib.pyplot as plt

import railgrip as rg

factors = [0.97, 0.985, 1.0, 1.015, 1.03]
scenario = rg.Scenario.load("plain", {"start.speed": "30 km/h", "adhesion.polach": "wet", "estimator.kind": "none"})
levels = {"slip held at 1 to 2 %": (0.01, 0.02), "slip held at 10 to 15 %": (0.10, 0.15)}

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for name, (low, high) in levels.items():
    law = {"kind": "slip_two_state", "parameters": {"low": low, "high": high}}
    distances = rg.sweep(scenario, {"truth.wheel_radius": factors}, controller=law).to_pandas()["distance"]
    axes.plot([100 * (factor - 1) for factor in factors], distances, "o-", label=name)
axes.set(xlabel="error of the wheel radius [%]", ylabel="braking distance [m]")
axes.legend()
axes.grid(alpha=0.3)
plt.show()
