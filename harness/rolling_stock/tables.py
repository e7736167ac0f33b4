"""A train in words and columns."""

from railgrip.report.table import Table
from railgrip.rolling_stock.schema import GRAVITY, Train
from railgrip.rolling_stock.stopping import HandCalculation, by_hand


def table_of_axles(train: Train) -> Table:
    """Return one row for each axle: where it is, what it carries, what turns and brakes with it."""
    # Whatever the speed, full brake is the same at the rim.
    force = by_hand(train, 10.0).brake_force
    valve_of_group = [valve for valve, count in enumerate(train.groups_per_valve) for _ in range(count)]
    rows = [
        {
            "car": train.cars[axle.car].name,
            "bogie": train.bogies_in_train[axle.bogie].kind,
            "axle": number,
            "at": axle.position,
            "mass": axle.mass / 1e3,
            "group": axle.group + 1,
            "valve": valve_of_group[axle.group] + 1,
            "units": round(axle.units),
            "full brake": rim / 1e3,
            "of the load": rim / (axle.mass * GRAVITY),
        }
        for number, (axle, rim) in enumerate(zip(train.axles, force.tolist(), strict=True), start=1)
    ]
    forms = {"at": "{:.2f} m", "mass": "{:.2f} t", "full brake": "{:.1f} kN", "of the load": "{:.3f}"}
    return Table(rows, forms, ("car", "bogie"))


def sentence_of_stop(train: Train, speed: float, stop: HandCalculation) -> str:
    """Return how a train stops by hand calculation."""
    return (
        f"{train.name}: {train.mass / 1e3:.1f} t, {stop.rotating_mass / train.mass:.1%} more by what turns; from "
        f"{3.6 * speed:g} km/h {stop.distance:.1f} m in {stop.duration:.1f} s by hand (EN 14531-1), "
        f"{stop.deceleration:.2f} m/s² after {stop.equivalent_time:.2f} s, adhesion up to {stop.adhesion.max():.3f}"
    )
