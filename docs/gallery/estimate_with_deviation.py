"""Estimated adhesion with ±2σ

The extended Kalman filter estimates the adhesion of each group from noisy readings. The band is what the filter
claims: twice its standard deviation about the estimate.
"""

import matplotlib.pyplot as plt

import railgrip as rg

noise = {"speed": "0.05 m/s", "wheelset_speed": "0.1 rad/s", "acceleration": "0.03 m/s**2", "deflection": "0.2 mm"}
changes = {"start.speed": "50 km/h", "estimator.noise": "service", "sensors": {"kind": "white", "noise": noise}}
trace = rg.run(rg.Scenario.load("trapezoid", changes), controller="slip_two_state").trace
trace = trace.isel(time=slice(None, None, 20))

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
estimate, deviation = (trace[name][:, 0] for name in ("estimate_adhesion", "estimate_adhesion_sd"))
axes.fill_between(trace["time"], estimate - 2 * deviation, estimate + 2 * deviation, alpha=0.3, label="±2σ")
axes.plot(trace["time"], estimate, label="estimate")
axes.plot(trace["time"], trace["group_adhesion"][:, 0], "k", lw=1, label="true")
axes.set(xlabel="time [s]", ylabel="adhesion of the leading group [1]")
axes.legend()
plt.show()
