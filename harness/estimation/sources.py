"""Where recordings come from: a stop of a scenario, or a user's file; and their track force, if [course] asks for it.

A run that [course] finds the track force of brings `speed` (optical or radar), `acceleration_along[1]` … (as many as
there are, feeling g sin β too), `latitude`, `longitude`, `height` (NaN between the samples of the receiver), wheelset
speeds, cylinder pressures, `driving` (0 or 1: the filter knows no traction and begins when there is none) and, if
somebody recorded it, `braking`; else braking begins where a cylinder fills. The trace of a stop has `traction` and
`driver_demand` in their place. What comes back begins with the coasting before the brake and has `track_force` beside
the readings.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray

from railgrip.errors import EstimationError
from railgrip.estimation.run import model_of, units_of
from railgrip.estimation.spec import CourseTable, Specification, check_mass
from railgrip.estimation.stop import recording_of_stop
from railgrip.estimation.track.braking import braking_of
from railgrip.scenario.quantity import in_units
from railgrip.trace.netcdf import FILE_NAME, read_trace
from railgrip.trace.read import FileRecording, recorded
from railgrip.trace.samples import evenly, with_signals

_ALWAYS = {"driving": "1", "braking": "1"}
"""Signals that the whole run must tell, if it tells them."""
_UNITS_OF_RUN = {"latitude": "deg", "longitude": "deg", "height": "m"} | _ALWAYS


def recording_of_estimation(
    specification: Specification,
    *,
    data: Path | None = None,
    scenario: str | None = None,
    seed: int | None = None,
    import_from: Sequence[Path] = (),
) -> xarray.Dataset:
    """Return what an estimation's filter is given.

    Args:
        data: A trace, or a file read by [data]; a stop of the scenario of [source] when None.
        scenario: Another one than [source] says.
        seed: Likewise.
        import_from: Folders of classes that the scenario names.

    Raises:
        EstimationError: There is no scenario or file, or no estimate can be made of it; in a sentence.
        ScenarioError: There is no such scenario, or it fails.
    """
    check_mass(specification)
    if data is not None:
        recording = recording_for(specification, data).recording
    else:
        source = specification.simulated()
        seed = source.seed if seed is None else seed
        recording = recording_of_stop(scenario or source.scenario, seed, source.noise, import_from)
    recording = completed(specification, recording)
    return recording if specification.course is None else with_track_force(recording, specification.course)


def with_track_force(run: xarray.Dataset, course: CourseTable) -> xarray.Dataset:
    """Return a run from its coasting on, with the force of gradient and curves.

    Raises:
        EstimationError: A reading is missing, nobody braked, or the train was driven until then.
    """
    return braking_of(
        run, course.mass, curve_law=course.curve_law, low_pass=course.low_pass, trust=course.trust
    ).recording


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
        columns = list(specification.data.columns)
        of_run = {name: "m/s2" for name in columns if name.partition("[")[0] == "acceleration_along"}
        of_run |= {name: unit for name, unit in _UNITS_OF_RUN.items() if name in columns}
        units = {name: unit for name, unit in units.items() if name != "track_force"} | of_run
        inputs = [name for name in inputs if name != "track_force"] + [name for name in of_run if name in _ALWAYS]
        outputs += [name for name in of_run if name not in _ALWAYS]
    return recorded(path, specification.data, units, inputs, outputs)
