"""Braking curves of ETCS

Where an ETCS onboard unit warns the driver and brakes before a supervised location: the indication I, the permitted
speed P, the warning W, the interventions SBI2 and EBI, and the emergency brake curve EBD from which they follow. The
curves come from the stops of a train file and the dispersion of its brake, here from estimates.
"""

import matplotlib.pyplot as plt

import railgrip as rg

curves = rg.etcs("vt642")
limits = curves.to_pandas().query("target == 'SvL'").groupby("limit", sort=False)

figure, axes = plt.subplots(layout="constrained", figsize=(7, 4))
for name, rows in limits:
    axes.plot(rows["location_m"], rows["speed_km_h"], label=name)
axes.set(xlabel="location, supervised location at 0 [m]", ylabel="speed [km/h]")
axes.legend()
plt.show()
