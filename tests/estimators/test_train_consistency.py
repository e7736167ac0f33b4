"""Consistency of the train filters on the model that they assume: mean NEES, NIS and whiteness.

Truth is the stochastic model that the filter assumes: the equations of the prediction over a period with the pressures
held, then a draw of the process noise that the tuning adds in a period; readings with the tuning's noise; an initial
error drawn from the tuning's start. It is integrated separately from the filter, in CasADi with half the period. The
test therefore evaluates the filter (discretisation, Jacobians, gain, covariance, gate), not the model of a train.

Operation: braking at 22 m/s with an adhesion of 0.1 in every group, suspension settled and wheelsets rolling, at the
pressures that balance it. Either these are held, or group 2 is released for 0.15 s, so that its gate closes and opens;
a frozen pad friction is constant in truth, too, because that is what the gate assumes. This demonstrates that a gate
leaves the filter consistent, not that it closes: meanwhile the random walk of pad friction is only a twentieth of its
initial deviation. test_ekf.py checks frozen states.

All states are evaluated together. At constant pressures no reading determines one combination of the 25 states, the
distribution of braking between the two wheelsets of the Jacobs bogie, and three of the 13: the initial error remains
there, and P is large.

Run length: 0.4 s. Errors decay with time constants of 0.7 ms (ideal sensors) to 0.3 s (service sensors), eigenvalues of
(I − KH)Φ, so the instants include both the remainder of the initial error and the stationary error due to noise. The
only nonlinear terms of the equations are adhesion times load and v² of the drag. Load is known to 0.25 % at the start
and to 0.07 % at the end, v to 0.5 %, so the linearisation holds for any adhesion. But adhesion's random walk is
unbounded: after 0.4 s at 0.1/√s it is between −0.11 and 0.34 in all runs, wheelset speeds between 35 and 82 rad/s;
after some seconds wheels would turn backwards, for which the equations are not valid.

Errors at successive instants of a run are correlated, so NEES is averaged over runs at fixed instants, never over time.
Innovations of a consistent filter are independent in time, so NIS is averaged over runs and steps. All checks together
have a level of 95 % by Bonferroni's inequality, which holds even though instants belong to the same runs.

Sources: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), §5.4; Hosking, The
Multivariate Portmanteau Statistic, J. American Statistical Association 75 (1980), for whiteness of several readings.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product

import casadi as ca
import numpy as np
import pytest
from nees import chi_square_bounds, nees
from sampling import sample
from scipy.optimize import root
from small_models import PAD_GATE, draws, runge_kutta, train_prediction

from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import NOISE_SETS
from railgrip.estimators.prediction import CasadiPrediction

PERIOD = 1e-3
SPEED, ADHESION, RADIUS = 22.0, 0.10, 0.38
RUNS, STEPS = 100, 400
INSTANTS = (20, 100, 250, 400)
"""Steps at which NEES is evaluated: in the transient, before the release, at its end, and at the end of the run."""
RELEASED = slice(100, 250)
LAGS = 10
"""Lags of the whiteness test [steps]: the ideal tuning follows adhesion within 5 of them."""

MODELS = {
    "TrainPrediction": "train",
    "TrainPredictionReduced": "reduced",
    "TrainPredictionDisturbed": "disturbed",
    "TrainPredictionLoaded": "loaded",
    "TrainPredictionReducedDisturbed": "reduced_disturbed",
}
TUNINGS = (
    *product(("TrainPrediction", "TrainPredictionReduced"), ("ideal", "service")),
    ("TrainPredictionDisturbed", "service"),
    ("TrainPredictionLoaded", "service"),
    ("TrainPredictionReducedDisturbed", "service"),
)
BRAKING = ("held", "one group released")
CONFIDENCE = 1.0 - 0.05 / (len(TUNINGS) * len(BRAKING) * (len(INSTANTS) + 2))
"""Level of each two-sided check, for 95 % of all of them together."""


@dataclass(frozen=True)
class Tuned:
    """A prediction, the noise variances of its tuning, and its start."""

    prediction: CasadiPrediction
    process: Vector
    reading: Vector
    start: Vector
    mean: Vector
    pressures: Vector


@cache
def tuned(model: str, sensors: str) -> Tuned:
    prediction = train_prediction(model)
    noises = NOISE_SETS[f"{MODELS[model]}_{sensors}"]
    mean, pressures = settled(prediction)
    return Tuned(
        prediction,
        noises.process_noise(prediction.states),
        noises.reading_noise(prediction.outputs),
        noises.start_covariance(prediction.states),
        mean,
        pressures,
    )


def places(prediction: CasadiPrediction, name: str) -> list[int]:
    return [i for i, state in enumerate(prediction.states) if state.partition("[")[0] == name]


def settled(prediction: CasadiPrediction) -> tuple[Vector, Vector]:
    """State and inputs in which wheelsets roll with the train and the suspension is settled."""
    sizes = {
        "speed": SPEED,
        "wheelset_speed": SPEED / RADIUS,
        "pad_friction": 0.36,
        "group_adhesion": ADHESION,
        "dz": 0.0,
        "ddz": 0.0,
    }
    state = np.array([sizes.get(name.partition("[")[0], 0.0) for name in prediction.states])
    w, dz, ddz = (places(prediction, name) for name in ("wheelset_speed", "dz", "ddz"))

    def parts(unknown):
        state[dz] = 1e-3 * unknown[4:]
        return state, np.append(1e5 * unknown[:4], 0.0)

    def unrest(unknown):
        slope = prediction.derivative(*parts(unknown))
        return np.concatenate([slope[w] - slope[0] / RADIUS, slope[ddz]])

    found = root(unrest, np.concatenate([np.full(4, 2.0), np.zeros(len(dz))]))
    assert found.success
    return parts(found.x)


@cache
def truth(model: str, sensors: str, braking: str) -> tuple[Matrix, np.ndarray, np.ndarray]:
    """Return RUNS runs of the model: inputs (STEPS, nu), states (STEPS, RUNS, n) and readings (STEPS, RUNS, m)."""
    tuning = tuned(model, sensors)
    prediction, of = tuning.prediction, tuning.prediction.equations
    slope, output = (
        ca.Function("f", [of.x, of.u], [ca.substitute(expression, of.p, ca.DM(prediction.parameters))])
        for expression in (of.derivative, of.output)
    )
    ahead = ca.Function("ahead", [of.x, of.u], [runge_kutta(slope, of.x, of.u, PERIOD)]).map(RUNS)
    output = output.map(RUNS)

    held = np.tile(tuning.pressures, (STEPS, 1))
    if braking == "one group released":
        held[RELEASED, 1] = 0.0
    (frozen,) = (i for i, name in enumerate(prediction.states) if name == "pad_friction[2]")
    random = np.random.default_rng([TUNINGS.index((model, sensors)), BRAKING.index(braking)])
    # The derivative of the frozen state is zero in any case.
    noises = PERIOD * tuning.process, tuning.reading
    return held, *draws(ahead, output, (tuning.mean, tuning.start), noises, held, frozen, random, RUNS)


def checks(tuning: Tuned, true: tuple, *, process: float = 1.0, reading: float = 1.0) -> list[tuple[float, ...]]:
    """NEES at each instant, NIS and whiteness of a filter whose noises are multiplied by `process` and `reading`.

    Each with the bounds of the interval that contains it with the probability CONFIDENCE if the filter is consistent.
    """
    prediction, (held, state, seen) = tuning.prediction, true
    ours = CompiledFilter(prediction, process * tuning.process, reading * tuning.reading, PERIOD, PAD_GATE)
    n, m = len(prediction.states), len(prediction.outputs)
    errors, squares = np.empty((len(INSTANTS), RUNS)), np.empty((STEPS, RUNS))
    innovations = np.empty((STEPS, RUNS, m))
    for run in range(RUNS):
        belief = ours.start(tuning.mean, tuning.start)
        for j, (begin, end) in enumerate(zip((0, *INSTANTS), INSTANTS, strict=False)):
            part = slice(begin, end)
            followed = ours.follow(belief, held[part], seen[part, run])
            belief = GaussianEstimate(mean=ours.mean.copy(), covariance=ours.covariance.copy())
            errors[j, run] = nees(belief, state[end - 1, run])
            squares[part, run] = followed.squared_innovation
            innovations[part, run] = seen[part, run] - followed.expectation
    return [
        *((mean, *chi_square_bounds(n, RUNS, CONFIDENCE)) for mean in errors.mean(axis=1)),
        (squares.mean(), *chi_square_bounds(m, RUNS * STEPS, CONFIDENCE)),
        (portmanteau(innovations), *chi_square_bounds(LAGS * m * m, confidence=CONFIDENCE)),
    ]


def portmanteau(innovations: np.ndarray) -> float:
    """Sum of squares of the correlations of all readings over all LAGS, each of variance one: chi-square of LAGS·m².

    Innovations are whitened by their scatter over the runs at each step, not by the filter's covariance: NIS checks S.
    """
    steps, runs, _ = innovations.shape
    factor = np.linalg.cholesky(np.einsum("kri,krj->kij", innovations, innovations) / runs)
    white = np.linalg.solve(factor, innovations.transpose(0, 2, 1))
    lagged = ((np.einsum("kir,kjr->ij", white[lag:], white[:-lag]), steps - lag) for lag in range(1, LAGS + 1))
    return float(sum(np.sum(products**2) / (runs * count) for products, count in lagged))


@pytest.mark.parametrize(("tuning", "braking"), sample([*product(TUNINGS, BRAKING)], 8))
def test_mean_nees_nis_and_whiteness_are_within_their_chi_square_bounds(tuning, braking):
    for figure, low, high in checks(tuned(*tuning), truth(*tuning, braking)):
        assert low < figure < high


@pytest.mark.parametrize(
    ("tuning", "wrong", "factor"), sample([*product(TUNINGS, ("process", "reading"), (0.1, 10.0))], 6)
)
def test_a_filter_with_a_tenth_or_ten_times_the_noise_is_inconsistent(tuning, wrong, factor):
    """Each check can fail: noise ten times too small gives errors above the claimed ones, ten times too large below.

    Innovations are correlated in both cases, because the filter weights readings wrongly. The first instant is
    excluded: there the remainder of the initial error still hides the noise.
    """
    _, *errors, (white, _, highest) = checks(tuned(*tuning), truth(*tuning, "held"), **{wrong: factor})
    for figure, low, high in errors:
        assert figure > high if factor < 1.0 else figure < low
    assert white > highest
