"""Friction from the lateral motion of a wheelset

Three filters estimate the creep force of a wandering wheelset from its lateral velocity and yaw rate. This script
runs the small form of the study `railgrip study lateral` and reads its table of errors.
"""

import subprocess
import sys
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import pandas as pd

with TemporaryDirectory() as folder:
    command = [sys.executable, "-m", "railgrip", "study", "lateral", "--quick", "--out", folder]
    subprocess.run(command, check=True, capture_output=True)
    errors = pd.read_csv(f"{folder}/quick/errors.csv")

forces = errors[(errors["quantity"] == "creep_force") & (errors["plant"] == "paper")]
table = 1e-3 * forces.pivot_table(index="test", columns="filter", values="rmse", sort=False)
axes = table.plot.bar(logy=True, figsize=(7, 4), rot=20)
axes.set(xlabel="rail", ylabel="RMS error of the creep force [kN]")
axes.figure.set_layout_engine("constrained")
plt.show()
