"""The few numbers by which a change of the study of learned friction is seen."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from railgrip.campaign.workers import workers
from railgrip.estimators.learned.channels import COMBINATIONS
from railgrip.report.baseline import Finding
from railgrip.studies.axle_box.evaluate import Recipe, exchanged, within_runs, without_each
from railgrip.studies.axle_box.gather import run_of, spectral_features
from railgrip.studies.axle_box.instrumented_car import MPH
from railgrip.studies.axle_box.reduction import CHANNELS, SPECTRAL
from railgrip.studies.axle_box.runs import campaign
from railgrip.studies.axle_box.study import FULL, dry_or_not, passes

SPEED: Final = 60
"""mph, the shortest runs."""
LENGTH: Final = 200.0
"""m, half of the paper's."""
TRAINED: Final = 0.5
"""Relative tolerance of errors of networks: rounding sends training to another of its minima, some of them no better.
A plant, filter or split that has changed moves them by more."""
LEVEL: Final = 1e-3
"""Relative tolerance of means over signals, which no training stands behind."""


def headlines(tell: Callable[[str], None]) -> list[Finding]:
    """Return errors of the paper's networks at one speed, and levels and features of what they were trained on."""
    tell(f"learn, six runs at {SPEED} mph")
    recipe = Recipe(starts=3)
    with workers(2) as pool:
        runs = list(pool.map(run_of, [run for run in campaign(length=LENGTH) if run.speed == SPEED * MPH]))
        tell("learn, training")
        training = {
            "bias inside": pool.submit(within_runs, runs, recipe),
            "bias outside": pool.submit(within_runs, runs, replace(recipe, bias="outside")),
            "labels exchanged": pool.submit(within_runs, runs, recipe, exchanged),
            "a run left out": pool.submit(without_each, runs, replace(recipe, starts=1)),
        }
        scores = {name: one.result() for name, one in training.items()}
    who = f"learn {SPEED} mph"
    findings = [Finding(f"{who}, {name}: MAE", score.mae, "1", TRAINED * score.mae) for name, score in scores.items()]
    mean = scores["bias inside"].mae_of_mean
    findings.append(Finding(f"{who}, always the mean: MAE", mean, "1", LEVEL * mean))
    sets = passes(FULL)
    reports = dry_or_not(sets)["campaign"]
    rule = float(np.mean([abs(run.friction - reports[run.name]) for run in sets["campaign"]]))
    findings.append(Finding("learn, dry or not: MAE", rule, "1", LEVEL * rule))
    for motion in COMBINATIONS["longitudinal, lateral, yaw"]:
        level = float(np.mean([run.blocks[:, CHANNELS[motion]].mean() for run in runs]))
        findings.append(Finding(f"{who}, {motion}: mean of blocks", level, "m/s2", LEVEL * level))
    features = np.mean([spectral_features(run)[-1] for run in runs], axis=0)
    for name in ("lateral over yaw leading, 2 Hz", "quadrature leading, 4 Hz"):
        value = float(features[SPECTRAL.names.index(name)])
        findings.append(Finding(f"{who}, {name}", value, "1", LEVEL))
    return findings
