"""Plain results of stops, as the type test ships them."""

from typing import Any

from railgrip.studies.type_test.track_case import TrackCase


def row_of(case: TrackCase, controller: str, distance: float, **changes: Any) -> dict[str, Any]:
    """A stop with standstill after a distance [m] that satisfies every clause."""
    values = {
        "case": case.name, "variants": {name: value for name, value in case.variants().items() if name != "case"},
        "speed": case.speed, "controller": controller, "outcome": "standstill", "distance_m": distance,
        "duration_s": 20.0, "longest_lock_s": 0.0, "locked_distance_m": 0.0, "air_l": 100.0, "strokes": 10,
        "tread_energy_mj": 0.1, "utilisation": 0.9,
    }  # fmt: skip
    return values | changes
