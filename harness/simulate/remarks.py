"""Sentences on a scenario whose values are valid but unusual, or contradict each other in part.

They are printed, stored with the stop, and listed on pages of stops and campaigns. What no check can notice is listed
in docs/limits_of_checks.md.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import nan

from railgrip.base import registry
from railgrip.base.names import ElementName
from railgrip.base.units import GRAVITY
from railgrip.controllers.law import GroupLaw
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.adhesion import reach_of
from railgrip.scenario.demand import Phase, PhaseEnd
from railgrip.scenario.faults import Fault, amount_of
from railgrip.scenario.onboard import BuiltInLaw, Controller
from railgrip.scenario.profile import Adhesion, FromTable, Points
from railgrip.scenario.quantity import in_units, unusual
from railgrip.scenario.schema import Scenario
from railgrip.scenario.track import Track
from railgrip.scenario.vehicle_table import RecipePlant, Source, TrainFile
from railgrip.simulate.faults.sensor import DistortedReading
from railgrip.simulate.faults.site import iterate_faults
from railgrip.simulate.named_models import remarks_on_train
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.metrics import Metrics

_FAR = 4.0
"""Factor on the range of a search beyond which a parameter of a law is unusual."""
_FASTER = 1.3
"""Speed over the maximum speed of a train above which it is unusual."""
_TOP_SPEED = 120 / 3.6
"""Maximum speed of the VT 642, the train of the recipes TwoPartTrain [m/s] (Schwarz, Lüdicke and Heckmann)."""
_LARGEST_FACTOR = 5.0
"""Factor of a fault on a reading beyond which it is unusual."""
_ROUNDING = 1e-3
"""Share by which a pressure may differ because of rounding or a perturbation."""
_STEEP = 0.04
"""Gradient beyond which a line from a file is unusual."""
_MISS = 5.0  # m; a driver who stops at a platform is within a few metres
_WEAKEST_FORCE = 100.0  # N; less accelerates a car of 40 t by 2.5 mm/s2


def remarks_before(scenario: Scenario) -> list[str]:
    """Return the remarks on a scenario.

    Raises:
        ScenarioError: The law of pad friction of its train file does not hold at the speeds of the stop.
    """
    sentences = [
        *(f"{key} {words}" for key, words in unusual(scenario)),
        *_speed(scenario.vehicle.source, scenario.start.speed),
        *_rail(scenario.adhesion),
        *_track(scenario.track),
        *_controller(scenario.controller),
        *_driver(() if scenario.demand is None else scenario.demand.phases),
        *_target(scenario),
        *_faults(scenario.faults),
    ]
    return [
        *(f"{scenario.name}: {sentence}." for sentence in sentences),
        *doubts(scenario),
        *remarks_on_train(scenario),
    ]


def doubts(scenario: Scenario) -> list[str]:
    """Return a sentence for each file of a scenario whose axis appears to have another unit than declared."""
    adhesion, demand, speed = scenario.adhesion, scenario.demand, scenario.start.speed
    sentences: list[str] = []
    if isinstance(adhesion, FromTable):
        columns = adhesion.curve
        strongest = GRAVITY * adhesion.factor * float(columns.values.max())
        if adhesion.over == "distance":
            sentences += _late_begin(f"[adhesion] file {adhesion.file.entry}", float(columns.points[0]))
            doubt = columns.doubt(speed**2 / (2.0 * strongest), reach_of(scenario))
        else:
            doubt = columns.doubt(speed / strongest, scenario.horizon)
        sentences += [f"[adhesion] file {adhesion.file.entry} {doubt}"] if doubt else []
    if isinstance(adhesion, Points) and adhesion.over == "distance":
        sentences += _late_begin("[adhesion] points", adhesion.places[0])
    if demand is not None and demand.file is not None:
        doubt = demand.profile().doubt(0.0 if scenario.has_traction else speed / GRAVITY, scenario.horizon)
        sentences += [f"[demand] file {demand.file.entry} {doubt}"] if doubt else []
    return [f"{scenario.name}: {sentence}." for sentence in sentences]


def _late_begin(what: str, begin: float) -> list[str]:
    """Return a sentence if a profile over distance begins after the brake demand [m]."""
    if begin <= 0.0:
        return []
    return [f"{what} begins {begin:g} m after the brake demand; until there, the friction of its first point applies"]


def remarks_on_vehicle(vehicle: VehicleData) -> list[str]:
    """Return the remarks on a vehicle under its controller and on its track."""
    return [f"{vehicle.scenario.name}: {words}." for words in (*_pressures(vehicle), *_places(vehicle))]


def _places(vehicle: VehicleData) -> Iterator[str]:
    """Yield a sentence if places of wheelsets, or the track under them at the start, are not known."""
    line, behind = vehicle.scenario.track.line, vehicle.formation.wheelset_position
    if vehicle.track_force.is_even:
        return
    if not behind:
        yield (
            "[track] gradient and curve under the leading wheelset act on the whole train, because the plant does not "
            "declare the positions of its wheelsets: give [vehicle.formation] wheelset_position"
        )
    elif line is not None and line.ends[0] > -behind[-1]:
        yield (
            f"[track.line] {line.file.entry} begins {0.0 - line.ends[0]:g} m behind the leading wheelset, and the last "
            f"one is {behind[-1]:g} m behind it; behind its end the first gradient is assumed to go on"
        )


def _pressures(vehicle: VehicleData) -> Iterator[str]:
    """Yield a sentence if cylinders allow more pressure than the controller knows: it never demands that."""
    scenario, changed = vehicle.scenario, vehicle.scenario.vehicle.parameters
    if scenario.actuation.kind != "ideal" or not any(ElementName.of(name).array == "p_max" for name in changed):
        return
    pairs = zip(vehicle.true.brakes, vehicle.nominal.formation.brakes, strict=True)
    higher = [
        f"{true.pressure_max / 1e5:g} bar in group {group}, where the controller knows {known.pressure_max / 1e5:g} bar"
        for group, (true, known) in enumerate(pairs, start=1)
        if true is not None and true.pressure_max > (1 + _ROUNDING) * known.pressure_max
    ]
    if higher:
        yield (
            f"[vehicle.parameters] p_max is {', '.join(higher)} and demands no more, so that the higher pressure has "
            "no effect; give p_max in [controller.parameters], too"
        )


def remarks_after(scenario: Scenario, duration: float, distance: float) -> list[str]:
    """Return a remark for each part of a scenario that the stop did not reach, and one if it left its track.

    Args:
        scenario: Scenario of the stop.
        duration: Duration of the stop [s].
        distance: Distance that the train covered [m].
    """
    times = {
        **{f"[faults[{number}]]": fault.begin for number, fault in enumerate(scenario.faults, start=1)},
        **{f"[sanders[{number}]]": sander.begin for number, sander in enumerate(scenario.sanders, start=1)},
    }
    track = scenario.track
    places = {
        **{f"[adhesion.patch[{number}]]": patch.begin for number, patch in enumerate(scenario.adhesion.patch, start=1)},
        **{f"[track.gradient[{number}]]": part.begin for number, part in enumerate(track.gradient, start=1)},
        **{f"[track.curve[{number}]]": part.begin for number, part in enumerate(track.curve, start=1)},
    }
    left: list[str] = []
    if track.plan is not None:
        at, end = float(track.plan.place(distance)), track.plan.alignment().length
        if not 0.0 <= at <= end:
            left.append(
                f"{scenario.name}: [track.plan] is {end:g} m long, and the train stopped at {at:.4g} m; beyond its "
                "ends gradient and curvature are assumed to go on."
            )
    if track.line is not None and distance > track.line.ends[1]:
        left.append(
            f"{scenario.name}: [track.line] {track.line.file.entry} ends {track.line.ends[1]:g} m from the start, and "
            f"the train stopped after {distance:.4g} m; beyond its end the last gradient is assumed to go on."
        )
    late = [
        *((key, begin, "s", duration) for key, begin in times.items()),
        *((key, begin, "m", distance) for key, begin in places.items()),
    ]
    return left + [
        f"{scenario.name}: {key} had no effect: it begins at {begin:g} {unit}, and the stop ended at {end:.3g} {unit}."
        for key, begin, unit, end in late
        if begin >= end
    ]


def remarks_on_use(scenario: Scenario, metrics: Metrics) -> list[str]:
    """Return a remark if a stop misses its target, and one if it uses more adhesion than the ideal bound allows.

    The stop of the bound itself has none: the definition of `utilisation` explains it, and the sentence would suspect
    brakes that the bound has.
    """
    sentences = ["" if scenario.controller.kind == "ideal_bound" else metrics.excess_over_bound()]
    if abs(error := metrics.target_error) > _MISS:
        side = "behind" if error > 0.0 else "before"
        sentences.append(f"the train stopped {abs(error):.4g} m {side} its target at {target_of(scenario):g} m.")
    return [f"{scenario.name}: {sentence}" for sentence in sentences if sentence]


def target_of(scenario: Scenario) -> float:
    """Return the distance of the last target of the driver, or of that of the law, from the start [m]; NaN without."""
    phases = () if scenario.demand is None else scenario.demand.phases
    of_driver = [phase.stop_at.distance for phase in phases if phase.stop_at is not None]
    return _target_of_law(scenario.controller) or (of_driver[-1] if of_driver else nan)


def _target_of_law(table: Controller) -> float:
    """Return the parameter `target` that the scenario gives a built-in law [m]; 0 without one."""
    given = table.parameters.get("target") if isinstance(table, BuiltInLaw) else None
    return 0.0 if given is None else in_units("[controller.parameters]", {"target": given}, {"target": "m"})["target"]


def _target(scenario: Scenario) -> Iterator[str]:
    """Yield a sentence if the brakes of a train cannot stop it at a target that it approaches from the start."""
    source, speed, target = scenario.vehicle.source, scenario.start.speed, target_of(scenario)
    aim = None if scenario.demand is None or not scenario.demand.phases else scenario.demand.phases[0].stop_at
    if aim is None and not _target_of_law(scenario.controller):
        return
    shortest, brake = 0.0, "the full_deceleration of [demand.phases[1]] stop_at"
    if aim is not None:
        shortest = speed**2 / (2.0 * aim.full_deceleration)
    elif isinstance(source, TrainFile):
        shortest, brake = by_hand(load_train(source.file.path), speed).distance, "the emergency brake on dry rail"
    if shortest > target:
        yield (
            f"the target at {target:g} m cannot be reached: from {3.6 * speed:g} km/h the train takes {shortest:.4g} m "
            f"with {brake}"
        )


def _speed(source: Source, speed: float) -> Iterator[str]:
    highest = 0.0
    if isinstance(source, TrainFile):
        highest = max((stop.speed for stop in load_train(source.file.path).reference), default=0.0)
    elif isinstance(source, RecipePlant) and source.name.startswith("TwoPartTrain"):
        highest = _TOP_SPEED
    if highest and speed > _FASTER * highest:
        yield (
            f"[start] speed is {3.6 * speed:.4g} km/h ({speed:g} m/s), and the train is known up to "
            f"{3.6 * highest:.4g} km/h; a number without a unit is in m/s"
        )


def _rail(adhesion: Adhesion) -> Iterator[str]:
    for key, frictions in {
        "[adhesion] mu0": getattr(adhesion, "mu0", ()),
        **{f"[adhesion.patch[{number}]] mu0": patch.mu0 for number, patch in enumerate(adhesion.patch, start=1)},
    }.items():
        if frictions and frictions[0] > frictions[-1] and [*frictions] == sorted(frictions, reverse=True):
            yield f"{key} falls from the leading wheelset to the last; wheels clean the rail for those behind"
    if (conditioning := adhesion.conditioning) is not None and conditioning.recovered < adhesion.lowest:
        yield (
            f"[adhesion.conditioning] recovered {conditioning.recovered:g} is below all friction of the rail, so no "
            "wheelset cleans it"
        )
    if (sand := adhesion.sand) is not None and sand.mu0 <= adhesion.lowest:
        yield f"[adhesion.sand] mu0 {sand.mu0:g} is not above any friction of the rail, so sand has no effect"
    for (number, patch), (_, behind) in pairwise(
        sorted(enumerate(adhesion.patch, start=1), key=lambda at: at[1].begin)
    ):
        if patch.begin + patch.length > behind.begin:
            yield (
                f"[adhesion.patch[{number}]] from {patch.begin:g} m on {patch.length:g} m reaches into the one that "
                f"begins at {behind.begin:g} m; length is not the place of the end"
            )


def _track(track: Track) -> Iterator[str]:
    if 0.0 < abs(track.force) < _WEAKEST_FORCE:
        yield f"[track] force is {track.force:g} N, which moves no train; a number without a unit is in N"
    line = track.line
    steepest = 0.0 if line is None else max((slope for _, slope in line.sections), key=abs)
    if line is not None and abs(steepest) > _STEEP:
        yield (
            f"[track.line] {line.file.entry} has a gradient of {1e3 * steepest:.0f} ‰; main lines stay below 35 ‰ (INF "
            "TSI, 4.2.3.3). Heights of receivers must be smoothed first"
        )


def _controller(table: Controller) -> Iterator[str]:
    """Yield a sentence for each parameter of a built-in law far outside the range of its search."""
    if not isinstance(table, BuiltInLaw) or table.kind not in registry.modules(registry.LAWS):
        return
    law = registry.part(registry.LAWS, table.kind, GroupLaw)
    ranges = next(iter(law.ranges.values()), {})
    units = law.tuning.units()
    known = {name: value for name, value in table.parameters.items() if name in ranges and name in units}
    for name, value in in_units("[controller.parameters]", known, units).items():
        low, high = ranges[name]
        if value and not low / _FAR <= value <= high * _FAR:
            unit = "" if units[name] == "1" else f" {units[name]}"
            yield (f"[controller.parameters] {name} is {value:g}{unit}; its search covers {low:g} to {high:g}{unit}")


def _faults(faults: Sequence[Fault]) -> Iterator[str]:
    """Yield a sentence for each reading that a fault multiplies by a large factor."""
    for where, fault in iterate_faults(faults, DistortedReading):
        factor = amount_of(fault.value, "1", where) if fault.kind == "scaled" else 0.0
        if abs(factor) > _LARGEST_FACTOR:
            yield (
                f"{where} value is {factor:g}, by which the reading of a {fault.part} is multiplied; 0.8 makes it 20 % "
                "too low"
            )


def _driver(phases: Sequence[Phase]) -> Iterator[str]:
    """Yield a sentence for each condition that ends no phase, because the one of a phase before it is later."""
    latest: dict[str, float] = {}
    for number, phase in enumerate(phases, start=1):
        end = phase.until
        if isinstance(end, PhaseEnd) and end.kind in ("time", "distance"):
            if end.value <= latest.get(end.kind, -1.0):
                yield (
                    f"[demand.phases[{number}]] until {end.kind} {end.value:g} is not after that of a phase before it; "
                    "both are since the start of the stop"
                )
            latest[end.kind] = max(end.value, latest.get(end.kind, -1.0))
