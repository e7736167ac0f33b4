"""One run of one scenario: its inputs, its outcome and figures, and the two files that store it.

stop.json has digests of its content and of trace.nc, so a changed or truncated file is not accepted as a result.
"""

import glob
import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self, cast

import xarray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, create_model

from railgrip.base.arrays import Array
from railgrip.base.errors import RecordError, UnitError, WriteFailed
from railgrip.base.files import finite, path_of, write_json
from railgrip.base.records import LARGEST_TRACE, claim, discard, read_bounded, read_json, require_free, words_of
from railgrip.base.tables import JsonObject
from railgrip.base.units import to_si
from railgrip.report.reference import label
from railgrip.report.table import ReportTable
from railgrip.scenario.conditioning import RepeatedDistances
from railgrip.scenario.load import Tables
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Name, Seed, table_error
from railgrip.trace.metrics import FIGURES, Metrics
from railgrip.trace.recorder import FILE_NAME as TRACE_FILE
from railgrip.trace.recorder import read_trace, require_stop, thin, write_trace

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

STOP_FILE = "stop.json"
FILES = (STOP_FILE, TRACE_FILE)
"""What `write_stop` writes into a folder."""
PAGE_FILES = ("index.html", "stop.png", "stop.svg", "stop.pdf")
"""Files that `railgrip report` adds."""
CAMPAIGN_FILE = "campaign.json"
"""In the folder of a campaign, next to the folders of its stops."""

_DIGEST = "sha256"
_TRACE_DIGEST = "trace_sha256"


_OPTIONAL = ("classes", "dependencies", "limited_demands", "fmu_warnings", "remarks", "cars")
"""Attributes of a stop that its file has unless they are empty."""

Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


Car = Annotated[tuple[FiniteFloat, FiniteFloat], Field(strict=False)]
"""Front and rear of a car behind the leading wheelset [m]."""


class Stored(BaseModel):
    """A table of a result file: no value is converted to another type, and keys that reports do not use are kept."""

    model_config = ConfigDict(strict=True, frozen=True, extra="allow", allow_inf_nan=False)


def _table(base: type[Stored] = Stored, **keys: Any) -> Any:
    """Return a table that has further keys: each is a type, or a type and the value of a missing one."""
    fields = {name: key if isinstance(key, tuple) else (key, ...) for name, key in keys.items()}
    return create_model("StoredTable", __base__=base, **cast("Any", fields))


def _ratios(parameters: JsonObject) -> JsonObject:
    """Check the slips of slip-based control, which its name in tables contains."""
    for name in ("low", "high"):
        value = parameters.get(name, 0.0)
        try:
            is_ratio = isinstance(to_si(value, "1") if isinstance(value, str) else value, int | float)
        except UnitError:
            is_ratio = False
        if not is_ratio:
            raise table_error(f"{name} is not a ratio")
    return parameters


_KIND = _table(kind=str)
_CURVE = _table(name=str)
_PATCH = _table(mu0=(list[FiniteFloat], []), polach=(_CURVE | None, None))
_ADHESION = _table(
    _KIND,
    polach=_CURVE,
    polach_of_wheelset=(list[_CURVE], []),  # pyrefly: ignore[invalid-annotation]
    patch=(list[_PATCH], []),  # pyrefly: ignore[invalid-annotation]
    calibrated=(dict[str, FiniteFloat], {}),
)
_CONSTANT = _table(_ADHESION, mu0=list[FiniteFloat])
_CONTROLLER = _table(_KIND, tuning=(str, "paper"), parameters=(JsonObject, {}))
_SLIP_CONTROLLER = _table(_CONTROLLER, parameters=(Annotated[JsonObject, AfterValidator(_ratios)], {}))
_SCENARIO = _table(
    name=Name,
    description=(str, ""),
    seed=Seed,
    vehicle=_table(train=(str | None, None), model=(str | None, None), plant=(str | None, None)),
    start=_table(speed=Annotated[FiniteFloat, Field(ge=0, le=1e6)]),
    adhesion=_ADHESION,
    sensors=_KIND,
    actuation=_KIND,
    estimator=_table(_KIND, model=(str, "")),
    controller=_CONTROLLER,
    limits=_table(alpha_max=FiniteFloat),
)
"""The keys of a resolved scenario that reports use."""


def _check_scenario(table: JsonObject) -> None:
    """Check a resolved scenario, and its tables whose keys depend on their kind."""
    scenario = _SCENARIO.model_validate(table)
    if scenario.adhesion.kind == "constant":
        _CONSTANT.model_validate(table["adhesion"])
    if scenario.controller.kind.startswith("slip_"):
        _SLIP_CONTROLLER.model_validate(table["controller"])


class StoredStop(Stored):
    """The keys of stop.json."""

    outcome: str
    reason: str
    scenario: JsonObject
    scenario_digest: Digest
    metrics: JsonObject
    versions: dict[str, str]
    fmus: dict[str, str]
    classes: dict[str, JsonObject] = {}
    dependencies: dict[str, str] = {}
    fmu_warnings: dict[str, dict[str, int]] = {}
    remarks: Annotated[tuple[str, ...], Field(strict=False)] = ()
    cars: Annotated[tuple[Car, ...], Field(strict=False)] = ()
    trace_sha256: Digest | None
    sha256: Digest


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Stop:
    """One run of one scenario: `.outcome`, `.reason`, `.metrics`, `.trace` (xarray).

    `.to_pandas()` returns the samples, `.write(folder)` writes the stop to files, `.plot()` draws it.

    Attributes:
        name: Name of the scenario, or of the stop in its campaign.
        inputs: The scenario as resolved, plain values in SI units.
        digest: Digest of the scenario and the files it names.
        outcome: How it ended.
        reason: The end in one sentence, for people.
        metrics: The figures taken from the trace.
        versions: Versions of what took part: "railgrip", "python", "casadi" …, and of each FMU the tool that made it.
        fmus: Name of each FMU → SHA-256 of its file.
        classes: controller, estimator or sensors → class, digest of its source and parameters, as JSON values, where
            it is the user's own.
        dependencies: Files and packages that these classes consist of or read; see `railgrip.simulate.user_files`.
        limited_demands: Number of decisions of a controller from outside of this project that demanded pressures beyond
            what cylinders take, and were limited.
        fmu_warnings: Name of each FMU that warned → kind of message → number. Messages that differ only in numbers
            are of one kind.
        remarks: Sentences on valid but unusual values of the scenario and the files it names.
        cars: Both ends of each car behind the leading wheelset [m]; empty unless the train is from a train file.
        directory: Folder of its files; None for a stop that was not read from files.
        trace_digest: SHA-256 of the file of the trace; None where the samples were not kept.
        variants: Axis of the campaign → variant.
        paper_distance: Published distance of this stop [m], or None.
        conditioning: Repeats with slightly changed parameters, or None.
        parsed: The scenario; None until it is asked for.
        samples: The trace in memory, with all samples, one each communication period; None if it is in the file.
    """

    name: str
    inputs: Mapping[str, Any]
    digest: str
    outcome: Outcome
    reason: str
    metrics: Metrics
    versions: Mapping[str, str]
    fmus: Mapping[str, str]
    classes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    dependencies: Mapping[str, str] = field(default_factory=dict[str, str])
    limited_demands: int = 0
    fmu_warnings: Mapping[str, Mapping[str, int]] = field(default_factory=dict[str, Mapping[str, int]])
    remarks: tuple[str, ...] = ()
    cars: tuple[tuple[float, float], ...] = ()
    directory: Path | None = None
    trace_digest: str | None = None
    variants: Mapping[str, str] = field(default_factory=dict[str, str])
    paper_distance: float | None = None
    conditioning: RepeatedDistances | None = None
    parsed: Scenario | None = None
    samples: xarray.Dataset | None = None

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        trace: xarray.Dataset,
        *,
        outcome: Outcome,
        reason: str,
        metrics: Metrics,
        versions: Mapping[str, str],
        fmus: Mapping[str, str],
    ) -> Self:
        """Return the stop of a run of a scenario, with all samples, one each communication period."""
        return cls(
            name=scenario.name,
            inputs=scenario.resolved(),
            digest=scenario.digest(),
            outcome=outcome,
            reason=reason,
            metrics=metrics,
            versions=versions,
            fmus=fmus,
            parsed=scenario,
            samples=trace,
        )

    @property
    def scenario(self) -> Scenario:
        """The scenario.

        Raises:
            ScenarioError: A file that the scenario of a stored stop names is missing.
        """
        if self.parsed is not None:
            return self.parsed
        return Tables.of(dict(self.inputs), self._folder, str(self._folder)).value(Scenario)

    @property
    def trace(self) -> xarray.Dataset:
        """The samples, which are read from the file on each access if they are not in memory.

        Raises:
            RecordError: The file is missing, was changed, is unreadable or does not contain the trace of a stop.
        """
        if self.samples is not None:
            return self.samples
        path = self._folder / TRACE_FILE
        trace = read_trace(path, self._content_of_trace())
        require_stop(path, trace, groups=len(self.metrics.longest_lock))
        return trace

    @property
    def stored_trace(self) -> xarray.Dataset:
        """The samples that a file has: one each `periods.trace`."""
        if self.samples is None:
            return self.trace
        return thin(self.samples, int(self.scenario.periods.steps_of("trace")))

    @property
    def has_trace(self) -> bool:
        """Whether the samples were kept."""
        return self.samples is not None or (self._folder / TRACE_FILE).exists()

    @property
    def braking_distance(self) -> float | None:
        """Distance to standstill [m]; None where the stop ended otherwise."""
        return self.metrics.distance if self.outcome is Outcome.STANDSTILL else None

    @property
    def figures(self) -> Metrics:
        """The metrics without air used if actuation is ideal: pressures then change without valves."""
        return replace(self.metrics, air_used=nan) if self.inputs["actuation"]["kind"] == "ideal" else self.metrics

    @property
    def title(self) -> str:
        """Name of the scenario, for a random rail with its seed, since it is one draw of many."""
        name = self.inputs["name"].replace("_", " ")
        return f"{name}, seed {self.inputs['seed']}" if self.inputs["adhesion"]["kind"] == "random" else name

    @property
    def distance_text(self) -> str:
        """Braking distance for readers; the distance travelled if the train did not stop."""
        if self.braking_distance is None:
            return f"no standstill: {self.metrics.distance_travelled:.1f} m travelled"
        return f"{self.braking_distance:.1f} m"

    @property
    def heading(self) -> str:
        """Title of its figure: scenario, controller, equipment, distance and consistency of the estimates."""
        inputs, metrics = self.inputs, self.metrics
        utilisation = (
            f", {100 * metrics.utilisation:.1f} % of the possible adhesion used"
            if isfinite(metrics.utilisation)
            else ""
        )
        consistency = "" if metrics.nis_ratio is None else f"; median NIS {metrics.nis_ratio:.2g} of the expected one"
        return (
            f"{self.title}: {label(inputs)}, actuation {inputs['actuation']['kind']}, "
            f"sensors {inputs['sensors']['kind']}; {self.distance_text} in "
            f"{metrics.duration:.1f} s{utilisation}{consistency}"
        )

    def warning_sentences(self) -> Iterator[str]:
        """Yield each kind of warning of the FMUs once, with its number."""
        for name, messages in self.fmu_warnings.items():
            for message, count in messages.items():
                yield f"{name} warned {count:,} time{'s' if count > 1 else ''}: {message.rstrip('.')}."

    @property
    def own_repeats(self) -> RepeatedDistances | None:
        """Repeats, unless they belong to another scenario or another distance."""
        repeats = self.conditioning
        return repeats if repeats and repeats.belongs(self.digest, self.braking_distance) else None

    def __repr__(self) -> str:
        inputs, metrics, start = self.inputs, self.metrics, 3.6 * self.inputs["start"]["speed"]
        kinds = [
            f"{name} {self.classes.get(name, {}).get('class', inputs[name]['kind'])}"
            for name in ("controller", "estimator", "sensors")
        ]
        samples = (
            "samples in its file"
            if self.samples is None
            else f"{self.samples.sizes['time']} samples of {len(self.samples.data_vars)} signals"
        )
        used = f"{used}, " if (used := metrics.use_of_adhesion()) else ""
        lines = (
            f"Stop of {inputs['name']}, seed {inputs['seed']}: {self.outcome.value}, {self.reason}",
            f"  {metrics.distance_travelled:.2f} m in {metrics.duration:.2f} s from {start:.1f} km/h, "
            f"mean deceleration {metrics.mean_deceleration:.3f} m/s2",
            f"  {used}longest lock {max(metrics.longest_lock):.2f} s",
            f"  {', '.join(kinds)}, actuation {inputs['actuation']['kind']}; {', '.join(self.fmus) or 'no FMU'}",
            f"  {samples}; scenario {self.digest[:8]}",
            *(f"  {sentence}" for sentence in (*self.remarks, *self.warning_sentences())),
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
            "scenario_digest": self.digest,
            "versions": json.dumps(dict(sorted(self.versions.items()))),
            "fmus": json.dumps(dict(sorted(digests.items()))),
        }

    def write(self, directory: Path | str) -> None:
        """Write stop.json and trace.nc into a folder; see `write_stop`."""
        folder = path_of(directory, "directory")
        require_no_campaign(folder)
        write_stop(self, folder)

    def plot(self) -> "Figure":
        """Return a figure (matplotlib) with a column for each group: speed, slip, adhesion, friction and pressure."""
        from railgrip.report.figures import signals_figure  # matplotlib takes half a second to load

        return signals_figure(self.stored_trace, self.metrics, self.heading)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the samples over time [s]; `slip[2]` is the slip of the second group.

        Values are in SI units, which `attrs["units"]` has by column.
        """
        import pandas

        columns: dict[str, Array] = {}
        units: dict[str, str] = {}
        for name, variable in self.trace.data_vars.items():
            if variable.dims[:1] != ("time",):
                continue
            values = variable.values.reshape(variable.sizes["time"], -1)
            for number, column in enumerate(values.T, start=1):
                label = f"{name}[{number}]" if variable.ndim > 1 else str(name)
                columns[label] = column
                units[label] = variable.attrs.get("units", "1")
        frame = pandas.DataFrame(columns, index=pandas.Index(self.trace["time"].values, name="time"))
        frame.attrs["units"] = {"time": "s", **units}
        return frame

    def _repr_html_(self) -> str:
        figures = metrics_table(self.figures)
        return f"<pre>{self!r}</pre><details><summary>Figures</summary>{figures.__html__()}</details>"

    def require_unchanged_trace(self) -> None:
        """Check that trace.nc is the file that was written with stop.json.

        Raises:
            RecordError: It is missing, was changed or is not whole.
        """
        self._content_of_trace()

    def _content_of_trace(self) -> bytes:
        path = self._folder / TRACE_FILE
        try:
            content = read_bounded(self._folder, TRACE_FILE, LARGEST_TRACE)
        except FileNotFoundError as problem:
            raise RecordError(f"{path}: there is no such trace; a stop writes it next to its stop.json") from problem
        if hashlib.sha256(content).hexdigest() != self.trace_digest:
            raise RecordError(f"{path}: is not the file that was written with its stop.json; run the stop again")
        return content

    @property
    def _folder(self) -> Path:
        return self.directory or Path()


def require_no_campaign(directory: Path) -> None:
    """Refuse a folder inside that of a campaign, whose page would go on to show the stop that was there.

    Raises:
        RecordError: It is one.
    """
    parent = directory.absolute().parent
    if (parent / CAMPAIGN_FILE).exists():
        raise RecordError(f"{directory}: belongs to the campaign in {parent}; name another folder for a single stop")


def require_no_result(directory: Path) -> None:
    """Refuse the folder of a stop or campaign, whose page would be lost.

    Raises:
        RecordError: It is one.
    """
    if any((directory / name).exists() for name in (STOP_FILE, CAMPAIGN_FILE)):
        raise RecordError(f"{directory}: holds a result with its own page; name another folder")


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

    An earlier result in the folder is replaced, and its page is removed afterwards. If the disk is full,
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
        "scenario": stop.inputs,
        "scenario_digest": stop.digest,
        "versions": dict(sorted(stop.versions.items())),
        "fmus": dict(sorted(stop.fmus.items())),
        **{name: value for name in _OPTIONAL if (value := getattr(stop, name))},
        _TRACE_DIGEST: None,
    }
    path = directory / TRACE_FILE
    try:
        if keep_trace:
            write_trace(stop.stored_trace, path, stop.attributes())
            content[_TRACE_DIGEST] = hashlib.sha256(path.read_bytes()).hexdigest()
    except WriteFailed:
        _write_content(content, directory)
        raise
    _write_content(content, directory)


def _write_content(content: Mapping[str, Any], directory: Path) -> None:
    write_json(directory / STOP_FILE, {**content, _DIGEST: _digest(content)})
    discard(directory, PAGE_FILES if content[_TRACE_DIGEST] else (TRACE_FILE, *PAGE_FILES))


def _digest(content: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the content of stop.json, independent of its white space."""
    return hashlib.sha256(json.dumps(finite(content), sort_keys=True).encode()).hexdigest()


def others_like(directory: Path) -> str:
    """Return a clause that names results next to an empty folder: runs with its name and a digest."""
    others = sorted(path.parent for path in directory.parent.glob(f"{glob.escape(directory.name)}-*/{STOP_FILE}"))
    more = f" and {len(others) - 3} more" if len(others) > 3 else ""
    return f"; there is {', '.join(map(str, others[:3]))}{more}" if others else ""


def is_campaign(directory: Path) -> bool:
    """Return whether a folder is that of a campaign; if not, it is that of a stop.

    Raises:
        RecordError: It is neither.
    """
    if (directory / CAMPAIGN_FILE).exists() or (directory / STOP_FILE).exists():
        return (directory / CAMPAIGN_FILE).exists()
    like = others_like(directory) or "; name the folder of a run, of a stop in a campaign, or of a campaign"
    raise RecordError(f"{directory}: has neither {CAMPAIGN_FILE} nor {STOP_FILE}{like}")


def read_stop(directory: Path) -> Stop:
    """Return the content of the stop.json in a folder.

    Raises:
        RecordError: Missing, not the result of a stop, or changed since it was written.
    """
    path = directory / STOP_FILE
    try:
        content = read_json(directory, STOP_FILE)
        stored = StoredStop.model_validate(content)
        _check_scenario(stored.scenario)
        stop = Stop(
            name=stored.scenario["name"],
            inputs=stored.scenario,
            directory=directory,
            outcome=Outcome(stored.outcome),
            reason=stored.reason,
            digest=stored.scenario_digest,
            metrics=Metrics.from_plain(stored.metrics),
            versions=stored.versions,
            fmus=stored.fmus,
            trace_digest=stored.trace_sha256,
            **{name: getattr(stored, name) for name in _OPTIONAL if name in StoredStop.model_fields},
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
    return stop


def metrics_table(metrics: Metrics) -> ReportTable:
    """Return the figures of a stop with units and definitions."""
    rows = [
        (name.replace("_", " "), value_text(getattr(metrics, name)), figure.unit, figure.meaning)
        for name, figure in FIGURES.items()
    ]
    return ReportTable.of(("figure", "value", "unit", "meaning"), rows, left=4)


def value_text(value: object, digits: int = 4) -> str:
    """Return a number, or comma-separated numbers, with some digits; a dash for None and NaN."""
    if isinstance(value, tuple):
        texts = [value_text(part, digits) for part in value]
        return ", ".join(f"({t})" if isinstance(part, tuple) else t for part, t in zip(value, texts, strict=True))
    if value is None or (isinstance(value, float) and isnan(value)):
        return "–"
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)
