"""The search for the parameters of adhesion-based control."""

import tomllib
from dataclasses import fields
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from controllers.adhesion_based import SeekerTuning
from controllers.tuning import SEEKER
from harness.scenario.campaign import load_campaign
from harness.tune_control import RANGES, Found, search, text_of, values_of

CAMPAIGNS = Path(__file__).parents[2] / "harness" / "scenario" / "campaigns"


def rails_of(campaign: str):
    return [stop.scenario for stop in load_campaign(CAMPAIGNS / f"{campaign}.toml").stops]


@pytest.mark.parametrize("judged", ["table1", "shapes", "unseen"])
def test_no_result_is_reported_of_a_rail_that_was_trained_on(judged):
    """Neither the friction nor the draw of chance."""
    trained, shown = rails_of("training"), rails_of(judged)
    assert not {s.adhesion.model_dump_json() for s in trained} & {s.adhesion.model_dump_json() for s in shown}
    assert not {s.seed for s in trained} & {s.seed for s in shown}


@pytest.mark.parametrize("actuation", list(RANGES))
def test_what_was_found_lies_where_it_was_searched(actuation):
    for name, (low, high) in RANGES[actuation].items():
        assert low <= getattr(SEEKER[actuation], name) <= high


def test_every_parameter_is_searched_on_its_logarithm():
    names = tuple(RANGES["ideal"])
    values = values_of(names, np.log([RANGES["ideal"][name][0] for name in names]))
    assert values == pytest.approx({name: low for name, (low, _) in RANGES["ideal"].items()})


def test_the_file_says_what_was_found_and_on_what():
    values = {name: low for name, (low, _) in RANGES["ideal"].items()}
    found = Found(values=values, rails=("even", "rough"), distances=(80.0, 90.0), slip_based=(100.0, 100.0))
    text = text_of({"ideal": found})
    assert tomllib.loads(text)["ideal"] == values
    assert set(values) < {field.name for field in fields(SeekerTuning)}
    # The geometric mean of 0.8 and 0.9 is 0.8485.
    assert "-15.1 % against slip-based control" in text
    assert "rough: 90.0 m (100.0 m)" in text


def test_a_search_ends_no_worse_than_it_began(tmp_path):
    """Three generations of eight sets on one rail, from a jogging pace: a run of the real thing in seconds."""
    rails = tmp_path / "training.toml"
    text = (CAMPAIGNS / "training.toml").read_text(encoding="utf-8")
    first, _, rest = text.partition("[axes.rail.patches]")
    rails.write_text(
        first.replace("../library", str(CAMPAIGNS.parent / "library"))
        + "[axes.edge]"
        + rest.partition("[axes.edge]")[2].replace("../edges", str(CAMPAIGNS.parent / "edges")),
        encoding="utf-8",
    )
    rails.write_text(rails.read_text(encoding="utf-8") + '\n[sweep]\n"start.speed" = ["9 km/h"]\n', encoding="utf-8")
    best: list[float] = []
    found = search("ideal", lambda number, value: best.append(value), rails=rails, population=8, generations=2)
    assert len(best) == 2
    assert best[1] <= best[0]
    assert found.rails == ("even",)
    assert found.reduction == pytest.approx(best[-1], abs=1e-9)
    for name, value in found.values.items():
        low, high = RANGES["ideal"][name]
        assert 0.99 * low <= value <= 1.01 * high


def test_the_committed_parameters_are_those_of_a_search():
    """With the distances they were found by, as `text_of` writes them."""
    text = files("controllers").joinpath("seeker.toml").read_text(encoding="utf-8")
    assert text.startswith(text_of({}).rstrip())
    for actuation, ranges in RANGES.items():
        assert set(tomllib.loads(text)[actuation]) == set(ranges)
    assert text.count("% against slip-based control, on:") == len(RANGES)
