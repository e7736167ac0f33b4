"""Stops of version 2 of the type test under laws with and without a limit on releases."""

from typing import Any

import numpy as np

from railgrip.recording.samples import period_of
from railgrip.scenario.file import merge
from railgrip.simulate.run import run_stop
from railgrip.studies.type_test.case_set import case_named
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of, trains_of
from railgrip.trace.measures import largest_sum


def stop_row(case: str, law: str, limit: float) -> dict[str, Any]:
    """Return the distance of a stop [m], or NaN, and the longest release of a group [s]; without a limit for 0.

    A group is released while less than a twentieth of full pressure is demanded, and the train is faster than 1 m/s.
    """
    entrant, the_case = entrants(2)[law], case_named(case)
    tables = merge(entrant.model_dump(), {"controller": {"release_max": f"{limit} s"}} if limit else {})
    limited = {law: type(entrant).model_validate(tables)}
    (planned,) = campaign_of([the_case], limited, train_of(None), trains=trains_of([the_case])).stops
    stop = run_stop(planned.scenario)
    return {"distance": stop.metrics.distance, "standstill": stop.outcome == "standstill", "longest": longest(stop)}


def longest(stop: Any) -> float:
    """Return the longest time without a demand on a group [s]."""
    demand, moves = stop.trace["demand"].values, stop.trace["speed"].values > 1.0
    released = (demand < 0.05 * demand.max(axis=0)) & moves[:, None]
    periods = np.full(len(released), period_of(stop.trace))
    return max(largest_sum(of_group, periods) for of_group in released.T)
