"""Effect of the initial adhesion

Braking distance over the friction of the rail, for three controllers. The dashed line is the shortest distance that
friction alone would allow, v²/(2 mu0 g). A stop that does not end within the horizon of the scenario has no point.
"""

import matplotlib.pyplot as plt
import numpy as np

import railgrip as rg

speed, friction = 30 / 3.6, [0.03, 0.045, 0.06, 0.08, 0.11, 0.15]
scenario = rg.Scenario.load("plain", {"start.speed": speed, "adhesion.polach": "wet", "estimator.kind": "none"})
laws = ["full_brake", "slip_two_state", "constant_slip"]

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for law in laws:
    table = rg.sweep(scenario, {"adhesion.mu0": friction}, controller=law).to_pandas()
    axes.loglog(friction, table["distance"], "o-", label=law)
axes.loglog(friction, speed**2 / (2 * 9.81 * np.array(friction)), "k--", label="v²/(2 mu0 g)")
axes.set(xlabel="friction mu0 [1]", ylabel="braking distance [m]")
axes.set_xticks(friction, friction)
axes.set_yticks([30, 50, 80, 120], [30, 50, 80, 120])
axes.minorticks_off()
axes.legend()
axes.grid(alpha=0.3)
plt.show()
