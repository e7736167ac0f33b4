"""Stops on disk, in the order of their names: results of the harness, or files that a user recorded."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray

from railgrip.errors import EstimationError
from railgrip.estimation.recorded.files import FORMATS
from railgrip.estimation.recorded.specified import taken_for
from railgrip.estimation.recording import recording_of
from railgrip.estimation.spec import Specification, parameters_for
from railgrip.formation import Formation
from railgrip.record.trace import FILE_NAME, read_trace, trace_of, write_trace
from railgrip.signals import Signal
from railgrip.studies.monitor.evidence import GROUPS, MODEL, Evidence, evidence_of

TEMPERATURE = "reading_disc_temperature"
"""Variable (time, group) of a trace that tells the temperature of the discs [K]; its first sample is used."""

UNKNOWN_TEMPERATURE = 313.15
"""What discs are taken to have at the first sample where nobody tells, as the plant does: 40 °C."""

_SIGNALS = {
    "speed": Signal("reading_speed", "train", "m/s", "read speed of the train"),
    "acceleration": Signal("reading_acceleration", "train", "m/s2", "read acceleration of the train"),
    "wheelset_speed": Signal("reading_wheelset_speed", "group", "rad/s", "read rotational speed of the wheelsets"),
    "cylinder_pressure": Signal("reading_cylinder_pressure", "group", "Pa", "read brake cylinder pressure"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """Stops of a folder.

    Attributes:
        names: Of those that gave evidence, in order.
        evidence: One each.
        sentences: What was left out, mended or assumed.
    """

    names: tuple[str, ...]
    evidence: tuple[Evidence, ...]
    sentences: tuple[str, ...]


def stops_in(
    folder: Path,
    specification: Specification | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Found:
    """Return the evidence of all stops in a folder.

    A stop is a folder with a trace.nc in it, or, with a specification that maps their columns, a recorded file. One
    that cannot be used is left out and said.

    Raises:
        EstimationError: There is no stop.
    """
    if not folder.is_dir():
        raise EstimationError(f"{folder}: there is no such folder; name one that holds stops.")
    if specification is None:
        places = sorted(path.parent for path in folder.glob(f"*/{FILE_NAME}"))
    else:
        if specification.model.class_ != MODEL:
            raise EstimationError(
                f"{specification.name}: [model] class is '{specification.model.class_}', the monitor wants '{MODEL}'."
            )
        places = sorted(path for path in folder.iterdir() if path.suffix.lower() in FORMATS)
    parameters = {} if specification is None else parameters_for(specification)
    if not places:
        what = f"*/{FILE_NAME}" if specification is None else ", ".join(f"*{suffix}" for suffix in FORMATS)
        hint = "; for recorded files give their map, --map FILE.toml" if specification is None else ""
        raise EstimationError(f"{folder}: there are no stops ({what}) in it{hint}.")
    names: list[str] = []
    evidence: list[Evidence] = []
    sentences: list[str] = []
    assumed = 0
    for number, place in enumerate(places):
        progress(number, len(places))
        try:
            temperature = np.full(GROUPS, UNKNOWN_TEMPERATURE)
            if specification is None:
                trace = read_trace(place / FILE_NAME)
                recording = recording_of_trace(trace, place.name)
                if TEMPERATURE in trace:
                    temperature = trace[TEMPERATURE].values[0]
                else:
                    assumed += 1
            else:
                taken = taken_for(specification, place)
                recording = taken.recording
                sentences += [f"{place.name}: {sentence}" for sentence in recording.attrs["flags"]]
                assumed += 1
            found = evidence_of(recording, temperature, parameters)
        except EstimationError as problem:
            sentences.append(f"{place.name}: left out: {problem}")
            continue
        names.append(place.name)
        evidence.append(found)
    if assumed:
        sentences.append(
            f"{assumed} stops do not tell the temperature of their discs; {UNKNOWN_TEMPERATURE - 273.15:.0f} °C is "
            "assumed at their beginning, 0.7 ‰ of friction a kelvin."
        )
    return Found(names=tuple(names), evidence=tuple(evidence), sentences=tuple(sentences))


def recording_of_trace(trace: xarray.Dataset, name: str) -> xarray.Dataset:
    """Return the readings of a trace as a recording.

    Raises:
        EstimationError: A reading is not in it.
    """
    signals: dict[str, tuple[np.ndarray, str]] = {}
    for what, signal in _SIGNALS.items():
        if signal.name not in trace:
            raise EstimationError(f"the trace has no {signal.name}; a stop that no sensor read tells nothing.")
        values = np.asarray(trace[signal.name].values, dtype=np.float64)
        if signal.extent == "train":
            signals[what] = values, signal.unit
        else:
            signals |= {f"{what}[{g + 1}]": (values[:, g], signal.unit) for g in range(GROUPS)}
    time = trace["time"].values
    # The last row of a trace stands where the train does, off the grid of the kept ones.
    period = float(time[1] - time[0])
    even = np.flatnonzero(np.abs(np.diff(time) - period) > 1e-6)
    kept = int(even[0]) + 1 if even.size else time.size
    return recording_of({n: (values[:kept], unit) for n, (values, unit) in signals.items()}, period=period, name=name)


def write_recording(recording: xarray.Dataset, temperature: np.ndarray, folder: Path) -> None:
    """Write a recording as a stop that `stops_in` finds: trace.nc in a folder of its name."""
    blocks: dict[Signal, np.ndarray] = {}
    for what, signal in _SIGNALS.items():
        names = [what] if signal.extent == "train" else [f"{what}[{g + 1}]" for g in range(GROUPS)]
        blocks[signal] = np.stack([recording[name].values for name in names], axis=1)
    count = recording.sizes["time"]
    discs = Signal(TEMPERATURE, "group", "K", "read temperature of the discs before the stop")
    blocks[discs] = np.tile(temperature, (count, 1))
    place = folder / str(recording.attrs["name"])
    place.mkdir(parents=True, exist_ok=True)
    write_trace(trace_of(blocks, Formation((1,) * GROUPS), float(recording.attrs["period"])), place / FILE_NAME)
