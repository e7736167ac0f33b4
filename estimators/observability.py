"""Observability: symbolic at a point, and numeric along a trajectory.

Two questions are answered. *Can* the states be determined from the readings and their time derivatives
(`observability`), as in Schwarz and Keck (2020, eq. 16)? And *how accurately*, from noisy readings over a window of a
real trajectory (`along`)? The first is a property of the model at a point; the second depends on sensors, excitation
and time.
"""

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Array, Matrix, Vector, transition
from railgrip.estimators.design import noise_matrix, positive_definite
from railgrip.estimators.prediction import CasadiPrediction, Prediction

ROUNDING = 1e-11
"""Singular values below this share of the largest count as zero. Entries are exact derivatives in double precision;
some Lie derivatives lose about three of sixteen digits by rounding, and the scaling of columns a few more."""


LARGEST_ORDER = 6
"""Largest order of derivatives: the size of the expressions grows fast with it."""


def readings_and_rates(prediction: CasadiPrediction, order: int, x: Vector, u: Vector) -> tuple[Vector, Matrix]:
    """Return z = [y, ẏ, ÿ, …] with derivatives up to `order`, and ∂z/∂x, by Lie derivatives of the outputs along f.

    Shapes (m·(order + 1),) and (m·(order + 1), n); expressions grow with each derivative.

    Source: Hermann and Krener, IEEE Trans. Automatic Control 22 (1977) 728, with inputs constant in time.
    """
    of = prediction.equations
    rates = [of.output]
    for _ in range(order):
        rates.append(ca.jtimes(rates[-1], of.x, of.derivative))
    stack = ca.vertcat(*rates)
    both = ca.Function("rates", [of.x, of.u, of.p], [stack, ca.densify(ca.jacobian(stack, of.x))])
    z, jacobian = (np.asarray(output, dtype=np.float64) for output in both(x, u, prediction.parameters))
    return z[:, 0], jacobian


@dataclass(frozen=True, slots=True, kw_only=True)
class Observability:
    """Observability of the states from readings and their derivatives at one point.

    Attributes:
        states: Names of the states.
        order: Highest derivative that was needed, or the last one that did not raise the rank.
        rank: Number of independent combinations of states that are determined.
        null_space: Undetermined directions, shape (n − rank, n), unit vectors in units of `scale`.
        undetermined: Names of the states with a share in an undetermined direction of more than ten tolerances.
    """

    states: tuple[str, ...]
    order: int
    rank: int
    null_space: Matrix
    undetermined: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """Whether every state is determined."""
        return self.rank == len(self.states)


def observability(
    prediction: CasadiPrediction,
    x: Vector,
    u: Vector,
    scale: ArrayLike,
    tolerance: float = ROUNDING,
) -> Observability:
    """Return which states [y, ẏ, …] determines at a point.

    Derivatives are added until every state is determined, or until one more does not raise the rank: at a regular point
    later ones do not raise it either.

    Args:
        prediction: The model.
        x: The point, shape (n,).
        u: Constant inputs there, shape (nu,).
        scale: Typical size of each state, positive, shape (n,), which makes columns comparable.
        tolerance: Share of the largest singular value below which one counts as zero. The default is for states that
            are determined in principle; a smoothed model, whose released pads still rub, requires a larger one.

    Raises:
        EstimatorError: A size is not positive, or shapes do not match the model.
    """
    n = len(prediction.states)
    size = _sizes(scale, prediction.states)
    if np.shape(x) != (n,) or np.shape(u) != (len(prediction.inputs),):
        raise EstimatorError(
            f"observability: requires {n} states and {len(prediction.inputs)} inputs, "
            f"got shapes {np.shape(x)} and {np.shape(u)}."
        )
    rank, order, directions = 0, 0, np.eye(n)
    for order in range(LARGEST_ORDER + 1):
        jacobian = readings_and_rates(prediction, order, x, u)[1] * size
        # Readings and their derivatives have different units, so only the direction of a row is meaningful.
        lengths = np.linalg.norm(jacobian, axis=1, keepdims=True)
        rows = jacobian[lengths[:, 0] > 0.0] / lengths[lengths > 0.0][:, np.newaxis]
        _, values, directions = np.linalg.svd(rows) if rows.size else (None, np.zeros(0), np.eye(n))
        count = int(np.sum(values > tolerance * np.max(values, initial=0.0)))
        if count == n or (order > 0 and count == rank):
            rank = count
            break
        rank = count
    null_space = directions[rank:]
    part = np.linalg.norm(null_space, axis=0) if null_space.size else np.zeros(n)
    # If values up to `tolerance` count as zero, directions are accurate to about the same share.
    least = max(1e-6, 10.0 * tolerance)
    names = tuple(name for name, share in zip(prediction.states, part, strict=True) if share > least)
    return Observability(
        states=prediction.states,
        order=order,
        rank=rank,
        null_space=null_space,
        undetermined=names,
    )


def gramian(prediction: Prediction, x: Matrix, u: Matrix, period: float, reading_noise: ArrayLike) -> Matrix:
    """Return the discrete observability Gramian Σ Φᵀ(k,0) Hᵀ R⁻¹ H Φ(k,0) along a trajectory, shape (n, n).

    It is the Fisher information: the inverse of the covariance of the state at the first sample given all readings, if
    the model is exact.

    Args:
        prediction: The model, linearised at the samples; transitions are those of `belief`.
        x: States at K samples, shape (K, n).
        u: Inputs held from each sample to the next, shape (K, nu).
        period: Seconds between samples.
        reading_noise: Covariance of the readings, (m,) of variances or (m, m).
    """
    noise = noise_matrix("reading_noise", reading_noise, prediction.outputs)
    if not positive_definite(noise):
        raise EstimatorError("observability: reading_noise is not positive definite.")
    whitening = np.linalg.inv(np.linalg.cholesky(noise))
    since_start = np.eye(len(prediction.states))
    rows: list[Matrix] = []
    for state, inputs in zip(x, u, strict=True):
        rows.append(whitening @ prediction.output_jacobian(state, inputs) @ since_start)
        since_start = transition(prediction.derivative_jacobian(state, inputs), period) @ since_start
    stack = np.concatenate(rows)
    return stack.T @ stack


def along(
    prediction: Prediction,
    x: Matrix,
    u: Matrix,
    period: float,
    reading_noise: ArrayLike,
    scale: ArrayLike,
    window: int,
    stride: int,
) -> tuple[NDArray[np.intp], Vector, Matrix]:
    """Return the accuracy with which noisy readings over windows of a trajectory determine the state at their start.

    Returns:
        Index of the first sample of each window, shape (k,).
        Smallest singular value of its scaled Gramian, shape (k,): the square of (size of the state over its
        uncertainty) in the worst direction, below 1 if the uncertainty exceeds the typical size.
        Standard deviation of each state given the window alone, shape (k, n), in the unit of the state; infinity for a
        state on which the readings have no information.

    Args:
        prediction: The model.
        x: States at K samples, shape (K, n); a truth or the means of a filter.
        u: Inputs held from each sample to the next, shape (K, nu).
        period: Seconds between samples.
        reading_noise: Covariance of the readings, (m,) of variances or (m, m).
        scale: Typical size of each state, shape (n,), positive.
        window: Samples in a window.
        stride: Samples from the start of one window to the next.

    Raises:
        EstimatorError: A window is longer than the trajectory, or a size is not positive.
    """
    if not 1 <= window <= len(x) or stride < 1:
        raise EstimatorError(
            f"observability: window must be 1 to {len(x)} samples and stride at least 1, got {window} and {stride}."
        )
    size = _sizes(scale, prediction.states)
    starts = np.arange(0, len(x) - window + 1, stride)
    smallest, deviation = np.empty(starts.size), np.empty((starts.size, size.size))
    for i, first in enumerate(starts):
        part = slice(first, first + window)
        information = gramian(prediction, x[part], u[part], period, reading_noise) * np.outer(size, size)
        values, directions = np.linalg.eigh(information)
        smallest[i] = max(values[0], 0.0)
        deviation[i] = size * _deviation(values, directions)
    return starts, smallest, deviation


def _deviation(values: Vector, directions: Matrix) -> Vector:
    """Return √diag(G⁻¹) from the eigenvalues and -vectors of G; infinity for states in its null space."""
    n = values.size
    # Upper bound of the rounding error of a zero eigenvalue of a sum of squares.
    null = values <= n * np.finfo(np.float64).eps * values[-1]
    variance = np.sum(directions[:, ~null] ** 2 / values[~null], axis=1)
    blind = np.linalg.norm(directions[:, null], axis=1) > 1e-6
    return np.where(blind, math.inf, np.sqrt(variance))


def _sizes(scale: ArrayLike, states: tuple[str, ...]) -> Vector:
    size = np.asarray(scale, dtype=np.float64)
    if size.shape != (len(states),) or not np.all(size > 0.0):
        raise EstimatorError(
            f"observability: scale requires a positive size for each of {', '.join(states)}, got {size.tolist()}."
        )
    return size


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


def linearised_bound(
    prediction: Prediction,
    process_noise: Vector,
    reading_noise: Vector,
    period: float,
    covariance: Matrix,
    states: Matrix,
    inputs: Matrix,
    every: int = 1,
) -> Array:
    """Return `posterior_bound` along one trajectory, shape (k // every, n, n).

    It is the Riccati recursion of the model linearised along the trajectory. Unlike the recursion of the information
    it permits states without process noise. Every reading exists after every step.

    Args:
        prediction: The model, n states and m outputs.
        process_noise: Densities of independent noises in (unit of the state)²/s, shape (n,).
        reading_noise: Variances of independent readings, shape (m,).
        period: Of a step [s].
        covariance: At the start, shape (n, n).
        states: Trajectory, shape (k + 1, n).
        inputs: Inputs of every step, shape (k, nu).
        every: Steps from one row of the result to the next.
    """
    added, noise, identity = np.diag(process_noise * period), np.diag(reading_noise), np.eye(len(covariance))
    bound = np.empty((len(inputs) // every, *covariance.shape))
    for k, held in enumerate(inputs):
        phi = transition(prediction.derivative_jacobian(states[k], held), period)
        jacobian = prediction.output_jacobian(states[k + 1], held)
        covariance = phi @ covariance @ phi.T + added
        gain = np.linalg.solve(jacobian @ covariance @ jacobian.T + noise, jacobian @ covariance).T
        kept = identity - gain @ jacobian
        covariance = kept @ covariance @ kept.T + (gain * reading_noise) @ gain.T
        if (k + 1) % every == 0:
            bound[k // every] = covariance
    return bound
