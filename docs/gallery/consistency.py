"""NEES over time

The normalised estimation error squared compares the error of an estimate with the variance that the filter claims.
For a consistent filter its mean is 1 for each state; high values mean that the filter is too sure. NIS does the same
with readings in place of true values. The lines are means over 0.5 s.
"""

import matplotlib.pyplot as plt

import railgrip as rg

noise = {"speed": "0.05 m/s", "wheelset_speed": "0.1 rad/s", "acceleration": "0.03 m/s**2", "deflection": "0.2 mm"}
changes = {"start.speed": "50 km/h", "estimator.noise": "service", "sensors": {"kind": "white", "noise": noise}}
trace = rg.run(rg.Scenario.load("trapezoid", changes), controller="slip_two_state").trace

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
error = trace["estimate_adhesion"] - trace["group_adhesion"]
nees = ((error / trace["estimate_adhesion_sd"]) ** 2).mean("group")
nis = trace["estimate_nis"] / trace["estimate_readings"]
axes.semilogy(trace["time"], nees.rolling(time=500, center=True).mean(), label="NEES of adhesion")
axes.semilogy(trace["time"], nis.rolling(time=500, center=True).mean(), label="NIS over its expectation")
axes.axhline(1, color="k", ls="--", lw=1, label="consistent filter")
axes.set(xlabel="time [s]", ylabel="normalised squared error [1]")
figure.legend(loc="outside upper center", ncols=3, fontsize="small")
axes.grid(alpha=0.3)
plt.show()
