"""A folder of a user's own runs is read, evaluated and used for training; unusable data are refused."""

import numpy as np
import pandas as pd
import pytest
from data_table import data_table
from one_process import one_process
from scipy.io import savemat
from wrong import table as stored

import railgrip as rg
from railgrip.base.errors import EstimationError, ScenarioError
from railgrip.estimation.axle_box import recordings
from railgrip.estimation.axle_box.recordings import (
    PERIOD,
    UNITS,
    plain_table,
    read_folder,
    read_labels,
    read_recordings_file,
)
from railgrip.estimators.learned.trained import BOXES, GeneralEstimator, load

RATE = 5120
SECONDS = 6.4


def signals(seed=1, seconds=SECONDS, speed=26.8, rate=RATE):
    draw = np.random.default_rng(seed)
    count = int(seconds * rate)
    columns = {"time": np.arange(count) / rate, "speed": np.full(count, speed)}
    return columns | {name: 268 + draw.standard_normal(count) for name in BOXES}


def write(file, columns):
    frame = pd.DataFrame(columns)
    if file.suffix == ".parquet":
        frame.to_parquet(file)
    elif file.suffix == ".mat":
        savemat(file, {name.replace("[", "_").replace("]", ""): frame[name].to_numpy() for name in frame})
    else:
        frame.to_csv(file, index=False)
    return file.name


def write_labels(file, rows, header="file,friction,direction"):
    file.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows), ""]))
    return file


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for k in range(4):
        write(folder / f"{k}.parquet", signals(k))
    return folder


@pytest.fixture(scope="module")
def dataset(folder):
    labels = write_labels(folder / "labels.csv", [(f"{k}.parquet", 0.1 + 0.08 * k, (-1) ** k) for k in range(4)])
    return read_folder(folder, labels)


def test_runs_yield_scores_and_estimators(folder, dataset, tmp_path, monkeypatch):
    assert [run.group for run in dataset[0]] == [60] * 4
    assert [run.friction for run in dataset[0]] == pytest.approx([0.10, 0.18, 0.26, 0.34])
    assert dataset[0][0].blocks.shape == (int(SECONDS * RATE) // 50, 20)
    file = folder / "mine.toml"
    network = '[network]\ninputs = "left, right"\nstarts = 1\n'
    file.write_text(f'name = "mine"\n[runs]\nfolder = "."\nlabels = "labels.csv"\n{network}')
    monkeypatch.setattr(recordings, "MEMBERS", 12)
    monkeypatch.setattr(recordings, "read_folder", lambda *_: (dataset[0], ("0.parquet: mended.",)))
    with one_process():
        scores = rg.learn_friction(file, tmp_path)
    assert scores[["estimator", "judged_on", "mph", "starts"]].fillna(0).values.tolist() == [
        ["network of the paper", "last 20 % of runs seen", 60, 1],
        ["network of the paper", "a run left out", 60, 1],
        ["all speeds", "a run left out", 0, 1],
    ]
    assert scores["mae"].between(0, 1).all()
    assert scores.attrs["repairs"] == ("0.parquet: mended.",)
    names = {f"friction{speed}.{kind}" for speed in ("", "_60mph") for kind in ("json", "fmu")}
    assert {path.name for path in tmp_path.glob("friction*")} == names
    general = load(tmp_path / "friction.json")
    assert isinstance(general, GeneralEstimator)
    assert general.ensemble.second == ()  # the slope of a real creep curve is unknown
    assert load(tmp_path / "friction_60mph.json").networks[0].hidden_weights.shape == (6, 8)


def test_direction_rotates_the_car(folder, dataset, tmp_path):
    behind = read_folder(folder, write_labels(tmp_path / "b.csv", [("0.parquet", 0.2, -1), ("1.parquet", 0.3, 1)]))
    ahead, reversed_run = dataset[0][0].slow, behind[0][0].slow
    np.testing.assert_array_equal(reversed_run[:, :4], -ahead[:, 3::-1])
    np.testing.assert_array_equal(reversed_run[:, 4:8], ahead[:, 7:3:-1])


def table(units="m/s**2", names=None, **changes):
    names = names or {name: name for name in UNITS}
    columns = {name: {"column": column, "unit": "m/s" if name == "speed" else units} for name, column in names.items()}
    values = {"time": {"column": "time", "unit": "s"}, "period": PERIOD, "frozen": 0.5, "spike": 20.0}
    return data_table(columns, longest_gap=0.05, **values | changes)


def one_run(folder, columns, chosen=None, suffix=".parquet"):
    names = [write(folder / f"a{suffix}", columns), write(folder / f"b{suffix}", columns)]
    labels = write_labels(folder / "labels.csv", [(names[0], 0.2, 1), (names[1], 0.3, 1)])
    return read_folder(folder, labels, chosen)


def test_units_and_names_are_converted_by_the_map(folder, dataset, tmp_path):
    """The same run in g, under the names of a MATLAB file."""
    columns = signals(0)
    columns |= {name: columns[name] / 9.80665 for name in BOXES}
    names = {name: name.replace("[", "_").replace("]", "") for name in UNITS}
    run = one_run(tmp_path, columns, table("g_n", names), ".mat")[0][0]
    # A division and a multiplication round at 270 * 2e-16, which the filter accumulates.
    np.testing.assert_allclose(run.slow, dataset[0][0].slow, rtol=0, atol=1e-9)


def test_another_rate_is_resampled(tmp_path):
    """2560 samples a second of motions below 20 Hz give the slow signals of 5120, apart from interpolation.

    Straight lines between samples of 20 Hz are off by (2 pi 20 / 2560)^2 / 8 = 3e-4 of the amplitude.
    """
    fine = signals(0)
    waves = {name: 268 + np.sin(2 * np.pi * (2 + k) * fine["time"]) for k, name in enumerate(BOXES)}
    whole = one_run(tmp_path, fine | waves)[0][0].slow
    coarse = {name: values[::2] for name, values in (fine | waves).items()}
    (tmp_path / "coarse").mkdir()
    run = one_run(tmp_path / "coarse", coarse)[0][0].slow
    count = min(len(whole), len(run))
    np.testing.assert_allclose(run[128:count], whole[128:count], rtol=0, atol=2 * 2 * 3e-4)


def test_a_short_gap_is_interpolated_and_a_spike_is_reported(tmp_path):
    columns = signals(0)
    columns["left[2]"][5000:5100] = np.nan  # 20 ms
    columns["right[1]"][9000] = 2000.0
    run = one_run(tmp_path, columns)
    assert np.isfinite(run[0][0].slow).all()
    assert "a.parquet: left[2], 0.976–0.996 s: no samples; interpolated between the neighbours." in run[1]
    assert any(remark.startswith("a.parquet: right[1], 1.758 s (1 samples): off") for remark in run[1])


def test_only_the_period_covered_by_all_sensors_is_used(tmp_path):
    columns = signals(0, seconds=7.0)
    columns["left[1]"][:1024] = np.nan
    assert len(one_run(tmp_path, columns)[0][0].slow) == (int(7.0 * RATE) - 1024) // 40


def spoiled(name, begin, end, value):
    columns = signals(0)
    columns[name][begin:end] = value
    return columns


@pytest.mark.parametrize(
    ("recording", "sentence"),
    [
        (lambda: spoiled("left[3]", 2000, 4000, np.nan), r"left\[3\] is missing from 0\.390 s for 0\.391 s \(gap\)"),
        (lambda: spoiled("left[3]", 2000, 8000, 268.1), r"left\[3\] is missing from 0\.391 s for 1\.17 s \(frozen"),
        (lambda: spoiled("lateral[1]", 0, None, np.nan), r"lateral\[1\].* has 0 usable samples"),
        (lambda: spoiled("speed", 0, None, 0.2), r"the 6\.4 s and 1 m that all sensors cover are too little"),
        (lambda: signals(0, seconds=3.0), r"the 3\.0 s and 80 m that all sensors cover are too little"),
        (lambda: signals(0, seconds=9.0, rate=100), r"left\[1\] has 100 samples a second; estimators need 256 or more"),
        (lambda: {k: v for k, v in signals(0).items() if k != "left[3]"}, r"has no column 'left\[3\]'"),
    ],
    ids=["gap", "frozen", "dead", "standing", "short", "slow", "column"],
)
def test_unusable_data_are_refused(tmp_path, recording, sentence):
    with pytest.raises(EstimationError, match=sentence):
        one_run(tmp_path, recording())


def test_a_map_that_does_not_match_is_refused(tmp_path):
    labels = write_labels(tmp_path / "labels.csv", [("a.csv", 0.2, 1), ("b.csv", 0.3, 1)])
    with pytest.raises(EstimationError, match=r"period is 1000 us; write '195\.312 us', 5120 samples a second"):
        read_folder(tmp_path, labels, table(period=1e-3))
    few = {name: name for name in UNITS if name != "lateral[4]"}
    with pytest.raises(EstimationError, match=r"\[data\.columns\] lacks lateral\[4\]"):
        read_folder(tmp_path, labels, table(names=few))
    with pytest.raises(EstimationError, match=r"a\.csv: there is no such file"):
        read_folder(tmp_path, labels)
    with pytest.raises(EstimationError, match=r"gone\.csv: there is no such file"):
        read_folder(tmp_path, tmp_path / "gone.csv")
    write(tmp_path / "a.csv", {name: values[:100] for name, values in signals(0).items()})
    with pytest.raises(EstimationError, match=r"left\[1\].*kg"):
        read_folder(tmp_path, labels, table("kg"))


@pytest.mark.parametrize(("rows", "sentence"), stored(__file__, "tables.toml")["wrong_labels"])
def test_an_impossible_label_is_refused(tmp_path, rows, sentence):
    with pytest.raises(EstimationError, match=sentence):
        read_labels(write_labels(tmp_path / "labels.csv", rows))


def test_a_file_has_the_inputs_of_the_training(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('name = "mine"\n[runs]\nfolder = "runs"\nlabels = "l.csv"\n[network]\ninputs = "lateral, yaw"\n')
    table = read_recordings_file(path)
    assert table.network.recipe().inputs == "lateral, yaw"
    assert table.data is None
    assert set(plain_table().columns) == set(UNITS)
    path.write_text('name = "mine"\n[runs]\nfolder = "runs"\nlabels = "l.csv"\n[network]\ninputs = "vertical"\n')
    with pytest.raises(ScenarioError, match=r"\[network\] inputs is 'vertical'; there is longitudinal, lateral, yaw; "):
        read_recordings_file(path)
