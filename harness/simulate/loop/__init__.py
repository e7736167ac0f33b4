"""Simulate one stop, sample by sample: plant, sensors, estimator, controller and valves, each at its own period.

`Loop` runs `kernel/cycle.c`, which calls parts in C and returns for those in Python; `parts` defines the parts.
"""
