"""One run of one scenario: what came out, from what, and the two files that keep it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import xarray

from railgrip.errors import RecordError, Unwritten
from railgrip.files import write_json
from railgrip.scenario.schema import Scenario
from railgrip.trace.metrics import Metrics
from railgrip.trace.netcdf import FILE_NAME as TRACE_FILE
from railgrip.trace.netcdf import read_trace, write_trace
from railgrip.trace.outcome import Outcome
from railgrip.trace.recorder import thinned

STOP_FILE = "stop.json"
FILES = (STOP_FILE, TRACE_FILE)
"""What `write_stop` writes into a folder."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop:
    """One run of one scenario, from braking to its end.

    Attributes:
        scenario: What was asked.
        outcome: How it ended.
        reason: The end in one sentence, for people.
        trace: All samples, one each communication period.
        metrics: The figures taken from the trace.
        versions: Of what took part: "railgrip", "python", "casadi" …, and of each FMU the tool that made it.
        fmus: Name of each FMU → SHA-256 of its file.
        classes: controller, estimator or sensors → class, digest of its source and parameters, as JSON values, where
            it is the user's own.
        limited_demands: Decisions of a controller from outside of this project that demanded pressures beyond what
            cylinders take, and were limited.
    """

    scenario: Scenario
    outcome: Outcome
    reason: str
    trace: xarray.Dataset
    metrics: Metrics
    versions: Mapping[str, str]
    fmus: Mapping[str, str]
    classes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    limited_demands: int = 0

    def write(self, directory: Path | str) -> None:
        """Write stop.json and trace.nc into a folder; see `write_stop`."""
        write_stop(self, Path(directory))


@dataclass(frozen=True, slots=True, kw_only=True)
class StopRecord:
    """What the file of a stop says; see `Stop`.

    Attributes:
        directory: Where the files are.
        scenario: As resolved, plain values in SI units.
        digest: Of the scenario and the files it names.
    """

    directory: Path
    outcome: Outcome
    reason: str
    scenario: Mapping[str, Any]
    digest: str
    metrics: Metrics
    versions: Mapping[str, str]
    fmus: Mapping[str, str]

    @property
    def braking_distance(self) -> float | None:
        """To standstill [m]; None where the stop ended otherwise."""
        return self.metrics.distance if self.outcome is Outcome.STANDSTILL else None

    @property
    def has_trace(self) -> bool:
        """Whether the samples were kept."""
        return (self.directory / TRACE_FILE).exists()

    def trace(self) -> xarray.Dataset:
        """Return the kept samples.

        Raises:
            RecordError: The trace is missing or unreadable.
        """
        return read_trace(self.directory / TRACE_FILE)


def write_stop(stop: Stop, directory: Path, *, keep_trace: bool = True) -> None:
    """Write trace.nc, unless it is not to be kept, and then stop.json: where both are, the trace is whole.

    A trace may find no place where the figures still do: they are kept without it. The same stop gives the same
    bytes; there is no clock time in them. The trace keeps a row each
    `periods.trace`.

    Raises:
        Unwritten: The disk is full, or may not be written.
    """
    for name in FILES:
        (directory / name).unlink(missing_ok=True)
    content = {
        "outcome": stop.outcome.value,
        "reason": stop.reason,
        "distance_m": stop.metrics.distance,
        "duration_s": stop.metrics.duration,
        "doubts": list(stop.metrics.doubts()),
        "metrics": stop.metrics.to_plain(),
        "scenario": stop.scenario.resolved(),
        "scenario_digest": stop.scenario.digest(),
        "versions": dict(sorted(stop.versions.items())),
        "fmus": dict(sorted(stop.fmus.items())),
        **({"classes": stop.classes} if stop.classes else {}),
        **({"limited_demands": stop.limited_demands} if stop.limited_demands else {}),
    }
    try:
        if keep_trace:
            write_trace(thinned(stop.trace, stop.scenario.periods.every("trace")), directory / TRACE_FILE)
    except Unwritten:
        write_json(directory / STOP_FILE, content)
        raise
    write_json(directory / STOP_FILE, content)


def read_stop(directory: Path) -> StopRecord:
    """Return what the stop.json in a folder says.

    Raises:
        RecordError: Missing, or not the result of a stop.
    """
    path = directory / STOP_FILE
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return StopRecord(
            directory=directory,
            outcome=Outcome(content["outcome"]),
            reason=content["reason"],
            scenario=content["scenario"],
            digest=content["scenario_digest"],
            metrics=Metrics.from_plain(content["metrics"]),
            versions=content["versions"],
            fmus=content["fmus"],
        )
    except FileNotFoundError as problem:
        raise RecordError(f"{path}: there is no such result; `railgrip run FILE --out DIR` makes one") from problem
    except (OSError, UnicodeDecodeError) as problem:
        raise RecordError(f"{path}: cannot be read: {problem}") from problem
    except (ValueError, KeyError, TypeError) as problem:
        raise RecordError(f"{path}: is not the result of a stop of this version ({problem})") from problem
