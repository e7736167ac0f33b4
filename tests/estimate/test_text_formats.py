"""A text file reads back to the same SI values with any separator, decimal sign, encoding, unit and column order."""

import csv
import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from data_table import data_table
from hypothesis import given
from hypothesis import strategies as st
from wrong import table as stored

from railgrip.base.errors import EstimationError
from railgrip.base.units import conversion, unit
from railgrip.estimation.inspection import inspect_recording
from railgrip.recording.delimited import read_delimited
from railgrip.recording.files import unit_at_end
from railgrip.recording.read import read_recording
from railgrip.recording.samples import reading_of
from railgrip.recording.table import DataTable
from railgrip.scenario.curve import read_curve

PERIOD = 0.01
SAMPLES = 40
SIGNALS = {
    "speed": ("m/s", {"km/h": (1 / 3.6, 0.0), "m/s": (1.0, 0.0), "mph": (0.44704, 0.0)}),
    "acceleration": ("m/s2", {"g": (9.80665, 0.0), "mg": (9.80665e-3, 0.0), "m/s²": (1.0, 0.0)}),
    "wheelset_speed": ("rad/s", {"U/min": (np.pi / 30, 0.0), "rad/s": (1.0, 0.0), "°/s": (np.pi / 180, 0.0)}),
    "cylinder_pressure": ("Pa", {"bar": (1e5, 0.0), "kPa": (1e3, 0.0), "psi": (6894.757293168361, 0.0)}),
    "disc_temperature": ("K", {"°C": (1.0, 273.15), "K": (1.0, 0.0)}),
}
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
SUFFIXES = {"km/h": "kmh", "m/s": "mps", "m/s²": "ms2", "U/min": "rpm", "rad/s": "rad_s", "°/s": "deg_s", "°C": "degC"}
NOTATIONS = ("{name} [{unit}]", "{name} ({unit})", "{name}_{suffix}", "{name} in {suffix}")


@st.composite
def files(draw: st.DrawFn) -> tuple[bytes, dict[str, str], dict[str, np.ndarray]]:
    """Content of a file, header of each signal and of `time`, and the values in SI units."""
    decimal = draw(st.sampled_from(".,"))
    separator = draw(st.sampled_from(",;\t|"))
    time_unit = draw(st.sampled_from(sorted(TIMES)))
    headers, columns, values = {}, {}, {}
    ticks = [k * PERIOD / TIMES[time_unit] for k in range(SAMPLES)]
    for name, (_, units) in SIGNALS.items():
        symbol = draw(st.sampled_from(sorted(units)))
        digits = draw(st.integers(0, 4))
        first, slope = draw(st.floats(-900, 900)), draw(st.floats(-9, 9))
        numbers = [round(first + slope * k, digits) for k in range(SAMPLES)]
        headers[name] = _header(draw, name, symbol)
        columns[headers[name]] = [f"{number:.{digits}f}" for number in numbers]
        gain, shift = units[symbol]
        values[name] = gain * np.array(numbers) + shift
    headers["time"] = _header(draw, "t", time_unit)
    columns[headers["time"]] = [f"{tick:.15f}" for tick in ticks]
    columns["remark"] = ["ok" if k % 2 else "a, b; c" for k in range(SAMPLES)]
    order = draw(st.permutations(list(columns)))
    out = io.StringIO(newline="")
    writer = csv.writer(out, delimiter=separator, lineterminator=draw(st.sampled_from(["\n", "\r\n"])))
    writer.writerow(order)
    rows = ([columns[name][k] for name in order] for k in range(SAMPLES))
    writer.writerows([cell if cell[0].isalpha() else cell.replace(".", decimal) for cell in row] for row in rows)
    return out.getvalue().encode(draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]))), headers, values


def _header(draw: st.DrawFn, name: str, symbol: str) -> str:
    return draw(st.sampled_from(NOTATIONS)).format(name=name, unit=symbol, suffix=SUFFIXES.get(symbol, symbol))


def table(columns: dict[str, Any], **changes: Any) -> DataTable:
    """Return a map of columns, without limits of faults: ramps are not sensors, and their rounding is not noise."""
    return data_table(columns, **{"time": {"column": "t"}, "frozen": 1e3, "spike": 1e6} | changes)


def csv_of(folder: Path, text: str) -> Path:
    path = folder / "run.csv"
    path.write_text(text, encoding="utf-8")
    return path


@given(files())
def test_a_file_of_any_format_reads_back_to_the_same_values(tmp_path_factory, file):
    content, headers, values = file
    path = tmp_path_factory.mktemp("format") / "run.csv"
    path.write_bytes(content)
    units = {name: target for name, (target, _) in SIGNALS.items()}
    of_file = table({name: {"column": headers[name]} for name in SIGNALS}, time={"column": headers["time"]})
    recording = read_recording(path, of_file, units, [], list(SIGNALS)).recording
    assert recording.sizes["time"] == SAMPLES
    for name, expected in values.items():
        # Instants and units are rounded once each: 1e-9 of the largest value.
        largest = np.abs(expected).max()
        np.testing.assert_allclose(reading_of(recording, name), expected, rtol=0.0, atol=1e-9 * largest + 1e-12)


@pytest.mark.parametrize(
    ("name", "target", "expected"),
    [
        ("v_km_h", "m/s", "km/h"),
        ("v / km/h", "m/s", "km/h"),
        ("wheel_l", "rad/s", None),
        ("p_C", "Pa", None),
        ("brake_h", "Pa", None),
        ("speed", "m/s", None),
    ],
)
def test_a_unit_at_the_end_of_a_name_counts_if_it_fits(name, target, expected):
    assert unit_at_end(name, target) == expected


def test_g_is_gravity_for_an_acceleration_and_gram_for_a_mass():
    """Standard gravity by the third CGPM (1901)."""
    assert conversion(unit("g"), unit("m/s2")) == (9.80665, 0.0)
    assert conversion(unit("g_0"), unit("m/s2")) == (9.80665, 0.0)
    assert conversion(unit("g"), unit("kg")) == (1e-3, 0.0)


@pytest.mark.parametrize(("text", "columns"), stored(__file__, "tables.toml")["separators"])
def test_separator_and_decimal_sign_are_detected(tmp_path, text, columns):
    values = read_delimited(csv_of(tmp_path, text)).values
    assert {name: values[name].tolist() for name in columns} == columns


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("t;F\n0;50,000\n1;48,500\n", r"column 'F' has numbers such as '50,000', whose comma is .* or separates thous"),
        ("t;F\n0;950\n1;1,050\n", r"'1,050', whose comma is .* decimal = ','"),
        ('t,F\n0,"50,000"\n1,"48,500"\n', r"'50,000', whose comma is"),
        ("t;F\n0.5;50,000\n1.5;48,500\n", r"column 'F' .* '50,000', and column 't' numbers with points"),
        ("t;F\n0.5;50,5\n1.5;48,5\n", r"column 'F' .* '50,5', and column 't' numbers with points"),
        # No consistent separator: decimal commas cannot be distinguished from separating commas.
        *((text, "") for text in ("t,v\n0,1,5\n1,2,5\n", "logged by X\nt;v\n0;1\n", "")),
    ],
)
def test_an_ambiguous_comma_is_refused(tmp_path, text, sentence):
    with pytest.raises(EstimationError, match=rf"run\.csv.*{sentence}"):
        read_delimited(csv_of(tmp_path, text))


def test_the_key_decimal_determines_the_meaning_of_a_comma(tmp_path):
    """The value is 50 with a decimal comma; with a decimal point the text is refused, never read as another number."""
    path = csv_of(tmp_path, "t;F\n0;50,000\n1;48,500\n")
    changes = {"time": {"column": "t", "unit": "s"}, "period": 1.0, "longest_gap": 1.5}

    def read(decimal):
        of_file = table({"pad_force": {"column": "F", "unit": "kN"}}, **changes, **decimal)
        return read_recording(path, of_file, {"pad_force": "N"}, ["pad_force"], [])

    assert reading_of(read({"decimal": ","}).recording, "pad_force").tolist() == [50e3, 48.5e3]
    for decimal in ({}, {"decimal": "."}):
        with pytest.raises(EstimationError, match="50,000"):
            read(decimal)
    for text, decimal in (("t;F\n0,5;50.000\n1,5;48.000\n", {}), ("t;F\n0,5;50.000\n1,5;48.500\n", {"decimal": ","})):
        csv_of(tmp_path, text)
        with pytest.raises(EstimationError, match=r"column 'F' must have numbers, .* '50\.000'.* decimal sign .* ','"):
            read(decimal)


def test_the_key_separator_divides_lines_by_a_mark_that_is_not_looked_for(tmp_path):
    changes = {"time": {"column": "t", "unit": "s"}, "period": 1.0, "longest_gap": 1.5}
    columns = {"pad_force": {"column": "F", "unit": "kN"}}
    path = csv_of(tmp_path, "t:F\n0:50,5\n1:48,5\n")
    of_file = table(columns, separator=":", decimal=",", **changes)
    found = read_recording(path, of_file, {"pad_force": "N"}, ["pad_force"], [])
    assert reading_of(found.recording, "pad_force").tolist() == [50.5e3, 48.5e3]
    with pytest.raises(EstimationError):
        read_recording(path, table(columns, **changes), {"pad_force": "N"}, ["pad_force"], [])


def test_tables_of_a_scenario_refuse_thousands_separators(tmp_path):
    """Friction, demand and track are read by the same function."""
    path = tmp_path / "rail.csv"
    for number in ('"1,000"', "1_000", "1 000", "1'000"):
        path.write_text(f"distance,mu0\n0,0.1\n{number},0.1\n", encoding="utf-8")
        with pytest.raises(ValueError, match="line 3: 2 finite numbers"):
            read_curve(path)


@pytest.mark.parametrize(
    "row", ["s;km/h;rev/min;kN", "[s];[km/h];[rpm];[kN]", "(s);kmh;U/min;kN", "s;km/h;rev/min;kN;-"]
)
@pytest.mark.parametrize("decimal", [".", ","])
def test_a_second_header_line_contains_the_units(tmp_path, row, decimal):
    names = "t;v;n;F"
    numbers = [f"{0.01 * k:.2f};{72 - 0.1 * k:.1f};{300 - k:.1f};12.5".replace(".", decimal) for k in range(40)]
    if row.endswith("-"):
        names, numbers = f"{names};remark", [f"{line};ok" for line in numbers]
    path = csv_of(tmp_path, "\n".join([names, row, *numbers]))
    columns = {"speed": {"column": "v"}, "wheelset_speed": {"column": "n"}, "pad_force": {"column": "F"}}
    units = {"speed": "m/s", "wheelset_speed": "rad/s", "pad_force": "N"}
    arguments = units, ["pad_force"], ["speed", "wheelset_speed"]
    recording = read_recording(path, table(columns), *arguments).recording
    for name, first in (("speed", 20.0), ("wheelset_speed", 10 * np.pi), ("pad_force", 12.5e3)):
        assert reading_of(recording, name)[0] == pytest.approx(first)
    assert not inspect_recording(path, Path("rig_own")).unrecognised
    columns["speed"]["unit"] = "m/s"
    with pytest.raises(EstimationError, match="its unit in the file is 'km/h', in the map 'm/s'"):
        read_recording(path, table(columns), *arguments)


@pytest.mark.parametrize("row", ["0;1", "1;1", "start;stop", "0;s"])
def test_a_row_of_numbers_or_words_is_not_a_row_of_units(tmp_path, row):
    path = csv_of(tmp_path, f"t;v\n{row}\n2;3\n")
    assert read_delimited(path).units == {}
    assert len(read_delimited(path).values["t"]) == 2


def test_no_warning_of_a_library_is_passed_on(tmp_path):
    """pandas warns about dates without a common format; the user cannot act on it."""
    path = csv_of(tmp_path, "Datum;v [km/h];F [kN]\n12:00:01;3;1\n12:00:02;4;1\n12:00:03;5;1\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert inspect_recording(path, Path("rig_own")).findings[0].period == 1.0
