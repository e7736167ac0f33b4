"""Where recordings come from: one function for each kind of `[source]`.

A branch that brings a twin adds one line to `_maker`; what it returns is called with the scenario's name and the seed.
"""

from collections.abc import Callable

import xarray

from harness.estimate.error import EstimationError
from harness.estimate.spec import SourceTable

Maker = Callable[[str, int | None], xarray.Dataset]
"""Scenario and seed, None for the scenario's own, to a recording."""

KINDS = ("roller_rig", "wagon")


def recording_for(source: SourceTable) -> xarray.Dataset:
    """Return the recording that a `[source]` asks for.

    Raises:
        EstimationError: There is no such kind or no such scenario.
    """
    return _maker(source.kind)(source.scenario, source.seed)


def _maker(kind: str) -> Maker:
    # Imported when asked for: twins bring the FMU compiler, and reading a file needs none of it.
    if kind == "roller_rig":
        from harness.twins.rig_scenario import rig_scenario
        from harness.twins.roller_rig import run_rig

        return lambda scenario, seed: run_rig(rig_scenario(scenario), seed)
    if kind == "wagon":
        from harness.twins.wagon import run_wagon, wagon_scenario

        return lambda scenario, seed: run_wagon(wagon_scenario(scenario), seed)
    raise EstimationError(f"[source] kind is '{kind}'; there is {', '.join(KINDS)}.")
