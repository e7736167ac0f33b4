"""What tuning minimises: equation (14) of the paper, and the same with consistency."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from railgrip.errors import EstimationError, FilterDiverged
from railgrip.estimators.compiled import CompiledFilter, Estimates
from railgrip.studies.field_test.filtering import Task, follow
from railgrip.studies.field_test.noise import GROUPS, Noise

R_WHEEL = 0.38
"""Weight of |Δω| against |Δv| [m]: errors of the rim count as errors of the train."""

FRICTION = slice(1 + GROUPS, 1 + 3 * GROUPS)
"""μ_B and α among the states."""

DIVERGED = 1e3
"""Value of noises with which the filter diverges; any other is below."""

WEIGHT = 0.02
"""What a factor of ten in NIS or NEES costs [m/s]: about half of what the sensors' noise makes of the surprise, so
that neither term drowns the other."""

Kind = Literal["paper", "consistent"]


@dataclass(frozen=True, slots=True)
class Terms:
    """What one braking says about noises.

    Attributes:
        deviation: O_c of equation (14): mean of Σ r|ω measured − ω observed| + |v measured − v observed| [m/s].
        surprise: The same of the readings before they were seen, |ω measured − ω expected| … [m/s]: unlike O_c it
            cannot be made small by repeating what was read.
        nis: Mean normalised innovation squared over its degrees, 1 if the filter expects its readings rightly.
        nees: Mean of (error/sd)² over μ_B (brakes applied) and α, 1 if it knows its errors; NaN without truth.
    """

    deviation: float
    surprise: float
    nis: float
    nees: float


def terms_of(task: Task, estimate: Estimates) -> Terms:
    """Return the terms of one braking."""
    apart, ahead = (
        np.abs(task.readings - prediction).mean(axis=0)
        for prediction in (estimate.mean[:, : 1 + GROUPS], estimate.expectation)
    )
    nees = np.nan
    if task.truth is not None:
        # Before the brake is applied pad friction is held still and says nothing.
        after = slice(task.braking.brake + round(1.0 / task.period), None)
        error = (estimate.mean - task.truth)[after, FRICTION]
        nees = float(np.mean(error**2 / estimate.variance[after, FRICTION]))
    return Terms(
        deviation=float(apart[0] + R_WHEEL * apart[1:].sum()),
        surprise=float(ahead[0] + R_WHEEL * ahead[1:].sum()),
        nis=float(estimate.squared_innovation.sum() / estimate.degrees.sum()),
        nees=nees,
    )


def value(kind: Kind, terms: Sequence[Terms]) -> float:
    """Return the worst case: of the deviations, or of the surprises and the distance of NIS and NEES from 1.

    Raises:
        EstimationError: Consistency is asked for without truth.
    """
    if kind == "paper":
        return max(term.deviation for term in terms)
    if any(np.isnan(term.nees) for term in terms):
        raise EstimationError("tuning for consistency wants recordings whose truth is known; tune for 'paper'.")
    return max(term.surprise + WEIGHT * (abs(np.log10(term.nis)) + abs(np.log10(term.nees))) for term in terms)


def evaluate(kind: Kind, tasks: Sequence[Task], filter_: CompiledFilter, noise: Noise) -> float:
    """Return the objective of noises over brakings."""
    try:
        return value(kind, [terms_of(task, follow(task, filter_, noise)) for task in tasks])
    except FilterDiverged:
        return DIVERGED
