"""A driver's demand

A driver accelerates, coasts, brakes in steps, releases and then brakes fully. Wheel-slide protection can only lower
the pressure that the driver demands.
"""

import matplotlib.pyplot as plt

import railgrip as rg

trace = rg.run("service_steps").trace

figure, (top, bottom) = plt.subplots(2, 1, sharex=True, layout="constrained", figsize=(7, 5))
top.plot(trace["time"], 3.6 * trace["speed"], "k")
force = top.twinx()
force.plot(trace["time"], 1e-3 * trace["traction"], "C1")
bottom.plot(trace["time"], 1e-5 * trace["driver_demand"][:, 0], label="driver's demand")
bottom.plot(trace["time"], 1e-5 * trace["cylinder_pressure"][:, 0], "--", label="cylinder pressure")
top.set_ylabel("speed [km/h]")
force.set_ylabel("traction [kN]", color="C1")
bottom.set(xlabel="time [s]", ylabel="pressure of group 1 [bar]")
bottom.legend()
plt.show()
