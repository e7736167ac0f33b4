"""One run of one scenario: its outcome and figures, its inputs, and the two files that store it.

stop.json has digests of its content and of trace.nc, so a changed or truncated file is not accepted as a result.
"""

import glob
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import nan
from pathlib import Path
from typing import Any

import xarray
from pydantic import ValidationError

from railgrip.base.errors import RecordError, WriteFailed
from railgrip.base.files import finite, write_json
from railgrip.base.outputs import claim, discard, require_free
from railgrip.base.records import LARGEST_TRACE, read_bounded, read_json, words_of
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.trace.metrics import Metrics
from railgrip.trace.netcdf import FILE_NAME as TRACE_FILE
from railgrip.trace.netcdf import read_trace, write_trace
from railgrip.trace.recorder import require_stop, thin
from railgrip.trace.stored import StoredScenario, StoredStop

STOP_FILE = "stop.json"
FILES = (STOP_FILE, TRACE_FILE)
"""What `write_stop` writes into a folder."""
PAGE_FILES = ("index.html", "stop.png", "stop.svg", "stop.pdf")
"""Files that `railgrip report` adds."""
CAMPAIGN_FILE = "campaign.json"
"""In the folder of a campaign, next to the folders of its stops."""

_DIGEST = "sha256"
_TRACE_DIGEST = "trace_sha256"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop:
    """One run of one scenario, from braking to its end.

    Attributes:
        scenario: The question.
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

    def __repr__(self) -> str:
        """Return a summary in five lines."""
        scenario, metrics, start = self.scenario, self.metrics, 3.6 * self.scenario.start.speed
        parts = {"controller": scenario.controller, "estimator": scenario.estimator, "sensors": scenario.sensors}
        kinds = [f"{name} {self.classes.get(name, {}).get('class', part.kind)}" for name, part in parts.items()]
        used = f"{used}, " if (used := metrics.use_of_adhesion()) else ""
        lines = (
            f"Stop of {scenario.name}, seed {scenario.seed}: {self.outcome.value}, {self.reason}",
            f"  {metrics.distance_travelled:.2f} m in {metrics.duration:.2f} s from {start:.1f} km/h, "
            f"mean deceleration {metrics.mean_deceleration:.3f} m/s2",
            f"  {used}longest lock {max(metrics.longest_lock):.2f} s",
            f"  {', '.join(kinds)}, actuation {scenario.actuation.kind}; {', '.join(self.fmus) or 'no FMU'}",
            f"  {self.trace.sizes['time']} samples of {len(self.trace.data_vars)} signals; scenario "
            f"{scenario.digest()[:8]}",
        )
        return "\n".join(lines)

    def attributes(self) -> dict[str, str | int]:
        """Return the attributes of trace.nc, under CF names where CF defines one.

        They contain no date: the same scenario gives the same bytes.
        """
        scenario = self.scenario
        parts = {name: getattr(scenario, name).kind for name in ("controller", "estimator", "sensors", "actuation")}
        digests = {name: f"{self.versions.get(name, '')}, SHA-256 {digest}" for name, digest in self.fmus.items()}
        return {
            "title": f"Stop of {scenario.name}, seed {scenario.seed}: {self.outcome.value}",
            "source": f"railgrip {self.versions.get('railgrip', '')}, simulated",
            "comment": f"{scenario.description}. {self.reason}",
            "question": f"braking from {scenario.start.speed:.6g} m/s with "
            + ", ".join(f"{name} {kind}" for name, kind in parts.items()),
            "outcome": self.outcome.value,
            "seed": scenario.seed,
            "scenario_digest": scenario.digest(),
            "versions": json.dumps(dict(sorted(self.versions.items()))),
            "fmus": json.dumps(dict(sorted(digests.items()))),
        }

    def record(self, directory: Path = Path()) -> "StopRecord":
        """Return the content of the file of the stop, without the samples; no file is read."""
        return StopRecord(
            directory=directory,
            outcome=self.outcome,
            reason=self.reason,
            scenario=self.scenario.resolved(),
            digest=self.scenario.digest(),
            metrics=self.metrics,
            versions=self.versions,
            fmus=self.fmus,
            classes=self.classes,
        )

    def write(self, directory: Path | str) -> None:
        """Write stop.json and trace.nc into a folder; see `write_stop`."""
        require_no_campaign(Path(directory))
        write_stop(self, Path(directory))


@dataclass(frozen=True, slots=True, kw_only=True)
class StopRecord:
    """What the file of a stop says; see `Stop`.

    Attributes:
        directory: Where the files are.
        scenario: As resolved, plain values in SI units.
        digest: Of the scenario and the files it names.
        classes: See `Stop`.
        trace_digest: SHA-256 of the trace's file; None where the samples were not kept.
    """

    directory: Path
    outcome: Outcome
    reason: str
    scenario: Mapping[str, Any]
    digest: str
    metrics: Metrics
    versions: Mapping[str, str]
    fmus: Mapping[str, str]
    classes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    trace_digest: str | None = None

    @property
    def braking_distance(self) -> float | None:
        """To standstill [m]; None where the stop ended otherwise."""
        return self.metrics.distance if self.outcome is Outcome.STANDSTILL else None

    @property
    def figures(self) -> Metrics:
        """The metrics without air used if actuation is ideal: pressures then change without valves."""
        is_ideal = self.scenario["actuation"]["kind"] == "ideal"
        return replace(self.metrics, air_used=nan) if is_ideal else self.metrics

    @property
    def has_trace(self) -> bool:
        """Whether the samples were kept."""
        return (self.directory / TRACE_FILE).exists()

    def require_unchanged_trace(self) -> None:
        """Check that trace.nc is the file that was written with stop.json.

        Raises:
            RecordError: It is missing, was changed or is not whole.
        """
        self._content_of_trace()

    def trace(self) -> xarray.Dataset:
        """Return the kept samples.

        Raises:
            RecordError: The trace is missing, was changed, is unreadable or is not that of a stop.
        """
        path = self.directory / TRACE_FILE
        trace = read_trace(path, self._content_of_trace())
        require_stop(path, trace, groups=len(self.metrics.longest_lock))
        return trace

    def _content_of_trace(self) -> bytes:
        path = self.directory / TRACE_FILE
        try:
            content = read_bounded(self.directory, TRACE_FILE, LARGEST_TRACE)
        except FileNotFoundError as problem:
            raise RecordError(f"{path}: there is no such trace; a stop writes it next to its stop.json") from problem
        if hashlib.sha256(content).hexdigest() != self.trace_digest:
            raise RecordError(f"{path}: is not the file that was written with its stop.json; run the stop again")
        return content


def require_no_campaign(directory: Path) -> None:
    """Refuse a folder inside that of a campaign, whose page would go on to show the stop that was there.

    Raises:
        RecordError: It is one.
    """
    parent = directory.absolute().parent
    if (parent / CAMPAIGN_FILE).exists():
        raise RecordError(
            f"{directory}: belongs to the campaign in {parent}; name another folder for a stop of its own"
        )


def require_no_result(directory: Path) -> None:
    """Refuse the folder of a stop or campaign, whose page would be lost.

    Raises:
        RecordError: It is one.
    """
    if any((directory / name).exists() for name in (STOP_FILE, CAMPAIGN_FILE)):
        raise RecordError(f"{directory}: holds a result with a page of its own; name another folder")


def require_place(directory: Path) -> None:
    """Check that the result of a stop may be written into a folder, which need not exist.

    Raises:
        RecordError: The folder is that of a campaign, whose report would show another result, or files of the user are
            in the way.
    """
    if (directory / CAMPAIGN_FILE).exists():
        raise RecordError(f"{directory}: holds the results of a campaign; name another folder for those of a stop")
    require_free(directory, *FILES)


def discard_stop(directory: Path) -> None:
    """Remove the result of a stop from its folder, and the page that was made of it; files of the user stay."""
    discard(directory, (*FILES, *PAGE_FILES))


def write_stop(stop: Stop, directory: Path, *, keep_trace: bool = True) -> None:
    """Write trace.nc, if it is to be kept, and then stop.json: if both exist, the trace is complete.

    An earlier result in the folder is replaced, and its page is removed afterwards. If there is no room for the trace,
    the figures are kept without it. The same stop gives the same bytes, without clock times. The trace has one row per
    `periods.trace`.

    Raises:
        RecordError: The folder is that of a campaign, or files of the user are in the way.
        WriteFailed: The disk is full, or may not be written.
    """
    require_place(directory)
    claim(directory, *FILES)
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
        _TRACE_DIGEST: None,
    }
    path = directory / TRACE_FILE
    try:
        if keep_trace:
            write_trace(thin(stop.trace, int(stop.scenario.periods.every("trace"))), path, stop.attributes())
            content[_TRACE_DIGEST] = hashlib.sha256(path.read_bytes()).hexdigest()
    except WriteFailed:
        _write_content(content, directory)
        raise
    _write_content(content, directory)


def _write_content(content: Mapping[str, Any], directory: Path) -> None:
    write_json(directory / STOP_FILE, {**content, _DIGEST: _digest(content)})
    discard(directory, PAGE_FILES if content[_TRACE_DIGEST] else (TRACE_FILE, *PAGE_FILES))


def _digest(content: Mapping[str, Any]) -> str:
    """Return the SHA-256 of what stop.json says, whatever the spaces in it."""
    return hashlib.sha256(json.dumps(finite(content), sort_keys=True).encode()).hexdigest()


def others_like(directory: Path) -> str:
    """Return a clause that names results next to an empty folder: runs with its name and a digest."""
    beside = sorted(path.parent for path in directory.parent.glob(f"{glob.escape(directory.name)}-*/{STOP_FILE}"))
    more = f" and {len(beside) - 3} more" if len(beside) > 3 else ""
    return f"; there is {', '.join(map(str, beside[:3]))}{more}" if beside else ""


def read_stop(directory: Path) -> StopRecord:
    """Return the content of the stop.json in a folder.

    Raises:
        RecordError: Missing, not the result of a stop, or changed since it was written.
    """
    path = directory / STOP_FILE
    try:
        content = read_json(directory, STOP_FILE)
        stored = StoredStop.model_validate(content)
        StoredScenario.check(stored.scenario)
        record = StopRecord(
            directory=directory,
            outcome=Outcome(stored.outcome),
            reason=stored.reason,
            scenario=stored.scenario,
            digest=stored.scenario_digest,
            metrics=Metrics.from_plain(stored.metrics),
            versions=stored.versions,
            fmus=stored.fmus,
            classes=stored.classes,
            trace_digest=stored.trace_sha256,
        )
    except FileNotFoundError as problem:
        like = others_like(directory) or "; `railgrip run FILE --out DIR` makes one"
        raise RecordError(f"{path}: there is no such result{like}") from problem
    except ValidationError as problem:
        raise RecordError(f"{path}: is not the result of a stop of this version ({words_of(problem)})") from problem
    except RecordError:
        raise
    except ValueError as problem:
        raise RecordError(f"{path}: is not the result of a stop of this version ({problem})") from problem
    if content.pop(_DIGEST) != _digest(content):
        raise RecordError(f"{path}: was changed after the stop had written it; run the stop again")
    return record
