"""Track force for a train's filter, from the train's own run: what [course] of an estimation asks for.

A run brings `speed` (optical or radar), `acceleration_along[1]` … (as many as there are, feeling g sin β too),
`latitude`, `longitude`, `height` (NaN between the samples of the receiver), wheelset speeds, cylinder pressures,
`driving` (0 or 1: the filter knows no traction and begins when there is none) and, if somebody recorded it, `braking`;
else braking begins where a cylinder fills. The trace of a stop has `traction` and `driver_demand` in their place. What
comes back begins with the coasting before the brake and has `track_force` beside the readings.
"""

import xarray

from railgrip.estimation.spec import CourseTable
from railgrip.estimation.track.braking import braking_of

UNITS = {"latitude": "deg", "longitude": "deg", "height": "m", "driving": "1", "braking": "1"}
ALWAYS = ("driving", "braking")
"""Signals that the whole run must tell, if it tells them."""
ACCELEROMETER = "acceleration_along"
TRACK_FORCE = "track_force"


def units_of_run(columns: list[str]) -> dict[str, str]:
    """Return the units of the signals among `columns` that serve to find the track force."""
    of_sensors = {name: "m/s2" for name in columns if name.partition("[")[0] == ACCELEROMETER}
    return of_sensors | {name: unit for name, unit in UNITS.items() if name in columns}


def with_track_force(run: xarray.Dataset, course: CourseTable) -> xarray.Dataset:
    """Return a run from its coasting on, with the force of gradient and curves.

    Raises:
        EstimationError: A reading is missing, nobody braked, or the train was driven until then.
    """
    return braking_of(
        run, course.mass, curve_law=course.curve_law, low_pass=course.low_pass, trust=course.trust
    ).recording
