"""The few numbers by which a change of the lateral study is seen."""

from collections.abc import Callable
from typing import Any, Final

from railgrip.campaign.workers import workers
from railgrip.report.baseline import Finding
from railgrip.studies.lateral.judge import measure
from railgrip.studies.lateral.run import Case, simulate
from railgrip.studies.lateral.wheelset import CONDITIONS, TESTS

SPEED: Final = 25.0
SEED: Final = 1
TOLERANCE: Final = 0.05
"""Relative, of rms errors: half a million steps of a filter at 1e-7 of its scale are another machine's arithmetic."""
FILTERS: Final = {
    "paper": ("literal", "known_track", "unknown_track"),
    "softer": ("known_track",),
    "slightly_softer": ("known_track",),
    "service": ("known_track", "unknown_track"),
}
"""By plant."""


def headlines(tell: Callable[[str], None]) -> list[Finding]:
    """Return what the filters make of one transition through all conditions, of softer contacts and other sensors."""
    tell("lateral")
    findings: list[Finding] = []
    with workers(2) as pool:
        for plant, measures in zip(FILTERS, pool.map(_measures, FILTERS), strict=True):
            for name in FILTERS[plant]:
                findings += _of_filter(f"lateral, {plant}, {name}", name, measures)
            constant = measures["constant"]["friction"]
            who = f"lateral, {plant}, the best constant"
            findings.append(Finding(f"{who}: friction RMSE", constant, "1", TOLERANCE * constant))
            if measures["observability"] is not None:
                least = min(value for value in measures["observability"]["service"] if value is not None)
                who = f"lateral, {plant}: least sd of mu0, service sensors"
                findings.append(Finding(who, least, "1", TOLERANCE * least))
    return findings


def _measures(plant: str) -> dict[str, Any]:
    return measure(simulate(Case(test=TESTS[-1], speed=SPEED, plant=plant, seed=SEED)), observe=plant == "paper")


def _of_filter(who: str, name: str, measures: dict[str, Any]) -> list[Finding]:
    rms = measures["errors"][name]["friction"]["rmse"]
    findings = [Finding(f"{who}: friction RMSE", rms, "1", TOLERANCE * abs(rms or 1))]
    if name in measures["detection"]:
        counts = measures["detection"][name]["confusion"]
        right = sum(counts[k][k] for k in range(len(CONDITIONS))) / sum(map(sum, counts))
        findings.append(Finding(f"{who}: condition right, share of time", right, "1", 0.01))
    return findings
