"""Creep curves

Full brake without wheel-slide protection drives the wheels from rolling to lock, and adhesion over slip draws the
creep curve of the rail. All curves have the same maximum friction `mu0` = 0.1.
"""

import matplotlib.pyplot as plt

import railgrip as rg

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for curve in ("dry", "wet", "low", "soap", "leaf"):
    rail = {"kind": "constant", "polach": curve, "mu0": 0.1}
    changes = {"adhesion": rail, "limits.horizon": "12 s", "start.speed": "100 km/h"}
    trace = rg.run(rg.Scenario.load("plain", changes), controller="full_brake").trace
    steps = (trace["slip"].values[:, 0] < 0.95).sum()
    axes.semilogx(100 * trace["slip"][:steps, 0], trace["group_adhesion"][:steps, 0], label=curve)
axes.set(xlabel="slip [%]", ylabel="adhesion [1]", xlim=(0.02, 100), ylim=(0, 0.1))
axes.legend(title="creep curve")
axes.grid(alpha=0.3)
plt.show()
