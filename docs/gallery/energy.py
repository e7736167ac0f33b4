"""Where the energy goes

The kinetic energy of the train becomes heat in the brake pads, heat in the contacts of wheel and rail, and work of
the running resistance. With locked wheels the contacts take most of it.
"""

import matplotlib.pyplot as plt

import railgrip as rg

scenario = rg.Scenario.load("plain", {"start.speed": "50 km/h", "estimator.kind": "none"})
parts = {
    "pad_heat": "pads",
    "contact_heat": "wheel and rail",
    "resistance_work": "resistance",
    "kinetic_energy": "kinetic",
}

figure, panels = plt.subplots(1, 2, sharey=True, layout="constrained", figsize=(8, 4))
for axes, law in zip(panels, ("full_brake", "slip_three_state"), strict=True):
    trace = rg.run(scenario, controller=law).trace
    axes.stackplot(trace["distance"], [1e-6 * trace[name] for name in parts], labels=parts.values())
    axes.set(title=law, xlabel="distance [m]")
panels[0].set_ylabel("energy [MJ]")
panels[1].legend(loc="lower right")
plt.show()
