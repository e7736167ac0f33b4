"""Clocks and tables as loggers write them: read with the right instants, or refused with the cause."""

import re
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from data_table import data_table
from wrong import table as stored

from railgrip.base.errors import EstimationError
from railgrip.estimation.inspection import inspect_recording
from railgrip.recording.delimited import cause_of_step_back
from railgrip.recording.files import read_series
from railgrip.recording.read import read_recording

SPEED = {"v": {"column": "v", "unit": "m/s"}}
T = np.arange(0.0, 130.0, 0.5)
"""Two minutes, so that clocks pass a full minute."""
V = 20.0 - 0.1 * T + 0.01 * np.sin(9.0 * T)


@pytest.fixture(autouse=True, scope="module")
def _own_zone():
    """Instants are those of the file, whatever the time zone of the machine is, here with half hours of summer time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TZ", "AAA-10:30BBB-11,M1.1.0,M11.2.0")
        getattr(time, "tzset", int)()
        yield
    getattr(time, "tzset", int)()


def table(columns=SPEED, **changes):
    return data_table(columns, **{"period": "0.5 s", "longest_gap": "2 s", "frozen": "9 s"} | changes)


def times_of(path, **changes):
    """Return the instants of a file from the first, and its speeds."""
    series = next(iter(read_series(path, table(**changes)).values()))
    return series.time - series.time[0], series.values


def csv(folder, text_or_columns):
    path = folder / "run.csv"
    if isinstance(text_or_columns, str):
        path.write_text(text_or_columns, encoding="utf-8")
    else:
        pd.DataFrame(text_or_columns).to_csv(path, index=False)
    return path


def stamps(form, begin="2025-01-04 23:59:30", zone="UTC"):
    time = pd.Timestamp(begin, tz="UTC") + pd.to_timedelta(T, unit="s")
    return time.tz_convert(zone).strftime(form)


@pytest.mark.parametrize(("form", "time"), stored(__file__, "tables.toml")["dates"])
@pytest.mark.parametrize("begin", ["2025-01-04 23:59:30", "2025-11-12 23:59:30"])
def test_dates_over_midnight_have_the_right_instants(tmp_path, form, time, begin):
    path = csv(tmp_path, {"t": stamps(form, begin), "v": V})
    found, _ = times_of(path, time={"column": "t", "unit": "timestamp"} | time)
    np.testing.assert_allclose(found, T, atol=1e-6)


def test_one_date_needs_no_order(tmp_path):
    path = csv(tmp_path, {"t": stamps("%d/%m/%Y %H:%M:%S.%f", "2025-01-04 10:00"), "v": V})
    np.testing.assert_allclose(times_of(path, time={"column": "t", "unit": "timestamp"})[0], T, atol=1e-6)


@pytest.mark.parametrize(
    ("forms", "begin", "sentence"),
    [
        (("%d/%m/%Y", "%m/%d/%Y", "%d-%m-%Y"), "2025-01-04 23:59:30", r"month may be first; write order = 'day first'"),
        # The year may be first: 25-01-31 and 25-02-01 as days of 2031 and 2001 are 30 years apart.
        *((("%y-%m-%d", "%y/%m/%d", "%d-%m-%y"), f"2025-01-{day} 23:59:30", "two digits and may be first or last")
          for day in (30, 31)),
        # Of spreadsheets: as hours and minutes, which pandas reads, they would last sixty times as long.
        (("%M:%S.%f", "%M:%S,%f", "2025-01-04 %M:%S.%f"), "2025-01-04 10:00", "with one colon; write hours, minutes"),
    ],
)  # fmt: skip
def test_ambiguous_dates_and_times_are_asked_for(tmp_path, forms, begin, sentence):
    for form in forms:
        path = csv(tmp_path, {"t": stamps(form if "S" in form else f"{form} %H:%M:%S.%f", begin), "v": V})
        with pytest.raises(EstimationError, match=sentence):
            times_of(path, time={"column": "t", "unit": "timestamp"})


@pytest.mark.parametrize("header", ["t,v,p,v", "t,v,p,v ", "t, v,p,v"])
def test_a_name_of_two_columns_names_neither(tmp_path, header):
    path = csv(tmp_path, header + "\n0,1,5,9\n0.5,2,5,8\n1,3,5,7\n")
    with pytest.raises(EstimationError, match=r"has no column 'v'; it has t, column 2: v, p, column 4: v"):
        times_of(path)
    found = read_series(path, table({"v": {"column": "column 4: v", "unit": "m/s"}}))
    assert found["column 4: v"].values.tolist() == [9.0, 8.0, 7.0]


@pytest.mark.parametrize("blank", ["unchanged", "missing"])
def test_rows_of_one_signal_each_at_the_same_instant_are_one_sample(tmp_path, blank):
    """A bus logger writes a row for each message; the later ones are not a period late, and not lost."""
    v, p = 20.0 - T, 3.0 + 0.1 * T
    rows = "".join(f"{t},{v[k]},\n{t},,{p[k]}\n" for k, t in enumerate(T))
    columns = SPEED | {"p": {"column": "p", "unit": "bar"}}
    recording = read_recording(
        csv(tmp_path, "t,v,p\n" + rows), table(columns, blank=blank), {"v": "m/s", "p": "Pa"}, ["p"], ["v"]
    ).recording
    np.testing.assert_allclose(recording["reading_p"].values, 1e5 * p)
    np.testing.assert_allclose(recording["reading_v"].values, v)


def test_times_of_day_as_hhmmss_are_recognised(tmp_path):
    seconds = 13 * 3600 + 59 * 60 + 10 + T
    number = np.floor(seconds / 3600) * 1e4 + np.floor(seconds % 3600 / 60) * 100 + seconds % 60
    path = csv(tmp_path, {"t": number, "v": V})
    with pytest.raises(EstimationError, match="unit = 'hhmmss'"):
        times_of(path)
    np.testing.assert_allclose(times_of(path, time={"column": "t", "unit": "hhmmss"})[0], T, atol=1e-6)


@pytest.mark.parametrize(
    ("column", "unit", "cause"),
    [
        (stamps("%H:%M:%S.%f"), "timestamp", "passes midnight"),
        (stamps("%Y-%m-%d %H:%M:%S.%f", "2025-10-26 00:59:30", "Europe/Berlin").str[:24], "timestamp", "daylight"),
        ((2**32 - 20e6 + 1e6 * T) % 2**32, "us", "counter of 32 bits overflows: add 4294.967296 s"),
        ((2**32 - 20e8 + 1e8 * T) % 2**32 / 1e8, "s", "counter of 32 bits overflows: add 42.94967296 s"),
        ((65536 - 20e3 + 1e3 * T) % 65536, "ms", "counter of 16 bits overflows: add 65.536 s"),
        (np.concatenate([T[:100], T[:160]]), "s", "cut the file there"),
        (T[::-1], "s", "restore their order"),
    ],
    ids=["midnight", "daylight saving", "microseconds", "10 ns", "16 bits", "two recordings", "reversed"],
)
def test_a_clock_that_runs_backwards_is_named(tmp_path, column, unit, cause):
    """ "Sort the file" would mix both hours, or put the second half first."""
    path = csv(tmp_path, {"t": column, "v": V})
    with pytest.raises(EstimationError, match=f"time goes backwards.*{cause}") as refusal:
        read_recording(path, table(time={"column": "t", "unit": unit}), {"v": "m/s"}, ["v"], [])
    assert "sort" not in str(refusal.value)
    if unit == "s":
        try:
            (notice,) = inspect_recording(path, Path("wagon"), time="t").notices
        except EstimationError as no_two_values_at_rising_times:
            notice = str(no_two_values_at_rising_times)
        assert re.search(f"time goes backwards at sample .*{cause}.*estimate` refuses the file", notice)


def test_a_clock_that_is_set_back_by_another_time_is_not_explained_away():
    assert "set back" in cause_of_step_back(500.0, 433.0, 0.5)


def test_stamps_cut_to_seconds_are_reported_and_spread(tmp_path):
    path = csv(tmp_path, {"t": np.floor(T / 5) * 5, "v": V})
    (series,) = read_series(path, table()).values()
    assert "234 of 260 rows of run.csv repeat an instant" in series.notices[0]
    found, _ = times_of(path, time={"column": "t", "unit": "s", "repeats": "spread"})
    np.testing.assert_allclose(found, T, atol=1e-9)


@pytest.mark.parametrize("blank", [None, "unchanged", "missing"])
def test_a_log_of_changes_is_filled_if_the_map_says_so(tmp_path, blank):
    rows, columns = 300, 5
    values = np.full((rows, columns), np.nan)
    values[0] = 1.0
    draw = np.random.default_rng(2)
    for row in range(1, rows):
        values[row, draw.integers(columns)] = row
    path = csv(tmp_path, {"t": np.arange(rows) * 0.1} | {f"c{i}": values[:, i] for i in range(columns)})
    maps = {f"x[{i}]": {"column": f"c{i}", "unit": "m/s"} for i in range(columns)}
    if blank is None:
        with pytest.raises(EstimationError, match=r"write blank = 'unchanged'"):
            read_series(path, table(maps))
        return
    found = np.stack([series.values for series in read_series(path, table(maps, blank=blank)).values()], axis=1)
    expected = pd.DataFrame(values).ffill().to_numpy() if blank == "unchanged" else values
    np.testing.assert_array_equal(found, expected)


def test_repeated_headers_and_footers_are_left_out(tmp_path):
    """Also a footer with quotes, or with blank lines between its lines."""
    lines = ["t,v", *(f"{t},{v}" for t, v in zip(T, V, strict=True))]
    lines[100:100] = ["t,v"]
    path = csv(tmp_path, "\n".join([*lines, "", "End of file", "", '"Operator: X"', "Summary"]) + "\n")
    (series,) = read_series(path, table()).values()
    np.testing.assert_allclose(series.time, T)
    assert "1 lines repeat the header, the first is line 101" in series.notices[0]
    assert "3 lines at the end" in series.notices[1]


@pytest.mark.parametrize(
    ("separator", "form"),
    [(";", lambda v: f"{v:,.2f}"), (";", lambda v: f"{v:,.2f}".replace(",", "'")),
     (";", lambda v: f"{v:,.2f}".replace(",", " ").replace(".", ",")),
     (";", lambda v: f"{v:,.2f}".translate(str.maketrans(",.", ".,")))],
    ids=["1,234.50", "1'234.50", "1 234,50", "1.234,50"],
)  # fmt: skip
def test_separators_of_thousands_that_are_certain_are_removed(tmp_path, separator, form):
    values = np.round(100.0 * V, 2)
    decimal = "," if form(0.5) == "0,50" else "."
    text = "\n".join(f"{t:.1f}".replace(".", decimal) + separator + form(v) for t, v in zip(T, values, strict=True))
    path = csv(tmp_path, f"t{separator}v\n{text}\n")
    np.testing.assert_allclose(times_of(path)[1], values, rtol=1e-12)


@pytest.mark.parametrize("kind", ["index of dates", "index of numbers", "dates", "dates with a zone"])
def test_index_and_dates_of_parquet_are_columns(tmp_path, kind):
    pytest.importorskip("pyarrow")
    dates = pd.Timestamp("2025-01-04 10:00") + pd.to_timedelta(T, unit="s")
    frame = pd.DataFrame({"v": V})
    frame["t"] = T if kind == "index of numbers" else dates.tz_localize("Europe/Berlin") if "zone" in kind else dates
    path = tmp_path / "run.parquet"
    (frame.set_index("t") if "index" in kind else frame).to_parquet(path)
    unit = "s" if kind == "index of numbers" else "timestamp"
    found, values = times_of(path, time={"column": "t", "unit": unit})
    np.testing.assert_allclose(found, T, atol=1e-6)
    np.testing.assert_array_equal(values, V)


@pytest.mark.parametrize("version", ["3.30", "4.10"])
def test_a_channel_that_occurs_twice_has_a_group(tmp_path, version):
    """Twice in one group and once in another, as a channel at several rates."""
    asammdf = pytest.importorskip("asammdf")

    def signal(factor, time=T):
        return asammdf.Signal(samples=factor * np.interp(time, T, V), timestamps=time, name="v", unit="m/s")

    file = asammdf.MDF(version=version)
    file.append([signal(1.0), signal(2.0)])
    file.append([signal(3.0, T[::2])])
    path = tmp_path / ("run.mdf" if version < "4" else "run.mf4")
    file.save(path)
    with pytest.raises(EstimationError, match=r"there are 3 channels 'v'.*write group"):
        read_series(path, table())
    places = [(0, 1), (0, 2), (1, None)]
    for factor, (group, index) in enumerate(places, start=1):
        place = {"group": group} | ({} if index is None else {"index": index})
        (series,) = read_series(path, table({"v": {"column": "v"} | place})).values()
        np.testing.assert_allclose(series.values, factor * np.interp(series.time, T, V))


@pytest.mark.parametrize("period", [0.001, 0.01, 0.1, 1.0])
def test_a_clock_since_1970_keeps_its_resolution(tmp_path, period):
    """In the proposal, over a gap that begin and end avoid."""
    time = 1.76295e9 + period * np.concatenate([np.arange(50), 5000 + np.arange(200)])
    columns = {"t [s]": time, "v [m/s]": 20.0 + 0.01 * np.sin(time)}
    columns |= {"n [rad/s]": 40.0 + np.sin(time), "F [kN]": 10.0 + np.cos(time)}
    inspection = inspect_recording(csv(tmp_path, columns), Path("rig_own"))
    assert f'period = "{1e3 * period:g} ms"' in inspection.proposal
    lines = dict(line.split(" = ", 1) for line in inspection.proposal.splitlines() if line.startswith(("begin", "end")))
    begin, end = (float(lines[key].split('"')[1].removesuffix(" s")) for key in ("begin", "end"))
    assert begin == pytest.approx(time[50], abs=0.1 * period)
    assert end == pytest.approx(time[-1], abs=0.1 * period)
