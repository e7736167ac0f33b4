"""Plausible mistakes in a train file are refused, announced, or leave the stop as it is.

Each mistake turns a correct file into one that a person may well write: another unit, a diameter for a radius, a value
of a car for one of an axle. What cannot be noticed is listed in docs/limits_of_checks.md.
"""

import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from sampling import FUZZ

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.registry import shelf
from railgrip.base.units import to_si
from railgrip.rolling_stock.check import fastest_stop, findings
from railgrip.rolling_stock.schema import NAMED, train_of
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.load import load, scenario_of
from railgrip.simulate.named_models import remarks_on_train
from railgrip.simulate.vehicle_data import VehicleData

Tables = dict[str, Any]

SAME = 0.002
"""Relative change of the distance up to which a stop counts as unchanged: published distances are rounded to this."""


def si(value: object, unit: str) -> float:
    return to_si(value, unit) if isinstance(value, str) else float(value)  # type: ignore[arg-type]


def entries(tables: Tables, table: str, key: str) -> list[Tables]:
    """Return a table with the key, or else all entries of the table."""
    entry = tables[table]
    return [entry] if key in entry else list(entry.values() if isinstance(entry, Mapping) else entry)


def scale(table: str, key: str, factor: float, unit: str) -> Callable[[Tables], None]:
    """Return the change of a key by a factor in all entries of a table."""

    def change(tables: Tables) -> None:
        for part in entries(tables, table, key):
            if key not in part:
                continue
            values = part[key]
            many = isinstance(values, list)
            scaled = [factor * si(value, unit) for value in (values if many else [values])]
            part[key] = scaled if many else scaled[0]

    return change


def set_to(table: str, key: str, value: object) -> Callable[[Tables], None]:
    """Return the replacement of the value of a key in all entries of a table."""

    def change(tables: Tables) -> None:
        for part in entries(tables, table, key):
            part[key] = value

    return change


def axle_masses_of_bogies(tables: Tables) -> None:
    """Without axle_masses the cars carry them equally: give each axle the load of its bogie."""
    for car in tables["cars"]:
        count = sum(len(tables["bogies"][mount["kind"]]["axles"]) for mount in car["bogies"])
        masses = car.get("axle_masses") or [si(car["mass"], "kg") / count] * count
        car["axle_masses"] = [2 * si(mass, "kg") for mass in masses]


MISTAKES: dict[str, Callable[[Tables], None]] = {
    "the diameter of wheels for their radius": scale("bogies", "wheel_radius", 2, "m"),
    "the radius of wheels in mm": scale("bogies", "wheel_radius", 1e3, "m"),
    "the radius of wheels in inches": scale("bogies", "wheel_radius", 39.37, "m"),
    "the diameter of discs for the radius of pads": scale("brakes", "friction_radius", 2, "m"),
    "inertia 100 times as high": scale("bogies", "inertia", 100, "kg.m2"),
    "inertia in t.m2": scale("bogies", "inertia", 1e-3, "kg.m2"),
    "the load of an axle for the mass of a car": scale("cars", "mass", 1 / 4, "kg"),
    "the load of a bogie for that of an axle": axle_masses_of_bogies,
    "the mass of cars in t": scale("cars", "mass", 1e-3, "kg"),
    "the mass of cars in pounds": scale("cars", "mass", 2.2046, "kg"),
    "a temperature in °C for K": set_to("pads", "temperature_nominal", "60 K"),
    "a bare temperature in °C": set_to("pads", "temperature_nominal", 60),
    "a difference of temperatures in °C": set_to("pads", "temperature_range", "150 degC"),
    "a drag coefficient 10 times as high": scale("resistance", "drag_coefficient", 10, "1"),
    "the frontal area in cm2": scale("resistance", "frontal_area", 1e4, "m2"),
    "pressure in MPa for bar": scale("brakes", "pressure_max", 10, "Pa"),
    "pressure in bar for Pa": scale("brakes", "pressure_max", 1e-5, "Pa"),
    "pressure in kPa for Pa": scale("brakes", "pressure_max", 1e-3, "Pa"),
    "the force of the spring in kN for N": scale("brakes", "spring_force", 1e-3, "N"),
    "the diameter of the piston for its area": set_to("brakes", "piston_area", 0.203),
    "the area of the piston in cm2": scale("brakes", "piston_area", 1e4, "m2"),
    "the efficiency in per cent": scale("brakes", "efficiency", 100, "1"),
    "pad friction in per cent": scale("brakes", "pad_friction", 100, "1"),
    "the rigging ratio for all axles of the train": scale("brakes", "rigging", 8, "1"),
    "twice as many brake units": scale("bogies", "units", 2, "1"),
    "axle positions in mm": scale("bogies", "axles", 1e3, "m"),
    "axle positions in feet": scale("bogies", "axles", 3.281, "m"),
    "the length of cars in mm": scale("cars", "length", 1e3, "m"),
    "the length of cars in feet": scale("cars", "length", 3.281, "m"),
    "the mass of frames for all bogies": scale("bogies", "frame_mass", 10, "kg"),
    "stiffness in N/mm for N/m": scale("bogies", "stiffness", 1e-3, "N/m"),
    "stiffness in MN/m as kN/m": scale("bogies", "stiffness", 1e3, "N/m"),
    "damping in kN.s/m for N.s/m": scale("bogies", "damping", 1e-3, "N.s/m"),
    "the radius of bearings in mm": scale("resistance", "bearing_radius", 1e3, "m"),
    "bearing friction in per mille": scale("resistance", "bearing_friction", 1e3, "1"),
    "the arm of rolling resistance in mm": scale("resistance", "rolling_arm", 1e3, "m"),
    "the speed of pads in km/h for m/s": scale("pads", "speed_nominal", 1 / 3.6 / 3.6, "m/s"),
    "the force of pads in kN for N": scale("pads", "force_nominal", 1e-3, "N"),
    "an effect in per cent": scale("pads", "speed_effect", 100, "1"),
}


def units_as_integers(tables: Tables) -> Tables:
    for bogie in tables["bogies"].values():
        bogie["units"] = [round(value) for value in bogie["units"]]
    return tables


def verdict(tables: Tables, correct: float) -> str:
    """Return the fate of a file: refused, announced, unchanged, or unnoticed."""
    try:
        train = train_of(units_as_integers(tables), "mine.toml")
        remarks = findings(train)
        if remarks:
            return "refused" if any(remark.wrong for remark in remarks) else "announced"
        distance = by_hand(train, fastest_stop(train)).distance
    except InputError:
        return "refused"
    return "unchanged" if abs(distance / correct - 1) < SAME else f"unnoticed: {distance:.1f} for {correct:.1f} m"


def tables_of(name: str) -> Tables:
    return tomllib.loads(Path(shelf("trains")[name]).read_text(encoding="utf-8"))


@cache
def correct_distance(name: str) -> float:
    """The distance of a train of the library, calculated once: it takes longer than to read a file."""
    train = train_of(tables_of(name), name)
    return by_hand(train, fastest_stop(train)).distance


@pytest.mark.parametrize(
    ("mistake", "name"),
    [
        (mistake, name)
        for number, mistake in enumerate(sorted(MISTAKES))
        for place, name in enumerate(NAMED)
        if FUZZ or (number + place) % len(NAMED) == 0  # one train after the other
    ],
)
def test_a_mistake_in_all_parts_is_noticed(mistake: str, name: str) -> None:
    tables = tables_of(name)
    MISTAKES[mistake](tables)
    assert not verdict(tables, correct_distance(name)).startswith("unnoticed")


def test_a_run_refuses_what_the_check_refuses(tmp_path: Path) -> None:
    text = Path(shelf("trains")["vt642"]).read_text(encoding="utf-8").replace('mass = "42 t"', 'mass = "24 t"')
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    scenario = load(shelf("scenarios")["plain"]).tables() | {"vehicle": {"train": "mine.toml"}}
    with pytest.raises(InputError, match=r"mine.toml: .* the axles carry 84 t"):
        VehicleData(scenario_of(scenario, directory=tmp_path, origin="ours"))


@pytest.mark.parametrize("speed", [30, 34])
def test_a_law_of_friction_that_does_not_hold_at_the_speed_of_a_stop_is_refused(tmp_path: Path, speed: int) -> None:
    """Friction of 0.35 that falls evenly to 0.05 at 23.3 m/s of pads, 37.7 m/s of the train of 380 mm wheels."""
    text = Path(shelf("trains")["vt642"]).read_text(encoding="utf-8")
    text = text.replace("speed_effect = 0.12", "speed_effect = 1").replace(
        "temperature_effect = 0.10", "temperature_effect = 0"
    )
    text = text.replace("force_effect = 0.08", "force_effect = 0").replace(
        'speed_nominal = "13 m/s"', f'speed_nominal = "{23.3 / (2 - 0.05 / 0.35):.6g} m/s"'
    )
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    tables = load(shelf("scenarios")["plain"]).tables() | {
        "vehicle": {"train": "mine.toml"},
        "start": {"speed": speed + 5},
    }
    scenario = scenario_of(tables, directory=tmp_path, origin="ours")
    if speed + 5 < 37.7:
        assert not [sentence for sentence in remarks_on_train(scenario) if "friction" in sentence]
    else:
        with pytest.raises(ScenarioError, match=r"\[pads.organic\] speed_effect, force_effect: friction falls to 0.0"):
            remarks_on_train(scenario)


@pytest.mark.parametrize(("table", "name"), [("command", "emu387"), ("track_brakes", "tram")])
def test_a_delay_beyond_the_plants_is_refused_at_its_key(table: str, name: str) -> None:
    """RailBraking.Pneumatics.DelayLine has 101 samples of 10 ms."""
    tables = tables_of(name)
    part = tables["command"] if table == "command" else next(iter(tables["track_brakes"].values()))
    part["delay"] = "1 s"
    train_of(tables, "mine.toml")
    part["delay"] = ".4 min"
    with pytest.raises(InputError, match=r"delay must be at most 1 s, got '.4 min'"):
        train_of(tables, "mine.toml")
