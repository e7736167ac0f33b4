"""The search for the parameters of brake control."""

import tomllib
from collections.abc import Iterable
from importlib.resources import files

import numpy as np
import pytest
from command_line import exit_code
from one_process import Here, one_process
from written_campaigns import CAMPAIGNS

from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.campaign.searches import EQUIPMENT, RANGES, Optimum, parameters_of, point_of, search, set_of, text_of
from railgrip.controllers.law import Law
from railgrip.controllers.laws.slip_two_state import SlipLevels
from railgrip.controllers.parameters import SEARCHED, TYPE_TEST, file_of
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.simulate.controller import controller_of
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.type_test.entrants import entrants, training

OF_THE_TEST = [(law, version) for law in sorted(RANGES) for version in TYPE_TEST if set_of(law, version) != SEARCHED]
"""Laws with a set for a version of the type test that is not their only one."""
CASES = [(law, *case) for law, cases in RANGES.items() for case in cases]


def rails_of(campaign: str):
    return [stop.scenario for stop in load_campaign(CAMPAIGNS / f"{campaign}.toml").stops]


@pytest.mark.parametrize("judged", ["table1", "shapes", "unseen", "adverse"])
def test_no_rail_of_a_reported_campaign_is_a_training_rail(judged):
    """Neither the friction nor the seed."""
    trained, other_rails = rails_of("training"), rails_of(judged)
    assert not {s.adhesion.model_dump_json() for s in trained} & {s.adhesion.model_dump_json() for s in other_rails}
    assert not {s.seed for s in trained} & {s.seed for s in other_rails}


def text_with(law: str, version: int | None) -> str:
    return files(registry.LAWS).joinpath(file_of(law, set_of(law, version))).read_text(encoding="utf-8")


def committed(law: str, version: int | None = None):
    return tomllib.loads(text_with(law, version))


SETS = [
    *((*case, None) for case in CASES),
    *(
        (law, "pneumatic", slip, version)
        for law, version in OF_THE_TEST
        for slip in committed(law, version)["pneumatic"]
    ),
]
"""Law, actuation, slip, and the version of the type test that the set is for."""


@pytest.mark.parametrize(("law", "actuation", "slip", "version"), SETS)
def test_optimised_parameters_are_within_their_search_ranges(law, actuation, slip, version):
    """Apart from rounding to two digits."""
    values, ranges = dict(committed(law, version)[actuation][slip]), RANGES[law][actuation, slip]
    if "high" in values:
        values["high_over_low"] = values.pop("high") / values["low"]
    assert set(values) == set(ranges)
    for name, (low, high) in ranges.items():
        assert 0.9 * low <= values[name] <= 1.1 * high


def law_with(actuation: str, slip: str, **controller: str) -> Law:
    """The law of a scenario with this actuation and this source of slip."""
    equipment = CAMPAIGNS.parent / "equipment" / f"{EQUIPMENT[actuation]}.toml"
    table = merge(read_toml(CAMPAIGNS.parent / "library" / "plain.toml"), read_toml(equipment))
    table = merge(table, {"controller": controller})
    if slip == "read":
        table = merge(table, {"estimator": {"kind": "none"}})
    law = controller_of(VehicleData(scenario_of(table, directory=CAMPAIGNS, origin="plain.toml")))
    assert isinstance(law, Law)
    return law


def parameters_in(law: Law, names: Iterable[str]) -> dict[str, float]:
    places = [quantity.name for quantity in law.formula.parameters]
    return {name: law.parameters[places.index(name)] for name in names}


@pytest.mark.parametrize(("law", "actuation", "slip"), [case for case in CASES if case[0].startswith("slip_")])
def test_levels_depend_on_actuation_and_source_of_slip(law, actuation, slip):
    def levels(tuning: str):
        controller = law_with(actuation, slip, kind=law, tuning=tuning)
        return parameters_in(controller, ("low", "high", "hold"))

    hold = law == "slip_three_state"
    assert levels("searched") == committed(law)[actuation][slip] | {"hold": hold}
    assert levels("paper") == {"low": 0.10, "high": 0.15, "hold": hold}


@pytest.mark.parametrize(("law", "actuation", "slip", "version"), [one for one in SETS if one[3]])
def test_a_scenario_uses_the_set_for_the_type_test(law, actuation, slip, version):
    values = dict(committed(law, version)[actuation][slip])
    assert parameters_in(law_with(actuation, slip, kind=law, tuning=TYPE_TEST[version]), values) == values
    assert values != committed(law)[actuation][slip]  # otherwise the assertion above proves nothing


@pytest.mark.parametrize(("law", "version"), OF_THE_TEST)
def test_the_set_for_the_type_test_requires_valves(law, version):
    name = TYPE_TEST[version]
    with pytest.raises(ScenarioError, match=f"tuning '{name}': {law} has no set for ideal .* there is pneumatic"):
        law_with("ideal", "estimated", kind=law, tuning=name)


@pytest.mark.parametrize("version", TYPE_TEST)
def test_each_version_of_the_type_test_has_the_sets_of_its_own_training_cases(version):
    """Levels of publications and those set by hand are named in the entrant."""
    for name, entrant in entrants(version).items():
        controller = entrant.tables["controller"]
        if controller["kind"] in RANGES and entrant.tuned and name != "adhesion_literal":
            assert controller.get("tuning", SEARCHED) == set_of(controller["kind"], version), name


def test_an_unavailable_set_of_a_law_is_refused():
    with pytest.raises(ScenarioError, match=r"tuning is 'type_test'; wheel_reference has searched, type_test_2"):
        law_with("pneumatic", "read", kind="wheel_reference", tuning="type_test")
    with pytest.raises(ScenarioError, match=r"tuning is 'paper'; full_brake has no set"):
        law_with("pneumatic", "read", kind="full_brake", tuning="paper")


def test_a_search_on_training_cases_does_not_change_the_set_of_the_papers(tmp_path, monkeypatch):
    """A law that uses one set for both has one file."""

    def found(law, actuation, slip, *_, rail_stops, **__):
        rails = tuple(stop.variants["rail"] for stop in rail_stops)
        return Optimum(values={"low": 0.05, "high": 0.2}, sets=5, rails=rails, distances=(90.0,), reference=(100.0,))

    monkeypatch.setattr("railgrip.campaign.searches.search", found)
    options = ("--cases", "1", "--budget", "5", "--out", str(tmp_path))
    with one_process():
        code = exit_code("maintain", "tune-control", "--law", "slip_three_state", "--law", "wheel_reference", *options)
    assert code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"slip_three_state.type_test.toml", "wheel_reference.toml"}
    text = (tmp_path / "slip_three_state.type_test.toml").read_text(encoding="utf-8")
    assert "`railgrip maintain tune-control --law slip_three_state --cases 1 --budget 5`" in text
    assert "#   1of1-2021, " in text
    levels = {"low": 0.05, "high": 0.2}
    assert tomllib.loads(text) == {"pneumatic": {"read": levels, "estimated": levels}}


@pytest.mark.parametrize("law", list(RANGES))
def test_the_committed_parameters_result_from_a_search(law):
    """The file includes the distances of the search, as `text_of` writes them."""
    text = text_with(law, None)
    if text.startswith(f"# Parameters of {law} before any search."):
        assert not entrants()[law].tuned  # so comparisons do not present it as tuned
        return
    assert text.startswith(text_of(law, {}).partition(" `")[0])
    assert text.count("% against slip-based control, on:") == len(RANGES[law])


@pytest.mark.parametrize(("law", "version"), OF_THE_TEST)
def test_the_sets_for_the_type_test_result_from_training_cases(law, version):
    text, valves = text_with(law, version), committed(law, version)["pneumatic"]
    command = f"railgrip maintain tune-control --law {law} --cases 16 --budget 32" + (version > 1) * " --version 2"
    assert text.startswith(text_of(law, {}, command).rstrip())
    assert text.count("# The best of 32 sets: ") == len(valves)
    for case in training(16, version):
        assert text.count(f"#   {case.variants['rail']}: ") == len(valves)


def test_every_parameter_is_searched_on_a_logarithmic_scale():
    ranges = RANGES["adhesion_based"]["ideal", "estimated"]
    lowest = np.log([low for low, _ in ranges.values()])
    values = parameters_of(tuple(ranges), lowest)
    assert values == pytest.approx({name: low for name, (low, _) in ranges.items()})
    assert point_of(ranges, values) == pytest.approx(lowest)


def test_every_pair_of_searched_levels_can_switch():
    """At the corners of the range, where rounding to two digits brings them closest."""
    ranges = RANGES["slip_two_state"]["ideal", "read"]
    for low in np.geomspace(*ranges["low"], 200):
        for ratio in ranges["high_over_low"]:
            levels = parameters_of(tuple(ranges), np.log([low, ratio]))
            SlipLevels(**levels)


def test_the_file_states_result_and_training_cases():
    values = {"low": 0.01, "high": 0.02}
    optimum = Optimum(values=values, sets=16, rails=("even", "rough"), distances=(80.0, 90.0), reference=(100.0, 100.0))
    text = text_of("slip_two_state", {("ideal", "read"): optimum})
    assert tomllib.loads(text)["ideal"]["read"] == values
    # The geometric mean of 0.8 and 0.9 is 0.8485.
    assert "The best of 16 sets: -15.1 % against slip-based control" in text
    assert "rough: 90.0 m (100.0 m)" in text


@pytest.fixture(scope="module")
def one_rail(tmp_path_factory):
    """The first training rail, at jogging pace: a real search in seconds."""
    file = tmp_path_factory.mktemp("rails") / "training.toml"
    text = (CAMPAIGNS / "training.toml").read_text(encoding="utf-8")
    first, _, rest = text.partition("[axes.rail.patches]")
    file.write_text(
        first.replace("../library", str(CAMPAIGNS.parent / "library"))
        + "[axes.equipment]"
        + rest.partition("[axes.equipment]")[2].replace("../equipment", str(CAMPAIGNS.parent / "equipment"))
        + '\n[sweep]\n"start.speed" = ["9 km/h"]\n',
        encoding="utf-8",
    )
    return file


@pytest.mark.parametrize(
    ("law", "actuation", "slip"),
    [("adhesion_based", "ideal", "estimated"), ("slip_three_state", "ideal", "read")],
)
def test_a_search_ends_no_worse_than_it_started(law, actuation, slip, one_rail):
    best: list[float] = []
    notify = lambda _, value: best.append(value)
    optimum = search(law, actuation, slip, notify, Here(), rails=one_rail, sets=12)
    assert len(best) >= 2
    assert best == sorted(best, reverse=True)
    assert optimum.rails == ("even",)
    assert optimum.reduction == pytest.approx(best[-1], abs=1e-9)
    assert optimum.reduction < 0.0  # compared with levels of 10 and 15 %, beyond the peak of this rail
    assert optimum.sets >= 12 * len(RANGES[law][actuation, slip])
