"""Small quantiles of a performance that depends on standard normal numbers and on discrete failure states.

P(g < k) = Σ P(state) P(g(state, U) < k): states are enumerated, and the continuous distribution within each state is
sampled.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from math import ceil, comb, log, sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri, stdtrit

from railgrip.estimators.belief import Array
from railgrip.trace.k_wet import Interval

Performance = Callable[[Array], Array]
"""Standard normal numbers, shape (n, dimension) → performance, shape (n, outputs) or (n,); small is bad."""

CONFIDENCE = 0.95
"""Confidence of the intervals of K."""

_TURNS = 3
_STEP = 1e-3
_ROUNDING = 1e-9

_GRID = 8000
"""Values at which the distributions of the failure states are mixed: 2e-4 apart where K reaches from 0 to 1.4."""

_CHAIN = 10
"""Length of a Markov chain: one over the share that each level keeps."""
_CORRELATION = 0.8


@dataclass(frozen=True, slots=True)
class State:
    """A failure state and its probability.

    Attributes:
        available: Number of units of each group, or of several like groups together, that still brake.
        probability: Probability of the state.
    """

    available: tuple[int, ...]
    probability: float


@dataclass(frozen=True, slots=True)
class Rates:
    """Failure probabilities of components, with common causes by the beta-factor model of IEC 61508-6, annex D.

    A component fails alone with (1 − β) q, and with all others of its set with β q.

    Attributes:
        isolated: Probability that a unit is isolated.
        stuck: Probability that the valve of a group is stuck.
        isolated_beta: Share of `isolated` in which all units of the group are isolated.
        stuck_beta: Share of `stuck` in which the valves of all groups are stuck.
    """

    isolated: float
    stuck: float
    isolated_beta: float = 0.0
    stuck_beta: float = 0.0

    @property
    def total_loss(self) -> float:
        """Probability that all valves are stuck by a common cause."""
        return self.stuck_beta * self.stuck

    def of_group(self, units: int) -> tuple[float, ...]:
        """Return the probability of 0, 1 … `units` braking units in a group, without the common cause of all valves."""
        alone = (1 - self.isolated_beta) * self.isolated
        together = self.isolated_beta * self.isolated
        stuck = (1 - self.stuck_beta) * self.stuck
        # The group is lost by its valve or by the common cause of its units.
        lost = stuck + (1 - stuck) * together
        return tuple(
            (1 - lost) * comb(units, count) * alone ** (units - count) * (1 - alone) ** count + lost * (count == 0)
            for count in range(units + 1)
        )

    def of_groups(self, units: int | Sequence[int]) -> tuple[float, ...]:
        """Return the probability of 0, 1 … braking units in a group, or in several groups together."""
        groups = [np.array(self.of_group(n)) for n in ([units] if isinstance(units, int) else units)]
        return tuple(reduce(np.convolve, groups).tolist())

    def of_states(self, units: Sequence[int | Sequence[int]], available: ArrayLike) -> Array:
        """Return the probability that exactly the `available` units, shape (states, groups), brake in each state."""
        counts = np.asarray(available)
        probability = np.ones(len(counts))
        for group, n in enumerate(units):
            probability *= np.array(self.of_groups(n))[counts[:, group]]
        return (1 - self.total_loss) * probability + self.total_loss * ~counts.any(axis=1)


def states_of(units: Sequence[int | Sequence[int]], rates: Rates, *, neglect: float) -> tuple[tuple[State, ...], float]:
    """Return the failure states of highest probability and the total probability of all others.

    Units of a group are exchangeable, so only their number counts; a stuck valve takes all units of its group.

    Args:
        units: Number of units of each group; a sequence stands for several like groups, which count together.
        rates: Failure probabilities.
        neglect: Maximum total probability of the others.
    """
    groups = [list(enumerate(rates.of_groups(n))) for n in units]
    states, rest = [State((), 1.0)], 0.0
    for group in groups:
        candidates = [State((*state.available, count), state.probability * p) for state in states for count, p in group]
        candidates.sort(key=lambda state: (-state.probability, state.available))
        # Summed in ascending order: the difference from one would lose all digits.
        tail = np.cumsum([state.probability for state in reversed(candidates)])
        excess = min(int(np.searchsorted(tail, neglect / len(groups), side="right")), len(candidates) - 1)
        rest += float(tail[excess - 1]) if excess else 0.0
        states = candidates[: len(candidates) - excess]
    if rates.total_loss > 0.0:
        available, lost = [state.available for state in states], (0,) * len(units)
        if lost not in available and rest + rates.total_loss <= neglect:
            rest += rates.total_loss
        elif lost not in available:
            available.append(lost)
        probabilities = rates.of_states(units, available).tolist()
        states = [State(*state) for state in zip(available, probabilities, strict=True)]
        states.sort(key=lambda state: (-state.probability, state.available))
    return tuple(states), rest


class Sample:
    """Values with weights: the weights of those below k estimate the probability of being below k.

    Attributes:
        values: Shape (n,), rising.
        weights: Weight of each value.
    """

    def __init__(self, values: Array, weights: Array) -> None:
        """Create a sample from values in any order, and the weight of each."""
        order = np.argsort(values, kind="stable")
        self.values, self.weights = values[order], weights[order]
        self._below = np.cumsum(self.weights)

    def quantile(self, probability: float) -> float:
        """Return the quantile of a probability."""
        place = int(np.searchsorted(self._below, probability))
        return float(self.values[min(place, len(self.values) - 1)])

    def probability_of_at_most(self, values: Array) -> Array:
        """Return the estimated distribution function at some values."""
        return np.append(0.0, self._below)[np.searchsorted(self.values, values, side="right")]


def pool_samples(samples: Sequence[Sample], shares: Sequence[float]) -> Sample:
    """Return the sample of a mixture, each part with its share."""
    weights = [share * sample.weights for sample, share in zip(samples, shares, strict=True)]
    return Sample(np.concatenate([sample.values for sample in samples]), np.concatenate(weights))


def estimates(
    runs: Sequence[Sample], probabilities: Sequence[float], neglected: float = 0.0, confidence: float = CONFIDENCE
) -> tuple[Interval, ...]:
    """Return quantiles of all runs together, with intervals from the scatter of single runs (sectioning).

    Neglected failure states may be worse than all others, so they extend the intervals downwards.

    Raises:
        ValueError: Neglected states are as probable as a quantile.

    Source: Asmussen, Glynn: Stochastic Simulation (2007), III.5.
    """
    if neglected >= min(probabilities):
        raise ValueError(
            f"states of a probability of {neglected:g} are left out of a quantile of {min(probabilities):g}"
        )
    together = pool_samples(runs, [1 / len(runs)] * len(runs))
    width = float(stdtrit(len(runs) - 1, (1 + confidence) / 2)) / sqrt(len(runs))
    intervals: list[Interval] = []
    for probability in probabilities:
        half = width * float(np.std([run.quantile(probability) for run in runs], ddof=1))
        value = together.quantile(probability)
        intervals.append(Interval(value, together.quantile(probability - neglected) - half, value + half))
    return tuple(intervals)


def widen(
    intervals: Sequence[Interval],
    parts: Sequence[Sample],
    shares: Array,
    probabilities: Sequence[float],
) -> tuple[Interval, ...]:
    """Return intervals of 95 % of quantiles that include the uncertainty of the probabilities of the failure states.

    The quantile is computed for each draw of the probabilities; the interval ranges from the lower to the upper
    quantile of the results, extended by the interval of sampling. Neglected states extend the intervals downwards.

    Args:
        intervals: Intervals of sampling alone.
        parts: Sample of each state.
        shares: Draws of the states' probabilities, shape (draws, states).
        probabilities: Probabilities of the quantiles.
    """
    grid = np.linspace(min(part.values[0] for part in parts), max(part.values[-1] for part in parts), _GRID)
    cumulative = shares @ np.array([part.probability_of_at_most(grid) for part in parts])
    left_out = np.maximum(1.0 - shares.sum(axis=1), 0.0)
    tails = ((1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2)
    wide: list[Interval] = []
    for bounds, probability in zip(intervals, probabilities, strict=True):
        places = [
            np.array([np.searchsorted(row, p) for row, p in zip(cumulative, below, strict=True)])
            for below in (probability - left_out, np.full(len(shares), probability))
        ]
        worst, best = (grid[np.minimum(place, len(grid) - 1)] for place in places)
        low = float(np.quantile(worst, tails[0])) - (bounds.value - bounds.low)
        high = float(np.quantile(best, tails[1])) + (bounds.high - bounds.value)
        wide.append(Interval(bounds.value, min(low, bounds.low), max(high, bounds.high)))
    return tuple(wide)


def worst_points(performance: Performance, dimension: int, depth: int, guides: Sequence[int] | None = None) -> Array:
    """Return centres for sampling: the origin, and for each output the worst points at distances 1 to `depth` from it.

    `guides` are the outputs for which they are searched, all of them unless given.

    Each is the fixed point −r ∇g/|∇g| of the first-order reliability method on a sphere of radius r, after three
    iterations. A point that is not the worst increases the variance, but causes no bias.
    """
    points = [np.zeros(dimension)]
    outputs = performance(points[0][None, :]).shape[1]
    for output in (range(outputs) if guides is None else guides) if depth > 0 else ():
        point = points[0]
        for radius in range(1, depth + 1):
            for _ in range(_TURNS):
                around = performance(np.vstack([point, point + _STEP * np.eye(dimension)]))[:, output]
                slope = (around[1:] - around[0]) / _STEP
                length = float(np.linalg.norm(slope))
                point = -radius * slope / length if length > 0 else point
            points.append(point)
    return np.array(points)


def importance_sample(
    performance: Performance, points: Array, samples: int, random: np.random.Generator
) -> tuple[Array, Array]:
    """Return performances, shape (n, outputs), and weights, shape (n,), of draws about several points.

    The draws are from normal distributions about all points, the same number of each (rounded up), weighted by the
    density of their mixture. One of them is the original distribution, so that no weight exceeds their number over n.

    Source: Hesterberg, Technometrics 37 (1995) 185; Owen, Zhou, JASA 95 (2000) 135.
    """
    each = -(-samples // len(points))
    sample = np.repeat(points, each, axis=0) + random.standard_normal((each * len(points), points.shape[1]))
    exponents = sample @ points.T - 0.5 * np.sum(points**2, axis=1)
    top = exponents.max(axis=1)
    density = np.exp(top) * np.exp(exponents - top[:, None]).mean(axis=1)
    return performance(sample), 1.0 / (density * len(sample))


def subset_sample(
    performance: Performance,
    dimension: int,
    probability: float,
    samples: int,
    random: np.random.Generator,
) -> Sample:
    """Return a sample that reaches down to the quantile of a probability, by subset simulation.

    Each level keeps the worst tenth of the previous one and continues from them in Markov chains, whose candidates
    ρ u + √(1−ρ²) ξ, ρ = 0.8, are accepted if they are below the threshold. `samples` is a multiple of ten.

    Source: Au, Beck, Probab. Eng. Mech. 16 (2001) 263; candidates: Papaioannou et al., Probab. Eng. Mech. 41 (2015) 89.
    """
    chains = samples // _CHAIN
    u = random.standard_normal((chains * _CHAIN, dimension))
    g, weight = performance(u), np.full(len(u), 1.0 / len(u))
    values: list[Array] = []
    weights: list[Array] = []
    for _ in range(_levels(probability)):
        order = np.argsort(g, kind="stable")
        worst, threshold = order[:chains], g[order[chains]]
        values.append(g[order[chains:]])
        weights.append(weight[chains:])
        weight = weight / _CHAIN
        x, y = u[worst], g[worst]
        states, performances = [x], [y]
        for _ in range(_CHAIN - 1):
            candidate = _CORRELATION * x + sqrt(1 - _CORRELATION**2) * random.standard_normal(x.shape)
            g_candidate = performance(candidate)
            is_accepted = g_candidate <= threshold
            x, y = np.where(is_accepted[:, None], candidate, x), np.where(is_accepted, g_candidate, y)
            states.append(x)
            performances.append(y)
        u, g = np.concatenate(states), np.concatenate(performances)
    return Sample(np.concatenate([*values, g]), np.concatenate([*weights, weight]))


def subset_cost(probability: float, samples: int) -> int:
    """Return the number of evaluations of `subset_sample`."""
    return samples // _CHAIN * (_CHAIN + _levels(probability) * (_CHAIN - 1))


def _levels(probability: float) -> int:
    return max(ceil(-log(probability, _CHAIN) - _ROUNDING) - 1, 0)


def depth(state: State, smallest: float) -> int:
    """Return the distance from the origin to which a state must be sampled for a quantile of probability `smallest`."""
    inside = smallest / state.probability
    return 0 if inside >= 0.5 else int(np.ceil(-ndtri(inside)))
