"""Tables and sentences about a train."""

from collections import Counter

from railgrip.report.table import ReportTable
from railgrip.rolling_stock.schema import Train
from railgrip.rolling_stock.stopping import HandCalculation, full_brake_force, parking_forces
from railgrip.vehicle.formation import axle_load


def table_of_axles(train: Train) -> ReportTable:
    """Return one row for each axle: position, load, coupled axles, and brake."""
    force = full_brake_force(train)
    rows = [
        {
            "car": train.cars[axle.car].name,
            "bogie": bogie.kind,
            "axle": number,
            "at": axle.position,
            "mass": axle.mass / 1e3,
            "group": axle.group + 1,
            "valve": train.valve_of_group[axle.group] + 1,
            "units": round(axle.units),
            "full brake": rim / 1e3,
            "of the load": rim / axle_load(axle.mass),
            "dynamic brake": bogie.data.dynamic_brake if axle.dynamic_units else None,
            "on the rail": ", ".join(name for name, _ in bogie.rail_brakes if number - 1 == bogie.axles[0]) or None,
            "parking": holding / 1e3 or None,
        }
        for number, (axle, rim, holding) in enumerate(
            zip(train.axles, force.tolist(), parking_forces(train).tolist(), strict=True), start=1
        )
        for bogie in [train.bogies_in_train[axle.bogie]]
    ]
    forms = {"at": "{:.2f} m", "mass": "{:.2f} t", "full brake": "{:.1f} kN", "of the load": "{:.3f}"}
    table = ReportTable(rows, forms | {"parking": "{:.1f} kN"}, ("car", "bogie", "dynamic brake", "on the rail"))
    return table.drop_empty_columns()


def table_of_distributors(train: Train) -> ReportTable:
    """Return one row for each car with a distributor of its own or an accelerator of the brake pipe."""
    rows = [
        {
            "car": car.name,
            "distributor": car.distributor,
            "filling": None if distributor is None else distributor.fill_time,
            "release": None if distributor is None else distributor.release_time,
            "inshot": (distributor.inshot or None) if distributor else None,
            "low stage": None if stages is None else stages.low_share,
            "below": None if stages is None else 3.6 * stages.speed_down,
            "high from": None if stages is None else 3.6 * stages.speed_up,
            "accelerator": car.accelerator,
            "opens": None if vent is None else vent.opening_rate / 1e5,
            "closes": None if vent is None else vent.closing_pressure / 1e5,
        }
        for car, distributor, vent in zip(train.cars, train.distributor_of_car, train.accelerator_of_car, strict=True)
        for stages in [None if distributor is None else distributor.stages]
        if distributor or vent
    ]
    forms = {"low stage": "{:.2f}", "below": "{:.0f} km/h", "high from": "{:.0f} km/h", "opens": "{:g} bar/s"}
    forms |= {"closes": "{:g} bar", "filling": "{:g} s", "release": "{:g} s", "inshot": "{:.2f}"}
    return ReportTable(rows, forms, ("car", "distributor", "accelerator")).drop_empty_columns()


def sentence_of_equipment(train: Train) -> str:
    """Return a sentence on dynamic brakes, distributors and accelerators; empty for a train without any."""
    words: list[str] = []
    for name, count in Counter(b.data.dynamic_brake for b in train.bogies_in_train if b.dynamic_brake).items():
        brake = train.dynamic_brakes[str(name)]
        words.append(f"{name} on {count} bogies: {brake.kind.replace('_', ' ')}, {brake.performance}")
    for kind, count in Counter(car.distributor for car in train.cars if car.distributor).items():
        distributor, parts = train.distributors[kind], list[str]()
        if distributor.fill_time is not None:
            parts.append(f"filling in {distributor.fill_time:g} s")
        if distributor.inshot:
            parts.append(f"{100 * distributor.inshot:.0f} % at once")
        if distributor.release_time is not None:
            parts.append(f"release in {distributor.release_time:g} s")
        if (stages := distributor.stages) is not None:
            parts.append(
                f"{100 * stages.low_share:.0f} % of the pressure below {3.6 * stages.speed_down:g} km/h, the full "
                f"pressure from {3.6 * stages.speed_up:g} km/h"
            )
        words.append(f"{kind} in {count} of {len(train.cars)} cars: {', '.join(parts)}")
    for kind, count in Counter(car.accelerator for car in train.cars if car.accelerator).items():
        vent = train.accelerators[kind]
        words.append(
            f"{kind} in {count} of {len(train.cars)} cars vents the pipe where it falls by {vent.opening_rate / 1e5:g} "
            f"bar/s, down to {vent.closing_pressure / 1e5:g} bar"
        )
    return f"{train.name}: {'; '.join(words)}" if words else ""


def plain_stop(speed: float, stop: HandCalculation) -> dict[str, float]:
    """Return a stop by hand calculation as plain values in SI units; `speed` is the speed at the brake demand [m/s]."""
    return {
        "speed": speed,
        "distance": stop.distance,
        "duration": stop.duration,
        "deceleration": stop.deceleration,
        "equivalent_time": stop.equivalent_time,
        "rotating_mass": float(stop.rotating_mass),
        "adhesion_max": float(stop.adhesion.max()),
        "dynamic_work": stop.dynamic_work,
    }


def sentence_of_stop(train: Train, speed: float, stop: HandCalculation) -> str:
    """Return a sentence on the stop by hand calculation."""
    return (
        f"{train.name}: {train.mass / 1e3:.1f} t, {100 * stop.rotating_mass / train.mass:.1f} % rotating mass; "
        f"from {3.6 * speed:g} km/h {stop.distance:.1f} m in {stop.duration:.1f} s by hand (EN 14531-1), "
        f"{stop.deceleration:.2f} m/s² after {stop.equivalent_time:.2f} s, adhesion up to {stop.adhesion.max():.3f}"
    )
