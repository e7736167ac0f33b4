"""The studies behind baselines, and the files that keep what was accepted of them."""

from pathlib import Path

import pytest

from harness.estimate.error import EstimationError
from harness.headlines import STUDIES, headlines
from harness.verdict.baseline import load_baseline

BASELINES = Path(__file__).parents[1] / "baselines"


def test_a_study_that_is_not_there_gets_a_sentence():
    with pytest.raises(EstimationError, match="there is no study 'estimation'; there is estimate"):
        headlines("estimation")


@pytest.mark.parametrize("path", sorted(BASELINES.glob("*.toml")), ids=lambda path: path.stem)
def test_every_baseline_is_of_something_that_can_be_run_and_accepts_something(path):
    baseline = load_baseline(path)
    assert baseline.accepted
    if baseline.campaign is None:
        assert baseline.study in STUDIES
    else:
        assert (path.parent / baseline.campaign).exists()


def test_the_accepted_figures_are_what_was_asked_for():
    """Adhesion within 0.02 outside protection events, above it no longer than 0.1 s; distance within 0.5 %; ten stops."""
    figures = load_baseline(BASELINES / "estimate.toml").figures
    for scenario in ("slide", "sand"):
        for of in ("paper", "own"):
            assert figures[f"rig-{scenario}, rig-{of}: adhesion error outside protection events"].value <= 0.02
            assert figures[f"rig-{scenario}, rig-{of}: longest adhesion error above 0.02"].value <= 0.1
    assert abs(figures["field c6: distance, relative error"].value) <= 5e-3
    for noises in ("paper", "consistent"):
        assert abs(figures[f"field c6, noises '{noises}': braking distance, relative error"].value) <= 5e-3
    assert figures["monitor: stops until lost friction is found"].value <= 10
    assert figures["monitor: stops until a sticking brake is found"].value <= 10
    assert figures["monitor: false alarms"].value == 0
