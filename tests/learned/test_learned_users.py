"""A folder of somebody's own runs is read, judged and answered with sentences."""

import numpy as np
import pytest

from estimators.learned.online import BOXES
from harness.learn.own import judge_own
from harness.learn.users import COLUMNS, DataError, read_labels, read_runs, read_table

RATE = 5120


def write_run(file, generator, seconds=6.2, speed=26.8, rate=RATE, **spoiled):
    count = int(seconds * rate)
    held = {"time": np.arange(count) / rate, "speed": np.full(count, speed)}
    held |= {name: 268 + generator.standard_normal(count) for name in BOXES}
    held |= spoiled
    header = ",".join(held)
    np.savetxt(file, np.column_stack(list(held.values())), delimiter=",", header=header, comments="", fmt="%.9g")


def write_labels(file, rows, header="file,friction,direction"):
    file.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows), ""]))
    return file


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("runs")
    draw = np.random.default_rng(1)
    for k in range(4):
        write_run(made / f"{k}.csv", draw)
    return made


def test_runs_become_a_report(folder, tmp_path):
    labels = write_labels(tmp_path / "labels.csv", [(f"{k}.csv", 0.1 + 0.08 * k, (-1) ** k) for k in range(4)])
    runs = read_runs(folder, labels)
    assert [run.group for run in runs] == [60] * 4
    assert [run.friction for run in runs] == pytest.approx([0.10, 0.18, 0.26, 0.34])
    assert runs[0].blocks.shape == (int(6.2 * RATE) // 50, 12)
    text, ensemble = judge_own(runs)
    assert "a run left out" in text
    assert ensemble.second == ()  # nobody knows the slope of a real creep curve


def test_direction_turns_the_car_around(folder, tmp_path):
    ahead, _ = read_runs(folder, write_labels(tmp_path / "a.csv", [("0.csv", 0.2, 1), ("1.csv", 0.3, 1)]))
    behind, _ = read_runs(folder, write_labels(tmp_path / "b.csv", [("0.csv", 0.2, -1), ("1.csv", 0.3, 1)]))
    np.testing.assert_array_equal(behind.slow[:, :4], -ahead.slow[:, 3::-1])
    np.testing.assert_array_equal(behind.slow[:, 4:], ahead.slow[:, :3:-1])


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match=r"there is no file .*gone\.csv"):
        read_table(tmp_path / "gone.csv")


def test_a_missing_column_is_named(tmp_path):
    (tmp_path / "few.csv").write_text(",".join(c for c in COLUMNS if c != "left[3]") + "\n1\n")
    with pytest.raises(DataError, match=r"few\.csv: it has no column left\[3\]"):
        read_table(tmp_path / "few.csv")


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ([("a.csv", 1.2, 1), ("b.csv", 0.2, 1)], "line 2: friction lies between 0 and 1, got 1.2"),
        ([("a.csv", 0.3, 1), ("b.csv", "wet", 1)], "line 3: friction is a number, got 'wet'"),
        ([("a.csv", 0.3, 2), ("b.csv", 0.2, 1)], "line 2: direction is 1 or -1, got 2"),
        ([("a.csv", 0.3, 1), ("a.csv", 0.2, 1)], "line 3: a.csv is labelled twice"),
        ([("a.csv", 0.3, 1)], "it labels 1 runs; training needs 2 or more"),
    ],
)
def test_a_label_that_cannot_be_is_answered(tmp_path, rows, sentence):
    with pytest.raises(DataError, match=sentence):
        read_labels(write_labels(tmp_path / "labels.csv", rows))


def test_another_rate_is_refused(tmp_path):
    write_run(tmp_path / "slow.csv", np.random.default_rng(0), seconds=12, rate=512)
    write_run(tmp_path / "too.csv", np.random.default_rng(0), seconds=12, rate=512)
    labels = write_labels(tmp_path / "labels.csv", [("slow.csv", 0.2, 1), ("too.csv", 0.3, 1)])
    with pytest.raises(DataError, match=r"slow\.csv: it has 512 samples a second; resample it to 5120"):
        read_runs(tmp_path, labels)


def test_a_gap_is_named(tmp_path):
    values = np.full(100, 3.0)
    values[7] = np.nan
    write_run(tmp_path / "gap.csv", np.random.default_rng(0), seconds=100 / RATE, speed=10.0, **{"left[2]": values})
    with pytest.raises(DataError, match=r"line 9: left\[2\] is nan"):
        read_table(tmp_path / "gap.csv")
