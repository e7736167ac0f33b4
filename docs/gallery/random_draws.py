"""A distribution over random rails

Twenty draws of a rail with random friction: the empirical distribution of the braking distance for two controllers.
Each draw is the same rail for both.
"""

import matplotlib.pyplot as plt
import numpy as np

import railgrip as rg

scenario = rg.Scenario.load("random", {"start.speed": "25 km/h", "estimator.kind": "compiled"})

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for law in ("slip_two_state", "adhesion_based"):
    distances = rg.sweep(scenario, {"seed": range(20)}, controller=law).to_pandas()["distance"]
    axes.step(np.sort(distances), np.arange(1, 21) / 20, where="post", label=law)
axes.set(xlabel="braking distance [m]", ylabel="share of the draws [1]", ylim=(0, 1))
axes.legend()
axes.grid(alpha=0.3)
plt.show()
