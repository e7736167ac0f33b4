"""Recordings with any units, factors, rows of units and decimal signs: estimated or refused, without traceback or hang.

`make fuzz` runs more of them than the tests.
"""

import json
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_fuzz_questions import answered, many

from railgrip.base.errors import UnitError
from railgrip.base.units import conversion, unit
from railgrip.estimation.inspection import inspect_recording
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import estimate_of, load_specification
from railgrip.recording.delimited import SPELLINGS

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

HEAD = """
extends = "rig_own"
[model]
kind = "compiled"
[data]
time = { column = "t", unit = %s }
period = "20 ms"
longest_gap = "1 s"
frozen = "2 s"
spike = 8.0
%s
[data.columns]
"""

SIGNALS = {
    "speed": (["m/s", "km/h", "mph", "kmh"], ["rev/min", "", "%", "m"]),
    "wheelset_speed": (["rad/s", "rev/min", "U/min", "deg/s"], ["1/min", "Hz", "m/s"]),
    "pad_force": (["N", "kN"], ["bar", "kPa", "psi", "mA", "t", "furlong"]),
}
"""Right and wrong units of each signal."""
SI = {"v": "m/s", "n": "rad/s", "F": "N", "t": "s"}
FACTORS = st.sampled_from(
    [1.0, -1.0, 3.6, 0.0, 1e6, 1e-9, 1e300, "8 kN/bar", "2 1/m", "1 m/rad", "5 kN/mA", "0 N/bar", "x"]
)
OFFSETS = st.sampled_from([0.0, -4.0, 1e5, 1e300, "1 kN"])
MINIMA = st.sampled_from(["0 N", "0 m/s", "0", 0.0, 1e9, "1 bar"])
SELDOM = st.sampled_from([False, False, False, False, False, False, True])
"""Mostly right values are drawn, so that later stages are reached."""
CELLS = st.sampled_from(["", "-", "n/a", "50,000", "1.234,5", "1_000", "∞", "1e400", "0x10", "true", "'", '"'])
MOST = 300
"""Samples of a file."""


def number(value: float, digits: int, decimal: str, thousands: str) -> str:
    """Return a number as a logger writes it."""
    text = f"{value:,.{digits}f}" if thousands else f"{value:.{digits}f}"
    return text.replace(",", "T").replace(".", decimal).replace("T", thousands)


@st.composite
def recordings(draw: st.DrawFn) -> tuple[str, str]:
    """Text of a file and of the estimation that maps its columns."""
    count = draw(st.sampled_from([0, 1, 2, 7, 60])) if draw(SELDOM) else MOST
    time = 0.02 * np.arange(count)
    speed = np.maximum(30.0 - np.maximum(time - 2.0, 0.0), 0.0)
    values = {"t": time, "v": speed, "n": speed / 0.46, "F": np.where(time > 2.0, 2e4, 0.0)}
    decimal, separator = draw(st.sampled_from(".,")), draw(st.sampled_from(";,\t|"))
    thousands = draw(st.sampled_from([",", ".", " ", "'"])) if draw(SELDOM) else ""
    scale = draw(st.sampled_from([3.6, 1e-3, 1e3, 1e6])) if draw(SELDOM) else 1.0
    digits = {name: draw(st.integers(0, 5)) for name in values}
    digits["t"] = draw(st.sampled_from([2, 3, 6]))
    units = {name: draw(st.sampled_from(of[draw(SELDOM)])) for name, of in zip("vnF", SIGNALS.values(), strict=True)}
    units["t"] = draw(st.sampled_from(["ms", "min", "timestamp", ""])) if draw(SELDOM) else "s"
    for name, symbol in units.items():
        with suppress(UnitError, KeyError):  # a wrong unit has no correct numbers
            values[name] = values[name] / conversion(unit(SPELLINGS.get(symbol.lower(), symbol)), unit(SI[name]))[0]
    place = draw(st.sampled_from(["map", "header", "row", "both"]))
    names = {name: f"{name} [{units[name]}]" if place == "header" and name != "t" else name for name in values}
    rows = [[names[name] for name in values]]
    if place in ("row", "both"):
        brackets = draw(st.sampled_from(["{}", "[{}]", "({})", " {} "]))
        rows.append([brackets.format(units[name]) for name in values])
    for k in range(count):
        rows.append([number(scale * values[name][k], digits[name], decimal, thousands) for name in values])
    for _ in range(draw(st.integers(1, 3)) if draw(SELDOM) else 0):
        row = draw(st.integers(0, len(rows) - 1))
        rows[row][draw(st.integers(0, len(rows[row]) - 1))] = draw(CELLS)
    quote = draw(st.booleans())
    text = "\n".join(separator.join(f'"{cell}"' if quote and "," in cell else cell for cell in row) for row in rows)
    key = draw(st.sampled_from(["", "", f'decimal = "{decimal}"', 'separator = ";"', 'contradictions = "warn"']))
    toml = HEAD % (json.dumps(units["t"]), key)
    for signal, name in zip(SIGNALS, "vnF", strict=True):
        entry = {"column": names[name]}
        entry |= {
            key: draw(of)
            for key, of in {"factor": FACTORS, "offset": OFFSETS, "minimum": MINIMA}.items()
            if draw(SELDOM)
        }
        if place in ("map", "both"):
            entry["unit"] = units[name]
        entry["may_rest"] = draw(st.booleans())
        pairs = ", ".join(f"{key} = {json.dumps(value)}" for key, value in entry.items())
        toml += f"{signal} = {{ {pairs} }}\n"
    return text, toml


@many
@given(recordings(), st.sampled_from([None, None, ".", ","]))
def test_a_recording_with_any_units_is_estimated_or_refused(tmp_path: Path, recording, decimal):
    """An estimated recording has an input at every sample, and no library warning reaches the user."""
    text, toml = recording
    file, estimation = tmp_path / "run.csv", tmp_path / "run.toml"
    file.write_text(text, encoding="utf-8")
    estimation.write_text(toml, encoding="utf-8")

    def estimate():
        specification = load_specification(estimation)
        read = recording_of_estimation(specification, data=file)
        assert np.isfinite(read["reading_pad_force"].values).all()
        estimates = estimate_of(specification, read)
        assert estimates.sizes["time"] == read.sizes["time"]
        assert estimates.attrs["warnings"].splitlines() == read.attrs["warnings"]

    with warnings.catch_warnings():
        warnings.simplefilter("error")  # as a warning would reach the user
        warnings.simplefilter("ignore", RuntimeWarning)  # numpy's, of numbers beyond any sensor
        answered(estimate)
        answered(lambda: inspect_recording(file, Path("rig_own"), decimal=decimal))
