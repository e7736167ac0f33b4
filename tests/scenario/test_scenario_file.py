"""A scenario file is read completely and exactly, or refused in sentences that name file, table and key."""

from fractions import Fraction
from pathlib import Path

import pytest
from synthetic import LIBRARY

from railgrip.api import Scenario
from railgrip.base.errors import ScenarioError
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.schema import SAMPLES

TRAPEZOID = LIBRARY / "trapezoid.toml"
VALVES = ["vehicle.plant=TwoPartTrainPneumatic", "actuation.kind=pneumatic"]


def test_units_are_converted_and_bare_numbers_are_si():
    assert load(TRAPEZOID, ["start.speed=36 km/h"]).start.speed == pytest.approx(10.0)
    assert load(TRAPEZOID, ["start.speed=10"]).start.speed == 10.0
    assert load(TRAPEZOID, ["adhesion.conditioning.fraction=12 %"]).adhesion.conditioning.fraction == 0.12
    assert load(TRAPEZOID, ["periods.trace=5 ms"]).periods.steps_of("trace") == 5


def test_a_resolved_scenario_loads_to_the_same_scenario():
    scenario = load(TRAPEZOID, ['vehicle.parameters.p_max=["3.4 bar", 2e5]', "limits.alpha_max=tsi_short_formation"])
    again = scenario_of(scenario.resolved(), directory=TRAPEZOID.parent, origin="again")
    assert again == scenario
    assert again.digest() == scenario.digest()
    assert scenario.limits.alpha_max == 0.13
    assert scenario.vehicle.parameters["p_max[1]"].si("Pa") == pytest.approx(3.4e5)
    assert scenario.vehicle.parameters["p_max[2]"].si("Pa") == 2e5


def test_a_foreign_plant_is_mapped_by_name_list_or_table():
    entries = ["speed='train.v'", "mu0={ variable = 'rail[{i}].grip', scale = 0.01 }", "slip=['a', 'b', 'c', 'd']"]
    scenario = load(TRAPEZOID, [f"vehicle.map.{entry}" for entry in entries])
    assert scenario.vehicle.map["speed"] == "train.v"
    assert scenario.vehicle.map["mu0"] == {"variable": "rail[{i}].grip", "scale": 0.01}
    again = scenario_of(scenario.resolved(), directory=TRAPEZOID.parent, origin="again")
    assert again.digest() == scenario.digest()


def test_omitted_tables_are_not_part_of_the_resolved_scenario():
    """The digest equals that of results written before these tables existed."""
    resolved = load(LIBRARY / "plain.toml").resolved()
    assert not {"demand", "faults", "truth", "sanders"} & set(resolved)
    assert not {"recovery", "sand"} & set(resolved["adhesion"])


def test_the_digest_depends_on_values_and_not_on_spelling():
    base = load(TRAPEZOID).digest()
    assert load(TRAPEZOID, ["start.speed=80000 m/h"]).start.speed == pytest.approx(load(TRAPEZOID).start.speed)
    assert load(TRAPEZOID, ["limits.horizon=90"]).digest() == base
    assert load(TRAPEZOID, ["seed=7"]).digest() != base


LINE = {"origin": 0.0, "direction": "rising"}


@pytest.mark.parametrize(
    ("key", "table", "content"),
    [
        ("adhesion", {"kind": "table", "polach": "dry", "file": "own.csv"}, "time,mu0\n0,0.1\n9,0.2\n"),
        ("demand", {"file": "own.csv"}, "time,pressure\n0,0\n1,100000.2\n"),
        ("track", {"line": LINE | {"file": "own.csv"}}, "distance,slope\n0,0.005\n9000,0.002\n"),
    ],
)
def test_the_digest_depends_on_the_content_of_named_files(tmp_path, key, table, content):
    def written(text):
        (tmp_path / "own.csv").write_text(text, encoding="utf-8")
        tables = load(TRAPEZOID).resolved() | {key: table}
        return scenario_of(tables, directory=tmp_path, origin="mine.toml")

    scenario = written(content)
    assert written(content).digest() == scenario.digest() != written(content.replace("2\n", "3\n")).digest()
    assert "own.csv" in str(scenario.resolved())
    assert str(tmp_path) not in str(scenario.resolved())


def test_a_named_polach_set_becomes_the_plants_parameters():
    polach = load(TRAPEZOID, ["adhesion.polach=dry"]).adhesion.polach
    # Polach, Wear 258 (2005) 992, dry.
    assert polach.plant_parameters() == {"k_A": 1.0, "k_S": 0.4, "A_falling": 0.4, "B_falling": 0.6}


def test_a_missing_copy_of_a_recipe_is_refused_with_the_command_that_creates_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ScenarioError, match=r"--set at the current folder; `railgrip build ForeignTrain` makes one"):
        load(TRAPEZOID, ["vehicle.plant=build/fmus/ForeignTrain.fmu"])


def test_a_path_on_the_command_line_is_relative_to_the_current_folder(tmp_path, monkeypatch):
    """Wherever the scenario is; written files contain it relative to the folder of the scenario, like all others."""
    (tmp_path / "mine.fmu").write_bytes(b"")
    monkeypatch.chdir(tmp_path)
    vehicle = load(Path("foreign_train"), ["vehicle.plant=mine.fmu"]).vehicle
    assert vehicle.plant is not None
    assert vehicle.plant.path.resolve() == tmp_path / "mine.fmu"
    assert (LIBRARY / vehicle.plant.entry).resolve() == tmp_path / "mine.fmu"


@pytest.mark.parametrize("override", ["start.speed", "=3", "start.speed=", "vehicle.parameters.r[2]=3"])
def test_an_override_without_key_or_value_is_refused(override):
    with pytest.raises(ScenarioError, match="--set "):
        load(TRAPEZOID, [override])


@pytest.mark.parametrize(
    "step", ["1 ms", "2 ms", "5 ms", "10 ms", "0.5 ms", "0.25 ms", "2.5 ms", "0.1 ms", "0.4 ms", "0.8 ms", "0.3 ms"]
)
def test_no_communication_step_ends_on_a_sample_of_the_valves(step):
    """By enumeration, for two thousand steps; coinciding instants are half of the common divisor apart."""
    milliseconds = Fraction(step.removesuffix(" ms"))
    scenario = load(TRAPEZOID, [*VALVES, f"periods.communication={step}"])
    begin = Fraction(scenario.plant_begin).limit_denominator(10**9) * 1000
    away = [abs((begin + k * milliseconds - Fraction("0.5") + 1) % 2 - 1) for k in range(2000)]
    assert min(away) > 0
    if begin:
        assert min((k * milliseconds - Fraction("0.5")) % 2 for k in range(2000)) == 0
        assert min(away) == begin < milliseconds
    assert load(TRAPEZOID, [f"periods.communication={step}"]).plant_begin == 0.0


PERIODS = ["periods.estimator=1 ms", "periods.controller=10 ms", "controller.kind=full_brake"]


@pytest.mark.parametrize(
    ("step", "periods"),
    [
        ("0.25 ms", {"estimator": 4, "controller": 40, "trace": 40}),
        ("2 ms", {"estimator": 1, "controller": 5, "trace": 5}),
        ("4 ms", {"estimator": 1, "controller": Fraction(5, 2), "trace": 2}),
        ("5 ms", {"estimator": 1, "controller": 2, "trace": 2}),
        ("20 ms", {"estimator": 1, "controller": 1, "trace": 1}),
    ],
)
def test_any_periods_are_possible_with_any_communication_step(step, periods):
    """Shorter periods become the step; rows of the trace are as close to their period as whole steps allow."""
    loaded = load(TRAPEZOID, [f"periods.communication={step}", *PERIODS])
    assert {name: loaded.periods.steps_of(name) for name in periods} == periods
    assert loaded.periods.estimator == max(1e-3, loaded.periods.communication)


@pytest.mark.parametrize(
    ("points", "lines"),
    [([["x", 0.1]], 1), ([["x", 0.1], [1.0, "y"]], 2), ([[0.0, 0.1], ["x", 0.1]], 1), ([], 1)],
)
def test_a_list_without_a_valid_item_has_a_sentence_for_each_item(points, lines):
    """It is not said to be empty, unless it is."""
    rail = {"kind": "points", "over": "time", "polach": "wet", "points": points}
    with pytest.raises(ScenarioError) as refusal:
        Scenario.load("trapezoid").replaced({"adhesion": rail})
    assert len(str(refusal.value).splitlines()) == lines
    assert ("at least 1 item" in str(refusal.value)) == (not points)


def test_the_sample_times_of_the_valves_are_those_of_the_plant():
    assert explicit(read("RailBraking.Pneumatics.ValveDelay")).clocks == [tuple(map(float, SAMPLES))]


def test_a_train_takes_the_place_of_the_plant_of_the_scenario():
    vehicle = Scenario.load("plain", {"vehicle.plant": None, "vehicle.train": "vt642"}).vehicle
    assert vehicle.plant is None
    assert vehicle.train is not None
