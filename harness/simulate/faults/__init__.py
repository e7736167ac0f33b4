"""Faults of a train: the tables [[faults]] with their keys, and the effect of each on commands or readings.

Each kind of fault is a subclass of `railgrip.scenario.faults.Fault` in a module here. It is translated to elementary
faults of `railgrip.simulate.faults.site`, or handled by the part that it concerns: the pole wheel, the plant.
"""
