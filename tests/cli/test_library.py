"""Names of the library are listed with a description, accepted by every command, and unambiguous."""

import json
from pathlib import Path

from users_parts import install_part

import railgrip as rg
from railgrip.base import registry
from railgrip.scenario.campaign import load_campaign

LIST = {kind: registry.meanings(kind) for kind in registry.SECTIONS}


def test_list_prints_every_name_of_every_kind_with_a_description(railgrip):
    result = railgrip("list", "--json")
    assert result.code == 0
    listed = json.loads(result.out)
    assert listed == LIST
    assert all(meaning and "\n" not in meaning for names in listed.values() for meaning in names.values())
    package = Path(rg.__file__).parent
    folders = {"scenarios": "scenario/library", "curves": "scenario/creep_curves", "trains": "scenario/trains"}
    for kind, folder in folders.items():
        assert sorted(listed[kind]) == sorted(path.stem for path in (package / folder).glob("*.toml"))


def test_an_installed_part_is_listed(railgrip, tmp_path_factory, monkeypatch):
    folder = tmp_path_factory.mktemp("site")
    install_part(folder, "controllers", "laws:Hold")
    monkeypatch.syspath_prepend(folder)
    registry.installed_names.cache_clear()
    try:
        assert "Installed: laws:Hold" in railgrip("list", "controllers").out
    finally:
        registry.installed_names.cache_clear()


def test_a_file_takes_precedence_over_a_name_of_the_library(railgrip, project):
    (project / "trapezoid").write_text((project / "wet.toml").read_text(encoding="utf-8"), encoding="utf-8")
    assert "wet: standstill" in railgrip("run", "trapezoid", "--set", "start.speed=36 km/h").out


def test_a_campaign_names_scenarios_and_equipment_of_the_library(railgrip, project):
    text = 'name = "both"\nscenarios = ["plain"]\n[axes.equipment]\nideal = "ideal"\nvalves = "{}"\n'
    (project / "both.toml").write_text(text.format("service"), encoding="utf-8")
    kinds = {stop.name: stop.scenario.sensors.kind for stop in load_campaign(project / "both.toml").stops}
    assert kinds == {"plain-ideal": "ideal", "plain-valves": "service"}
    (project / "both.toml").write_text(text.format("servce"), encoding="utf-8")
    result = railgrip("campaign", "both.toml")
    assert "both.toml: [axes.equipment] valves: servce: there is no such file, and no set of equipment" in result.err
    assert "did you mean service?" in result.err


def test_a_part_by_name_equals_the_scenario_with_that_kind():
    short = rg.Scenario.load("trapezoid", {"limits.horizon": "0.2 s", "estimator.kind": "none"})
    by_name = rg.run(short, controller="slip_two_state", estimator="compiled")
    by_key = rg.run(short.changed({"controller.kind": "slip_two_state", "estimator.kind": "compiled"}))
    assert by_name.scenario.resolved() == by_key.scenario.resolved()
    swept = rg.sweep(short, {"seed": [1]}, controller="full_brake")
    assert swept.to_pandas()["outcome"].tolist() == ["horizon"]
    with rg.open(short, estimator="compiled") as bench:
        assert bench.reset().adhesion is not None
