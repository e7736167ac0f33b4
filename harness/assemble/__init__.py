"""From a scenario to the parts of its stop, and to the stop: the only package that names concrete classes.

`files` finds the FMUs, `vehicle` says what is known of the vehicle; `plant`, `rail`, `faults`, `sensors`, `estimator`
and `controller` open a part each, `parts` all of them, and judges their stop; `ideal` stops as well as can be.
"""

from railgrip.assemble.parts import Assembled, OwnParts, assembled
from railgrip.assemble.run import braking_distance, run_stop, trace_of

__all__ = ["Assembled", "OwnParts", "assembled", "braking_distance", "run_stop", "trace_of"]
