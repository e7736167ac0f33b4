"""The filter of the field test and its tuning, on case 1, which is the shortest."""

import field_runs
import numpy as np
import pandas as pd
import pytest

from railgrip.base.errors import EstimationError, EstimatorError, ScenarioError
from railgrip.campaign.work import call, work
from railgrip.estimation.field_test import filtering
from railgrip.estimation.field_test.filtering import (
    NOISES,
    PHYSICAL,
    Noise,
    cases,
    divergence_time,
    follow,
    load_noise,
    save_noise,
    task_of,
)
from railgrip.estimation.field_test.filtering import run as run_case
from railgrip.estimation.field_test.score import Search, limits, score, terms_of, track_score, tune, value
from railgrip.estimation.motion import brake_mask, braking_of, traction_mask
from railgrip.estimation.results import observe, with_estimates_as_truth
from railgrip.estimation.sources import recording_for
from railgrip.estimation.spec import estimate_of
from railgrip.recording.samples import reading_of, truth_of, with_signals
from railgrip.report.style import save


@pytest.fixture(scope="module")
def case():
    return run_case(("c1", cases()["c1"]))


@pytest.fixture(scope="module")
def run(case):
    return case.recording


@pytest.fixture(scope="module")
def model():
    return filtering.equations()


@pytest.fixture(scope="module")
def task(case, model):
    return task_of(case.braking, model)


@pytest.fixture
def filter_(task, model):
    return filtering.filter_of(model, task.data.period)


def test_the_case_is_driven_as_in_table_4(run):
    brakes = int(np.argmax(brake_mask(run)))
    # The driver compares the speed every 5 ms: 65 km/h to 1 mm/s.
    assert truth_of(run, "v")[brakes] * 3.6 == pytest.approx(65.0, abs=0.01)
    pressures = [reading_of(run, f"cylinder_pressure[{i}]")[-1] / 1e5 for i in (1, 2)]
    # Filled through a first-order lag of 0.9 s over 15 s, read to 1 kPa.
    assert pressures == pytest.approx([3.4, 2.0], abs=0.05)


def test_case_6_has_the_times_of_figure_3():
    """Drives to 20 s and from 38 to 70 s, braking from 80 s at 85 km/h, standstill at 102 s."""
    run = run_case(("c6", cases()["c6"])).recording
    time, speed = run["time"].values, truth_of(run, "v")
    starts = np.flatnonzero(np.diff(traction_mask(run).astype(int)) == 1) + 1
    # A sample of the trace; the demand changes between two of them.
    assert time[starts] == pytest.approx([0.0, 38.0], abs=0.03)
    brakes = int(np.argmax(brake_mask(run)))
    assert time[brakes] == pytest.approx(80.0, abs=0.03)
    # The paper rounds speeds to 1 km/h and times to 1 s.
    assert 3.6 * speed[brakes] == pytest.approx(85.0, abs=0.5)
    deceleration = (speed[-51] - speed[-1]) / (time[-1] - time[-51])
    assert time[-1] + speed[-1] / deceleration == pytest.approx(102.0, abs=0.5)


def test_another_seed_changes_the_readings_but_not_the_run(run):
    other = run_case(("c1", cases()["c1"].model_copy(update={"seed": 1}))).recording
    np.testing.assert_array_equal(truth_of(other, "v"), truth_of(run, "v"))
    apart = reading_of(other, "speed") - reading_of(run, "speed")
    # Two white noises of 0.02 m/s, and two scales of 0.1 %, which are as much again at 18 m/s.
    assert 0.02 < apart.std() < 0.06


def test_the_track_is_recovered(case):
    errors = track_score(case)
    assert abs(errors["distance"]) < 5e-3
    # Half of a curve of 1000 m and a third of the smallest change of gradient, 3 ‰; measured 1.6e-4 and 0.7 ‰.
    assert errors["curvature"] < 5e-4
    assert errors["slope"] < 1.5e-3
    # One percent of the 97 kN of a full brake; measured 0.4 kN.
    assert errors["force"] < 1e3


def test_the_friction_of_the_train_is_found_but_not_its_distribution(task, filter_):
    errors = score(task, follow(task, filter_, PHYSICAL))
    # Relative to the best constants, which are only known afterwards; measured 0.34 and 0.24 of their error.
    assert errors["mean_pad_friction"] < 0.5 * errors["mean_pad_friction_constant"]
    assert errors["adhesion"] < 0.4 * errors["adhesion_constant"]
    # Five rates cannot determine eight frictions: single groups are as inaccurate as one constant for all, measured
    # 1.1 of its error, yet better than with noises tuned for consistency, measured 0.5 of their error.
    tuned = score(task, follow(task, filter_, load_noise(NOISES / "consistent.toml")))
    assert errors["pad_friction_constant"] < errors["pad_friction"] < 0.85 * tuned["pad_friction"]
    assert abs(errors["distance"]) < 5e-3


def test_innovations_reveal_an_overconfident_filter(task, filter_):
    """With variances scaled by 1e-8 gains and means are unchanged, so only innovations can reveal it."""
    assert divergence_time(task, follow(task, filter_, PHYSICAL)) is None
    overconfident = follow(task, filter_, PHYSICAL.scale(1e-8, 1e-8), start_scale=1e-8)
    assert divergence_time(task, overconfident) == pytest.approx(
        100 * task.data.period
    )  # after the first window of steps


def test_the_estimation_file_contains_the_filter_of_the_study(run, case, task, filter_):
    """`railgrip estimate` with [course], and the arrays of the study."""
    specification = filtering.specification()
    estimates = estimate_of(specification, braking_of(run, specification.course).recording)
    np.testing.assert_array_equal(estimates["time"].values, case.braking.recording["time"].values)
    # The FMU and the equations of one class, noises of the file with seven digits.
    reference = follow(task, filter_, PHYSICAL).mean
    np.testing.assert_allclose(estimates["mean"].values[1:], reference, rtol=1e-9, atol=1e-12)


def test_a_file_of_the_train_gives_the_estimates_of_the_run(run, tmp_path):
    """Through csv in the units of the library's map, without the driver's brake signal."""
    specification = filtering.specification()
    data, columns = specification.data, {"time": run["time"].values}
    factors = {"km/h": 3.6, "rev/min": 30.0 / np.pi, "bar": 1e-5}
    train = with_signals(run, {"driving": (traction_mask(run), "1"), "braking": (brake_mask(run), "1")})
    for name, column in data.columns.items():
        columns[column.column] = reading_of(train, name) * factors.get(column.unit, 1.0)
    other_columns = {name: column for name, column in data.columns.items() if name != "braking"}
    spec = specification.model_copy(update={"data": data.model_copy(update={"columns": other_columns})})
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    record = recording_for(spec, tmp_path / "run.csv")
    through = braking_of(record.recording, spec.course).recording
    pads = [
        estimate_of(spec, one)["mean"].sel(state="pad_friction[1]").values[-500:]
        for one in (through, braking_of(run, spec.course).recording)
    ]
    # One reading in ten thousand counts as a spike; the filter averages over about a hundred.
    assert np.abs(pads[0] - pads[1]).max() < 2e-3
    assert len(record.flags) < 20
    points, _ = observe(spec, with_estimates_as_truth(spec, through))
    # Five readings and five rates; the eight frictions are not determined.
    assert points[0][2].rank == 10


def test_a_retuned_filter_equals_a_new_one(task, model):
    noise, data = PHYSICAL.scale(3.0, 0.2), task.data
    new, other = filtering.filter_of(model, data.period, noise), filtering.filter_of(model, data.period)
    other.retune(noise.process, noise.readings)
    start = new.start(data.mean, data.covariance)
    means = [one.follow(start, data.inputs[:100], data.readings[:100]).mean for one in (new, other)]
    np.testing.assert_array_equal(*means)
    with pytest.raises(EstimatorError, match="negative eigenvalue"):
        other.retune(-noise.process, noise.readings)


def test_the_objective_of_the_paper_has_blind_spots(task, filter_):
    """It does not change with a common factor on all covariances, and it rewards repeating the readings."""
    factors = np.array([1e-4, 1.0, 1e4])
    terms = [terms_of(task, follow(task, filter_, PHYSICAL.scale(f, f), start_scale=f)) for f in factors]
    # Gains are equal but for rounding; the claimed variance follows the factor exactly.
    np.testing.assert_allclose([one.deviation for one in terms], terms[1].deviation, rtol=1e-6)
    np.testing.assert_allclose([one.nees for one in terms] * factors, terms[1].nees, rtol=1e-6)
    honest, blind = (terms_of(task, follow(task, filter_, PHYSICAL.scale(f, 1.0))) for f in (1.0, 1e-7))
    assert value("paper", [blind]) < 0.01 * value("paper", [honest])
    assert value("consistent", [blind]) > value("consistent", [honest])


def test_noises_at_a_bound_of_the_search_are_marked():
    bounds = np.array(limits())
    sets = {"inside": bounds.mean(axis=1), "low": bounds[:, 0] + 0.05, "high": bounds[:, 1] - 0.05}
    table = field_runs.noise_table({name: Noise.of(logarithms) for name, logarithms in sets.items()})
    for row in table.to_dict("records"):
        assert [row[name].endswith(" (bound)") for name in sets] == [False, True, True]


def test_an_oscillation_is_found_at_its_position():
    """A pulse of 5 % and 0.2 s on a rise over 20 s; the mean over two seconds takes a tenth of it."""
    time = 80.0 + 0.02 * np.arange(1000)
    friction = (0.35 + 0.002 * (time - 80.0)) * np.where(np.abs(time - 86.0) < 0.1, 1.05, 1.0)
    swing, instant = field_runs.oscillation(time, friction)
    assert swing == pytest.approx(0.9 * 0.05, rel=0.1)
    assert instant == pytest.approx(86.0, abs=0.12)


def test_figures_are_readable(case, task, filter_, tmp_path):
    """tests/conftest.py checks every saved figure."""
    for name, drawing in {
        "train": field_runs.train_figure(),
        "track": field_runs.track_figure(case),
        "speed": field_runs.speed_figure(case.recording),
        "readings": field_runs.readings_figure(case.braking),
        "friction": field_runs.friction_figure(task, follow(task, filter_, PHYSICAL)),
    }.items():
        assert save(drawing, tmp_path / f"{name}.png").is_file()


@pytest.mark.usefixtures("in_process", "own_cache")
def test_an_interrupted_search_ends_like_an_uninterrupted_one(task):
    def search(generations, fresh=False):
        with work("field_test", fresh=fresh) as own:
            size = Search(population=8, generations=generations, stage=1, seed=3)
            return tune("paper", [task], size, own.count, lambda stage: own.map(call, [stage])[0]), own.run_count

    search(1)
    whole, run_count = search(2)
    assert run_count == 1
    assert search(2, fresh=True) == (whole, 2)
    assert len(whole[2]) == 2


def test_noises_are_written_and_read_back(tmp_path):
    noise = Noise(tuple(10.0 ** -np.arange(1.0, 13.0)))
    path = save_noise(noise, tmp_path / "noise.toml", title="t", command="c", results={"objective": 0.1})
    # Written with seven digits.
    np.testing.assert_allclose(load_noise(path).values, noise.values, rtol=1e-6)
    path.write_text(path.read_text().replace('"speed" = 1', '"speed" = -1'))
    with pytest.raises(ScenarioError, match=r"\[noise\].*speed is -0\.1"):
        load_noise(path)


@pytest.mark.parametrize("name", ["paper", "consistent"])
def test_the_shipped_noises_name_the_command_that_found_them(name):
    path = NOISES / f"{name}.toml"
    assert len(load_noise(path).values) == 12
    assert f'command = "python tools tune {name} ' in path.read_text()


def test_a_run_without_braking_or_position_is_refused(run):
    course = filtering.specification().course
    with pytest.raises(EstimationError, match="the train did not brake"):
        braking_of(run.isel(time=slice(0, 2500)), course)
    incomplete = run.assign(reading_height=run["reading_height"] * np.nan).isel(time=slice(0, 100))
    with pytest.raises(EstimationError, match="GNSS gave no position"):
        braking_of(incomplete, course)
