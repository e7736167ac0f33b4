"""Gradients

Braking distance over the gradient of the track, positive uphill, on a dry and on a poor rail. On the poor rail the
adhesion that is left for braking is small, and a gradient takes a larger share of it.
"""

import matplotlib.pyplot as plt

import railgrip as rg

gradients = [-0.03, -0.015, 0.0, 0.015, 0.03]

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for curve, mu0 in {"dry": 0.5, "wet": 0.07}.items():
    changes = {"start.speed": "30 km/h", "estimator.kind": "none", "adhesion.polach": curve, "adhesion.mu0": mu0}
    sweep = rg.sweep(rg.Scenario.load("plain", changes), {"truth.gradient": gradients}, controller="slip_three_state")
    distance = sweep.to_pandas()["distance"].to_numpy()
    axes.plot([1000 * gradient for gradient in gradients], distance / distance[2], "o-", label=f"{curve}, mu0 {mu0}")
axes.set(xlabel="gradient [‰]", ylabel="distance over that on level track [1]")
axes.legend()
axes.grid(alpha=0.3)
plt.show()
