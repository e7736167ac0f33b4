"""Repeat the stops of a campaign: with the plant's parameters perturbed, and with other lots of sensors.

A distance that changes by a centimetre under a perturbation of 1e-7 is a property of the controller; one that changes
by a tenth is random. All controllers have the same lots, so that their distances can be compared in pairs. If
OpenModelica is on the PATH, its FMUs are repeated, and their distances are added to those of the built-in compiler.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Literal

from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.campaign.work import Work
from railgrip.report.stop import read_stop
from railgrip.report.table import names
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.conditioning import SMOOTH, ConditioningFile, RepeatedDistances
from railgrip.scenario.onboard import SampledSensors
from railgrip.scenario.quantity import Parameter
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle_table import ModelicaPlant, Nudge
from railgrip.simulate.run import braking_distance

Repeats = tuple[list[PlannedStop], list[PlannedStop]]
"""The repeats of a stop: with perturbed parameters of the plant, and with lots 1, 2, … of the sensors, none if sensors
have no errors."""


def repeats_of(stop: PlannedStop, *, count: int, lots: int, relative: float) -> Repeats:
    """Return the repeats of a stop.

    Args:
        stop: Stop of a campaign.
        count: Number of repeats with parameters perturbed by up to `relative`, as a share of their values.
        lots: Number of lots of sensors.
        relative: Maximum perturbation.
    """
    nudges = [Nudge(relative=relative, seed=seed) for seed in range(1, count + 1)]
    sensors = stop.scenario.sensors
    vehicle = stop.scenario.vehicle
    return [_repeat(stop, str(each.seed), vehicle=vehicle.model_copy(update={"nudge": each})) for each in nudges], [
        _repeat(stop, f"lot-{seed}", sensors=sensors.model_copy(update={"seed": seed}))
        for seed in range(1, lots + 1)
        if isinstance(sensors, SampledSensors)
    ]


def campaign_of(campaign: Campaign, repeats: dict[str, Repeats]) -> Campaign:
    """Return the campaign that runs the repeats."""
    return replace(
        campaign,
        name=f"{campaign.name}-conditioning",
        stops=tuple(stop for kinds in repeats.values() for kind in kinds for stop in kind),
        references=(),
        panels="none",
        conditioning=None,
    )


def conditioning_of(
    campaign: Campaign, repeats: dict[str, Repeats], directory: Path, relative: float
) -> ConditioningFile:
    """Return the conditioning of a campaign from the results of the repeats in a folder.

    Raises:
        RecordError: A repeat has no result.
    """
    stops: dict[str, RepeatedDistances] = {}
    for stop in campaign.stops:
        perturbed, lots = ([read_stop(directory / one.name) for one in kind] for kind in repeats[stop.name])
        figures = [one.metrics.compared() for one in perturbed]
        stops[stop.name] = RepeatedDistances(
            digest=stop.scenario.digest(),
            distances=tuple(sorted(_rounded(one.braking_distance) for one in perturbed)),
            lots=tuple(_rounded(one.braking_distance) for one in lots),
            figures={
                name: tuple(each[name] for each in figures)
                for name in figures[0]
                if all(name in each for each in figures)
            },
        )
    return ConditioningFile(relative=relative, stops=stops)


def merged(
    stops: Mapping[str, RepeatedDistances], before: Mapping[str, RepeatedDistances], compiler: str
) -> dict[str, RepeatedDistances]:
    """Return new repeats with what was measured before of the same stops.

    Distances at divided communication steps, at other tolerances and with the FMUs of other compilers are kept for
    stops of the same scenario whose median distance has not changed by more than `SMOOTH`. New repeats with the FMUs of
    another compiler than the built-in one are added to the former ones of the same scenario.

    Raises:
        ScenarioError: There are no repeats with the built-in compiler's FMUs to which those of another can be added.
    """
    same = {name: before[name] for name, stop in stops.items() if name in before and before[name].digest == stop.digest}
    if compiler != "native":
        if missing := [name for name in stops if name not in same]:
            raise ScenarioError(
                f"{names(missing)}: there are no repeats with FMUs of the built-in compiler to compare with; run "
                "`make conditioning` before without omc on the PATH"
            )
        return {
            name: same[name].model_copy(update={"compilers": same[name].compilers | {compiler: stop.distances}})
            for name, stop in stops.items()
        }
    kept = ("steps", "tolerances", "compilers")
    return {
        name: stop.model_copy(update={key: getattr(same[name], key) for key in kept})
        if name in same and abs(same[name].median - stop.median) <= SMOOTH
        else stop
        for name, stop in stops.items()
    }


DIVISORS = (2, 4)
"""Divisors of the communication step.

The changes with half and a quarter of it show the error of time discretisation.
"""


TOLERANCES = (1e-4, 1e-6, 1e-7)
"""Tolerances of the plant's solver besides its own, from loose to tight: the changes show the error of integration."""

Refinement = Literal["steps", "tolerances"]


def with_refinement(
    campaign: Campaign, before: ConditioningFile, work: Work, *, of: Refinement, count: int
) -> tuple[dict[str, RepeatedDistances], dict[str, str]]:
    """Return the repeats of stops with distances at divided communication steps, or at other tolerances of the solver.

    Each stop is repeated up to `count` times at each value, with the first of the perturbed parameters; only once if
    its distance hardly depends on them. The periods of sensors, estimator and controller are not divided.

    Returns:
        Repeats by stop; and for each other stop the reason.
    """
    values = DIVISORS if of == "steps" else TOLERANCES
    cases: list[tuple[str, float, Scenario]] = []
    without: dict[str, str] = {}
    for stop in campaign.stops:
        repeated = before.stops.get(stop.name)
        if stop.scenario.controller.kind in registry.ANALYSES:
            without[stop.name] = "an analysis, not a stop of the loop"
        elif of == "tolerances" and not isinstance(stop.scenario.vehicle.source, ModelicaPlant):
            without[stop.name] = "its plant is not compiled here, so that its tolerance is its own"
        elif repeated is None or repeated.digest != stop.scenario.digest():
            without[stop.name] = "has no repeats of its present scenario; run `make conditioning` before"
        else:
            seeds = range(1, 1 + (1 if repeated.is_smooth else count))
            cases += [
                (stop.name, value, _refine(stop.scenario, of, value, Nudge(relative=before.relative, seed=seed)))
                for value in values
                for seed in seeds
            ]
    distances = work.map(braking_distance, [scenario for *_, scenario in cases])
    found: dict[str, dict[float, list[float]]] = {}
    for (name, value, _), distance in zip(cases, distances, strict=True):
        found.setdefault(name, {}).setdefault(value, []).append(_rounded(distance))
    return {
        name: before.stops[name].model_copy(update={of: {value: tuple(each) for value, each in by_value.items()}})
        for name, by_value in found.items()
    }, without


def _refine(scenario: Scenario, of: Refinement, value: float, nudge: Nudge) -> Scenario:
    periods, parameters = scenario.periods, scenario.vehicle.parameters
    if of == "steps":
        periods = periods.model_copy(update={"communication": periods.communication / value})
    else:
        parameters = {**parameters, "_tolerance": Parameter(value)}
    vehicle = scenario.vehicle.model_copy(update={"nudge": nudge, "parameters": parameters})
    return scenario.model_copy(update={"periods": periods, "vehicle": vehicle})


def _repeat(stop: PlannedStop, suffix: str, **tables: object) -> PlannedStop:
    scenario = stop.scenario.model_copy(update=tables)
    return replace(stop, name=f"{stop.name}-{suffix}", scenario=scenario, keep_trace=False)


def _rounded(distance: float | None) -> float:
    # Rounded to the millimetre: the change by one communication step in the last metre per second.
    return math.inf if distance is None else round(distance, 3)
