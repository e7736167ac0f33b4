"""Wheels that are smaller or larger than the controller believes

Slip is computed with the nominal wheel radius. A smaller wheel seems to slip less, a larger one more. Control to a
small slip suffers first: with wheels that are too large it releases the brake nearly always, and some stops do not end
within the horizon.
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
