"""Errors of a filter relative to its own covariance, and chi-square bounds of their means."""

import numpy as np
from scipy.stats import chi2


def nees(estimate, truth, states=None):
    """Return eᵀP⁻¹e, chi-square with one degree of freedom per state; for all states if None.

    Solved in units of the states' standard deviations: variances of 1e-10 m² next to 1e-1 (rad/s)² cost more digits
    than correlations do. Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation
    (2001), §5.4.
    """
    places = np.arange(truth.size) if states is None else np.asarray(states)
    covariance = estimate.covariance[np.ix_(places, places)]
    deviation = np.sqrt(np.diagonal(covariance))
    error = (truth - estimate.mean)[places] / deviation
    return float(error @ np.linalg.solve(covariance / np.outer(deviation, deviation), error))


def chi_square_bounds(degrees, runs=1, confidence=0.95):
    """Return the interval that contains the mean of `runs` independent chi-square values with this probability.

    The NEES of n states has n degrees, the NIS of a step one per reading used. Values at successive steps of one run
    are not independent: average over runs, not over time.
    """
    tail = 0.5 * (1.0 - confidence)
    low, high = chi2.ppf([tail, 1.0 - tail], degrees * runs) / runs
    return float(low), float(high)
