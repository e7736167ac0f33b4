"""Assemble the parts of a stop from its scenario, and simulate the stop.

`files` finds or builds the FMUs, and `vehicle` collects the data of the vehicle. `plant`, `rail`, `faults`, `sensors`,
`estimator` and `controller` each open one part, and `parts` opens all of them. `loop` steps the parts; `run` runs a
scenario and returns its stop, and `ideal` computes the shortest stop that the rail allows. `export` writes the parts
for other tools.
"""
