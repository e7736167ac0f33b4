"""From a scenario to the parts of its stop, and the stop.

`files` finds the FMUs, and `vehicle` says what is known of the vehicle. `plant`, `rail`, `faults`, `sensors`,
`estimator` and `controller` each open a part, and `parts` opens all of them. `loop` steps them; `run` judges the stop.
`ideal` is the shortest stop that the rail allows.
"""
