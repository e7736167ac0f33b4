"""The best constant, known only afterwards: the reference that an estimator must beat.

A bound on an error is meaningless by itself: where the truth hardly changes, a constant estimate satisfies it without
any sensor. So tests of accuracy measure errors relative to those of the best constant.
"""

import numpy as np


def rmse_over_constant(estimate, truth):
    """Return the RMS error of an estimate over that of the best constant, each shape (k,) or (k, m), per column."""
    estimate, truth = np.asarray(estimate), np.asarray(truth)
    return np.sqrt(np.mean((estimate - truth) ** 2, axis=0)) / np.std(truth, axis=0)


def error_95_of_constant(truth):
    """Return the smallest bound on 95 % of the errors that a constant can have, per column of (k, m).

    It is half of the shortest interval that contains 95 % of the truth.
    """
    ordered = np.sort(np.asarray(truth), axis=0)
    held = int(np.ceil(0.95 * len(ordered)))
    return 0.5 * np.min(ordered[held - 1 :] - ordered[: len(ordered) - held + 1], axis=0)
