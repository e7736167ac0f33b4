"""Dispersion of brakes: K_dry

Pad friction and load of a train are not exactly known. K_dry_rst of ETCS is the share of the nominal deceleration
that a train achieves on dry rail with a given probability, here found by simulation of 30 draws. `railgrip study
k_factors` does it for probabilities down to 1e-9, with failures.
"""

import matplotlib.pyplot as plt
import numpy as np

import railgrip as rg

rail = {"start.speed": "40 km/h", "adhesion.polach": "dry", "adhesion.mu0": 0.5, "estimator.kind": "none"}
scenario = rg.Scenario.load("plain", rail)
random = np.random.default_rng(1)
lots, units, loads = random.normal(1, 0.045, 30), random.normal(1, 0.05 / 2, (30, 4)), random.normal(1, 0.02, 30)

nominal = rg.run(scenario, controller="full_brake").metrics.mean_deceleration
shares = []
for lot, unit, load in zip(lots, units, loads, strict=True):
    truth = scenario.changed({"truth": {"pad_friction": lot * unit, "load": load}})
    shares.append(rg.run(truth, controller="full_brake").metrics.mean_deceleration / nominal)

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
axes.step(np.sort(shares), np.arange(1, 31) / 30, where="post")
axes.axvline(np.quantile(shares, 0.1), color="C1", label="K_dry for a probability of 90 %, EBCL 1")
axes.set(xlabel="deceleration over the nominal one [1]", ylabel="share of the draws [1]", ylim=(0, 1))
axes.legend()
plt.show()
