"""The search for the parameters of brake control."""

import tomllib
from dataclasses import fields
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from one_process import Here

from railgrip.assemble.controller import controller_of
from railgrip.assemble.vehicle import VehicleData
from railgrip.campaign.tune_control import EDGES, RANGES, Optimum, parameters_of, search, text_of
from railgrip.controllers.adhesion_based import PeakSeekingTuning
from railgrip.controllers.slip_based import SlipBased, SlipLevels
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.scenario.merge import merged
from railgrip.studies.type_test.entrants import entrants

CAMPAIGNS = Path(__file__).parents[2] / "harness" / "scenario" / "campaigns"
CASES = [(law, *case) for law, cases in RANGES.items() for case in cases]


def rails_of(campaign: str):
    return [stop.scenario for stop in load_campaign(CAMPAIGNS / f"{campaign}.toml").stops]


@pytest.mark.parametrize("judged", ["table1", "shapes", "unseen", "adverse"])
def test_no_result_is_reported_of_a_rail_that_was_trained_on(judged):
    """Neither the friction nor the draw of chance."""
    trained, other_rails = rails_of("training"), rails_of(judged)
    assert not {s.adhesion.model_dump_json() for s in trained} & {s.adhesion.model_dump_json() for s in other_rails}
    assert not {s.seed for s in trained} & {s.seed for s in other_rails}


def committed(law: str):
    return tomllib.loads(files("railgrip.controllers").joinpath(f"{law}.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("law", "actuation", "slip"), CASES)
def test_what_was_found_lies_where_it_was_searched(law, actuation, slip):
    """Within a rounding to two digits."""
    values, ranges = dict(committed(law)[actuation][slip]), RANGES[law][actuation, slip]
    if "high" in values:
        values["high_over_low"] = values.pop("high") / values["low"]
    assert set(values) == set(ranges)
    for name, (low, high) in ranges.items():
        assert 0.9 * low <= values[name] <= 1.1 * high


@pytest.mark.parametrize(("law", "actuation", "slip"), [case for case in CASES if case[0].startswith("slip_")])
def test_a_scenario_takes_the_levels_of_its_actuation_and_of_how_it_knows_the_slip(law, actuation, slip):
    edge = CAMPAIGNS.parent / "edges" / f"{EDGES[actuation]}.toml"
    table = merged(read_toml(CAMPAIGNS.parent / "library" / "plain.toml"), read_toml(edge))
    table = merged(table, {"controller": {"kind": law}})
    if slip == "read":
        table = merged(table, {"estimator": {"kind": "none"}})

    def levels(tuning: str):
        variant = merged(table, {"controller": {"tuning": tuning}})
        scenario = scenario_of(variant, directory=CAMPAIGNS, origin="plain.toml")
        controller = controller_of(VehicleData(scenario))
        assert isinstance(controller, SlipBased)
        names = [quantity.name for quantity in controller.formula.parameters]
        return {name: controller.parameters[names.index(name)] for name in ("low", "high", "hold")}

    hold = law == "slip_three_state"
    assert levels("searched") == committed(law)[actuation][slip] | {"hold": hold}
    assert levels("paper") == {"low": 0.10, "high": 0.15, "hold": hold}


@pytest.mark.parametrize("law", list(RANGES))
def test_the_committed_parameters_are_those_of_a_search(law):
    """With the distances they were found by, as `text_of` writes them."""
    text = files("railgrip.controllers").joinpath(f"{law}.toml").read_text(encoding="utf-8")
    if text.startswith(f"# Parameters of {law} before any search."):
        assert not entrants()[law].tuned  # so nobody is compared with it as with a tuned one
        return
    assert text.startswith(text_of(law, {}).partition(" `")[0])
    assert text.count("% against slip-based control, on:") == len(RANGES[law])


def test_every_parameter_is_searched_on_its_logarithm():
    ranges = RANGES["adhesion_based"]["ideal", "estimated"]
    values = parameters_of(tuple(ranges), np.log([low for low, _ in ranges.values()]))
    assert values == pytest.approx({name: low for name, (low, _) in ranges.items()})


def test_every_pair_of_levels_that_is_searched_can_switch():
    """At the corners, where rounding to two digits brings them closest."""
    ranges = RANGES["slip_two_state"]["ideal", "read"]
    for low in np.geomspace(*ranges["low"], 200):
        for ratio in ranges["high_over_low"]:
            levels = parameters_of(tuple(ranges), np.log([low, ratio]))
            SlipLevels(**levels, speed_min=0.5, hold=False)


def test_the_file_says_what_was_found_and_on_what():
    values = {"low": 0.01, "high": 0.02}
    optimum = Optimum(values=values, sets=16, rails=("even", "rough"), distances=(80.0, 90.0), reference=(100.0, 100.0))
    text = text_of("slip_two_state", {("ideal", "read"): optimum})
    assert tomllib.loads(text)["ideal"]["read"] == values
    # The geometric mean of 0.8 and 0.9 is 0.8485.
    assert "The best of 16 sets: -15.1 % against slip-based control" in text
    assert "rough: 90.0 m (100.0 m)" in text


def test_all_that_is_searched_is_a_parameter_of_its_law():
    for cases in RANGES["adhesion_based"].values():
        assert set(cases) < {field.name for field in fields(PeakSeekingTuning)}


@pytest.fixture(scope="module")
def one_rail(tmp_path_factory):
    """The first training rail, from a jogging pace: a run of the real thing in seconds."""
    file = tmp_path_factory.mktemp("rails") / "training.toml"
    text = (CAMPAIGNS / "training.toml").read_text(encoding="utf-8")
    first, _, rest = text.partition("[axes.rail.patches]")
    file.write_text(
        first.replace("../library", str(CAMPAIGNS.parent / "library"))
        + "[axes.edge]"
        + rest.partition("[axes.edge]")[2].replace("../edges", str(CAMPAIGNS.parent / "edges"))
        + '\n[sweep]\n"start.speed" = ["9 km/h"]\n',
        encoding="utf-8",
    )
    return file


@pytest.mark.parametrize(
    ("law", "actuation", "slip"),
    [("adhesion_based", "ideal", "estimated"), ("slip_three_state", "ideal", "read")],
)
def test_a_search_ends_no_worse_than_it_began(law, actuation, slip, one_rail):
    best: list[float] = []
    tell = lambda _, value: best.append(value)
    optimum = search(law, actuation, slip, tell, Here(), rails=one_rail, sets=12)
    assert len(best) >= 2
    assert best == sorted(best, reverse=True)
    assert optimum.rails == ("even",)
    assert optimum.reduction == pytest.approx(best[-1], abs=1e-9)
    assert optimum.reduction < 0.0  # against levels of 10 and 15 %, beyond the peak of this rail
    assert optimum.sets >= 12 * len(RANGES[law][actuation, slip])
