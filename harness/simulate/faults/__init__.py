"""Faults of a train: the tables [[faults]] with their keys, and what each does between the plant and who meets it.

Each kind of fault is a subclass of `railgrip.scenario.faults.Fault` in a module here. What it does is one of the
elementary faults of `railgrip.simulate.loop.faults`, or known to who makes the part: the pole wheel, the plant.
"""
