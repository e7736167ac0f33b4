"""A controller of your own

A class with the methods `start` and `decide` is a controller: here, proportional control to a set slip. A sweep shows
which set slip suits which rail.
"""

import matplotlib.pyplot as plt
import numpy as np

import railgrip as rg


class Proportional:
    def __init__(self, target):
        self.target = target

    def start(self, formation):
        self.full = formation.pressure_max

    def decide(self, observation):
        return self.full * np.clip(1.5 - 0.5 * observation.slip / self.target, 0, 1)


targets = [0.01, 0.02, 0.05, 0.1, 0.2]
for curve in ("dry", "wet", "soap"):
    axes = {"start.speed": ["20 km/h"], "adhesion.polach": [curve], "controller.parameters.target": targets}
    plt.semilogx(targets, rg.sweep("plain", axes, Proportional).to_pandas()["distance"], "o-", label=curve)
plt.legend(title="creep curve")
plt.gca().set(xlabel="set slip [1]", ylabel="braking distance [m]")
plt.show()
