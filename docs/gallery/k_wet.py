"""K_wet of controllers

K_wet_rst of ETCS is the share of the dry-rail deceleration that remains on a wet rail. Here it is the ratio of mean
decelerations of the same train and controller on a dry and on a poor rail.
"""

import matplotlib.pyplot as plt

import railgrip as rg

scenario = rg.Scenario.load("plain", {"start.speed": "30 km/h", "estimator.kind": "none"})
laws = ["full_brake", "slip_two_state", "slip_three_state", "constant_slip", "wheel_reference"]
frictions = {"wet, mu0 0.10": ("wet", 0.10), "low, mu0 0.06": ("low", 0.06)}
dry = rg.run(scenario.changed({"adhesion.polach": "dry", "adhesion.mu0": 0.5}), controller="full_brake").metrics

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for place, (name, (curve, mu0)) in enumerate(frictions.items()):
    wet = scenario.changed({"adhesion.polach": curve, "adhesion.mu0": mu0})
    shares = [rg.run(wet, controller=law).metrics.mean_deceleration / dry.mean_deceleration for law in laws]
    axes.barh([number + 0.4 * place for number in range(len(laws))], shares, height=0.38, label=name)
axes.set_yticks([number + 0.2 for number in range(len(laws))], laws)
axes.set_xlabel("K_wet [1]")
figure.legend(title="rail", loc="outside right upper")
plt.show()
