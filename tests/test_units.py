"""Units are converted according to the SI brochure, and only between equal dimensions."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from wrong import answered, table

from railgrip.base.errors import UnitError
from railgrip.base.units import GRAVITY, Unit, conversion, to_si, unit
from railgrip.fmus.recipe import MODELICA


@pytest.mark.parametrize(
    ("spellings", "dimension", "factor"),
    [
        (["", "1"], "1", 1.0),
        (["%"], "1", 0.01),
        (["‰"], "1", 1e-3),
        (["Pa"], "kg.m-1.s-2", 1.0),
        (["bar"], "kg.m-1.s-2", 1e5),
        (["N.m", "N m"], "kg.m2.s-2", 1.0),
        (["kW.h"], "kg.m2.s-2", 3.6e6),
        (["kN"], "kg.m.s-2", 1e3),
        (["km/h", "kmph", "kmh"], "m.s-1", 1 / 3.6),
        (["mph"], "m.s-1", 0.44704),
        (["m/s2", "m/s²", "m/s^2"], "m.s-2", 1.0),
        (["rad/s"], "s-1.rad", 1.0),
        (["rev/min", "rpm"], "s-1.rad", 2 * math.pi / 60),
        (["J/(kg.K)"], "m2.s-2.K-1", 1.0),
        (["N/(km/h)"], "kg.s-1", 3.6),
        (["kN/(km/h)2"], "kg.m-1", 12960.0),
        (["daN/(km/h)2"], "kg.m-1", 129.6),
        (["lbf/(mph)^2"], "kg.m-1", 4.4482216152605 / 0.44704**2),
        (["N/(m/s)²"], "kg.m-1", 1.0),
        (["kg.m2", "kg*m**2"], "kg.m2", 1.0),
        (["mm"], "m", 1e-3),
        (["ft"], "m", 0.3048),
        (["l"], "m3", 1e-3),
        (["m3"], "m3", 1.0),
        (["ms"], "s", 1e-3),
        (["µs"], "s", 1e-6),
        (["s-1"], "s-1", 1.0),
        (["1/min"], "s-1", 1 / 60),
        (["deg", "°"], "rad", math.pi / 180),
        (["t"], "kg", 1e3),
        (["W.s/(K.m)"], "kg.m.s-2.K-1", 1.0),
        (["W/degC"], "kg.m2.s-3.K-1", 1.0),
    ],
)
def test_a_unit_string_has_its_defined_meaning(spellings: list[str], dimension: str, factor: float):
    for value in map(unit, spellings):
        assert sorted(value.dimension.split(".")) == sorted(dimension.split("."))
        # A handful of multiplications: a few units in the last place.
        assert value.factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize(
    "text",
    ["parsec", "J/kg.K", "kN/t/(km/h)", "m//s", "kN.", "k", "kh", "kPas", "Ns", "mkg", "2 m", "m**9**9", "m" * 5000],
)
def test_an_unknown_unit_is_refused(text: str):
    with pytest.raises(UnitError, match="is not a unit known here"):
        unit(text)


def test_celsius_has_an_offset_unless_it_is_a_difference():
    assert conversion(unit("degC"), unit("K")) == (1.0, 273.15)
    assert conversion(unit("degC"), unit("K"), difference=True) == (1.0, 0.0)


def test_a_frequency_is_not_an_angular_velocity_and_an_angle_not_a_ratio():
    with pytest.raises(UnitError, match=r"'Hz' \(s-1\) cannot become 'rad/s'"):
        conversion(unit("Hz"), unit("rad/s"))
    for written, target in (("3 deg", "1"), ("3 rpm", "Hz")):
        with pytest.raises(UnitError, match=f"'{written[2:]}' cannot be converted to '{target}'"):
            to_si(written, target)


@pytest.mark.parametrize(("written", "time"), [("90 1/min", "min"), ("9 Hz", "s"), ("9 1/s", "s"), ("9 min-1", "min")])
def test_a_rotational_speed_states_what_it_counts(written: str, time: str):
    """Revolutions and radians per minute are 2π apart; the message names both, and neither is assumed."""
    with pytest.raises(UnitError, match=f"a rotational speed is written 'rev/{time}' or 'rad/{time}'"):
        to_si(written, "rad/s")
    assert to_si("90 rev/min", "rad/s") == pytest.approx(3 * math.pi, rel=1e-15)
    assert to_si("90 rad/min", "rad/s") == 1.5


def test_a_frequency_is_written_in_hertz_or_per_second():
    assert to_si("0.05 Hz", "1/s") == to_si("0.05 1/s", "Hz") == to_si("3 1/min", "Hz") == 0.05


@given(st.text(max_size=40))
def test_any_text_is_a_unit_or_refused_in_a_sentence(text: str):
    """And a quantity or refused."""

    def use():
        assert unit(text).factor > 0.0

    answered(use, UnitError, words="is not a unit known here")
    answered(lambda: to_si(text, "m/s"), UnitError, words="is ")


@pytest.mark.parametrize("factor", [0.0, math.inf, math.nan])
def test_a_factor_that_loses_the_value_is_refused(factor: float):
    with pytest.raises(UnitError, match="must be finite and the factor not 0"):
        Unit(name="odd", exponents=(0,) * 8, factor=factor, offset=0.0)


@given(st.floats(-1e9, 1e9), st.sampled_from([("km/h", "m/s"), ("bar", "Pa"), ("degC", "K"), ("rpm", "rad/s")]))
def test_converting_there_and_back_gives_the_same_value(value: float, pair: tuple[str, str]):
    source, target = map(unit, pair)
    there = conversion(source, target)
    back = conversion(target, source)
    magnitude = there[0] * value + there[1]
    # At most six roundings of 1.1e-16, of the largest number involved; for temperatures that is the offset.
    assert back[0] * magnitude + back[1] == pytest.approx(value, rel=1e-15, abs=4e-13)
    assert to_si(f"{value!r} {pair[0]}", pair[1]) == pytest.approx(magnitude, rel=1e-12, abs=1e-300)


def test_gravity_is_that_of_the_modelica_package():
    package = MODELICA / "RailBraking" / "package.mo"
    assert f"constant Types.Acceleration g = {GRAVITY} " in package.read_text(encoding="utf-8")


@pytest.mark.parametrize(("text", "remedy"), table(__file__, "tables.toml")["pressures"])
def test_a_pressure_with_its_reference_is_refused_with_what_to_write(text: str, remedy: str) -> None:
    with pytest.raises(UnitError, match=re.escape(remedy)):
        to_si(text, "Pa")
