"""The validation page on the law as printed: its guards, the limit of adhesion, and the filter without deflections."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from railgrip import api
from railgrip.base.registry import shelf
from railgrip.campaign.work import Work
from railgrip.controllers.laws.adhesion_based import AdhesionBased
from railgrip.report.reference import locked_text
from railgrip.report.statistics import endless
from railgrip.report.table import ReportTable
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.conditioning import read_conditioning
from railgrip.scenario.load import read_toml
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import run_stop, trace_of
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.papers.courses import LIMIT
from railgrip.studies.papers.table1 import SCENARIOS


def _changed(one: "Guarded", other: "Guarded") -> str:
    if one["distance"] is None or other["distance"] is None:
        return "no stop"
    change = f"{one['distance'] - other['distance']:+.1f} m".replace("-", "−")
    return f"{change}{locked_text(one['lock'])}"


_CASES: Final = read_toml(Path(__file__).parent / "library" / "printed.toml")
_BORROWING: Final = "with the parameters that were searched for peak seeking (railgrip)"
GUARDS: Final[Mapping[str, Mapping[str, Any]]] = _CASES["guards"] | {_BORROWING: {}}
"""Variant of the law as printed → its changed parameters; the last one has those of peak seeking."""
_BORROWED: Final = ("filter_time", "slip_small", "creep_small", "adhesion_small")
_REPEATS: Final = 3
PERTURBATION: Final = 1e-7
"""Perturbation of the accepted repeats, which the first row has."""
_EQUIPMENT: Final = ("ideal", "service")


Guarded = Mapping[str, float | None]
"""`distance`: median of three stops [m], None if most of them do not stop; `lock`: the longest lock in them [s]."""


def guards(work: Work, *, is_quick: bool = False) -> dict[str, dict[str, Guarded]]:
    """Return distance and lock of the law as printed without each of its guards, by equipment and scenario.

    The quick form has two variants, each with one stop in place of their median.
    """
    variants, repeats = (tuple(GUARDS)[:2], 1) if is_quick else (tuple(GUARDS), _REPEATS)
    campaign = load_campaign(shelf("campaigns")["table1"])
    planned = {
        f"{stop.variants['equipment']}-{stop.variants['scenario']}": stop.scenario
        for stop in campaign.only(lambda stop: stop.variants["controller"] == "adhesion_literal").stops
    }
    columns = [f"{equipment}-{name}" for equipment in _EQUIPMENT for name in SCENARIOS]
    cases = [
        _with_parameters(planned[column], variant, seed)
        for variant in variants
        for column in columns
        for seed in range(1, repeats + 1)
    ]
    stops = iter(work.map(distance_and_lock, cases))
    return {variant: {column: _summary([next(stops) for _ in range(repeats)]) for column in columns}
            for variant in variants}  # fmt: skip


def distance_and_lock(scenario: Scenario) -> tuple[float, float]:
    """Return braking distance [m], infinite without standstill, and longest lock of a group [s] of a stop."""
    stop = run_stop(scenario)
    return endless(stop.braking_distance), max(stop.metrics.longest_lock)


def _summary(stops: Sequence[tuple[float, float]]) -> Guarded:
    median = float(np.median([distance for distance, _ in stops]))
    return {
        "distance": round(median, 2) if math.isfinite(median) else None,
        "lock": round(max(lock for _, lock in stops), 2),
    }


def _with_parameters(scenario: Scenario, variant: str, seed: int) -> Scenario:
    parameters = GUARDS[variant]
    if variant == _BORROWING:
        tuning = AdhesionBased.load_tuning(scenario.actuation.kind, "estimated", period=1.0, adhesion_max=LIMIT)
        parameters = {name: getattr(tuning, name) for name in _BORROWED}
    changes = {
        "controller": {"parameters": dict(parameters)},
        "vehicle": {"nudge": {"relative": PERTURBATION, "seed": seed}},
    }
    return scenario.revised(changes)


def accepted_ranges() -> dict[str, str]:
    """Return median, range and longest lock of the repeats of the law as printed, by equipment and scenario."""
    campaign = load_campaign(shelf("campaigns")["table1"])
    assert campaign.conditioning is not None, "the campaign of Table 1 names the file of its repeats"
    repeats = read_conditioning(campaign.conditioning).stops
    found: dict[str, str] = {}
    for equipment in _EQUIPMENT:
        for name in SCENARIOS:
            one = repeats[f"{name}-{equipment}-adhesion_literal"]
            metres = [distance for distance in (one.lots or one.distances) if distance is not None]
            lock = locked_text(max(one.figures["longest_lock"]))
            found[f"{equipment}-{name}"] = f"{np.median(metres):.1f} m, {min(metres):.1f} – {max(metres):.1f} m{lock}"
    return found


def guards_table(found: Mapping[str, Mapping[str, Guarded]]) -> ReportTable:
    """Return a table of `guards`: the accepted distances, then changes by each variant in the same repeats [m]."""
    first, *variants = found
    rows = [(first, *accepted_ranges().values())]
    rows += [
        (variant, *(_changed(one, found[first][column]) for column, one in found[variant].items()))
        for variant in variants
    ]
    columns = [f"{equipment}: {name.replace('_', ' ')}" for equipment in _EQUIPMENT for name in SCENARIOS]
    return ReportTable.of(("ABC (paper)", *columns), rows)


_LIMITED: Final = ("adhesion_literal", "adhesion_based", "slope_seeking")
"""Laws with a limit of adhesion."""


def excesses(work: Work, *, is_quick: bool = False) -> list[dict[str, Any]]:
    """Return the maximum adhesion under each law with a limit, and its components; see `excess`.

    The quick form has ideal equipment alone.
    """
    campaign = load_campaign(shelf("campaigns")["table1"])
    equipment = ("ideal",) if is_quick else ("ideal", "instant", "service")
    stops = campaign.only(
        lambda stop: stop.variants["equipment"] in equipment and stop.variants["controller"] in _LIMITED
    ).stops
    found = work.map(excess, [stop.scenario for stop in stops])
    return [
        {name: stop.variants[name] for name in ("equipment", "controller", "scenario")} | each
        for stop, each in zip(stops, found, strict=True)
    ]


def excess(scenario: Scenario) -> dict[str, float]:
    """Return the maximum adhesion of any group in a stop, and its components.

    `peak`: maximum adhesion; `estimate`: estimated adhesion at that instant; `inertia`: part of the adhesion that
    accelerates the wheelsets, J dω/dt/(r F_z), the rest balances brake and bearings; `speed`: speed of the train at
    that instant [m/s]; `over`: longest time of a group above `LIMIT` [s].
    """
    trace = trace_of(scenario)
    adhesion, time = trace["group_adhesion"].values, trace["time"].values
    instant, group = np.unravel_index(np.argmax(adhesion), adhesion.shape)
    formation = VehicleData(scenario).nominal.formation
    load = formation.sum_by_group(trace["wheelset_load"].values)[instant, group]
    brake = formation.brakes[group]
    rates = np.gradient(trace["wheelset_speed"].values[:, group], time)
    return {
        "peak": float(adhesion[instant, group]),
        "estimate": float(trace["estimate_adhesion"].values[instant, group]),
        "inertia": float(brake.inertia * rates[instant] / (brake.wheel_radius * load)),
        "speed": float(trace["speed"].values[instant]),
        "over": float((adhesion > LIMIT).sum(axis=0).max() * (time[1] - time[0])),
    }


def limit_table(found: list[dict[str, Any]]) -> ReportTable:
    """Return the stops of `excesses` whose adhesion exceeds the limit."""
    rows = [
        (
            *(each[name].replace("_", " ") for name in ("controller", "equipment", "scenario")),
            *(each["peak"], each["estimate"], each["peak"] - each["inertia"]),
            *(each["inertia"], each["speed"], each["over"]),
        )
        for each in found
        if each["peak"] > LIMIT
    ]
    adhesions = ("greatest adhesion", "estimated then", "for brake and bearings", "for inertia")
    columns = dict.fromkeys(("law", "equipment", "rail"), "") | dict.fromkeys(adhesions, "{:.3f}")
    columns |= {"train speed then": "{:.1f} m/s", f"above {LIMIT:g}": "{:.2f} s"}
    return ReportTable.of(columns, rows, left=3)


LAWS: Final[Mapping[str, str]] = {"adhesion_based": "peak seeking (railgrip)", "slope_seeking": "slope-seeking control"}
"""Kind of controller → its name in the table."""

FILTERS: Final[Mapping[str, Mapping[str, Any]]] = _CASES["filters"]
"""Filter → changes of the scenario that select it."""


def deflections(work: Work) -> dict[str, dict[str, dict[str, list[float]]]]:
    """Return distance [m] and rms error of the estimated adhesion, by law, filter and scenario; equipment is ideal.

    Schwarz, Posielek and Goetjes (2021), section 2: deflections are readings (6) and states of the prediction (7), but
    the estimator does not necessarily need their readings.
    """
    cases = [(law, name, scenario) for law in LAWS for name in FILTERS for scenario in SCENARIOS]
    found: dict[str, dict[str, dict[str, list[float]]]] = {}
    for (law, name, scenario), result in zip(cases, work.map(_stop, cases), strict=True):
        found.setdefault(law, {}).setdefault(name, {})[scenario] = result
    return found


def _stop(case: tuple[str, str, str]) -> list[float]:
    law, name, scenario = case
    metrics = run_stop(api.Scenario.load(scenario, {"controller.kind": law, **FILTERS[name]})).metrics
    errors = metrics.adhesion_rmse
    if errors is None:
        raise ValueError(f"{scenario} with {law} and a filter '{name}' has no estimates of adhesion")
    return [metrics.distance, float(np.sqrt(np.mean(np.square(errors))))]


def deflection_table(found: Mapping[str, Mapping[str, Mapping[str, list[float]]]]) -> ReportTable:
    """Return distance, change against the filter that reads deflections, and rms error; see `deflections`."""
    rows: list[tuple[str, ...]] = []
    columns: dict[str, None] = {}
    for law, filters in found.items():
        first, *_ = filters.values()
        columns |= dict.fromkeys(first)
        for name, scenarios in filters.items():
            cells = [
                f"{distance:.1f} m"
                + ("" if scenarios is first else f" ({distance - first[scenario][0]:+.1f} m)".replace("-", "−"))
                + f", {error:.4f}"
                for scenario, (distance, error) in scenarios.items()
            ]
            rows.append((f"{LAWS[law]}: {name}", *cells))
    return ReportTable.of(("distance, rms error of adhesion", *(name.replace("_", " ") for name in columns)), rows)
