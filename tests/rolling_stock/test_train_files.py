"""A train file states all data with their sources; impossible values are refused with file and key."""

import re
import tomllib
from pathlib import Path

import pytest

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


JACOBS = [{"kind": "trailer", "at": "24 m", "shared": True}]


def stiff(value):
    return lambda tables: tables["bogies"]["trailer"].update(stiffness=value)


def damped(value):
    return lambda tables: tables["bogies"]["trailer"].update(damping=value)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: t["bogies"]["trailer"].update(brake="drum"), "[bogies.trailer] brake names 'drum'"),
        (lambda t: t["cars"][1]["bogies"][0].update(kind="jacobs"), "[cars[2]] bogies names 'jacobs'"),
        (lambda t: t["bogies"]["trailer"].update(axles=[0, 1, 3]), "axles that are not equally spaced"),
        (lambda t: t["bogies"]["trailer"].update(units=[1, 2, 3]), "has 2 axles and 3 units"),
        (lambda t: t["cars"][0].update(axle_masses=["1 t"]), "[cars[1]] axle_masses has 1 values, A has 4 axles"),
        (lambda t: t["cars"][1].update(coupler="bar"), "[cars[2]] is the last car"),
        (lambda t: t["cars"][1]["bogies"][0].update(at="23 m"), "the positions of the axles do not increase"),
        (lambda t: t["cars"][0].update(mass="44 kN"), "[cars[1]] mass is '44 kN'"),
        (lambda t: t["cars"][0].update(weight=3), "[cars[1]] has no key 'weight'"),
        (lambda t: t.update(sanders=[{"wheelset": 9, "rate": "2 kg/min", "delay": 1}]), "[sanders[1]] is at wheelset"),
        (lambda t: t["cars"][0].update(distributor="P"), "[cars[1]] distributor names 'P', which is not in [dis"),
        (lambda t: t["cars"][1].update(accelerator="slow"), "[cars[2]] accelerator names 'slow', which is not in [acc"),
        (lambda t: t["distributors"]["R"].update(low_share=1.5), "[distributors.R] low_share must be at most 1"),
        (lambda t: t["distributors"]["R"].update(speed_down="80 km/h"), "speed_down 80 km/h and speed_up 70 km/h"),
        (lambda t: t["distributors"]["R"].update(stage_time=0), "[distributors.R] stage_time must be at least"),
        (lambda t: t["distributors"]["R"].pop("estimated"), "[distributors.R] has numbers without an origin"),
        (lambda t: t["accelerators"]["quick"].update(closing_pressure="6 bar"), "closing_pressure must be below"),
        (lambda t: t["accelerators"]["quick"].update(closing_pressure="4.6 bar"), "closing_pressure must be below"),
        (lambda t: t["accelerators"]["quick"].update(opening_rate="0.7 bar"), "[accelerators.quick] opening_rate is"),
        (lambda t: t["accelerators"]["quick"].update(conductance="1 cm2"), "[accelerators.quick] conductance is"),
        (lambda t: t["cars"][0].update(count=0), "[cars[1]] count is 0"),
        (lambda t: t["cars"][0].update(count=65), "[cars[1]] count is 65"),
        (lambda t: t["cars"][0].update(count=64), "cars has 65 cars with those of count; a train has 64 at most"),
        (lambda t: t["cars"][0].update(count=2.0), "[cars[1]] count is 2.0"),
        (lambda t: t["cars"][0].update(count=True), "[cars[1]] count is True"),
        (lambda t: t.update(cars=[t["cars"][0] | {"bogies": JACOBS, "axle_masses": ["11 t"] * 2, "count": 2}]),
         "[cars[1]] is the last car"),
        (stiff("2.4 mN/m"), "[bogies.trailer] stiffness must be at least 10000 N/m, got '2.4 mN/m'; "
         "expected is 10000 to 1e+10 N/m; axle boxes"),
        (stiff(5e-324), "[bogies.trailer] stiffness is 5e-324, too small to calculate with; give 0, "
         "or at least 2.2e-308"),
        (damped("5e-310 N.s/m"), "[bogies.trailer] damping is '5e-310 N.s/m', too small to calculate with"),
        (damped("24 mN.s/m"), "got '24 mN.s/m'; expected is 0, or 10 to 1e+09 N.s/m; dampers"),
        (lambda t: t["bogies"]["trailer"].update(wheel_radius="0.46 mm"),
         "expected is 0.15 to 0.7 m; this is the radius, not the diameter; wheels have"),
    ],
)  # fmt: skip
def test_an_impossible_train_is_refused_with_its_key(piped, change, sentence):
    change(piped)
    refusal = refused(piped)
    assert refusal.startswith("ours.toml: ")
    assert sentence in refusal


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


@pytest.mark.parametrize("name", NAMED)
def test_the_trains_of_the_library_state_the_source_of_every_number(name):
    train = load_train(Path(name))
    assert train.name == name
    tables = [train.resistance, *train.pads.values(), *train.brakes.values(), *train.bogies.values(), *train.cars,
              *train.couplers.values(), *train.track_brakes.values(), train.command]  # fmt: skip
    assert all(table.source or table.estimated for table in tables)


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
