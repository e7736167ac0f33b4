"""The six runs of the field test."""

from collections.abc import Callable, Sequence

import xarray

from railgrip.estimation.track.braking import Braking, braking_of
from railgrip.twins.field_scenario import FieldScenario
from railgrip.twins.field_train import run_case

TUNING = ("c1", "c2", "c3", "c4", "c5")
TEST = "c6"
"""Not looked at while tuning."""


def brakings(
    scenario: FieldScenario, cases: Sequence[str], tell: Callable[[str], None] = lambda case: None
) -> dict[str, tuple[xarray.Dataset, Braking]]:
    """Return run and braking of each case.

    Raises:
        EstimationError: See `run_case` and `braking_of`.
    """
    made: dict[str, tuple[xarray.Dataset, Braking]] = {}
    for case in cases:
        tell(case)
        run = run_case(scenario, case)
        made[case] = run, braking_of(run, scenario.train.mass, curve_law=scenario.track.curve_law)
    return made
