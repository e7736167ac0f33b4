"""Where recordings come from: a twin, one function for each kind of `[source]`, or a user's file.

A new twin is one line in `_maker`; what that returns is called with the scenario's name and the seed.
"""

from collections.abc import Callable
from pathlib import Path

import xarray

from railgrip.errors import EstimationError
from railgrip.estimation.recorded.specified import taken_for
from railgrip.estimation.spec import SourceTable, Specification, check_mass

Maker = Callable[[str, int | None], xarray.Dataset]
"""Scenario and seed, None for the scenario's own, to a recording."""

KINDS = ("roller_rig", "wagon", "field")


def recording_of_estimation(
    specification: Specification, *, data: Path | None = None, scenario: str | None = None, seed: int | None = None
) -> xarray.Dataset:
    """Return what an estimation's filter is given.

    Args:
        specification: The estimation.
        data: A user's file, read by [data]; the twin of [source] when None.
        scenario: Another one of the twin than [source] says.
        seed: Likewise.

    Raises:
        EstimationError: There is no such twin, scenario or file, or no estimate can be made of it; in a sentence.
    """
    check_mass(specification)
    if data is not None:
        recording = taken_for(specification, data).recording
    else:
        changed = {name: value for name, value in (("scenario", scenario), ("seed", seed)) if value is not None}
        recording = recording_for(specification.twin().model_copy(update=changed))
    if specification.course is None:
        return recording
    # Imported when asked for: recovering a track takes SciPy's splines, a rig or wagon has none.
    from railgrip.estimation.course import with_track_force

    return with_track_force(recording, specification.course)


def recording_for(source: SourceTable) -> xarray.Dataset:
    """Return the recording that a `[source]` asks for.

    Raises:
        EstimationError: There is no such kind or no such scenario.
    """
    return _maker(source.kind)(source.scenario, source.seed)


def _maker(kind: str) -> Maker:
    # Imported when asked for: twins bring the FMU compiler, and reading a file needs none of it.
    if kind == "roller_rig":
        from railgrip.twins.rig_scenario import rig_scenario
        from railgrip.twins.roller_rig import run_rig

        return lambda scenario, seed: run_rig(rig_scenario(scenario), seed)
    if kind == "wagon":
        from railgrip.twins.wagon import run_wagon, wagon_scenario

        return lambda scenario, seed: run_wagon(wagon_scenario(scenario), seed)
    if kind == "field":
        from railgrip.twins.field_scenario import field_case
        from railgrip.twins.field_train import run_case

        return lambda scenario, seed: run_case(*field_case(scenario), seed)
    raise EstimationError(f"[source] kind is '{kind}'; there is {', '.join(KINDS)}.")
