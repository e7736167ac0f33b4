"""Posterior Cramér-Rao bound: the smallest covariance of any estimator, if the prediction and its noises are true."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.discretisation import transition
from railgrip.estimators.prediction import Prediction


def posterior_bound(
    prediction: Prediction,
    process_noise: Vector,
    reading_noise: Vector,
    period: float,
    covariance: ArrayLike,
    states: Array,
    inputs: Matrix,
    is_read: NDArray[np.bool_],
) -> Array:
    """Return the bound of the covariance at the start and after each of k steps, shape (k + 1, n, n).

    Args:
        prediction: The model, n states and m outputs; its Jacobians are those of its FMU.
        process_noise: Densities of independent noises in (unit of the state)²/s, positive, shape (n,).
        reading_noise: Variances of independent readings, shape (m,).
        period: Of a step [s].
        covariance: At the start, shape (n, n).
        states: Trajectories over which expectations are averaged, shape (draws, k + 1, n); a single one gives the bound
            of the model linearised along it.
        inputs: Inputs of every step, shape (k, nu).
        is_read: Which readings exist after every step, shape (k, m).

    Source: Tichavský, Muravchik, Nehorai, Posterior Cramér-Rao Bounds for Discrete-Time Nonlinear Filtering, IEEE
    Trans. Signal Processing 46 (1998) 1386, eq. 21 to 27 for additive Gaussian noise.
    """
    process_information = np.diag(1.0 / (process_noise * period))
    information = np.linalg.inv(np.asarray(covariance, dtype=np.float64))
    bound = np.empty((len(inputs) + 1, *information.shape))
    bound[0] = covariance
    for k, held in enumerate(inputs):
        weights = np.where(is_read[k], 1.0 / reading_noise, 0.0)
        previous, coupling = np.zeros_like(information), np.zeros_like(information)
        current = process_information.copy()
        for trajectory in states:
            phi = transition(prediction.derivative_jacobian(trajectory[k], held), period)
            jacobian = prediction.output_jacobian(trajectory[k + 1], held)
            previous += phi.T @ process_information @ phi / len(states)
            coupling -= phi.T @ process_information / len(states)
            current += (jacobian.T * weights) @ jacobian / len(states)
        information = current - coupling.T @ np.linalg.solve(information + previous, coupling)
        information = 0.5 * (information + information.T)
        bound[k + 1] = np.linalg.inv(information)
    return bound
