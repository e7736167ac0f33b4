"""A sample of cases for `make test`, and all of them for `make fuzz`."""

import os
from collections.abc import Sequence
from typing import TypeVar

Case = TypeVar("Case")
FUZZ = "RAILGRIP_FUZZ" in os.environ


def sample(cases: Sequence[Case], count: int) -> Sequence[Case]:
    """Return `count` of the cases, evenly spaced with the first and the last, or all of them with RAILGRIP_FUZZ."""
    if FUZZ or count >= len(cases):
        return cases
    return [cases[round(k * (len(cases) - 1) / max(count - 1, 1))] for k in range(count)]
