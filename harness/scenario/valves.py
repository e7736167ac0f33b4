"""Communication steps that a plant with valves cannot tell from its own samples."""

import math
from fractions import Fraction
from typing import Final

from railgrip.scenario.table import broken

SAMPLES: Final = Fraction("0.0005"), Fraction("0.002")
"""First sample of the valves' dead times in the plants of this project, and the time between two [s]: offset and period
of RailBraking.Pneumatics.ValveDelay."""


def off_the_samples(step: float) -> float:
    """Return a communication step [s] of which no multiple is a sample of the valves.

    Where they coincide, rounding decides whether a command acts before or after the sample, and a solver may be asked
    to integrate over the rounding error, at which that of OpenModelica's FMUs gives up.

    Raises:
        PydanticCustomError: A multiple is.
    """
    first, interval = SAMPLES
    exact = Fraction(step).limit_denominator(10**9)
    # n step = first + k interval has whole solutions where what divides step and interval divides first, too.
    common = Fraction(
        math.gcd(exact.numerator * interval.denominator, interval.numerator * exact.denominator),
        exact.denominator * interval.denominator,
    )
    if (first / common).denominator == 1:
        raise broken(
            f"of {step:g} s makes steps end on samples of the valves' dead times, every {float(interval):g} s from "
            f"{float(first):g} s on, where rounding decides which command they see; take whole milliseconds"
        )
    return step
