"""Where recordings come from: a stop of a scenario, or a user's file."""

from pathlib import Path

import numpy as np
import xarray

from railgrip.errors import EstimationError
from railgrip.estimation.run import model_of, units_of
from railgrip.estimation.spec import Specification, check_mass
from railgrip.scenario.quantity import in_units
from railgrip.trace.netcdf import FILE_NAME, read_trace
from railgrip.trace.read import FileRecording, recorded
from railgrip.trace.samples import evenly, with_signals


def recording_of_estimation(
    specification: Specification, *, data: Path | None = None, scenario: str | None = None, seed: int | None = None
) -> xarray.Dataset:
    """Return what an estimation's filter is given.

    Args:
        data: A trace, or a file read by [data]; a stop of the scenario of [source] when None.
        scenario: Another one than [source] says.
        seed: Likewise.

    Raises:
        EstimationError: There is no scenario or file, or no estimate can be made of it; in a sentence.
        ScenarioError: There is no such scenario, or it fails.
    """
    check_mass(specification)
    if data is not None:
        recording = recording_for(specification, data).recording
    else:
        # Imported when needed: a stop brings the FMU compiler, and reading a file needs none of it.
        from railgrip.estimation.stop import recording_of_stop

        source = specification.simulated()
        recording = recording_of_stop(scenario or source.scenario, source.seed if seed is None else seed, source.noise)
    recording = completed(specification, recording)
    if specification.course is None:
        return recording
    # Imported when asked for: recovering a track takes SciPy's splines, a rig or wagon has none.
    from railgrip.estimation.course import with_track_force

    return with_track_force(recording, specification.course)


def completed(specification: Specification, trace: xarray.Dataset) -> xarray.Dataset:
    """Return a trace on its even grid, with the inputs that the estimation gives a value.

    Raises:
        EstimationError: The grid is uneven, or a value is of no input or has another dimension.
    """
    units = {variable.name: variable.unit for variable in model_of(specification.model.class_).inputs}
    values = in_units(f"{specification.name}: [inputs]", specification.inputs, units)
    trace = evenly(trace)
    count = trace.sizes["time"]
    return with_signals(trace, {name: (np.full(count, value), units[name]) for name, value in values.items()})


def recording_for(specification: Specification, path: Path) -> FileRecording:
    """Return the recording in a file, and what had to be mended: a trace as it is, others by the estimation's [data].

    Raises:
        EstimationError: The estimation has no [data], or the file cannot be used; in a sentence.
        RecordError: The trace cannot be read.
    """
    if path.suffix == ".nc":
        trace = read_trace(path)
        # A stop's trace has the name of its folder.
        return FileRecording(
            recording=evenly(trace, path.parent.name if path.name == FILE_NAME else path.stem), flags=()
        )
    if specification.data is None:
        raise EstimationError(
            f"{specification.name}: has no [data], which says what the columns of {path.name} are; see "
            "harness/trace/table.py for an example."
        )
    model = model_of(specification.model.class_)
    units = units_of(specification.model.class_)
    inputs = [variable.name for variable in model.inputs if variable.name not in specification.inputs]
    outputs = [variable.name for variable in model.outputs]
    if specification.course is not None:
        from railgrip.estimation.course import ALWAYS, TRACK_FORCE, units_of_run

        of_run = units_of_run(list(specification.data.columns))
        units = {name: unit for name, unit in units.items() if name != TRACK_FORCE} | of_run
        inputs = [name for name in inputs if name != TRACK_FORCE] + [name for name in of_run if name in ALWAYS]
        outputs += [name for name in of_run if name not in ALWAYS]
    return recorded(path, specification.data, units, inputs, outputs)
