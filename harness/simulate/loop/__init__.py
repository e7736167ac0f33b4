"""Simulate one stop, sample by sample: plant, sensors, estimator, controller and valves, each with its period.

`parts` defines the parts of a stop, and `structs` converts them to the structs in C on which `Loop` runs
`kernel/cycle.c`. The cycle calls parts in C and returns for those in Python. Tables of the scenario and kinds of
sensors and faults fill the structs of their parts; `plausible` sets up the checks of the plant.
"""
