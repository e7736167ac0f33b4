"""Thresholds of slip-based control

Two-state control releases a brake above one slip and applies it again below another. Braking distance over both
thresholds on two rails with different creep curves.
"""

import matplotlib.pyplot as plt

import railgrip as rg

highs, shares = [0.01, 0.02, 0.05, 0.1, 0.2], [0.3, 0.9]
figure, panels = plt.subplots(1, 2, sharey=True, layout="constrained", figsize=(8, 3.5))
for axes, curve in zip(panels, ("wet", "soap"), strict=True):
    scenario = rg.Scenario.load("plain", {"start.speed": "20 km/h", "adhesion.polach": curve, "estimator.kind": "none"})
    for share in shares:
        laws = [{"kind": "slip_two_state", "parameters": {"low": share * s, "high": s}} for s in highs]
        distances = [rg.run(scenario, controller=law).metrics.distance for law in laws]
        axes.semilogx([100 * high for high in highs], distances, "o-", label=f"{100 * share:.0f} % of it")
    axes.set(title=f"creep curve {curve}", xlabel="slip that releases [%]")
    axes.set_xticks([100 * high for high in highs], [f"{100 * high:g}" for high in highs])
    axes.minorticks_off()
panels[0].set_ylabel("braking distance [m]")
panels[1].legend(title="slip that applies")
plt.show()
