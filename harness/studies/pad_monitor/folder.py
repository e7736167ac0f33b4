"""Stops on disk, in the order of their names: results of the harness, or files that a user recorded."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from railgrip.base.errors import EstimationError
from railgrip.base.records import inside
from railgrip.estimation.agreement import require_agreement
from railgrip.estimation.sources import complete_trace, recording_for
from railgrip.estimation.spec import Specification, parameters_for
from railgrip.recording.files import FORMATS
from railgrip.recording.samples import evenly
from railgrip.studies.pad_monitor.evidence import MODEL, Evidence, evidence_of, formation
from railgrip.trace.netcdf import FILE_NAME, read_trace

TEMPERATURE = "reading_disc_temperature"
"""Variable (time, group) of a trace with the temperature of the discs [K]; its first sample is used."""

UNKNOWN_TEMPERATURE = 313.15
"""Assumed temperature of the discs at the first sample where it is not given, as in the plant: 40 °C."""


def stops_in(
    folder: Path,
    specification: Specification | None = None,
    progress: Callable[[int, int], None] = lambda count, of: None,
) -> tuple[dict[str, Evidence], list[str]]:
    """Return the evidence of all stops in a folder, by name and in order, and remarks on omissions, corrections and
    assumptions.

    A stop is a folder with a trace.nc in it, or, with a specification that maps their columns, a recorded file. Stops
    that cannot be used are omitted with a remark.

    Raises:
        EstimationError: The folder has no stops.
    """
    if not folder.is_dir():
        raise EstimationError(f"{folder}: there is no such folder; name one that holds stops.")
    if specification is None:
        places = sorted(path.parent for path in folder.glob(f"*/{FILE_NAME}"))
    else:
        if specification.model.class_ != MODEL:
            raise EstimationError(
                f"{specification.name}: [model] class is '{specification.model.class_}', the monitor needs '{MODEL}'."
            )
        places = sorted(path for path in folder.iterdir() if path.suffix.lower() in FORMATS)
    parameters = {} if specification is None else parameters_for(specification)
    if not places:
        what = f"*/{FILE_NAME}" if specification is None else ", ".join(f"*{suffix}" for suffix in FORMATS)
        hint = "; for recorded files give their map, --map FILE.toml" if specification is None else ""
        raise EstimationError(f"{folder}: there are no stops ({what}) in it{hint}.")
    evidence: dict[str, Evidence] = {}
    sentences: list[str] = []
    assumptions = 0
    for number, place in enumerate(places):
        progress(number, len(places))
        try:
            temperature = np.full(formation().groups, UNKNOWN_TEMPERATURE)
            if specification is None:
                trace = read_trace(inside(folder, f"{place.name}/{FILE_NAME}"))
                recording = evenly(trace, place.name)
                if TEMPERATURE in trace:
                    temperature = trace[TEMPERATURE].values[0]
                else:
                    assumptions += 1
            else:
                recording = recording_for(specification, place).recording
                sentences += [f"{place.name}: {sentence}" for sentence in recording.attrs["flags"]]
                run = complete_trace(specification, recording)
                sentences += require_agreement(specification, run, run, place.name)
                assumptions += 1
            evidence[place.name] = evidence_of(recording, temperature, parameters)
        except EstimationError as problem:
            sentences.append(f"{place.name}: left out: {problem}")
    if assumptions:
        sentences.append(
            f"{assumptions} stops do not have the temperature of their discs; {UNKNOWN_TEMPERATURE - 273.15:.0f} °C is "
            "assumed at their beginning, 0.7 ‰ of friction a kelvin."
        )
    return evidence, sentences
