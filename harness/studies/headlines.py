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
    "type_test": (type_test,),
}


def _mean(name: str, value: float, unit: str = "1") -> Finding:
    return Finding(name, value, unit, MEAN * abs(value))
