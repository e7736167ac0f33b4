"""Friction from the lateral motion of a wheelset

Three filters estimate the creep force of a wandering wheelset from its lateral velocity and yaw rate, here for two and
a half seconds on each rail. The study of the lateral wheelset has ten seeds of ten seconds.
"""

import matplotlib.pyplot as plt
import pandas as pd

from railgrip.estimation.lateral.judge import measure
from railgrip.estimation.lateral.run import LateralCase, simulate
from railgrip.estimation.lateral.wheelset import TESTS

errors = {}
for test in TESTS:
    run = simulate(LateralCase(test=test.shorten(2.5), speed=25.0, plant="paper", seed=1))
    found = measure(run, observe=False)["errors"]
    errors[test.name] = {
        name: 1e-3 * (of_filter["creep_force"]["rmse"] or float("nan")) for name, of_filter in found.items()
    }

axes = pd.DataFrame(errors).T.plot.bar(logy=True, figsize=(7, 4), rot=20)
axes.set(xlabel="rail", ylabel="RMS error of the creep force [kN]")
axes.figure.set_layout_engine("constrained")
plt.show()
