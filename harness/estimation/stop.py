"""A stop of the loop as a recording: truth of its trace, read by instruments with white noise."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import xarray

from railgrip.assemble import trace_of
from railgrip.estimators.belief import Vector
from railgrip.scenario.load import load
from railgrip.scenario.quantity import Magnitude, in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.trace.recorder import thinned
from railgrip.trace.samples import evenly, recording_of


def stop_read(scenario: Scenario, name: str = "", import_from: Sequence[Path] = ()) -> xarray.Dataset:
    """Return the trace of a stop on the grid of [periods] trace, as a recording named after the scenario or otherwise.

    Classes that the scenario names are imported from the folders `import_from`.

    Raises:
        ScenarioError: It fails.
    """
    return evenly(thinned(trace_of(scenario, import_from), scenario.periods.every("trace")), name or scenario.name)


def recording_of_stop(
    scenario: str, seed: int | None, noise: Mapping[str, Magnitude], import_from: Sequence[Path] = ()
) -> xarray.Dataset:
    """Return the recording of a stop.

    Its signals are those of the plant under their names, an element of an array as `name[i]`, and `wheel_torque`, the
    known resistance of bearings and rolling, which drives a wheelset backwards. The true adhesion is that of the whole
    train, ΣF_x/ΣF_z.

    Args:
        scenario: Name or file.
        seed: Of the scenario and the noise; None for the scenario's own.
        noise: Signal → standard deviation of what is read, white from sample to sample; a signal without is not
            read. None at all leaves it to the sensors of the scenario: the trace of the stop is the recording.
        import_from: Folders of classes that the scenario names.

    Raises:
        ScenarioError: There is no such scenario, it fails, or its plant does not show what is to be read.
    """
    question = load(Path(scenario), [] if seed is None else [f"seed={seed}"])
    trace = stop_read(question, import_from=import_from)
    if not noise:
        return trace
    unit_of_signal = {
        str(name): str(trace[name].attrs.get("units", "")) for name in trace if not trace[name].isnull().any()
    }
    deviations = in_units(f"{question.name}: [source.noise]", noise, unit_of_signal)
    columns: dict[str, tuple[Vector, str]] = {}
    for name, deviation in deviations.items():
        for key, (values, unit) in _elements(trace, name, name).items():
            # A stream for each: what else is read changes no reading.
            white = generator(question.seed, f"instruments.{key}").standard_normal(values.size)
            columns[key] = values + deviation * white, unit
    columns |= _elements(trace, "track_force", "track_force")
    if "resistance_torque" in unit_of_signal:
        torques = _elements(trace, "resistance_torque", "wheel_torque")
        columns |= {key: (-values, unit) for key, (values, unit) in torques.items()}
    loads, forces = trace["wheelset_load"].values, (trace["adhesion"] * trace["wheelset_load"]).values
    truth = {"alpha": (forces.sum(axis=1) / loads.sum(axis=1), "1")}
    for name, state in (("speed", "v"), ("wheelset_speed", "w"), ("pad_friction", "mu_b")):
        truth |= _elements(trace, name, state)
    return recording_of(columns, period=question.periods.trace, truth=truth, name=question.name)


def _elements(trace: xarray.Dataset, name: str, other: str) -> dict[str, tuple[Vector, str]]:
    """Return a signal of a trace under another name, each element by itself, with its unit."""
    samples, unit = trace[name].values, str(trace[name].attrs["units"])
    if samples.ndim == 1:
        return {other: (samples, unit)}
    return {f"{other}[{i}]": (column, unit) for i, column in enumerate(samples.T, start=1)}
