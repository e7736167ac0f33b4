"""Recordings for an estimation: a stop of its scenario or a user's file, with the track force computed by [course].

To compute the track force, [course] requires a run with `speed` (optical or radar), `acceleration_along[1]` … (any
number, each including g sin β), `latitude`, `longitude`, `height` (NaN between the samples of the receiver), wheelset
speeds, cylinder pressures, `driving` (0 or 1: the filter does not model traction and starts after it) and, optionally,
`braking`; without it braking begins when a cylinder fills. The trace of a stop has `traction` and `driver_demand`
instead. The result begins with the coasting before the brake and has `track_force` in addition to the readings.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray

from railgrip.base.arrays import generator
from railgrip.base.errors import EstimationError
from railgrip.base.units import cut
from railgrip.estimation.agreement import require_agreement
from railgrip.estimation.braking import braking_of
from railgrip.estimation.check import require_consistent, require_groups, signals_of
from railgrip.estimation.spec import Specification
from railgrip.estimators.belief import Vector
from railgrip.recording.read import FileRecording, read_recording
from railgrip.recording.samples import evenly, readings_in, recording_of, with_signals
from railgrip.scenario.load import load
from railgrip.scenario.quantity import Magnitude, in_units
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import trace_of
from railgrip.simulate.user_parts import CustomParts
from railgrip.trace.netcdf import FILE_NAME, read_trace
from railgrip.trace.recorder import thin


def recording_of_estimation(
    specification: Specification,
    *,
    data: Path | None = None,
    scenario: str | None = None,
    seed: int | None = None,
    import_from: Sequence[Path] = (),
) -> xarray.Dataset:
    """Return the recording of an estimation.

    Its attribute `flags` has a sentence for each repair of a user's file, `warnings` one for each failed comparison of
    its signals (`railgrip.estimation.agreement`).

    Args:
        data: A trace, or a file read by [data]; None for a stop of the scenario of [source].
        scenario: Replaces that of [source].
        seed: Replaces that of [source].
        import_from: Folders of classes that the scenario names.

    Raises:
        EstimationError: The scenario or file is missing or not suitable, or its signals contradict each other more than
            on any vehicle.
        ScenarioError: The scenario does not exist, or its stop fails.
    """
    if data is not None:
        require_consistent(specification)
        recording = recording_for(specification, data).recording
    else:
        source = specification.source_scenario()
        scenario = scenario or source.scenario
        require_consistent(specification, scenario)
        recording = recording_of_stop(scenario, source.seed if seed is None else seed, source.noise, import_from)
    run, recording = recording_of_trace(specification, recording)
    if data is None or data.suffix == ".nc":  # a trace has its units and one clock
        return recording
    return recording.assign_attrs(warnings=require_agreement(specification, run, recording, data.name))


def recording_of_trace(specification: Specification, trace: xarray.Dataset) -> tuple[xarray.Dataset, xarray.Dataset]:
    """Return a trace completed by the estimation, and the part of it that the filter uses.

    Errors are those of `complete_trace` and, with [course], of `railgrip.estimation.braking.braking_of`.
    """
    run = complete_trace(specification, trace)
    return run, run if specification.course is None else braking_of(run, specification.course).recording


def complete_trace(specification: Specification, trace: xarray.Dataset) -> xarray.Dataset:
    """Return a trace on its even grid, with the constant inputs of the estimation.

    Raises:
        EstimationError: The grid is uneven, a constant belongs to no input or has another dimension, or the trace has
            groups that the model does not have.
    """
    units = {variable.name: variable.unit for variable in specification.model.prediction.model.inputs}
    values = in_units(f"{specification.name}: [inputs]", specification.inputs, units)
    require_groups(specification, readings_in(trace))
    trace = evenly(trace)
    count = trace.sizes["time"]
    return with_signals(trace, {name: (np.full(count, value), units[name]) for name, value in values.items()})


def recording_for(specification: Specification, path: Path) -> FileRecording:
    """Return the recording in a file and its repairs: a trace unchanged, other files by [data] of the estimation.

    Raises:
        EstimationError: The estimation has no [data], or the file cannot be used.
        RecordError: The trace cannot be read.
    """
    if path.suffix == ".nc":
        trace = read_trace(path)
        # The trace of a stop is named after its folder.
        return FileRecording(
            recording=evenly(trace, path.parent.name if path.name == FILE_NAME else path.stem), flags=()
        )
    if specification.data is None:
        raise EstimationError(
            f"{specification.name}: has no [data], which maps the columns of {cut(path.name)}; "
            f"`railgrip inspect {cut(path.name)} --for {specification.name}` proposes it."
        )
    units, inputs, outputs = signals_of(specification)
    return read_recording(path, specification.data, units, inputs, outputs)


def stop_read(
    scenario: Scenario, name: str = "", import_from: Sequence[Path] = (), *, objects: CustomParts | None = None
) -> xarray.Dataset:
    """Return the trace of a stop on the grid of [periods] trace as a recording, by default named after the scenario.

    Classes that the scenario names are imported from the folders `import_from`, unless `objects` replace parts.

    Raises:
        ScenarioError: The stop fails.
    """
    trace = trace_of(scenario, import_from, objects=objects)
    return evenly(thin(trace, int(scenario.periods.steps_of("trace"))), name or scenario.name)


def recording_of_stop(
    scenario: str, seed: int | None, noise: Mapping[str, Magnitude], import_from: Sequence[Path] = ()
) -> xarray.Dataset:
    """Return the recording of a stop.

    It has the signals of the plant under their names, elements of arrays as `name[i]`, and `wheel_torque`, the known
    resistance of bearings and rolling, negative because it opposes the rotation. The true adhesion is that of the whole
    train, ΣF_x/ΣF_z.

    Args:
        scenario: Name or file of the scenario.
        seed: Seed of the scenario and the noise; None for the scenario's own.
        noise: Signal → standard deviation of its reading, white from sample to sample; other signals are not read. If
            empty, the sensors of the scenario are used: the trace of the stop is the recording.
        import_from: Folders of classes that the scenario names.

    Raises:
        ScenarioError: The scenario does not exist, its stop fails, or its plant lacks a signal to be read.
    """
    stop_scenario = load(Path(scenario), [] if seed is None else [f"seed={seed}"])
    trace = stop_read(stop_scenario, import_from=import_from)
    if not noise:
        return trace
    unit_of_signal = {
        str(name): str(trace[name].attrs.get("units", "")) for name in trace if not trace[name].isnull().any()
    }
    deviations = in_units(f"{stop_scenario.name}: [source.noise]", noise, unit_of_signal)
    columns: dict[str, tuple[Vector, str]] = {}
    for name, deviation in deviations.items():
        for key, (values, unit) in _elements(trace, name, name).items():
            # One stream for each signal: its noise does not depend on which others are read.
            white = generator(stop_scenario.seed, f"instruments.{key}").standard_normal(values.size)
            columns[key] = values + deviation * white, unit
    columns |= _elements(trace, "track_force", "track_force")
    if "resistance_torque" in unit_of_signal:
        torques = _elements(trace, "resistance_torque", "wheel_torque")
        columns |= {key: (-values, unit) for key, (values, unit) in torques.items()}
    loads, forces = trace["wheelset_load"].values, (trace["adhesion"] * trace["wheelset_load"]).values
    truth = {"group_adhesion": (forces.sum(axis=1) / loads.sum(axis=1), "1")}
    for name in ("speed", "wheelset_speed", "pad_friction"):
        truth |= _elements(trace, name, name)
    return recording_of(columns, period=stop_scenario.periods.trace, truth=truth, name=stop_scenario.name)


def _elements(trace: xarray.Dataset, name: str, other: str) -> dict[str, tuple[Vector, str]]:
    samples, unit = trace[name].values, str(trace[name].attrs["units"])
    if samples.ndim == 1:
        return {other: (samples, unit)}
    return {f"{other}[{i}]": (column, unit) for i, column in enumerate(samples.T, start=1)}
