"""The few numbers by which a change of a whole study is seen: what `railgrip regress` compares for it.

Each is found in a reduced form of the study, in seconds, from fixed seeds. A tolerance is what another machine's
arithmetic may do to the number: little to a mean over thousands of samples, one sample to an instant, more to the
largest of many errors. A changed law moves it further.
"""

import math
from collections.abc import Callable
from importlib import import_module

import numpy as np

from railgrip import studies
from railgrip.report.baseline import Finding, Findings

Tell = Callable[[str], None]

MEAN, EXTREME = 0.02, 0.10
"""Relative tolerances of means and of the largest of many."""


def headlines(study: str, tell: Tell = lambda what: None) -> Findings:
    """Return the headline numbers of a study.

    Raises:
        EstimationError: There is no such study.
    """
    if study not in STUDIES:
        return studies.headlines(study)
    return Findings(values=tuple(finding for part in STUDIES[study] for finding in part(tell)))


def field(tell: Tell) -> list[Finding]:
    """Return what was recovered of the track in case 6, and the errors of both tuned filters in it."""
    from railgrip.studies.field_test.filtering import filter_of, follow, prediction, task_of
    from railgrip.studies.field_test.noise import LIBRARY, PHYSICAL, load_noise
    from railgrip.studies.field_test.runs import TEST, cases, run
    from railgrip.studies.field_test.score import score, track_score

    tell(f"field test, case {TEST}")
    test_run = run(cases()[TEST], TEST)
    track = track_score(test_run)
    findings = [
        # Of the smoothed motion; 1e-5 are 1 cm over the run.
        Finding(f"field {TEST}: distance, relative error", track["distance"], "1", 1e-5),
        _mean(f"field {TEST}: curvature RMSE", track["curvature"], "1/m"),
        _mean(f"field {TEST}: slope RMSE", track["slope"]),
        _mean(f"field {TEST}: track force RMSE", track["force"], "N"),
    ]
    model = prediction()
    task = task_of(test_run.braking, model)
    filter_ = filter_of(model, task.period)
    noises = {name: load_noise(LIBRARY / f"{name}.toml") for name in ("paper", "consistent")} | {"physical": PHYSICAL}
    scores = {name: score(task, follow(task, filter_, noise)) for name, noise in noises.items()}
    for name, result in scores.items():
        who = f"field {TEST}, noises '{name}'"
        findings += [
            Finding(f"{who}: braking distance, relative error", result["distance"], "1", 5e-5),
            _mean(f"{who}: adhesion RMSE", result["adhesion"]),
            _mean(f"{who}: pad friction RMSE", result["pad_friction"]),
            _mean(f"{who}: mean pad friction RMSE", result["mean_pad_friction"]),
        ]
    best, who = scores["physical"], f"field {TEST}, the best constant"
    return [
        *findings,
        _mean(f"{who}: adhesion RMSE", best["adhesion_constant"]),
        _mean(f"{who}: pad friction RMSE", best["pad_friction_constant"]),
        _mean(f"{who}: mean pad friction RMSE", best["mean_pad_friction_constant"]),
    ]


def type_test(tell: Tell) -> list[Finding]:
    """Return quantiles of the distance over the best tuned baseline's, in six short cases of the training set."""
    from railgrip.assemble import braking_distance
    from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of, training_cases

    taking_part = {name: entrants()[name] for name in ("constant_slip", "extremum_seeking", "slope_seeking")}
    ratios: list[float] = []
    for case in training_cases(6):
        tell(f"type test, {case.name}")
        stops = campaign_of([case], taking_part, train_of(None)).stops
        # What does not stop is endlessly long; a baseline that does not is none to compare with.
        distances = [braking_distance(stop.scenario) or math.inf for stop in stops]
        ratios.append(distances[-1] / min(distances[:-1]))
    who = "slope seeking, distance over that of the better tuned baseline"
    return [_mean(f"{who}: median of 6", float(np.median(ratios))), _mean(f"{who}: worst of 6", max(ratios))]


def _elsewhere(study: str) -> Callable[[Tell], list[Finding]]:
    """Return the headlines of a study that has a module of its own for them, loaded when they are asked for."""
    return lambda tell: import_module(f"railgrip.studies.{study}.headline").headlines(tell)


STUDIES: dict[str, tuple[Callable[[Tell], list[Finding]], ...]] = {
    "field_test": (field,),
    "learn": (_elsewhere("axle_box"),),
    "type_test": (type_test,),
}


def _mean(name: str, value: float, unit: str = "1") -> Finding:
    return Finding(name, value, unit, MEAN * abs(value))
