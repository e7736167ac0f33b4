"""Simulate one stop, sample by sample: plant, sensors, estimator, controller and valves, each with its period.

`parts` defines the parts of a stop, and `structs` converts them to the structs in C on which `Loop` runs
`kernel/cycle.c`. The cycle calls parts in C and returns for those in Python. `rail`, `driver`, `faults`, `sensors` and
`plausible` set up parts that are always in C, and describe their formulas.
"""
