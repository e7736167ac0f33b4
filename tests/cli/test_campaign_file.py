"""A campaign file yields every combination that it names; an entry that would match nothing is refused."""

import json
import re

import pytest
from wrong import table

from railgrip.base.errors import ScenarioError
from railgrip.scenario.campaign import load_campaign, selection_of


def campaign(project, text):
    path = project / "campaign.toml"
    path.write_text(f'name = "c"\nscenarios = ["wet.toml"]\n{text}', encoding="utf-8")
    return load_campaign(path)


def test_stops_are_the_product_of_axes_and_sweeps(project):
    plan = campaign(
        project,
        "[axes.equipment.a]\nseed = 1\n[axes.equipment.b]\nseed = 2\n"
        '[sweep]\n"start.speed" = ["80 km/h", "100 km/h", 30]\n',
    )
    assert [stop.name for stop in plan.stops][:2] == ["wet-a-80_km_h", "wet-a-100_km_h"]
    assert len(plan.stops) == 6
    assert plan.stops[-1].variants == {"scenario": "wet", "equipment": "b", "start.speed": "30"}
    assert plan.stops[-1].scenario.start.speed == 30.0
    assert plan.stops[-1].scenario.seed == 2


def test_a_variant_may_be_a_file_next_to_the_campaign(project):
    (project / "slow.toml").write_text('[start]\nspeed = "18 km/h"\n', encoding="utf-8")
    plan = campaign(project, '[axes.pace]\nslow = "slow.toml"\nquick = { start.speed = 20 }\n')
    assert {stop.name: stop.scenario.start.speed for stop in plan.stops} == {"wet-slow": 5.0, "wet-quick": 20.0}


def test_exclusions_and_references_match_by_axis(project):
    plan = campaign(
        project,
        "[axes.equipment.a]\n[axes.equipment.b]\n[axes.x.p]\n[axes.x.q]\n"
        '[[exclude]]\nequipment = "b"\nx = ["p"]\n'
        '[[reference]]\nmatch = { scenario = "wet", equipment = "a" }\ndistance = "100 m"\nsource = "a book"\n',
    )
    assert [stop.name for stop in plan.stops] == ["wet-a-p", "wet-a-q", "wet-b-q"]
    assert [bool(plan.reference_for(stop)) for stop in plan.stops] == [True, True, False]


def test_each_matching_stop_is_repeated_for_each_drawn_seed_without_a_trace(project):
    plan = campaign(
        project,
        '[draws]\nfirst = 3\nlast = 5\nmatch = { rail = "drawn" }\n'
        "[axes.rail.drawn]\n[axes.rail.slow]\nseed = 7\n[axes.pace]\nslow.start.speed = 10\nquick = {}\n",
    )
    drawn = [stop for stop in plan.stops if "draw" in stop.variants]
    assert [stop.name for stop in plan.stops][:4] == [f"wet-drawn-slow-{n}" for n in (3, 4, 5)] + ["wet-drawn-quick-3"]
    assert [stop.scenario.seed for stop in drawn] == [3, 4, 5, 3, 4, 5]
    assert [stop.variants["draw"] for stop in drawn] == ["3", "4", "5", "3", "4", "5"]
    assert [stop.scenario.start.speed for stop in drawn][:3] == [10, 10, 10]
    assert not any(stop.keep_trace for stop in drawn)
    # Stops that do not match the draws run once, with their own seed, and keep their traces.
    assert [(stop.scenario.seed, stop.keep_trace) for stop in plan.stops if stop not in drawn] == [(7, True)] * 2


def test_draws_of_sensors_with_a_seed_of_their_own_are_refused(project):
    """All draws would have one lot of sensors: the distribution would look narrower than it is."""
    lots = '[axes.equipment]\na = "service"\n[axes.lot.a]\nsensors.seed = 5\n'
    assert campaign(project, lots).stops[0].scenario.sensors.seed == 5
    with pytest.raises(ScenarioError, match=r"\[sensors\] seed is 5, so that all draws would have the same sensors"):
        campaign(project, lots + "[draws]\nfirst = 1\nlast = 2\n")


def test_the_first_matching_entry_gives_the_expected_outcome(project):
    plan = campaign(
        project,
        "[axes.e.a]\n[axes.e.b]\nseed = 4\n[draws]\nfirst = 1\nlast = 2\nmatch = { e = 'a' }\n"
        '[[expected]]\nmatch = { draw = "2" }\noutcome = "horizon"\n'
        '[[expected]]\nmatch = { e = "a" }\noutcome = "diverged"\n',
    )
    assert {stop.name: stop.expected.value for stop in plan.stops} == {
        "wet-a-1": "diverged", "wet-a-2": "horizon", "wet-b": "standstill",
    }  # fmt: skip


def test_a_drawn_scenario_equals_the_file_with_that_seed(project):
    (drawn,) = campaign(project, "[draws]\nfirst = 42\nlast = 42\n").stops
    (written,) = campaign(project, "[sweep]\nseed = [42]\n").stops
    assert drawn.scenario.digest() == written.scenario.digest()


@pytest.mark.usefixtures("in_process")
def test_selected_stops_are_repeated_and_the_others_kept(railgrip, project):
    text = (project / "pair.toml").read_text(encoding="utf-8")
    (project / "pair.toml").write_text(f'conditioning = "pair.json"\n{text}', encoding="utf-8")
    file = project / "pair.json"
    assert railgrip("tools", "conditioning", "pair.toml", "--repeats", 2).code == 0
    before = json.loads(file.read_text(encoding="utf-8"))["stops"]
    assert railgrip("tools", "conditioning", "pair.toml", "--repeats", 3, "--stops", min(before)).code == 0
    after = json.loads(file.read_text(encoding="utf-8"))["stops"]
    assert {name: len(stop["distances"]) for name, stop in after.items()} == dict.fromkeys(before, 2) | {min(before): 3}
    result = railgrip("tools", "conditioning", "pair.toml", "--stops", "no-such-stop")
    assert result.refuses("pair.toml has no such stop")
    result = railgrip("tools", "conditioning", "pair.toml", "--stops", min(before), "--relative", "1e-6")
    assert result.refuses("was moved by 1e-07")


MANY = {
    "1e10 combinations, all excluded": [
        *("[axes]", *(f"a{n}.v{m} = {{}}" for n in range(10) for m in range(10))),
        "[[exclude]]",
    ],
    "10^300 combinations": ["[axes]"] + [f"a{n}.v{m} = {{}}" for n in range(300) for m in range(10)],
    "a sweep of 2e5 values": [f'[sweep]\n"start.speed" = {list(range(200_000))}'],
    "draws up to the largest seed": [f"[draws]\nfirst = 0\nlast = {2**63 - 1}"],
    "1e3 combinations of 1e3 draws": [
        *("[draws]\nfirst = 1\nlast = 1000", "[axes]"),
        *(f"a{n}.v{m} = {{}}" for n in range(3) for m in range(10)),
    ],
}


@pytest.mark.parametrize("lines", MANY.values(), ids=MANY)
def test_a_campaign_of_too_many_stops_is_refused_before_any_is_created(project, monkeypatch, lines):
    monkeypatch.setattr("railgrip.scenario.campaign.PlannedStop", lambda **_: pytest.fail("a stop was created"))
    with pytest.raises(ScenarioError, match=r"campaign.toml: has .* a campaign may have 100,000"):
        campaign(project, "\n".join(lines))


TWO_AXES = """
sweep = { seed = [1, 2, 3] }
[axes.controller.brake]
controller.kind = "full_brake"
[axes.controller.slip]
controller.kind = "slip_two_state"
[[exclude]]
controller = "brake"
seed = "3"
"""


@pytest.mark.parametrize(
    ("choices", "names"),
    [
        ([], ["brake-1", "brake-2", "slip-1", "slip-2", "slip-3"]),
        (["controller=slip"], ["slip-1", "slip-2", "slip-3"]),
        (["seed=1,3"], ["brake-1", "slip-1", "slip-3"]),
        (["controller=brake", "seed=2,3"], ["brake-2"]),
    ],
)
def test_some_variants_of_a_campaign_are_selected(project, choices, names):
    selected = selection_of(campaign(project, TWO_AXES), choices)
    assert sorted("-".join(stop.variants[axis] for axis in ("controller", "seed")) for stop in selected.stops) == names


@pytest.mark.parametrize(("choices", "sentence"), table(__file__, "tables.toml")["wrong_selections"])
def test_a_wrong_selection_is_refused_with_the_names_that_exist(project, choices, sentence):
    with pytest.raises(ScenarioError, match=re.escape(sentence)):
        selection_of(campaign(project, TWO_AXES), choices)


def test_thousands_of_entries_that_match_are_refused_in_one_sentence(project):
    with pytest.raises(ScenarioError, match="exclude"):
        campaign(project, "[axes.e.a]\n" + '[[exclude]]\ne = "a"\n' * 2000)
