"""From a scenario to the parties of its stop, and to the stop: the only room that names concrete classes.

`files` finds the FMUs, `vehicle` says what is known of the vehicle; `plant`, `rail`, `faults`, `sensors`, `estimator`
and `controller` open a party each, `parties` all of them, and judges their stop; `ideal` stops as well as can be.
"""

from railgrip.assemble.parties import Assembled, OwnParties, assembled
from railgrip.assemble.run import braking_distance, run_stop, trace_of

__all__ = ["Assembled", "OwnParties", "assembled", "braking_distance", "run_stop", "trace_of"]
