"""Sentences of Schwarz, Posielek and Goetjes (2021) about figure 4 and the limit of adhesion, measured in a stop."""

from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from railgrip.report.stop import Stop

LIMIT = 0.15
"""Adhesion that the paper allows, after the TSI."""

COUPLED, LAST_RISE = (9.0, 16.0), 25.0
"""When adhesion is below the greatest possible, and when friction rises last, after the text of the paper [s]."""

_SMOOTHED = 0.2  # s; slower changes follow the friction of the rail, faster ones are chatter


def course_of_adhesion(stop: Stop) -> dict[str, Any]:
    """Return how a stop uses the adhesion of the rail, by name.

    `duration` [s]. Of wheelset 1: `used`, adhesion over the greatest possible up to the limit, means before, in and
    after `COUPLED`; `chatter`, rms deviation of adhesion from its mean over 0.2 s, before and after `LAST_RISE`. Of
    all groups: `used_groups`, as `used` until `LAST_RISE`; `peak`, the greatest adhesion; `over`, the longest time that
    one of them has more than `LIMIT` [s].
    """
    trace = stop.trace
    time, adhesion, greatest = trace["time"].values, trace["adhesion"].values[:, 0], trace["peak_adhesion"].values[:, 0]
    window = round(_SMOOTHED / float(time[1] - time[0]))
    deviation = adhesion - uniform_filter1d(adhesion, window)
    used = adhesion / np.minimum(greatest, LIMIT)
    parts = {"before": time < COUPLED[0], "coupled": (time >= COUPLED[0]) & (time < COUPLED[1])}
    parts["after"] = (time >= COUPLED[1]) & (time < LAST_RISE)
    of_groups = trace["group_adhesion"].values
    shares = of_groups / np.minimum(trace["ideal_adhesion"].values, LIMIT)
    return {
        "duration": stop.metrics.duration,
        "used": {name: float(np.mean(used[there])) for name, there in parts.items()},
        "chatter": [float(np.sqrt(np.mean(deviation[there] ** 2))) for there in (time < LAST_RISE, time >= LAST_RISE)],
        "used_groups": shares[time < LAST_RISE].mean(axis=0).tolist(),
        "peak": float(of_groups.max()),
        "over": max(stop.metrics.time_over_alpha_max),
    }
