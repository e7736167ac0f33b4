"""Thousands of wrong inputs: each ends in a sentence or a result within ten seconds, never in a traceback.

`make fuzz` runs more of them than the tests; RAILGRIP_FUZZ is the number of each kind.
"""

import os
import tomllib
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat
from synthetic import LAYOUT, TWO_PART_TRAIN
from wrong import answered as answered_or
from wrong import mutate

import railgrip.scenario
from railgrip.base.errors import ScenarioError
from railgrip.recording.read import read_recording
from railgrip.recording.samples import reading_of
from railgrip.recording.table import DataTable
from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.campaign import campaign_of
from railgrip.scenario.file import merge
from railgrip.scenario.load import load, scenario_of, validate_table
from railgrip.scenario.track import track_force_of

ROOM = Path(railgrip.scenario.__file__).parent
SCENARIOS = [path for path in sorted((ROOM / "library").glob("*.toml")) if path.stem != "foreign_train"]
SERVICE = tomllib.loads((ROOM / "equipment" / "service.toml").read_text(encoding="utf-8"))

many = settings(
    max_examples=int(os.environ.get("RAILGRIP_FUZZ", "15")),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::UserWarning")

units = st.sampled_from(
    ["", "s", "ms", "us", "m", "km", "km/h", "kmph", "1/min", "Hz",
     "1/s", "bar", "kN", "t", "%", "deg", "rpm", "m//s", "‰"]
)  # fmt: skip
numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.sampled_from([0, -1, 1e-300, 1e300, 1e-9, 1e9, 1e6, 10**400, 2**63, -0.0]),
)
values = st.one_of(
    numbers,
    st.booleans(),
    st.text(max_size=20),
    st.builds(lambda number, unit: f"{number} {unit}", numbers.filter(lambda n: n < 10**300), units),
    st.lists(numbers, max_size=7),
    st.dictionaries(st.text(max_size=5), numbers, max_size=2),
    st.sampled_from(["x" * 5000, "\0", "..", "../../etc/passwd", "/dev/null", "trapezoid.toml", "constant", "random"]),
    st.recursive(st.integers(), lambda inner: st.lists(inner, max_size=1), max_leaves=3),
)
answered = partial(answered_or, error=ScenarioError)


@many
@given(data=st.data())
def test_a_mutated_scenario_is_accepted_or_refused(data):
    table = tomllib.loads(data.draw(st.sampled_from(SCENARIOS)).read_text(encoding="utf-8"))
    if data.draw(st.booleans()):
        table = merge(table, SERVICE)
    for _ in range(data.draw(st.integers(1, 3))):
        mutate(table, data.draw, values)

    def question():
        scenario = scenario_of(table, directory=ROOM / "library", origin="mutant.toml")
        scenario.digest()
        profile_of(scenario, TWO_PART_TRAIN)
        track_force_of(scenario.track, 84e3)
        scenario.sensors.open(scenario, LAYOUT, 0.38)

    answered(question)


@many
@given(data=st.data())
def test_a_mutilated_file_is_read_or_refused(data, tmp_path):
    content = bytearray(data.draw(st.sampled_from(SCENARIOS)).read_bytes())
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(content)))
        content[at : at + data.draw(st.integers(0, 40))] = data.draw(
            st.one_of(
                st.binary(max_size=8), st.sampled_from([b"[" * 3000, b"9" * 5000, b"\xef\xbb\xbf", b"a." * 900, b'"""'])
            )
        )
    path = tmp_path / "mutant.toml"
    path.write_bytes(bytes(content))
    answered(lambda: load(path))


@many
@given(
    override=st.one_of(
        st.text(max_size=30),
        st.builds("{}={}".format, st.sampled_from(["start.speed", "seed", "name", "track", "a.b"]), values),
    )
)
def test_any_override_is_accepted_or_refused(override):
    answered(lambda: load(SCENARIOS[0], [override]))


UNITS = {"speed": "m/s", "wheelset_speed": "rad/s", "pad_force": "N"}
MAP = {
    "time": {"column": "t", "unit": "ms"},
    "period": "10 ms",
    "longest_gap": "100 ms",
    "frozen": "1 s",
    "spike": 8.0,
    "columns": {
        "speed": {"column": "v", "unit": "km/h"},
        "wheelset_speed": {"column": "n", "unit": "rev/min"},
        "pad_force": {"column": "F", "unit": "kN"},
    },
}


DAMAGE = {
    "jump": lambda column, at, draw: np.concatenate([column[:at], column[at:] + draw(st.floats(1e3, 1e15))]),
    "scale": lambda column, at, draw: column * draw(st.sampled_from([1e6, 1e-6, 1e300, -1.0, 0.0, np.nan])),
    "value": lambda column, at, draw: np.where(np.arange(len(column)) == at, draw(st.floats()), column),
    "all": lambda column, at, draw: np.full(len(column), draw(st.floats())),
    "text": lambda column, at, draw: np.array(
        [draw(st.text(max_size=4)) for _ in column[:3]] + [""] * len(column[3:]), dtype=object
    ),
    "short": lambda column, at, draw: column[:at],
    "back": lambda column, at, draw: column[::-1].copy(),
    "deep": lambda column, at, draw: column + 1j,
}
"""Kind → damaged column, from the column, a place in it, and a function that draws."""


def run(draw):
    """A short brake application as columns, one or more of them damaged."""
    count = draw(st.sampled_from([0, 1, 2, 3, 8, 200]))
    time = 10.0 * np.arange(count)
    frame = {"t": time, "v": 80.0 - 0.01 * time, "n": 400.0 - 0.05 * time, "F": 20.0 + 0.0 * time}
    for _ in range(draw(st.integers(0, 3))):
        intact = sorted(name for name, column in frame.items() if column.dtype == np.float64)
        if not intact:
            break
        name = draw(st.sampled_from(intact))
        column = frame.pop(name)
        at = draw(st.integers(0, max(len(column) - 1, 0)))
        if kind := draw(st.sampled_from([*DAMAGE, None])):  # or the column is gone
            frame[name] = DAMAGE[kind](column, at, draw)
    return frame


@many
@given(data=st.data())
def test_a_damaged_recording_is_repaired_or_refused(data, tmp_path):
    frame = run(data.draw)
    suffix = data.draw(st.sampled_from([".csv", ".csv", ".parquet", ".mat"]))
    path = tmp_path / f"run{suffix}"
    try:
        if suffix == ".mat":
            savemat(path, frame)
        else:
            whole = pd.DataFrame({name: pd.Series(column) for name, column in frame.items()})
            whole.to_csv(path, index=False) if suffix == ".csv" else whole.to_parquet(path)
    except (ValueError, NotImplementedError, TypeError, OverflowError, UnicodeEncodeError):
        path.write_bytes(b"")  # values that the writer of the format cannot represent
    if data.draw(st.integers(0, 9)) == 0:
        content = bytearray(path.read_bytes())
        content[len(content) // 2 :] = data.draw(st.binary(max_size=20))
        path.write_bytes(bytes(content))
    table = {**MAP, "time": dict(MAP["time"]), "columns": {name: dict(c) for name, c in MAP["columns"].items()}}
    if data.draw(st.booleans()):
        mutate(table, data.draw, values)
    inputs = ["pad_force"]

    def question():
        read = validate_table(DataTable, table, directory=tmp_path, origin="map.toml")
        record = read_recording(path, read, UNITS, inputs, ["speed", "wheelset_speed"])
        assert record.recording.sizes["time"] >= 2
        assert np.isfinite(reading_of(record.recording, "pad_force")).all()

    answered(question)


SMALL = """
name = "c"
scenarios = ["plain"]
[axes.rail.a]
seed = 2
[axes.rail.b]
start.speed = "80 km/h"
[sweep]
"start.speed" = [10, "50 km/h"]
[draws]
first = 1
last = 3
match = { rail = "a" }
[[exclude]]
rail = "b"
"start.speed" = "10"
[[expected]]
match = { rail = "b" }
outcome = "horizon"
"""


@many
@given(data=st.data())
def test_a_campaign_is_planned_or_refused(data):
    table = tomllib.loads(SMALL)
    for _ in range(data.draw(st.integers(0, 3))):
        mutate(table, data.draw, values)
    answered(lambda: campaign_of(table, ROOM / "campaigns" / "mutant.toml"))
