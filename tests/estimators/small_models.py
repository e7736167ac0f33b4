"""Prediction models of a few lines, written in CasADi, for the tests of the estimators."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace

import casadi as ca
import numpy as np

from railgrip.estimators.design import pad_gate
from railgrip.estimators.prediction import CasadiPrediction, with_state_names
from railgrip.fmus.native import lower
from railgrip.vehicle.brake import pressure_of


class SmallModel(SimpleNamespace):
    """States, inputs, parameters and outputs, with names, and the functions `derivative` and `output`."""

    __hash__ = object.__hash__  # filters are generated once for each model


Equation = Callable[[ca.SX, ca.SX, ca.SX, ca.SX], Sequence[ca.SX]]


def small_model(states: str, inputs: str, parameters: str, outputs: str, f: Equation, h: Equation) -> SmallModel:
    """Names separated by blanks; `f` and `h` are functions of the symbols (t, x, u, p)."""
    words = {"states": states, "inputs": inputs, "parameters": parameters, "outputs": outputs}
    names = {kind: tuple(SimpleNamespace(name=word) for word in text.split()) for kind, text in words.items()}
    sizes = {"t": 1, "x": len(names["states"]), "u": len(names["inputs"]), "p": len(names["parameters"])}
    given = [ca.SX.sym(symbol, size) for symbol, size in sizes.items()]
    functions = {
        name: ca.Function(name, given, [ca.vertcat(*equation(*given))])
        for name, equation in (("derivative", f), ("output", h))
    }
    return SmallModel(**names, **functions)


WHEELSET = {"m": 14_500.0, "J": 209.0, "r_wheel": 0.38, "r_friction": 0.22, "n_units": 2.0, "drag": 5.4}
"""A wheelset of the Jacobs bogie carrying its share of the train."""


def wheelset() -> SmallModel:
    """v, w, mu_b, alpha under pad force and track force; outputs speed, wheelset speed and acceleration."""

    def acceleration(x: ca.SX, u: ca.SX, p: ca.SX) -> ca.SX:
        return -9.81 * x[3] - p[5] / p[0] * x[0] ** 2 + u[1] / p[0]

    def f(t: ca.SX, x: ca.SX, u: ca.SX, p: ca.SX) -> list[ca.SX]:
        torque = p[4] * x[2] * u[0] * p[3]
        spin = (x[3] * p[0] * 9.81 * p[2] - torque) / p[1]
        return [acceleration(x, u, p), spin, (0.35 + 0.002 * (33.0 - x[1]) - x[2]) / 3.0, ca.SX(0)]

    return small_model(
        "v w mu_b alpha",
        "pad_force track_force",
        " ".join(WHEELSET),
        "speed wheelset_speed acceleration",
        f,
        lambda t, x, u, p: [x[0], x[1], acceleration(x, u, p)],
    )


PERIOD = 1e-3
DENSITY = np.array([1e-4, 1e-3, 1e-5, 1e-2])
READING = np.array([1e-4, 1e-4, 1e-3])
FIRST_MEAN = np.array([22.0, 22.0 / 0.38, 0.36, 0.06])
FIRST_VARIANCE = np.array([1e-2, 1e-1, 2.5e-3, 1e-3])
"""Noises of states and readings, and the initial estimate, of filters on the wheelset."""


PAD_GATE = pad_gate(pressure_of(1500.0, piston_area=0.0324, rigging=6.0 * 0.95, spring_force=1200.0), groups=4)
"""The gate of pad friction of the two-part train, at a pad force of 1500 N."""


def train_prediction(name: str) -> CasadiPrediction:
    """Return a prediction class of the two-part train with its own parameters."""
    model = with_state_names(lower(f"RailBraking.Predictions.{name}"))
    return CasadiPrediction(model, {parameter.name: parameter.start for parameter in model.parameters})


def runge_kutta(slope: ca.Function, x: ca.SX, u: ca.SX, period: float, steps: int = 2) -> ca.SX:
    """Return the state after a period under held inputs, by classical Runge-Kutta steps."""
    h = period / steps
    for _ in range(steps):
        k1 = slope(x, u)
        k2 = slope(x + 0.5 * h * k1, u)
        k3 = slope(x + 0.5 * h * k2, u)
        k4 = slope(x + h * k3, u)
        x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return x


def draws(
    ahead: ca.Function,
    output: ca.Function,
    start: tuple[np.ndarray, np.ndarray],
    noises: tuple[np.ndarray, np.ndarray],
    held: np.ndarray,
    frozen: int,
    random: np.random.Generator,
    runs: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return states (k, runs, n) and readings (k, runs, m) of motions that are drawn from a stochastic model.

    Args:
        ahead: States after a period, from states and inputs in the columns of matrices.
        output: Readings, likewise.
        start: Mean and variances of the initial states.
        noises: Variances that a period adds to the states, and variances of the readings.
        held: Inputs of each period.
        frozen: State without noise while the second input is 0.
        random: Generator of all draws.
        runs: Number of motions.
    """
    process, reading, initial = (np.sqrt(each)[:, np.newaxis] for each in (*noises, start[1]))
    now = start[0][:, np.newaxis] + initial * random.standard_normal((len(initial), runs))
    states, readings = [], []
    for inputs in held:
        noise = process * random.standard_normal(now.shape)
        if inputs[1] == 0.0:
            noise[frozen] = 0.0
        each = np.tile(inputs[:, np.newaxis], (1, runs))
        now = np.asarray(ahead(now, each)) + noise
        states.append(now.T)
        readings.append((np.asarray(output(now, each)) + reading * random.standard_normal((len(reading), runs))).T)
    return np.array(states), np.array(readings)


OSCILLATOR = {"k": 2.4e6, "c": 2.4e4, "m_1": 1750.0, "m_2": 1500.0}
"""Two masses on the primary suspension: modes as fast as a train prediction has them."""


def oscillator() -> SmallModel:
    """Linear: two masses in series; outputs the first deflection and the second acceleration."""

    def f(t: ca.SX, x: ca.SX, u: ca.SX, p: ca.SX) -> list[ca.SX]:
        first = p[0] * x[0] + p[1] * x[2]
        second = p[0] * (x[1] - x[0]) + p[1] * (x[3] - x[2])
        return [x[2], x[3], (second - first + u[0]) / p[2], -second / p[3]]

    return small_model(
        "z_1 z_2 dz_1 dz_2",
        "force",
        " ".join(OSCILLATOR),
        "deflection acceleration",
        f,
        lambda t, x, u, p: [x[0], f(t, x, u, p)[3]],
    )
