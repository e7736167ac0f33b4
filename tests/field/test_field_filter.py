"""The filter of the field test on one of its cases, and what tuning sees of it. Case 1 is the shortest."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from railgrip.campaign.work import work
from railgrip.errors import EstimationError, ScenarioError
from railgrip.estimation.observable import observe, with_estimates_as_truth
from railgrip.estimation.run import prediction_of
from railgrip.estimation.sources import recording_for, with_track_force
from railgrip.estimation.spec import estimate_of, settings_for
from railgrip.estimation.track.braking import Braking, braked, braking_of
from railgrip.estimation.track.braking import driven as driven_of
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.studies.field_test.filtering import Task, equations, filter_of, follow, lost, specification, task_of
from railgrip.studies.field_test.noise import LIBRARY, NAMES, PHYSICAL, Noise, load_noise, save_noise
from railgrip.studies.field_test.objective import terms_of, value
from railgrip.studies.field_test.runs import Run, cases
from railgrip.studies.field_test.runs import run as run_case
from railgrip.studies.field_test.score import common_factor, score, track_score
from railgrip.studies.field_test.tune import Search, tune
from railgrip.trace.samples import reading_of, truth_of, with_signals


@pytest.fixture(scope="module")
def journey() -> Run:
    return run_case(("c1", cases()["c1"]))


@pytest.fixture(scope="module")
def run(journey):
    return journey.recording


@pytest.fixture(scope="module")
def braking(journey) -> Braking:
    return journey.braking


@pytest.fixture(scope="module")
def model():
    return equations()


@pytest.fixture(scope="module")
def task(braking, model) -> Task:
    return task_of(braking, model)


def test_the_case_is_driven_as_table_4_says(run):
    brakes = int(np.argmax(braked(run)))
    # The driver looks at his speed every 5 ms: 65 km/h to 1 mm/s.
    assert truth_of(run, "v")[brakes] * 3.6 == pytest.approx(65.0, abs=0.01)
    pressures = [reading_of(run, f"cylinder_pressure[{i}]")[-1] / 1e5 for i in (1, 2)]
    # Filled through a first-order lag of 0.9 s over 15 s, read to 1 kPa.
    assert pressures == pytest.approx([3.4, 2.0], abs=0.05)


def test_other_sensors_read_the_same_run_otherwise(run):
    other = run_case(("c1", cases()["c1"].model_copy(update={"seed": 1}))).recording
    np.testing.assert_array_equal(truth_of(other, "v"), truth_of(run, "v"))
    apart = reading_of(other, "speed") - reading_of(run, "speed")
    # Two of 0.02 m/s white, and two scales of 0.1 %, which of 18 m/s are as much again.
    assert 0.02 < apart.std() < 0.06


def test_the_track_is_recovered_well_enough(journey):
    scores = track_score(journey)
    assert abs(scores["distance"]) < 5e-3
    # Half of a curve of 1000 m and a third of the smallest change of gradient, 3 ‰; measured 1.6e-4 and 0.7 ‰.
    assert scores["curvature"] < 5e-4
    assert scores["slope"] < 1.5e-3
    # A percent of the 97 kN of a full brake; measured 0.4 kN.
    assert scores["force"] < 1e3


def test_the_whole_train_s_friction_is_found_though_its_groups_share_is_not(task, model):
    scores = score(task, follow(task, filter_of(model, task.period), PHYSICAL))
    # Against the best constants, which are known only afterwards; measured 0.34 and 0.24 of them.
    assert scores["mean_pad_friction"] < 0.5 * scores["mean_pad_friction_constant"]
    assert scores["adhesion"] < 0.4 * scores["adhesion_constant"]
    # Five rates cannot tell eight frictions: single groups are known no better than by one constant for all, measured
    # 1.1 of its error, yet better than with noises tuned for consistency, measured 0.6 of theirs.
    tuned = score(task, follow(task, filter_of(model, task.period), load_noise(LIBRARY / "consistent.toml")))
    assert scores["pad_friction"] > scores["pad_friction_constant"]
    assert scores["pad_friction"] < 0.85 * tuned["pad_friction"]
    assert abs(scores["distance"]) < 5e-3


def test_a_filter_that_claims_far_too_much_is_told_to_be_lost(task, model):
    """The same gains, claims ten thousand times as narrow: no mean moves, so only innovations can tell."""
    filter_ = filter_of(model, task.period)
    assert lost(task, follow(task, filter_, PHYSICAL)) is None
    vain = follow(task, filter_, PHYSICAL.scaled(1e-8, 1e-8), start_scale=1e-8)
    instant = lost(task, vain)
    assert instant == pytest.approx(100 * task.period)  # after the first window of steps


def test_rates_of_five_readings_cannot_tell_eight_frictions_apart(model):
    """Rank of ∂(v̇, ω̇)/∂(μ_B, α), whatever the filter's noises."""
    x = np.array([20.0, *[20 / 0.38] * 4, *[0.35] * 4, 0.13, 0.08, 0.08, 0.13])
    jacobian = model.derivative_jacobian(x, np.array([3.4e5, 2e5, 2e5, 3.4e5, 0.0]))
    assert np.linalg.matrix_rank(jacobian[:5, 5:]) == 5


def test_following_in_c_is_stepping_in_python(task, model):
    """Two hundred steps around the brake's application, where the gate opens and everything moves."""
    compiled, place = filter_of(model, task.period), task.braking.brake - 50
    gate = settings_for(specification(), task.period).gate
    assert gate is not None
    assert task.inputs[place, 0] < gate.threshold < task.inputs[place + 100, 0]
    plain = ExtendedKalmanFilter(model, PHYSICAL.process, PHYSICAL.readings, task.period, gate)
    rows = slice(place, place + 200)
    belief = plain.start(task.start.mean, task.start.covariance)
    estimates = compiled.follow(belief, task.inputs[rows], task.readings[rows])
    for k, (inputs, readings) in enumerate(zip(task.inputs[rows], task.readings[rows], strict=True)):
        belief = plain.step(belief, inputs, readings)
        # Equal but for rounding, which two hundred steps carry on.
        np.testing.assert_allclose(estimates.mean[k], belief.mean, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(estimates.variance[k], np.diag(belief.covariance), rtol=1e-7)


def test_the_estimation_file_is_the_filter_of_the_report(run, braking, task, model):
    """`railgrip estimate` with [course], and the report's way over arrays."""
    estimates = estimate_of(specification(), with_track_force(run, specification().course))
    reference = follow(task, filter_of(model, task.period), PHYSICAL)
    np.testing.assert_array_equal(estimates["time"].values, braking.recording["time"].values)
    # The same C from the same numbers, sums apart.
    np.testing.assert_allclose(estimates["mean"].values[1:], reference.mean, rtol=1e-9, atol=1e-12)


def test_a_train_s_own_file_gives_the_estimates_of_the_run_itself(run, tmp_path: Path):
    """Through csv in the units of the library's map, without the driver's brake signal, and back."""
    data = specification().data
    columns = {"time": run["time"].values}
    factors = {"km/h": 3.6, "rev/min": 30.0 / np.pi, "bar": 1e-5}
    train = with_signals(run, {"driving": (driven_of(run), "1"), "braking": (braked(run), "1")})
    for name, column in data.columns.items():
        columns[column.column] = reading_of(train, name) * factors.get(column.unit, 1.0)
    other_columns = {name: column for name, column in data.columns.items() if name != "braking"}
    spec = specification().model_copy(update={"data": data.model_copy(update={"columns": other_columns})})
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    record = recording_for(spec, tmp_path / "run.csv")
    through = with_track_force(record.recording, spec.course)
    estimates, direct = estimate_of(spec, through), estimate_of(spec, with_track_force(run, spec.course))
    # A reading in ten thousand counts as a spike, which a filter with a hundred in memory hardly feels.
    apart = estimates["mean"].sel(state="mu_b[1]").values[-500:] - direct["mean"].sel(state="mu_b[1]").values[-500:]
    assert np.abs(apart).max() < 2e-3
    assert len(record.flags) < 20
    points, _ = observe(spec, with_estimates_as_truth(spec, through))
    # Eight frictions, five rates: two derivatives tell five more than the five readings.
    assert points[0][2].rank == 10


def test_retuned_is_as_made_anew(task, model):
    noise = PHYSICAL.scaled(3.0, 0.2)
    anew = filter_of(model, task.period, noise).follow(task.start, task.inputs[:100], task.readings[:100])
    other = filter_of(model, task.period)
    other.retune(noise.process, noise.readings)
    np.testing.assert_array_equal(other.follow(task.start, task.inputs[:100], task.readings[:100]).mean, anew.mean)


def test_the_paper_s_objective_does_not_see_a_common_factor(task, model):
    sweep = common_factor([task], filter_of(model, task.period), PHYSICAL)
    # Gains are the same but for rounding; the claimed spread follows the factor exactly.
    np.testing.assert_allclose(sweep["deviation"], sweep["deviation"][0], rtol=1e-6)
    np.testing.assert_allclose(sweep["nees"] * sweep["factor"], sweep["nees"][0] * sweep["factor"][0], rtol=1e-6)


def test_the_paper_s_objective_rewards_repeating_the_readings(task, model):
    filter_ = filter_of(model, task.period)
    honest, blind = (terms_of(task, follow(task, filter_, PHYSICAL.scaled(f, 1.0))) for f in (1.0, 1e-7))
    assert value("paper", [blind]) < 0.01 * value("paper", [honest])
    assert value("consistent", [blind]) > value("consistent", [honest])


@pytest.mark.usefixtures("in_process", "own_cache")
def test_an_interrupted_search_ends_as_one_that_was_not(task):
    def search(generations: int, fresh: bool = False):
        of = Search(population=8, generations=generations, stage=1, seed=3)
        with work("field_test", fresh=fresh) as own:
            return tune("paper", [task], of, own), own.made

    search(1)
    whole, made = search(2)
    assert made == 1
    assert search(2, fresh=True) == (whole, 2)
    assert len(whole[2]) == 2


def test_noises_are_kept_to_the_digit_that_matters(tmp_path: Path):
    noise = Noise(tuple(10.0 ** -np.arange(1.0, 13.0)))
    path = save_noise(noise, tmp_path / "noise.toml", title="t", command="c", results={"objective": 0.1})
    # Written with seven digits.
    np.testing.assert_allclose(load_noise(path).values, noise.values, rtol=1e-6)
    path.write_text(path.read_text().replace('"speed" = 1', '"speed" = -1'))
    with pytest.raises(ScenarioError, match=r"\[noise\].*speed is -0\.1"):
        load_noise(path)


@pytest.mark.parametrize("name", ["paper", "consistent"])
def test_the_committed_noises_say_how_they_were_found(name: str):
    path = LIBRARY / f"{name}.toml"
    assert len(load_noise(path).values) == len(NAMES)
    assert f'command = "railgrip maintain tune {name} ' in path.read_text()


def test_an_output_that_is_not_there_is_refused():
    with pytest.raises(EstimationError, match="TrainPredictionReduced has no output yaw; it has speed"):
        prediction_of("TrainPredictionReduced", outputs=("speed", "yaw"))


def test_a_run_without_braking_or_position_is_refused(run):
    with pytest.raises(EstimationError, match="nobody braked"):
        braking_of(run.isel(time=slice(0, 2500)), 84e3)
    incomplete = run.assign(reading_height=run["reading_height"] * np.nan).isel(time=slice(0, 100))
    with pytest.raises(EstimationError, match="GNSS gave no position"):
        braking_of(incomplete, 84e3)
