"""A train file states all data with their sources; impossible values are refused with file and key."""

import re
import tomllib
from pathlib import Path

import pytest
from wrong import change, table

from railgrip.base.errors import ScenarioError
from railgrip.base.registry import shelf
from railgrip.rolling_stock.check import findings
from railgrip.rolling_stock.modelica import class_text
from railgrip.rolling_stock.schema import NAMED, load_train, train_of


def refused(tables):
    with pytest.raises(ScenarioError) as refusal:
        train_of(tables, "ours.toml")
    return str(refusal.value)


def test_quantities_are_read_in_their_units(tables):
    tables["cars"][0]["mass"] = "44000 kg"
    tables["bogies"]["trailer"]["axles"] = [0, "2500 mm"]
    train = train_of(tables, "ours.toml")
    assert train.mass == pytest.approx(88e3)
    assert [axle.position for axle in train.axles[:4]] == pytest.approx([2.25, 4.75, 19.25, 21.75])
    assert train.axles[4].position == pytest.approx(26.25)
    assert [axle.car for axle in train.axles] == [0] * 4 + [1] * 4
    assert len(train.groups) == 8


def test_every_table_states_the_source_of_its_numbers(tables):
    del tables["brakes"]["disc"]["estimated"]
    assert "ours.toml: [brakes.disc] has numbers without an origin" in refused(tables)
    tables["brakes"]["disc"] |= {"source": "data sheet", "estimated": ["rigg"]}
    assert "[brakes.disc] calls 'rigg' estimated, which it does not have" in refused(tables)


def with_three_first_cars(tables, **keys):
    """Return the tables with three cars like the first, written out, and the same with `count`."""
    first, last = {**tables["cars"][0], **keys}, tables["cars"][1]
    written = [{**first, "name": f"A-{number}"} for number in (1, 2, 3)]
    return tables | {"cars": [*written, last]}, tables | {"cars": [{**first, "count": 3}, last]}


def test_count_is_the_same_as_cars_written_out(tables):
    """Axles, groups, valves, sanders by wheelset, and the plant are those of the longer file."""
    tables["sanders"] = [{"wheelset": 14, "rate": "2 kg/min", "delay": 1}]
    written, counted = (train_of(each, "ours.toml") for each in with_three_first_cars(tables))
    assert counted.model_dump() == written.model_dump()
    assert (counted.axles, counted.groups_per_valve) == (written.axles, written.groups_per_valve)
    assert class_text(counted, pneumatic=True) == class_text(written, pneumatic=True)
    assert train_of(counted.model_dump(mode="json"), "again.toml").model_dump() == written.model_dump()


@pytest.mark.parametrize("count", [1, 4])
def test_the_last_car_of_a_count_at_the_end_has_no_coupler(tables, count):
    tables["cars"] = [{**tables["cars"][0], "coupler": "bar", "count": count}]
    train = train_of(tables, "ours.toml")
    assert [car.coupler for car in train.cars] == ["bar"] * (count - 1) + [None]
    assert [car.name for car in train.cars] == [f"A-{number + 1}" for number in range(count)]


def test_messages_number_entries_of_the_file_and_name_each_once(tables):
    """The fourth car of the train is the second entry; equal cars have one finding."""
    _, counted = with_three_first_cars(tables, axle_masses=["12 t"] * 4, length="50.5 m")
    counted["cars"][0]["bogies"] = [{"kind": "trailer", "at": at} for at in ("0.5 m", "20.5 m")]
    keys = [finding.key for finding in findings(train_of(counted, "ours.toml"))]
    assert [keys.count(key) for key in ("[cars[1]] mass", "[cars[1]] bogies", "[cars[1]] length")] == [1, 1, 1]
    assert not any(key.startswith("[cars[2]]") for key in keys)
    counted["cars"][1] = {**counted["cars"][1], "coupler": "bar"}
    assert "[cars[2]] is the last car" in refused(counted)


@pytest.mark.parametrize(("key", "value", "sentence"), table(__file__, "tables.toml")["impossible_trains"])
def test_an_impossible_train_is_refused_with_its_key(piped, key, value, sentence):
    change(piped, key, value)
    refusal = refused(piped)
    assert refusal.startswith("ours.toml: ")
    assert sentence in refusal


def test_the_last_car_of_a_count_shares_no_bogie_with_the_next(piped):
    shared = [{"kind": "trailer", "at": "24 m", "shared": True}]
    piped["cars"] = [piped["cars"][0] | {"bogies": shared, "axle_masses": ["11 t"] * 2, "count": 2}]
    assert "[cars[1]] is the last car" in refused(piped)


@pytest.mark.parametrize(("key", "name"), [("distributor", "R"), ("accelerator", "quick")])
def test_equipment_of_a_brake_pipe_requires_one(piped, key, name):
    piped["cars"][1][key] = name
    assert train_of(piped, "ours.toml").cars[1].model_dump()[key] == name
    del piped["command"]
    assert f"[cars[2]] {key} needs a brake pipe: give [command] kind = 'brake_pipe'" in refused(piped)


def test_coupled_axles_turn_as_one_and_the_bogie_decides_on_shared_valves(tables):
    tables["bogies"]["trailer"] |= {"coupled": True, "valve": "car", "units": [2, 1], "inertia": [90, 120]}
    tables["cars"][1]["bogies"][1]["reversed"] = True
    train = train_of(tables, "ours.toml")
    assert train.groups == ((0, 1), (2, 3), (4, 5), (6, 7))
    assert train.groups_per_valve == (2, 2)
    assert [axle.units for axle in train.axles] == [2, 1, 2, 1, 2, 1, 1, 2]
    assert train.axles[-1].inertia == 90


def test_each_car_has_half_of_a_shared_bogie():
    train = load_train(Path("vt642"))
    assert [axle.car for axle in train.axles] == [0] * 3 + [1] * 3
    behind = [axle.position - train.axles[0].position for axle in train.axles]
    assert behind == pytest.approx([0, 1.9, 15.625, 18.275, 32, 33.9])
    assert train.groups == ((0, 1), (2,), (3,), (4, 5))


def quantities(table, path=()):
    """Yield the path of each quantity of a train file that has a unit."""
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        if isinstance(value, dict | list):
            yield from quantities(value, (*path, key))
        elif isinstance(value, str) and re.match(r"[\d.]+ \D", value) and key not in ("source", "description"):
            yield (*path, key)


@pytest.mark.parametrize("name", NAMED)
@pytest.mark.parametrize("factor", [1e-9, 1e9], ids=["milli for mega", "mega for milli"])
def test_a_prefix_wrong_by_two_steps_is_noticed_for_every_quantity(name, factor):
    """For example 2.4 mN/m instead of 2.4 MN/m; 0 has no prefix, and degC is not written with one."""
    file = shelf("trains")[name]
    before = {str(finding) for finding in findings(load_train(file))}
    unnoticed = []
    for *place, key in quantities(tomllib.loads(file.read_text(encoding="utf-8"))):
        tables = tomllib.loads(file.read_text(encoding="utf-8"))
        inner = tables
        for step in place:
            inner = inner[step]
        number, unit = inner[key].split(" ", 1)
        if not float(number) or unit == "degC":
            continue
        inner[key] = f"{float(number) * factor:g} {unit}"
        try:
            if {str(finding) for finding in findings(train_of(tables, "mine.toml"))} <= before:
                unnoticed.append((*place, key))
        except ScenarioError as refusal:
            name = next(step for step in reversed((*place, key)) if isinstance(step, str))
            assert name in str(refusal)  # noqa: PT017 (each of many)
    assert not unnoticed


def test_zero_damping_and_zero_slack_are_valid(tables):
    tables["bogies"]["trailer"]["damping"] = 0
    assert train_of(tables, "ours.toml").bogies["trailer"].damping == 0
