"""Stops with the law as printed without its guards, with laws that limit adhesion, and with filters without readings.

Equipment, laws and rails are those of the campaign `table1`.
"""

import math
from functools import cache

import numpy as np
from table1_stops import LIMIT

import railgrip as rg
from railgrip.base.registry import shelf
from railgrip.controllers.laws.adhesion_based import AdhesionBased
from railgrip.report.reference import locked_text
from railgrip.report.statistics import endless
from railgrip.scenario.campaign import Campaign, load_campaign
from railgrip.scenario.conditioning import read_conditioning
from railgrip.scenario.schema import Scenario
from railgrip.simulate.vehicle_data import VehicleData

GUARDS = {
    "as searched": {},
    "without the rolling guard": {"slip_small": 0.0, "creep_small": 0.0, "adhesion_small": 0.0},
    "without the guard below 0.5 m/s": {"speed_min": 0.0},
    "without the hold (half pressure where ṡ·α̇ = 0)": {"hold": 0.0},
    "with the alternative switching function α̇/ṡ": {"quotient": 1.0},
    "with the parameters that were searched for peak seeking (railgrip)": {},
}
"""Variant of the law as printed → its changed parameters; the last one has those of peak seeking."""
_BORROWED = ("filter_time", "slip_small", "creep_small", "adhesion_small")
PERTURBATION = 1e-7
"""Perturbation of the accepted repeats, which the first row has."""
FILTERS = {
    "Δz predicted and read": {"estimator.model": "TrainPrediction"},
    # A filter rejects readings that deviate by more than `outlier_limit` standard deviations: all deflections.
    "Δz predicted, not read": {
        "estimator.model": "TrainPrediction", "estimator.outlier_limit": {"deflection": 1e-9},
    },
    "no Δz: static loads": {"estimator.model": "TrainPredictionReduced"},
}  # fmt: skip
"""Filter → changes of the scenario that select it."""


@cache
def _campaign() -> Campaign:
    return load_campaign(shelf("campaigns")["table1"])


def planned(equipment: str, law: str, scenario: str) -> Scenario:
    """Return the scenario of a stop of the campaign."""
    return next(stop.scenario for stop in _campaign().stops if stop.name == f"{scenario}-{equipment}-{law}")


def limited(quick: bool) -> list[dict[str, str]]:
    """Return equipment, law and rail of the stops with a law that has a limit of adhesion."""
    equipment = ("ideal",) if quick else ("ideal", "instant", "service")
    laws = ("adhesion_literal", "adhesion_based", "slope_seeking")
    of_stops = (stop.variants for stop in _campaign().stops)
    return [
        {"equipment": one["equipment"], "law": one["controller"], "scenario": one["scenario"]}
        for one in of_stops
        if one["equipment"] in equipment and one["controller"] in laws
    ]


def guard_row(variant: str, equipment: str, scenario: str, repeats: int) -> dict[str, float | None]:
    """Return the median distance of perturbed stops [m], None if most do not stop, and the longest lock in them [s]."""
    stop = planned(equipment, "adhesion_literal", scenario)
    parameters = GUARDS[variant]
    if variant == list(GUARDS)[-1]:
        tuning = AdhesionBased.load_tuning(stop.actuation.kind, "estimated", period=1.0, adhesion_max=LIMIT)
        parameters = {name: getattr(tuning, name) for name in _BORROWED}
    stops = [
        rg.run(stop.revised({"controller": {"parameters": parameters},
                                "vehicle": {"nudge": {"relative": PERTURBATION, "seed": seed}}}))
        for seed in range(1, repeats + 1)
    ]  # fmt: skip
    median = float(np.median([endless(stop.braking_distance) for stop in stops]))
    lock = max(max(stop.metrics.longest_lock) for stop in stops)
    return {"distance": round(median, 2) if math.isfinite(median) else None, "lock": round(lock, 2)}


def accepted(equipment: str, scenario: str) -> str:
    """Return median, range and longest lock of the accepted repeats of the law as printed."""
    conditioning = _campaign().conditioning
    assert conditioning is not None, "the campaign of Table 1 names the file of its repeats"
    one = read_conditioning(conditioning).stops[f"{scenario}-{equipment}-adhesion_literal"]
    metres = [distance for distance in (one.lots or one.distances) if math.isfinite(distance)]
    lock = locked_text(max(one.figures["longest_lock"]))
    return f"{np.median(metres):.1f} m, {min(metres):.1f} – {max(metres):.1f} m{lock}"


def excess_row(equipment: str, law: str, scenario: str) -> dict[str, float]:
    """Return the maximum adhesion of any group in a stop, and its components.

    `peak`: maximum adhesion; `estimate`: estimated adhesion at that instant; `inertia`: part of the adhesion that
    accelerates the wheelsets, J dω/dt/(r F_z), the rest balances brake and bearings; `speed`: speed of the train at
    that instant [m/s]; `over`: longest time of a group above the limit [s].
    """
    stop = planned(equipment, law, scenario)
    trace = rg.run(stop).trace
    adhesion, time = trace["group_adhesion"].values, trace["time"].values
    instant, group = np.unravel_index(np.argmax(adhesion), adhesion.shape)
    formation = VehicleData(stop).nominal.formation
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


def filter_row(law: str, filter: str, scenario: str) -> dict[str, float]:
    """Return distance [m] and rms error of the estimated adhesion with ideal equipment.

    Schwarz, Posielek and Goetjes (2021), section 2: deflections are readings (6) and states of the prediction (7), but
    the estimator does not necessarily need their readings.
    """
    metrics = rg.run(rg.Scenario.load(scenario, {"controller.kind": law, **FILTERS[filter]})).metrics
    assert metrics.adhesion_rmse is not None, "these laws have a filter"
    return {"distance": metrics.distance, "error": float(np.sqrt(np.mean(np.square(metrics.adhesion_rmse))))}
