"""Recordings of the study of estimators are balanced, equal for all estimators, and evaluated by known errors."""

import json
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pandas
import pytest
import xarray
from command_line import done
from synthetic import TYPICAL
from wrong import table

from railgrip.base.errors import InputError
from railgrip.campaign.work import work
from railgrip.estimation.judgement import judge
from railgrip.estimation.models import model_of
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import estimate_of, load_specification
from railgrip.fmus.build import fmu
from railgrip.scenario.file import locate
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.estimators import replay as own_replay
from railgrip.studies.estimators.case_errors import (
    BUDGET,
    TRUTH,
    available_errors,
    bounds_of,
    errors_of,
    interval_score,
    largest_of_last,
    pads_are_identifiable,
    search,
    step_delay,
    truths_of,
    write_factors,
)
from railgrip.studies.estimators.estimators_study import FACTORS_FILE, Estimators
from railgrip.studies.estimators.recordings import (
    DEMANDS,
    FAMILIES,
    SEEDS,
    SENSORS,
    family_of,
    recording_cases,
    recording_of_case,
    scenario_of_case,
)
from railgrip.studies.estimators.replay import (
    CONSTANT,
    ESTIMATORS,
    FACTORS,
    FORCE_BALANCE,
    LOAD_DEVIATION,
    MODEL,
    REFERENCES,
    bound_of,
    force_over_load_deviation,
    model_of_estimator,
    noise_of,
    read_factors,
    replay,
    states,
    with_unmodelled,
)
from railgrip.studies.estimators.tables import (
    SETTLED,
    by_family,
    errors_of_estimation,
    leaderboard,
    pads_by_group,
    rank_estimators,
    skill,
    skill_of_groups,
    squares_of,
    vehicles,
)
from railgrip.trace.measures import SLOWEST

CONSTANTS = (("adhesion", 0.05), ("pad_friction", 0.35))


@pytest.fixture(autouse=True, scope="module")
def _fmus_are_closed():
    """Close the FMUs that a process of the study keeps open until its end."""
    yield
    own_replay._prediction.cache_clear()
    own_replay._own_prediction.cache_clear()


@pytest.fixture(scope="module")
def short():
    """A recording of few samples: an ideal stop from a low speed on a dry rail."""
    case = recording_cases(48, SEEDS["test"])[9]
    stop = replace(case.stop, speed=5.0, friction=0.15, rail="even", fault="none", gradient="level", load="as believed")
    return replace(case, sensors="ideal", demand="full", over="time", stop=stop)


@pytest.mark.parametrize("count", [12, 48])
def test_every_value_of_the_other_axes_is_equally_frequent(count):
    design = recording_cases(count, SEEDS["test"])
    for field, choices in (("sensors", SENSORS), ("demand", DEMANDS), ("over", ("time", "distance"))):
        assert set(Counter(getattr(case, field) for case in design).values()) == {count // len(choices)}


def test_the_sets_have_no_case_in_common():
    names = [case.stop.name for seed in SEEDS.values() for case in recording_cases(12, seed)]
    assert len(set(names)) == len(names)


def test_every_demand_is_recorded():
    for demand in DEMANDS:
        case = next(case for case in recording_cases(12, SEEDS["test"]) if case.demand == demand)
        recording = recording_of_case(case)
        assert recording.sizes["time"] > 100
        assert float(recording["reading_track_force"].max()) == 0.0


def test_errors_of_a_constant_are_those_of_its_definition(short):
    errors = errors_of((short, CONSTANT, CONSTANTS))
    recording = recording_of_case(short)
    truth = recording["group_adhesion"].values[recording["speed"].values > 10 / 3.6]
    assert errors["rmse"]["adhesion"] == pytest.approx(np.sqrt(np.mean((truth - 0.05) ** 2)), rel=1e-12)
    assert errors["bias"] == pytest.approx(0.05 - np.mean(truth), rel=1e-9)
    assert np.isnan(errors["coverage"]["adhesion"])
    total, count = truths_of(short)["adhesion"]
    assert total / count == pytest.approx(np.mean(truth), rel=1e-12)


def test_filters_that_differ_by_their_linearisation_agree_on_the_train(short):
    """Outputs of the prediction are linear but for the running resistance, and its derivatives nearly so."""
    reference = replay(short, "fmu").mean
    for kind in ("python", "iterated", "unscented", "cubature", "moving_horizon"):
        # The curvature of the prediction within 10 ms, far below the deviation of adhesion of 0.01.
        assert replay(short, kind).mean == pytest.approx(reference, abs=1e-5)


def test_all_estimators_get_the_same_readings_and_are_ranked(short):
    names = [name for name, entry in ESTIMATORS.items() if entry.is_fast or entry.is_reference]
    rows = [{"estimator": name, "case": "short"} | errors_of((short, name, CONSTANTS)) for name in names]
    frame = pandas.json_normalize(rows)
    assert frame["digest"].nunique() == 1
    ranked = rank_estimators(frame)["estimator"].tolist()
    assert ranked == [name for _, name in sorted(zip(frame["rmse.adhesion"], names, strict=True))]
    assert skill(squares_of(frame, FORCE_BALANCE, FORCE_BALANCE)) == 0.0
    assert {"smoother", "fixed_lag", *REFERENCES} <= set(ranked)


@pytest.mark.parametrize("estimator", ["fmu", "python", "disturbed", "fixed_lag"])
def test_a_wheelset_sensor_that_falls_to_0_is_left_out(short, estimator, monkeypatch):
    """The estimate is the same as without this reading, until a wheelset could have lost its speed in a slide."""
    fast = replace(short, stop=replace(short.stop, speed=30.0))
    found = []
    for value in (np.nan, 0.0):
        recording = recording_of_case(fast).isel(time=slice(130)).copy(deep=True)
        recording["reading_wheelset_speed"][100:, 0] = value
        monkeypatch.setattr("railgrip.studies.estimators.replay.recording_of_case", lambda case, it=recording: it)
        found.append(replay(fast, estimator).mean)
    np.testing.assert_array_equal(*found)


WEIGHT = 9.80665 * np.array([13400 + 14100, 14500, 14500, 14100 + 13400])
EFFECT = 0.38 * WEIGHT / np.array([222.0, 209.0, 209.0, 222.0])
"""r N/J of the groups of the two-part train [rad/s²]."""


def modelled(case, found):
    """Variances, except those of errors that are in no equation and follow from the mean."""
    arguments = recording_of_case(case), states(), found.mean
    nothing = np.zeros_like(found.variance)
    return found.variance - with_unmodelled(*arguments, nothing, case.sensors, model_of(MODEL), EFFECT)


def test_the_smoother_is_more_certain_than_the_filter_and_the_bound_positive(short):
    filtered, smoothed = (modelled(short, replay(short, name)) for name in ("fmu", "smoother"))
    assert np.all(smoothed <= filtered * (1.0 + 1e-6))
    assert np.all(bound_of(short) > 0.0)
    assert bound_of(short).shape == (recording_of_case(short).sizes["time"], len(states()))


def test_pad_friction_is_identifiable_once_the_pads_press(short):
    """Readings determine it only through the torque of the pads."""
    recording, known = recording_of_case(short), pads_are_identifiable(short)
    presses = recording["pad_force"].values > RELEASED_PADS
    first = np.argmax(presses, axis=0)
    assert not any(known[: k + 1, group].any() for group, k in enumerate(first))
    # Groups of a single wheelset have about half of the brake force of the others.
    assert known[-1].tolist() == [True, False, False, True]
    assert bounds_of(short)[1] == pytest.approx(
        [np.mean(known[where & (recording["speed"].values > SLOWEST), g]) for g, where in enumerate(presses.T)]
    )


def test_errors_of_single_pads_are_those_of_their_definition(short):
    recording, errors = recording_of_case(short), errors_of((short, CONSTANT, CONSTANTS))
    judged = pads_are_identifiable(short) & (recording["speed"].values > SLOWEST)[:, np.newaxis]
    for group in (0, 3):
        error = 0.35 - recording["pad_friction"].values[judged[:, group], group]
        assert errors["pads"][group] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert np.isnan(errors["pads"][1:3]).all()


def test_the_skill_of_groups_leaves_out_cases_in_which_they_are_not_identifiable():
    own = pandas.DataFrame({"estimator": "own", "pads": [(1.0, np.nan), (3.0, np.nan)]})
    reference = pandas.DataFrame({"pads": [(2.0, 1.0), (np.nan, 1.0)]})
    assert skill_of_groups(own, reference) == [0.75, pytest.approx(np.nan, nan_ok=True)]
    (row,) = pads_by_group(own, [(0.1, (0.5, 0.0))] * 2).rows
    assert row == {"group": 1, "identifiable": 0.5, "own": pytest.approx(np.sqrt(5.0))}


def frame_of(errors, coverage=math.nan):
    """A row for each estimator and case with these errors of adhesion; NaN has diverged."""
    return pandas.DataFrame(
        {"estimator": name, "case": f"case {k}", "rmse.adhesion": error, "diverged": math.isnan(error)}
        | dict.fromkeys(("bias", "delay", "step_delay", "microseconds", "lost", "admitted", "width", "nees", "nis"))
        | {f"{figure}.{target}": coverage for figure, target in (("coverage", "adhesion"), ("coverage", "speed"))}
        | {"pads": (error,) * 2}
        | {field: "all" for field in FAMILIES}
        for name, row in errors.items()
        for k, error in enumerate(row)
    ).astype({"bias": float, "delay": float, "step_delay": float, "microseconds": float})


def test_the_leaderboard_has_medians_and_skills_of_numpy_in_any_order_of_cases():
    draw = np.random.default_rng(1)
    errors = {name: draw.uniform(0.01, 0.1, 12) for name in ("fmu", CONSTANT, FORCE_BALANCE)}
    for order in (np.arange(12), draw.permutation(12)):
        frame = rank_estimators(frame_of({name: values[order] for name, values in errors.items()}))
        assert frame["estimator"].tolist() == sorted(errors, key=lambda name: np.median(errors[name]))
        for row in frame.itertuples():
            own = errors[row.estimator]
            assert row.median == pytest.approx(np.median(own), rel=1e-12)
            for value, reference in ((row.over_constant, CONSTANT), (row.over_force_balance, FORCE_BALANCE)):
                skill_of_all = 1.0 - np.sum(own**2) / np.sum(errors[reference] ** 2)
                assert value == pytest.approx(skill_of_all, abs=1e-12)


@pytest.mark.filterwarnings("error")
def test_an_estimator_that_diverged_in_every_case_has_empty_cells():
    frame = frame_of({CONSTANT: [0.1, 0.2], FORCE_BALANCE: [0.1, 0.1], "lost": [math.nan, math.nan]})
    last = leaderboard(rank_estimators(frame)).texts[-1]
    assert (last["estimator"], last["diverged"], last["cases"]) == ("lost", "2", "2")
    assert {last[name] for name in ("median RMSE", "from", "over constant", "95 %")} == {""}
    assert "lost" not in by_family(frame).columns
    assert [row["lost"] for row in pads_by_group(frame, [(0.1, (0.5, 0.5))] * 2).texts] == ["", ""]


@pytest.mark.usefixtures("in_process")
def test_a_small_run_states_that_it_does_not_rank_estimators(tmp_path):
    study = Estimators(estimator=["fmu"], cases=2)
    with work("estimators", tmp_path, workers=1) as job:
        page = study.page(job)
    page.write(tmp_path)
    assert "targets.csv" not in page.tables  # targets are for the estimators of the project
    assert "over 2 recordings, too few to rank estimators, is" in page.answer
    rows = json.loads((tmp_path / "estimators.json").read_text(encoding="utf-8"))
    assert {row["estimator"] for row in rows} == {CONSTANT, FORCE_BALANCE, "fmu"}


@pytest.mark.parametrize(("options", "sentence"), table(__file__, "tables.toml")["wrong_estimators"])
def test_an_unknown_estimator_or_train_is_refused_before_any_work(options, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "json.py").write_text(OWN, encoding="utf-8")
    (tmp_path / "lame.py").write_text("class Drag:\n    def start(self, first, formation): ...\n", encoding="utf-8")
    with work("estimators", tmp_path) as job, pytest.raises(InputError, match=sentence):
        Estimators(**options).page(job)


OWN = """
import numpy as np
import railgrip as rg

class Drag:
    provides = ("adhesion", "adhesion_sd", "speed", "slip")

    def start(self, first, formation):
        self.groups = formation.groups

    def step(self, observation):
        same = np.full(self.groups, -observation.acceleration / 9.81)
        slip = np.full(self.groups, 1.0 - 0.38 * observation.wheelset_speed[0] / observation.speed)
        return rg.Estimate(
            adhesion=same, adhesion_sd=np.full(self.groups, 0.02), speed=0.5 * observation.speed, slip=slip
        )
"""


def test_a_users_class_gets_the_same_readings_and_is_judged(short, tmp_path):
    (tmp_path / "drag.py").write_text(OWN, encoding="utf-8")
    errors = errors_of((short, f"{tmp_path / 'drag.py'}:Drag", CONSTANTS))
    recording = recording_of_case(short)
    assert errors["digest"] == errors_of((short, CONSTANT, CONSTANTS))["digest"]
    moving = recording["speed"].values > 10 / 3.6
    expected = -recording["reading_acceleration"].values[moving, np.newaxis] / 9.81
    truth = recording["group_adhesion"].values[moving]
    # The estimator receives the reading of the previous period.
    assert errors["rmse"]["adhesion"] == pytest.approx(np.sqrt(np.mean((expected - truth) ** 2)), rel=0.1)
    speed = recording["speed"].values[moving]
    assert errors["rmse"]["speed"] == pytest.approx(np.sqrt(np.mean((0.5 * speed) ** 2)), rel=0.05)
    assert 0.0 < errors["coverage"]["adhesion"] <= 1.0
    assert np.isnan(errors["rmse"]["pad_friction"])
    assert 0.0 <= errors["available"]["known"] <= 1.0


def test_the_adhesion_available_is_the_maximum_of_the_creep_curve(short):
    recording, scenario = recording_of_case(short), scenario_of_case(short)
    contact, slips = VehicleData(scenario).contact, np.geomspace(1e-3, 1.0, 20_000)
    for k in (10, 60):
        speed, load, friction = (
            np.full(slips.shape, float(value[k]))
            for value in (recording["speed"], recording["wheelset_load"][:, 2], recording["mu0"][:, 2])
        )
        highest = contact(slips, speed, load, friction).max()
        # The third wheelset is the second group.
        assert recording[TRUTH].values[k, 1] == pytest.approx(highest, rel=1e-4)
    assert np.all(recording["group_adhesion"] <= 1.001 * recording[TRUTH])


def sliding(deviation=0.0):
    """A trace whose slip passes the maximum 0.1 of a parabola at 0.05 back and forth, and reaches 0.2 there."""
    time = np.arange(2000) * 0.01
    slip = (0.11 + 0.09 * np.sin(2.0 * np.pi * time / 20.0))[:, np.newaxis]
    adhesion = 0.1 - (slip - 0.05) ** 2
    group = ("time", "group")
    return xarray.Dataset(
        {
            "speed": ("time", np.full(time.size, 20.0)),
            "estimate_adhesion": (group, adhesion),
            "estimate_slip": (group, slip),
            "estimate_slip_sd": (group, np.full(slip.shape, deviation)),
            TRUTH: (group, np.full(slip.shape, 0.1)),
        },
        coords={"time": time},
    )


def test_the_adhesion_available_is_known_beyond_the_maximum_of_the_creep_curve():
    trace = sliding()
    errors = available_errors(trace, 0.12, 1.96)
    # Slip is beyond 0.05 for three quarters of the time, and varies too little near its turning points.
    assert errors["known"] == pytest.approx(0.75, abs=0.1)
    # What is passed longer ago is forgotten.
    assert -0.0225 < errors["bias"] < 0.0
    assert errors["rmse"] < errors["constant"]
    assert errors["constant"] == pytest.approx(0.02)
    truth = np.abs(trace[TRUTH] - trace["estimate_adhesion"]).values
    assert truth.min() < errors["recent"] < truth.max()
    assert np.isnan(errors["coverage"])
    claimed = trace.assign(estimate_adhesion_sd=(("time", "group"), np.full((2000, 1), 0.05)))
    assert available_errors(claimed, 0.12, 1.96)["coverage"] == 1.0


def test_the_adhesion_available_is_unknown_where_slip_is():
    assert available_errors(sliding(deviation=0.1), 0.12, 1.96)["known"] == 0.0
    assert np.isnan(available_errors(sliding().drop_vars("estimate_slip"), 0.12, 1.96)["known"])


def test_the_largest_of_the_last_samples_includes_this_one():
    values = np.array([[1.0, 5.0, 2.0, 1.0, 0.0, 3.0]]).T
    assert largest_of_last(values, 3)[:, 0].tolist() == [1.0, 5.0, 5.0, 5.0, 2.0, 3.0]
    assert largest_of_last(values, 2)[:, 0].tolist() == [1.0, 5.0, 5.0, 2.0, 1.0, 3.0]


def test_a_users_prediction_fmu_is_the_filter_with_that_prediction(short):
    file = fmu(MODEL)
    own, same = replay(short, str(file)), replay(short, "fmu")
    np.testing.assert_array_equal(own.mean, same.mean)


def test_the_delay_after_a_step_is_that_of_a_shifted_estimate():
    time = np.arange(400) * 0.01
    truth = np.where(time < 2.0, 0.1, 0.05)[:, np.newaxis]
    estimate = np.where(time < 2.07, 0.1, 0.05)[:, np.newaxis]
    trace = xarray.Dataset(
        {
            "group_adhesion": (("time", "group"), truth),
            "estimate_adhesion": (("time", "group"), estimate),
            "speed": ("time", np.full(400, 20.0)),
        },
        coords={"time": time},
    )
    assert step_delay(trace) == pytest.approx(0.07)
    assert np.isnan(step_delay(trace.drop_vars("estimate_adhesion")))


def test_the_search_never_returns_worse_factors(monkeypatch):
    """A quadratic in the logarithms with its minimum at 3 in every direction."""
    count = Counter()

    def cost(estimator, sensors, cases, factors):
        count["evaluations"] += 1
        return sum(np.log(value / (3.0 if name == "all" else 1.0)) ** 2 for name, value in factors.items())

    monkeypatch.setattr("railgrip.studies.estimators.case_errors.evaluate", cost)
    factors = search(("fmu", "ideal", ()))
    assert factors == dict.fromkeys(FACTORS, 1.0) | {"all": 3.0}
    assert count["evaluations"] <= BUDGET


def test_the_interval_score_is_smallest_for_the_true_deviation():
    error = np.random.default_rng(1).normal(size=20_000)
    scores = [interval_score(error, np.full(error.size, sd)) for sd in (0.8, 1.0, 1.25)]
    assert scores[1] == min(scores)


def test_uncertainty_of_load_and_inertia_is_claimed_where_no_state_has_it(short):
    """With ideal sensors adhesion has both; draws of the load and a held rate are the references."""
    found = replay(short, "fmu")
    alpha, wheel = states().index("group_adhesion[1]"), states().index("wheelset_speed[1]")
    extra = (found.variance - modelled(short, found))[:, alpha]
    load = np.random.default_rng(1).uniform(1 - 3**0.5 * LOAD_DEVIATION, 1 + 3**0.5 * LOAD_DEVIATION, 1_000_000)
    of_load = np.mean((1 / load - 1) ** 2) * found.mean[:, alpha] ** 2
    rate = (found.mean[10:, wheel] - found.mean[:-10, wheel]) / 0.1
    of_inertia = np.append(np.zeros(10), (0.1 / 3**0.5 * rate / EFFECT[0]) ** 2)
    # A million draws determine a variance to 0.2 %.
    np.testing.assert_allclose(extra, of_load + of_inertia, rtol=0.01, atol=1e-12)
    assert force_over_load_deviation() > LOAD_DEVIATION
    assert np.all((found.variance - modelled(short, found))[:, states().index("speed")] == 0.0)


@pytest.mark.usefixtures("own_results", "in_process")
def test_a_search_of_one_estimator_keeps_the_noises_of_all_others(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("railgrip.studies.estimators.case_errors.BUDGET", 2)
    file = tmp_path / FACTORS_FILE
    file.parent.mkdir(parents=True)
    write_factors(file, {("fmu", "worn"): {"all": 2.0}, ("force_balance", "worn"): {"all": 2.0}})
    tune = "study", "estimators", "--tune", "--cases", "3", "--estimator", "force_balance"
    assert done(capsys, *tune, "--out", "tuned").code == 0
    found = read_factors(file)
    assert found["fmu", "worn"] == {"all": 2.0}
    assert set(found) == {("fmu", "worn"), *(("force_balance", sensors) for sensors in SENSORS)}
    for sensors in SENSORS:
        # Two evaluations: without a change, and with a factor of 3 of all deviations.
        assert {**found["force_balance", sensors], "all": 1.0} == dict.fromkeys(FACTORS, 1.0)
        assert found["force_balance", sensors]["all"] in (1.0, 3.0)
    assert "force_<wbr>balance" in (tmp_path / "tuned" / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("options", "sentence"), table(__file__, "tables.toml")["impossible_searches"])
def test_a_search_that_is_not_possible_is_refused_before_it_begins(options, sentence, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    refused = done(capsys, "study", "estimators", "--tune", *options)
    assert refused.code == 2
    assert sentence in " ".join(refused.err.split())


def test_the_common_factor_multiplies_every_deviation_and_no_other_factor_does():
    changes = {}, {"all": 3.0}, {"process.group_adhesion": 3.0}
    plain, common, one = (noise_of("fmu", "service", factors) for factors in changes)
    for field in ("process", "readings", "start"):
        before, after = getattr(plain, field), getattr(common, field)
        assert after == {name: pytest.approx(3.0 * value) for name, value in before.items()}
    assert one.process == {**plain.process, "group_adhesion": pytest.approx(3.0 * plain.process["group_adhesion"])}
    assert (one.readings, one.start) == (plain.readings, plain.start)


def test_every_case_has_one_family_of_each_axis_and_loads_differ():
    design = recording_cases(24, SEEDS["test"])
    for field in FAMILIES:
        counts = Counter(family_of(case, field) for case in design)
        assert len(counts) > 1
        assert min(counts.values()) >= 3


@pytest.mark.parametrize("estimator", ["fmu", "reduced", "disturbed"])
def test_the_train_file_of_the_two_part_train_has_its_predictions(estimator):
    """The same derivatives and readings at states drawn at random, whatever the order of the states."""
    ours, of_file = (model_of_estimator(estimator, train).equations({}) for train in ("", "vt642"))
    assert sorted(of_file.states) == sorted(ours.states)
    assert of_file.outputs == ours.outputs
    places = [ours.states.index(name) for name in of_file.states]
    random = np.random.default_rng(0)
    for _ in range(5):
        x = np.array([TYPICAL[name.partition("[")[0]] for name in ours.states]) * random.uniform(0.5, 1.5, len(places))
        u = np.append(random.uniform(0.5e5, 3e5, 4), 1e3)
        np.testing.assert_allclose(of_file.derivative(x[places], u), ours.derivative(x, u)[places], rtol=1e-12)
        np.testing.assert_allclose(of_file.output(x[places], u), ours.output(x, u), rtol=1e-12)


def test_cases_of_another_train_have_its_groups_and_its_speed():
    design, ours = (recording_cases(12, SEEDS["test"], train) for train in ("tram", ""))
    assert {case.groups for case in recording_cases(2, SEEDS["test"], "vt642")} == {4}
    assert {len(case.digest) for case in design} == {64}
    assert max(case.stop.speed for case in design) <= 60 / 3.6  # the fastest published stop of the tram
    assert max(case.stop.speed for case in ours) > 60 / 3.6
    assert [(case.sensors, case.demand, case.over) for case in design] == [
        (case.sensors, case.demand, case.over) for case in ours
    ]
    assert len(states("disturbed", "tram")) == len(states("", "tram")) + 8  # deflections of four wheelsets, and rates


def test_another_train_has_its_recordings_estimators_and_folder(short):
    case = replace(short, train="tram")
    assert recording_of_case(case).sizes["group"] == 4
    errors = [errors_of((case, name, CONSTANTS)) for name in (CONSTANT, FORCE_BALANCE, "fmu", "disturbed", "fixed_lag")]
    assert len({one["digest"] for one in errors}) == 1
    assert all(np.isfinite(one["rmse"]["adhesion"]) for one in errors)
    study = Estimators(train="tram", estimator=["fmu"])
    assert study.place == "tram"
    assert Estimators().place == ""


def test_a_train_is_one_of_the_library_or_a_file(tmp_path):
    file = tmp_path / "own.toml"
    file.write_bytes(locate("tram", "trains").read_bytes())
    names = [Estimators(train=train)._train() for train in (None, "tram", str(file))]
    assert names == ["", "tram", str(file.resolve())]


def test_a_filter_of_another_vehicle_has_the_errors_of_its_estimation(tmp_path):
    """In the comparison as from `railgrip estimate`; the first seconds of the stop are enough."""
    (tmp_path / "short.toml").write_text('extends = "wagon_stop"\nlimits.horizon = "4 s"\n', encoding="utf-8")
    (tmp_path / "wagon.toml").write_text(
        f'extends = "wagon"\n[source]\nscenario = "{tmp_path.as_posix()}/short.toml"\n', encoding="utf-8"
    )
    specification = load_specification(tmp_path / "wagon.toml")
    recording = recording_of_estimation(specification)
    estimates = estimate_of(specification, recording)
    judged = recording["time"].values >= SETTLED
    frame = errors_of_estimation(str(tmp_path / "wagon.toml")).set_index(["estimator", "quantity"], drop=False)
    own = judge(recording, estimates, "alpha", judged)
    assert pytest.approx(own.rmse, rel=1e-9) == frame.loc[("fmu", "group_adhesion"), "RMSE"]
    assert pytest.approx(own.nees, rel=1e-9) == frame.loc[("fmu", "group_adhesion"), "NEES"]
    assert (frame["bound"] > 0.0).all()
    assert len(vehicles(frame).rows) == len(frame)
