"""The filters on the prediction classes of RailBraking, as the harness uses them."""

import numpy as np
import pytest
from contracts.prediction import prediction_contract
from small_models import PAD_GATE, train_prediction

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import advance
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.consistency import delay
from railgrip.estimators.design import NOISE_SETS
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.observability import observability

PERIOD = 1e-3
FULL_BRAKE = np.array([3.4e5, 2.0e5, 2.0e5, 3.4e5, 0.0])
SIZES = {"speed": 20.0, "wheelset_speed": 50.0, "pad_friction": 0.35, "group_adhesion": 0.1, "dz": 3e-3, "ddz": 0.1}


@pytest.fixture(scope="module", params=["TrainPrediction", "TrainPredictionReduced"])
def prediction(request):
    return train_prediction(request.param)


def sizes(prediction):
    return np.array([SIZES[name.partition("[")[0]] for name in prediction.states])


def parts(prediction, sensors):
    chosen = NOISE_SETS[("train_" if len(prediction.states) == 25 else "reduced_") + sensors]
    noises = chosen.process_noise(prediction.states), chosen.reading_noise(prediction.outputs)
    return (prediction, *noises, PERIOD, PAD_GATE), chosen.start_covariance(prediction.states)


def rolling(prediction, speed=22.0, adhesion=0.05):
    """Start with rolling wheels, not in equilibrium."""
    start = {"speed": speed, "wheelset_speed": speed / 0.38, "pad_friction": 0.36, "group_adhesion": adhesion}
    return np.array([start.get(name.partition("[")[0], 0.0) for name in prediction.states])


def test_it_satisfies_the_contract_of_a_prediction(prediction):
    prediction_contract(prediction, rolling(prediction) + 1e-3, 0.7 * FULL_BRAKE + 1.0)


def test_missing_names_of_a_noise_set_for_another_model_are_listed():
    with pytest.raises(EstimatorError, match="'reduced train, ideal sensors': no process noise for ddz, dz"):
        NOISE_SETS["reduced_ideal"].process_noise(["speed", "dz[1]", "ddz[1]"])
    assert NOISE_SETS["train_ideal"].process_noise(["group_adhesion[2]"]) == pytest.approx([0.1**2])


def test_the_pad_gate_is_the_pressure_of_the_minimum_pad_force():
    """F = η i (p A − F_spring) = 1500 N."""
    assert 0.95 * 6.0 * (PAD_GATE.threshold * 0.0324 - 1200.0) == pytest.approx(1500.0, rel=1e-12)
    assert PAD_GATE.inputs[2] == "cylinder_pressure[3]"
    assert PAD_GATE.states[2] == "pad_friction[3]"


@pytest.mark.parametrize("sensors", ["ideal", "service"])
def test_compiled_equals_python_while_brakes_apply_and_release(prediction, sensors):
    """Brakes applied and released by slip control, readings with dropouts, each filter on its own estimate.

    The 25 states with ideal sensors, the worst conditioned case, run for 10 s in steps of 1 ms; tests/stops runs them
    in closed loop through a whole stop.
    """
    arguments, start = parts(prediction, sensors)
    steps = 10_000 if len(prediction.states) == 25 and sensors == "ideal" else 3_000
    plain, fast = ExtendedKalmanFilter(*arguments), CompiledFilter(*arguments)
    one = two = plain.start(rolling(prediction), start)
    random = np.random.default_rng(11)
    noise = np.sqrt(arguments[2])
    phase = np.array([0.0, 1.0, 2.0, 3.0])
    for k in range(steps):
        braked = np.sin(k / 400.0 + phase) > -0.4
        held = np.append(np.where(braked, FULL_BRAKE[:4], 0.0), 1e3 * np.cos(k / 2000.0))
        expected = prediction.output(one.mean, held)
        # The train keeps its speed: the filters read 22 m/s whatever the brakes do in their models.
        expected[0] += 0.05 * (22.0 - expected[0])
        expected[1:5] += 0.05 * (57.0 - expected[1:5])
        seen = expected + noise * random.standard_normal(expected.size)
        seen[random.random(expected.size) < 0.2] = np.nan
        one, two = plain.step(one, held, seen), fast.step(two, held, seen)
        if k % 500 == 499:
            # In units of typical values in a stop: a filter may estimate a deflection more accurately than necessary.
            assert np.max(np.abs(one.mean - two.mean) / sizes(prediction)) < 1e-9
            spread = np.outer(one.deviation, one.deviation)
            assert np.max(np.abs(one.covariance - two.covariance) / spread) < 1e-9


@pytest.mark.parametrize("sensors", ["ideal", "service"])
def test_a_step_of_adhesion_is_followed_within_a_tenth_of_a_second(prediction, sensors):
    """All groups lose half their adhesion; truth is the prediction, with readings of the assumed noise."""
    arguments, start = parts(prediction, sensors)
    ours = CompiledFilter(*arguments)
    truth = rolling(prediction, adhesion=0.12)
    ours.start(rolling(prediction, adhesion=0.11), start)
    groups = [prediction.states.index(f"group_adhesion[{i}]") for i in range(1, 5)]
    random = np.random.default_rng(12)
    noise = np.sqrt(arguments[2])
    held = FULL_BRAKE * np.array([0.8, 0.8, 0.8, 0.8, 0.0])
    steps = 1500
    true, found = np.empty((steps, 4)), np.empty((steps, 4))
    for k in range(steps):
        truth = advance(lambda x: prediction.derivative(x, held), truth, PERIOD)
        if k == 1000:
            truth[groups] *= 0.5
        ours.inputs[:] = held
        ours.readings[:] = prediction.output(truth, held) + noise * random.standard_normal(noise.size)
        ours.advance()
        true[k], found[k] = truth[groups], ours.mean[groups]
    time = np.arange(1, steps + 1) * PERIOD
    for i in range(4):
        assert delay(time, true[:, i], found[:, i], 1000 * PERIOD, tolerance=0.02) <= 0.1


def test_the_suspension_makes_adhesion_and_pad_friction_distinguishable(prediction):
    """With deflections everything is determined at once; without them only over time, as pressures change."""
    x = rolling(prediction) * (1.0 + 0.1 * np.sin(7.0 * np.arange(len(prediction.states))))
    found = observability(prediction, x, FULL_BRAKE * 0.7, sizes(prediction))
    if len(prediction.states) == 25:
        assert found.complete
    else:
        # Five accelerations (four wheelsets, the train) and eight coefficients: three directions are undetermined.
        assert found.rank == 10
        assert {name.partition("[")[0] for name in found.undetermined} == {"pad_friction", "group_adhesion"}


def test_released_pads_hide_their_friction(prediction):
    """The rounded start of the stroke leaves 3 N on released pads; 1e-3 is above that and below a real force."""
    if len(prediction.states) != 25:
        pytest.skip("without the suspension pad friction is not determined at a point in any case")
    pressures = FULL_BRAKE * np.array([0.7, 0.0, 0.7, 0.7, 0.0])
    found = observability(prediction, rolling(prediction), pressures, sizes(prediction), tolerance=1e-3)
    assert found.undetermined == ("pad_friction[2]",)
