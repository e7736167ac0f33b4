"""Statistics of controllers over draws and cases, with 95 % intervals.

Controllers are compared on the draws or cases that all of them have, so that the difficulty of a draw cancels:
`on_common` selects these, and `rank` refuses others. A stop without standstill counts as an infinite distance; it is
never omitted.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, Final, cast

import numpy as np

from railgrip.base.arrays import Array

CONFIDENCE: Final = 0.95

_ENDS: Final = (0.025, 0.975)
"""Of `CONFIDENCE`: (1 − 0.95)/2 is not 0.025 in floating point, and the 50th of 2000 would become the 51st."""

FEWEST_DRAWS: Final = 20
"""Minimum number of draws of a bootstrap interval: in place of 95 % it covers 79 % for the mean of 4 draws, 91 % of 20.
"""

_RESAMPLES: Final = 2000
_SEED: Final = 8


def on_common(frame: Any, entrant: str, case: Sequence[str], value: str) -> Any:
    """Return the rows of the cases in which every entrant has a value: on these alone entrants can be compared.

    An entrant without any value is left out.

    Args:
        frame: A row for each entrant and case.
        entrant: Column with the names of controllers, estimators or variants.
        case: Columns that identify a case.
        value: Column of the compared value: infinite without standstill, NaN if the entrant does not have the case.

    Raises:
        ValueError: An entrant has a case twice.
    """
    known = frame[frame[value].notna()]
    if known.duplicated([entrant, *case]).any():
        raise ValueError(f"an entrant has two rows of the same {', '.join(case)}")
    shared = known.groupby(list(case), dropna=False)[entrant].transform("nunique") if len(known) else known[entrant]
    return known[shared == known[entrant].nunique()]


def rank(frame: Any, entrant: str, case: Sequence[str], value: str) -> Any:
    """Return a row for each entrant, by name, the one with the smallest median first.

    Columns are `cases`; `failed`, the number of infinite values, by which entrants are ordered before their medians, so
    that none is first because it rarely came to a standstill; `median`; `lowest` and `highest`.

    Args:
        frame: As for `on_common`, which selects rows that are not refused.

    Raises:
        ValueError: Entrants have different cases.
    """
    if len(on_common(frame, entrant, case, value)) < len(frame):
        raise ValueError(f"entrants have different cases and cannot be ranked by {value}; see on_common")
    values = frame.groupby(entrant, sort=False)[value]
    statistics = values.agg(
        cases="size", failed=lambda own: int(np.isinf(own).sum()), median="median", lowest="min", highest="max"
    )
    return statistics.sort_values(["failed", "median"], kind="stable")


def finite(value: float) -> float | None:
    """Return a number, or None for NaN and infinity."""
    return float(value) if math.isfinite(value) else None


def endless(distance: float | None) -> float:
    """Return a distance, infinite for None."""
    return math.inf if distance is None else distance


def quantile(values: Sequence[float], share: float) -> float:
    """Return the smallest of the values that a share of them does not exceed; NaN without values.

    It is not interpolated, so that infinite values are handled.
    """
    return float(np.quantile(values, share, method="inverted_cdf")) if len(values) else math.nan


def relative_change(value: float, reference: float) -> float:
    """Return value over reference minus 1, and 0 if both are infinite."""
    return 0.0 if math.isinf(value) and math.isinf(reference) else value / reference - 1.0


def share_interval(count: int, of: int) -> tuple[float, float]:
    """Return the interval of a share; Clopper and Pearson, Biometrika 26 (1934)."""
    from scipy import stats  # takes half a second to load, which most campaigns do not need

    # scipy's stubs lack attributes that its documentation has, here and below.
    interval = cast("Any", stats.binomtest(count, of).proportion_ci(CONFIDENCE, method="exact"))
    return float(interval.low), float(interval.high)


def median_interval(values: Sequence[float]) -> tuple[float, float] | None:
    """Return the interval of a median; see `order_interval`."""
    return order_interval(values, 0.5)


def order_interval(values: Sequence[float], share: float) -> tuple[float, float] | None:
    """Return the interval of a quantile from order statistics, for any distribution; None with too few values.

    Source: Conover, Practical Nonparametric Statistics (1999), section 3.2.
    """
    from scipy import stats

    interval = cast("Any", stats.quantile_test(values, q=0, p=share)).confidence_interval(CONFIDENCE)
    low, high = float(interval.low), float(interval.high)
    return None if math.isnan(low) or math.isnan(high) else (low, high)


def draws_for_interval(share: float = 0.5) -> int:
    """Return the minimum number of draws of a bootstrap interval of a quantile.

    The ends of the interval are draws, so that it ends too early if all draws are often on one side of the quantile.
    """
    return max(FEWEST_DRAWS, math.ceil(math.log(_ENDS[0]) / math.log(max(share, 1.0 - share))))


def bootstrap_interval(
    cases: Sequence[Any] | Array,
    statistic: Callable[[Array], Array],
    *,
    fewest: int = FEWEST_DRAWS,
    interpolate: bool = True,
    resamples: int = _RESAMPLES,
    generator: np.random.Generator | None = None,
) -> tuple[float, float] | None:
    """Return the percentile bootstrap interval of a statistic over cases; None with fewer than `fewest` cases.

    `scipy.stats.bootstrap` draws other cases from the same seed, which would move all published intervals.

    Args:
        cases: Values of each case, shape (n, …).
        statistic: Function of resampled cases, shape (m, n, …), that returns m values.
        fewest: Minimum number of cases; for a statistic of quantiles `draws_for_interval`.
        interpolate: Whether ends are interpolated between resamples; the mean of two infinite distances is undefined.
        resamples: Number of resamples.
        generator: Generator of the draws; None for that of all published intervals of stops.

    Raises:
        ValueError: A value is NaN, or infinite although ends are interpolated.

    Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 13.
    """
    values = np.asarray(cases, dtype=np.float64)
    if np.isnan(values).any() or (interpolate and np.isinf(values).any()):
        raise ValueError("a bootstrap interval needs a number for each case; leave out the cases without one")
    if len(values) < fewest:
        return None
    random = np.random.default_rng(_SEED) if generator is None else generator
    draws = random.integers(len(values), size=(resamples, len(values)))
    method = "linear" if interpolate else "inverted_cdf"
    low, high = np.quantile(statistic(values[draws]), _ENDS, method=method)
    return float(low), float(high)


def quantile_interval(values: Sequence[float], share: float) -> tuple[float, float] | None:
    """Return the percentile bootstrap interval of a quantile, which may be infinite; None with too few values."""

    def quantiles(draws: Array) -> Array:
        return np.quantile(draws, share, axis=1, method="inverted_cdf")

    return bootstrap_interval(values, quantiles, fewest=draws_for_interval(share), interpolate=False)
