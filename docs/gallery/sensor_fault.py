"""A wheel speed sensor that fails

From 3 s to 6 s the sensor of the first group reads zero. Slip-based control takes the group for locked and releases
its brake.
"""

import matplotlib.pyplot as plt

import railgrip as rg

fault = {"part": "speed_sensor", "kind": "zero", "group": 1, "begin": "3 s", "end": "6 s"}
scenario = rg.Scenario.load("plain", {"start.speed": "50 km/h", "adhesion.mu0": 0.12, "faults": [fault]})
trace = rg.run(scenario, controller="slip_three_state").trace

figure, (top, bottom) = plt.subplots(2, 1, sharex=True, layout="constrained", figsize=(7, 5))
radius = float(trace["speed"][0] / trace["wheelset_speed"][0, 0])
top.plot(trace["time"], 3.6 * trace["speed"], "k", label="train")
top.plot(trace["time"], 3.6 * radius * trace["wheelset_speed"][:, 0], label="group 1, true")
top.plot(trace["time"], 3.6 * radius * trace["reading_wheelset_speed"][:, 0], "--", label="group 1, read")
bottom.plot(trace["time"], 1e-5 * trace["cylinder_pressure"][:, 0])
top.set_ylabel("speed at the rim [km/h]")
top.legend()
bottom.set(xlabel="time [s]", ylabel="pressure of group 1 [bar]")
plt.show()
