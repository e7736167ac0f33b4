"""From the faults of a scenario to what they do: to readings, to commands, or to the plant itself."""

from collections.abc import Iterator, Mapping, Sequence

from railgrip.controllers.brake import BrakeGroup
from railgrip.errors import ScenarioError
from railgrip.formation import Formation
from railgrip.loop.faults import CommandFault, Faults, ReadingFault
from railgrip.loop.sensors import MissingTeeth
from railgrip.scenario.faults import READ_BY, Fault
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.scenario.sensors import ServiceSensors
from railgrip.signals import Layout

_MOST_DRAWS = 2**17
"""Of noise: after 131 s it begins anew."""

_SLOWEST = 10.0  # s

_VENT, _HOLD, _FILL = -1.0, 0.0, 1.0


def faults_of(
    scenario: Scenario, layout: Layout, brakes: Sequence[BrakeGroup], *, outputs: frozenset[str], valves: bool
) -> Faults | None:
    """Return what is broken on the way to and from the plant; None where nothing is.

    Args:
        brakes: Of each group, nominal.
        outputs: Names of what the plant shows.
        valves: The plant takes positions of valves, else pressures.

    Raises:
        ScenarioError: A fault is none of this vehicle.
    """
    readings: list[ReadingFault] = []
    commands: list[CommandFault] = []
    for number, (where, fault) in enumerate(_named(scenario)):
        if fault.part in READ_BY and fault.kind != "missing_teeth":
            readings += _of_sensor(scenario, layout, number, where, fault)
        elif fault.part in ("valve", "supply") or (fault.kind == "isolated" and fault.value is None):
            if fault.part == "supply" and "air_used" not in outputs:
                raise ScenarioError(f"{where} empties a reservoir, but the plant does not show the air that it uses")
            commands += _of_brake(scenario, layout.formation, where, fault, brakes, valves)
    if not readings and not commands:
        return None
    every = max(round(1e-3 / scenario.periods.communication), 1)
    return Faults(layout, readings, commands, valves=valves, noise_every=every)


def missing_teeth(scenario: Scenario, formation: Formation) -> tuple[MissingTeeth, ...]:
    """Return the teeth that the pole wheel of each group misses.

    Raises:
        ScenarioError: There are no pole wheels, or more teeth are missing than there are.
    """
    missing = [MissingTeeth()] * formation.groups
    for where, fault in _named(scenario):
        if fault.kind != "missing_teeth":
            continue
        sensors = scenario.sensors
        if not isinstance(sensors, ServiceSensors):
            raise ScenarioError(f"{where} needs pole wheels, [sensors] kind 'service', and it is '{sensors.kind}'")
        count, begin, end = round(fault.amount("1", where)), *_samples(scenario, fault)
        if count >= sensors.wheel.pulses:
            raise ScenarioError(f"{where} takes {count} teeth of {sensors.wheel.pulses}; for all of them, kind 'dead'")
        for group in _places(fault.group, formation.groups, where, "group"):
            if missing[group].count:
                raise ScenarioError(f"{where}: the pole wheel of group {group + 1} misses teeth twice; keep one fault")
            missing[group] = MissingTeeth(count, begin, end)
    return tuple(missing)


def isolated_units(scenario: Scenario, formation: Formation, units: Mapping[str, float]) -> dict[str, float]:
    """Return the plant parameters `n_units[g]` that brake units which are isolated leave.

    Args:
        units: All numeric parameters of the plant.

    Raises:
        ScenarioError: The plant has no such parameter or fewer units, or units are isolated for a while only.
    """
    counts: dict[str, float] = {}
    for where, fault in _named(scenario):
        if fault.kind != "isolated" or fault.value is None:
            continue
        if not _lasts(fault):
            raise ScenarioError(
                f"{where} isolates some units of a group, which holds for the whole stop: leave out begin and end, or "
                "value, to isolate the group"
            )
        for group in _places(fault.group, formation.groups, where, "group"):
            name = f"n_units[{group + 1}]"
            if name not in units:
                raise ScenarioError(f"{where} isolates units of a group, but the plant has no parameter {name}")
            counts[name] = counts.get(name, units[name]) - fault.amount("1", where)
            if counts[name] <= 0.0:
                raise ScenarioError(
                    f"{where} isolates all units of group {group + 1}, which has {units[name]:g}, or more; leave out "
                    "value to isolate the group"
                )
    return counts


def isolated_groups(scenario: Scenario, formation: Formation) -> list[int]:
    """Return the zero-based groups whose brake is isolated for the whole stop."""
    faults = ((where, f) for where, f in _named(scenario) if f.kind == "isolated" and f.value is None and _lasts(f))
    return [group for where, f in faults for group in _places(f.group, formation.groups, where, "group")]


def _lasts(fault: Fault) -> bool:
    return not fault.begin and fault.end is None


def _named(scenario: Scenario) -> Iterator[tuple[str, Fault]]:
    for number, fault in enumerate(scenario.faults, start=1):
        yield f"{scenario.name}: [faults[{number}]]", fault


def _samples(scenario: Scenario, fault: Fault) -> tuple[int, int]:
    """Return the first sample with a fault, and the first one without it again."""
    period = scenario.periods.communication
    end = scenario.limits.horizon + 1.0 if fault.end is None else fault.end
    # A time is meant to the nearest sample; a fault lasts one at least.
    begin = round(fault.begin / period)
    return begin, max(round(end / period), begin + 1)


def _places(number: int | None, count: int, where: str, what: str) -> range:
    if number is None:
        return range(count)
    if number > count:
        raise ScenarioError(f"{where} is at {what} {number}, the vehicle has {count}")
    return range(number - 1, number)


def _of_sensor(scenario: Scenario, layout: Layout, number: int, where: str, fault: Fault) -> Iterator[ReadingFault]:
    quantity = READ_BY[fault.part]
    place = layout.reading[quantity]
    unit = next(signal.unit for signal in layout.reading_signals if signal.name == f"reading_{quantity}")
    begin, end = _samples(scenario, fault)
    what, place_number = ("wheelset", fault.wheelset) if fault.part == "deflection_sensor" else ("group", fault.group)
    kind, value = ("scaled", 0.0) if fault.kind == "zero" else (fault.kind, fault.amount(unit, where))
    for index in _places(place_number, place.stop - place.start, where, what):
        noise = None
        if kind == "noisy":
            noise = generator(scenario.seed, f"faults.{number}.{index}").standard_normal(_MOST_DRAWS)
        yield ReadingFault(
            kind=kind,  # pyright: ignore[reportArgumentType]  (the other kinds are of other parts)
            place=place.start + index,
            begin=begin,
            end=end,
            value=value,
            noise=noise,
        )


def _of_brake(
    scenario: Scenario, formation: Formation, where: str, fault: Fault, brakes: Sequence[BrakeGroup], valves: bool
) -> Iterator[CommandFault]:
    begin, end = _samples(scenario, fault)
    amount = fault.amount("1", where)
    if fault.kind == "slow" and amount > _SLOWEST:
        raise ScenarioError(
            f"{where} delays a valve by {amount:g} s; at most {_SLOWEST:g} s make sense, else it is held"
        )
    for group in _places(fault.group, formation.groups, where, "group"):
        full = _FILL if valves else brakes[group].pressure_max
        common = {"group": group, "begin": begin, "end": end}
        match fault.kind:
            case "filled":
                yield CommandFault(kind="fixed", value=full, **common)
            case "dumped" | "isolated":
                yield CommandFault(kind="fixed", value=_VENT if valves else 0.0, **common)
            case "held" if valves:
                yield CommandFault(kind="fixed", value=_HOLD, **common)
            case "held":
                yield CommandFault(kind="kept", **common)
            case "slow":
                delay = round(amount / scenario.periods.communication)
                yield CommandFault(kind="late", delay=delay, **common)
            case _:
                refill = (fault.refill or 0.0) * scenario.periods.communication
                yield CommandFault(
                    kind="limited", value=amount, pressure=fault.pressure or 0.0, refill=refill, **common
                )
