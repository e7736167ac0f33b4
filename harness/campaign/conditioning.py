"""Stops the train of a campaign again and again, the plant's parameters moved in the seventh digit.

A distance that this moves by a centimetre is a property of the controller; one that it moves by a tenth of itself is a
draw. Where OpenModelica is on the PATH and so compiles the plants, those of the built-in compiler stop once, too.
"""

from dataclasses import replace
from pathlib import Path

from railgrip.base import registry
from railgrip.campaign.work import Work
from railgrip.fmus.build import choose, fmu
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.conditioning import Conditioning, Repeated
from railgrip.scenario.file import NamedFile
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle import Nudge, Recipe
from railgrip.simulate.run import braking_distance
from railgrip.trace.stop import StopRecord, read_stop

_OTHER = "native"


Repeats = tuple[list[PlannedStop], dict[str, PlannedStop]]
"""What a stop is repeated as: with moved parameters, and with the plant of another compiler, by compiler."""


def repeats_of(stop: PlannedStop, *, count: int, relative: float) -> Repeats:
    """Return the repeats of a stop: `count` of them with parameters moved by up to `relative`.

    Raises:
        FmuError: The plant cannot be built by the other compiler.
    """
    nudges = [Nudge(relative=relative, seed=seed) for seed in range(1, count + 1)]
    nudged = [_changed(stop, f"{stop.name}-{nudge.seed}", nudge=nudge) for nudge in nudges]
    return nudged, _other_compiler(stop)


def campaign_of(campaign: Campaign, repeats: dict[str, Repeats]) -> Campaign:
    """Return the campaign that runs the repeats."""
    return replace(
        campaign,
        name=f"{campaign.name}-conditioning",
        stops=tuple(stop for nudged, compiled in repeats.values() for stop in (*nudged, *compiled.values())),
        references=(),
        panels="none",
        conditioning=None,
    )


def conditioning_of(campaign: Campaign, repeats: dict[str, Repeats], directory: Path, relative: float) -> Conditioning:
    """Return what the repeats in a folder say of the stops of a campaign.

    Raises:
        RecordError: One of them has no result.
    """
    stops: dict[str, Repeated] = {}
    for stop in campaign.stops:
        nudged, compiled = repeats[stop.name]
        records = [read_stop(directory / nudge.name) for nudge in nudged]
        distances = [_distance(record) for record in records]
        figures = [record.metrics.beside_distance() for record in records]
        stops[stop.name] = Repeated(
            digest=stop.scenario.digest(),
            distances=tuple(sorted(distances, key=lambda distance: (distance is None, distance))),
            compilers={compiler: _distance(read_stop(directory / stop.name)) for compiler, stop in compiled.items()},
            figures={
                name: tuple(each[name] for each in figures)
                for name in figures[0]
                if all(name in each for each in figures)
            },
        )
    return Conditioning(relative=relative, stops=stops)


DIVISORS = (2, 4)
"""Of the communication step: what half and a quarter of it move is the error of time discretisation."""


def with_divided_steps(
    campaign: Campaign, before: Conditioning, work: Work, *, count: int
) -> tuple[dict[str, Repeated], dict[str, str]]:
    """Return the repeats of stops with their distances at divided communication steps, and the stops that have none.

    Each stop is repeated up to `count` times at each step, with the first of the moved parameters; once where these
    hardly move it. The periods of sensors, estimator and controller stay.

    Returns:
        Repeats by stop; and for each other stop the reason.
    """
    cases: list[tuple[str, int, Scenario]] = []
    without: dict[str, str] = {}
    for stop in campaign.stops:
        repeated = before.stops.get(stop.name)
        if stop.scenario.controller.kind in registry.ANALYSES:
            without[stop.name] = "an analysis, not a stop of the loop"
        elif repeated is None or repeated.digest != stop.scenario.digest():
            without[stop.name] = "has no repeats of its present scenario; run `railgrip maintain conditioning` before"
        else:
            seeds = range(1, 1 + (1 if repeated.is_smooth else count))
            cases += [
                (stop.name, divisor, _divided(stop.scenario, divisor, Nudge(relative=before.relative, seed=seed)))
                for divisor in DIVISORS
                for seed in seeds
            ]
    distances = work.map(braking_distance, [scenario for *_, scenario in cases])
    steps: dict[str, dict[int, list[float | None]]] = {}
    for (name, divisor, _), distance in zip(cases, distances, strict=True):
        steps.setdefault(name, {}).setdefault(divisor, []).append(None if distance is None else round(distance, 3))
    return {
        name: before.stops[name].model_copy(update={"steps": {divisor: tuple(each) for divisor, each in of.items()}})
        for name, of in steps.items()
    }, without


def _divided(scenario: Scenario, divisor: int, nudge: Nudge) -> Scenario:
    periods = scenario.periods.model_copy(update={"communication": scenario.periods.communication / divisor})
    vehicle = scenario.vehicle.model_copy(update={"nudge": nudge})
    return scenario.model_copy(update={"periods": periods, "vehicle": vehicle})


def _other_compiler(stop: PlannedStop) -> dict[str, PlannedStop]:
    source = stop.scenario.vehicle.source
    if choose("auto") == _OTHER or not isinstance(source, Recipe):
        return {}
    path = fmu(source.name, _OTHER)
    plant = NamedFile(entry=str(path), path=path)
    return {_OTHER: _changed(stop, f"{stop.name}-{_OTHER}", plant=plant, trust=True)}


def _changed(stop: PlannedStop, name: str, **vehicle: object) -> PlannedStop:
    """Return a stop whose [vehicle] differs; of its result the figures are enough."""
    vehicle_table = stop.scenario.vehicle.model_copy(update=vehicle)
    scenario = stop.scenario.model_copy(update={"vehicle": vehicle_table})
    return replace(stop, name=name, scenario=scenario, keep_trace=False)


def _distance(record: StopRecord) -> float | None:
    # To the millimetre: what one communication step of the last metre per second moves.
    return None if record.braking_distance is None else round(record.braking_distance, 3)
