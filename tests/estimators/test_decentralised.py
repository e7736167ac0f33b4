"""The filter with a part for each bogie compared with the central one: estimates and their consistency.

Truth is the stochastic model that both assume, as in test_train_consistency.py: equations of the prediction and a draw
of its noises, on trains with and without suspension, pressures held or one group released for a while.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from nees import chi_square_bounds, nees
from sampling import sample
from small_models import draws, runge_kutta
from synthetic import TYPICAL

from railgrip.base.errors import EstimatorError, FilterDiverged
from railgrip.estimators.belief import GaussianEstimate
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import NOISE_SETS, Gate
from railgrip.estimators.filters.decentralised import Consist, DecentralisedFilter, part_equations
from railgrip.estimators.prediction import CasadiPrediction, with_state_names
from railgrip.fmus.native import lower
from railgrip.rolling_stock.modelica import nominal_data
from railgrip.rolling_stock.schema import load_train
from railgrip.simulate.train_prediction import CentralPrediction, central_of, consist_of, start_of
from railgrip.vehicle.formation import Formation

PERIOD, RUNS, STEPS = 1e-3, 40, 400
INSTANTS = (20, 100, 250, 400)
RELEASED = slice(100, 250)


def rigid(groups: int) -> tuple[Formation, dict[str, float]]:
    """A train of equal wheelsets without suspension."""
    masses = {f"m_wheelset[{i + 1}]": 15e3 for i in range(groups)}
    return Formation((1,) * groups), masses | {"J": 120.0, "r_wheel": 0.46, "n_units": 2.0, "r_friction": 0.24}


FRAMES = {"m_frame": 3500.0, "I_frame": 2200.0, "wheelbase": 2.0}
BOGIES = {f"wheelsets_per_bogie[{b + 1}]": 2.0 for b in range(4)}
TRAINS = {
    "two-part": (Formation((2, 1, 1, 2)), nominal_data(load_train(Path("vt642")))),
    "eight wheelsets": rigid(8),
    "two cars": (rigid(8)[0], rigid(8)[1] | BOGIES | FRAMES),
}


SENSORS = ("ideal", "service")


@dataclass(frozen=True)
class Case:
    """A train, its noises and RUNS draws of its motion: `held` (k, nu), `state` (k, RUNS, n), `seen` (k, RUNS, m)."""

    consist: Consist
    whole: CentralPrediction
    noises: tuple[np.ndarray, np.ndarray]
    gate: Gate
    mean: np.ndarray
    variances: np.ndarray
    held: np.ndarray
    state: np.ndarray
    seen: np.ndarray

    def decentralised(self) -> DecentralisedFilter:
        filter_ = DecentralisedFilter(self.consist, *self.noises, PERIOD, self.gate)
        filter_.start(self.mean, self.variances)
        return filter_

    def central(self) -> CompiledFilter:
        """Return the central filter of all states, in the order of `shared`."""
        states, readings = self.shared
        process, reading = self.noises
        prediction = CasadiPrediction(self.whole.model, self.whole.parameters)
        filter_ = CompiledFilter(prediction, process[states], reading[readings], PERIOD, self.gate)
        filter_.start(self.mean[states], self.variances[states])
        return filter_

    @property
    def shared(self) -> tuple[list[int], list[int]]:
        """The indices of each part's states and readings in the whole train."""
        states = [variable.name for variable in self.whole.model.states]
        return [self.consist.states.index(name) for name in states], [
            self.consist.outputs.index(name) for name in self.whole.readings
        ]


@cache
def case(train: str, sensors: str, released: bool = False) -> Case:
    formation, data = TRAINS[train]
    consist = consist_of(formation, data)
    tuning = NOISE_SETS[f"train_{sensors}"]
    states, outputs = consist.states, consist.outputs
    process, reading = tuning.process_noise(states), tuning.reading_noise(outputs)
    variances = tuning.start_covariance(states)
    mean = start_of(consist.states, formation, data, speed=22.0)
    pads = [states.index(f"pad_friction[{g + 1}]") for g in range(formation.groups)]
    mean[[states.index(f"group_adhesion[{g + 1}]") for g in range(formation.groups)]] = 0.1

    whole = central_of(formation, data)
    prediction = CasadiPrediction(whole.model, whole.parameters)
    of, x = prediction.equations, ca.SX.sym("x", len(states))
    known = ca.vertcat(x[[states.index(name) for name in prediction.states]], ca.DM(prediction.parameters))
    slope, output = (
        ca.Function("f", [x, of.u], [ca.substitute(expression, ca.vertcat(of.x, of.p), known)[places]])
        for expression, places in (
            (of.derivative, [prediction.states.index(name) for name in states]),
            (of.output, [whole.readings.index(name) for name in outputs]),
        )
    )
    # Pressures at which the wheels neither accelerate nor decelerate relative to the train, with static loads.
    wheels = [states.index(f"wheelset_speed[{g + 1}]") for g in range(formation.groups)]
    still = ca.vertcat(*(slope(mean, of.u)[w] for w in wheels))
    gain = ca.Function("gain", [of.u], [ca.jacobian(still, of.u), still])
    inputs = np.append(np.full(formation.groups, 1e5), 0.0)
    by_pressure, rest = (np.asarray(value) for value in gain(inputs))
    inputs[:-1] -= rest[:, 0] / np.diag(by_pressure[:, :-1])
    ahead = runge_kutta(slope, x, of.u, PERIOD)
    moved, shown = ca.Function("ahead", [x, of.u], [ahead]).map(RUNS), output.map(RUNS)

    # Each group's pressure varies independently: equal pressures would be a single direction of the acceleration.
    groups, time = np.arange(formation.groups), PERIOD * np.arange(STEPS)[:, np.newaxis]
    held = np.tile(inputs, (STEPS, 1))
    held[:, :-1] *= 1.0 + 0.3 * np.sin(2.0 * np.pi * (2.0 + 0.7 * groups) * time + groups)
    if released:
        held[RELEASED, 1] = 0.0
    random = np.random.default_rng([list(TRAINS).index(train), sensors == "ideal", released])
    state, seen = draws(moved, shown, (mean, variances), (PERIOD * process, reading), held, pads[1], random, RUNS)
    gate = Gate(
        states=tuple(states[pad] for pad in pads),
        inputs=tuple(f"cylinder_pressure[{g + 1}]" for g in range(formation.groups)),
        threshold=5e4,
    )
    return Case(consist, whole, (process, reading), gate, mean, variances, held, state, seen)


MIXED = {f"wheelsets_per_bogie[{b + 1}]": float(count) for b, count in enumerate((3, 2))}


@pytest.mark.parametrize("train", [*TRAINS, "three axles, then two"])
def test_the_parts_of_a_train_add_up_to_the_prediction_of_the_whole(train: str):
    """To rounding, at random states, with bogies of known frames anywhere in the train."""
    formation, data = TRAINS[train] if train in TRAINS else (rigid(5)[0], rigid(5)[1] | MIXED | FRAMES)
    consist, whole = consist_of(formation, data), central_of(formation, data)
    prediction = CasadiPrediction(whole.model, whole.parameters)
    assert set(whole.readings) == set(consist.outputs)
    assert consist.inputs == prediction.inputs
    outputs = {name: state for name, state in consist.readings if state is not None}
    random = np.random.default_rng(0)
    for _ in range(5):
        state = dict(zip(consist.states, random.uniform(0.5, 1.5, len(consist.states)), strict=True))
        for name in state:
            state[name] *= TYPICAL.get(name.partition("[")[0], 1e-3)
        u = np.append(random.uniform(0.5e5, 3e5, formation.groups), 1e3)
        each = [np.array([state[name] for name in part.states]) for part in consist.parts]
        own = [np.array([u[consist.inputs.index(name)] for name in part.inputs]) for part in consist.parts]
        force = sum(
            float(part.model.output(0, x, [*p, 0.0], part.parameters))
            for part, x, p in zip(consist.parts, each, own, strict=True)
        )
        a = float(consist.body.derivative(0, state["speed"], [force, u[-1]], consist.body_parameters))
        rates = {"speed": a}
        for part, x, p in zip(consist.parts, each, own, strict=True):
            rate = np.asarray(part.model.derivative(0, x, [*p, a], part.parameters)).ravel()
            rates |= dict(zip(part.states, rate, strict=True))
        # Bogies are numbered through the train; wheelsets without a bogie have no deflection.
        deflections = [outputs[name] for name in whole.readings if name.startswith("deflection")]
        of_train = {f"{d}dz[{i + 1}]": d + name for d in ("", "d") for i, name in enumerate(deflections)}
        names = [of_train.get(name, name) for name in prediction.states]
        x = np.array([state[name] for name in names])
        np.testing.assert_allclose(prediction.derivative(x, u), [rates[name] for name in names], rtol=1e-12, atol=1e-12)
        expected = [state[outputs[name]] if name in outputs else a for name in whole.readings]
        np.testing.assert_allclose(prediction.output(x, u), expected, rtol=1e-12)


@pytest.mark.parametrize(("train", "sensors", "released"), sample([*product(TRAINS, SENSORS, (False, True))], 5))
def test_mean_nees_and_nis_are_within_their_chi_square_bounds(train, sensors, released):
    """For all states together. 95 % for all checks together by Bonferroni's inequality: 12 cases of 5 checks."""
    true = case(train, sensors, released)
    filter_ = true.decentralised()
    n, m = filter_.mean.size, filter_.readings.size
    errors, squares = np.empty((len(INSTANTS), RUNS)), np.empty((STEPS, RUNS))
    for run in range(RUNS):
        filter_.start(true.mean, true.variances)
        for k in range(STEPS):
            filter_.inputs[:], filter_.readings[:] = true.held[k], true.seen[k, run]
            filter_.advance()
            squares[k, run] = filter_.squared_innovation
            if k + 1 in INSTANTS:
                belief = GaussianEstimate(mean=filter_.mean.copy(), covariance=filter_.joint())
                errors[INSTANTS.index(k + 1), run] = nees(belief, true.state[k, run])
    confidence = 1.0 - 0.05 / 60
    low, high = chi_square_bounds(n, RUNS, confidence)
    assert np.all((errors.mean(axis=1) > low) & (errors.mean(axis=1) < high)), (errors.mean(axis=1) / n, low, high)
    assert 0.5 < errors.mean() / n < 2.0
    low, high = chi_square_bounds(m, RUNS * STEPS, confidence)
    assert low < squares.mean() < high


@pytest.mark.parametrize(("train", "sensors"), sample([*product(TRAINS, SENSORS)], 3))
def test_it_errs_like_the_central_filter_and_never_underestimates_its_error(train, sensors):
    """Root mean square errors of adhesion, pad friction and wheel speed within 2 %, deviations never below 0.1 %.

    Deviations are up to 1 % larger with service sensors. With ideal sensors and eight groups with independent
    pressures, the readings determine more directions than are kept: some deviations are larger by 19 % for a while, the
    median is not.
    """
    true = case(train, sensors)
    ours, theirs = true.decentralised(), true.central()
    states, readings = true.shared
    own = list(range(len(states))), list(range(len(readings)))
    errors, shares = {ours: [], theirs: []}, []
    for run in range(5):
        for filter_, (each, _) in ((ours, own), (theirs, true.shared)):
            filter_.start(true.mean[each], true.variances[each])
        for k in range(STEPS):
            for filter_, (each, read) in ((ours, own), (theirs, true.shared)):
                filter_.inputs[:], filter_.readings[:] = true.held[k], true.seen[k, run][read]
                filter_.advance()
                errors[filter_].append(np.empty(len(each)))
                errors[filter_][-1][each] = filter_.mean - true.state[k, run][each]
            shares.append(np.sqrt(ours.covariance.diagonal()[states] / theirs.covariance.diagonal()))
    for name in ("group_adhesion", "pad_friction", "wheelset_speed"):
        places = [i for i, state in enumerate(true.consist.states) if state.partition("[")[0] == name]
        rms = {filter_: np.sqrt(np.mean(np.array(each)[:, places] ** 2)) for filter_, each in errors.items()}
        assert rms[ours] == pytest.approx(rms[theirs], rel=0.02), name
    assert np.min(shares) > 0.999
    assert np.median(shares) < 1.001
    assert np.max(shares) < (1.01 if sensors == "service" else 1.25)


def test_missing_readings_add_no_information():
    true = case("two-part", "service")
    filter_ = true.decentralised()
    before = filter_.covariance.diagonal().copy()
    filter_.inputs[:], filter_.readings[:] = true.held[0], np.nan
    filter_.advance()
    assert filter_.selection.sum() == 0
    assert filter_.squared_innovation == 0.0
    # All deviations grow, except those of deflection rates, which the dampers reduce.
    known = np.array([not name.startswith("ddz") for name in true.consist.states])
    assert np.all(filter_.covariance.diagonal()[known] > before[known])


def test_an_unusable_reading_leaves_the_estimate_unchanged():
    true = case("two-part", "service")
    filter_ = true.decentralised()
    filter_.inputs[:], filter_.readings[:] = true.held[0], true.seen[0, 0]
    filter_.advance()
    mean, joint = filter_.mean.copy(), filter_.joint()
    filter_.readings[0] = np.inf
    with pytest.raises(FilterDiverged, match="the correction by the readings"):
        filter_.advance()
    assert np.array_equal(filter_.mean, mean)
    assert np.array_equal(filter_.joint(), joint)


def test_parts_that_share_more_than_the_acceleration_are_refused():
    model = with_state_names(lower("RailBraking.Predictions.TrainPredictionReduced"))
    with pytest.raises(EstimatorError, match="linear in its acceleration"):
        part_equations(model, 0)


def test_noises_of_different_states_are_independent():
    true = case("two-part", "service")
    process = np.diag(true.noises[0])
    process[1, 2] = process[2, 1] = 1e-12
    with pytest.raises(EstimatorError, match="independent"):
        DecentralisedFilter(true.consist, process, true.noises[1], PERIOD)


def test_bogies_of_two_wheelsets_with_known_frames_have_suspension_and_others_do_not():
    formation, data = rigid(5)
    parts = consist_of(formation, data | MIXED | FRAMES).parts
    assert [len(part.states) for part in parts] == [3, 3, 3, 10]
    assert [len(part.states) for part in consist_of(formation, data).parts] == [3] * 5
