"""The ideal bound

The controller `ideal_bound` knows the creep curve at every instant and uses its peak. Utilisation is the impulse of
the contact forces over that of this bound.
"""

import matplotlib.pyplot as plt

import railgrip as rg

scenario = rg.Scenario.load("trapezoid", {"start.speed": "30 km/h"})
laws = ["full_brake", "slip_two_state", "slip_three_state", "slope_seeking", "adhesion_based", "ideal_bound"]
stops = [rg.run(scenario, controller=law) for law in laws]

figure, (left, right) = plt.subplots(1, 2, sharey=True, layout="constrained", figsize=(8, 3.5))
left.barh(laws, [stop.metrics.distance for stop in stops])
right.barh(laws, [100 * stop.metrics.utilisation for stop in stops], color="C1")
left.set_xlabel("braking distance [m]")
right.set(xlabel="utilisation [%]", xlim=(0, 105))
plt.show()
