"""The results in the folder of a campaign as one value, and the compilers that made the FMUs of its stops."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from railgrip.base.errors import RecordError
from railgrip.base.files import remove
from railgrip.scenario.conditioning import Repeated
from railgrip.trace.stop import CAMPAIGN_FILE, STOP_FILE, StopRecord, read_stop


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """One stop of a campaign.

    Attributes:
        name: Of the stop.
        variants: Axis → variant.
        record: Content of stop.json.
        paper_distance: Published distance of this stop [m], if there is one.
        conditioning: Repeats with slightly changed parameters, if there are some.
    """

    name: str
    variants: Mapping[str, str]
    record: StopRecord
    paper_distance: float | None
    conditioning: Repeated | None = None

    @property
    def repeats_of_this_stop(self) -> Repeated | None:
        """Repeats, unless they are of a stop with another scenario or another distance."""
        conditioning, record = self.conditioning, self.record
        return conditioning if conditioning and conditioning.belongs(record.digest, record.braking_distance) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """A campaign with the stops that have a result.

    Attributes:
        missing: Stops without a result, or with one of another scenario.
        permitted_distance: That a stop may take [m]; None where the campaign says none.
    """

    name: str
    description: str
    stops: tuple[Result, ...]
    missing: tuple[str, ...]
    permitted_distance: float | None = None


def read_results(directory: Path) -> Results:
    """Return the results in a campaign's folder.

    Raises:
        RecordError: The folder is not that of a campaign, or a result in it is unreadable.
    """
    path = directory / CAMPAIGN_FILE
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        plan = [
            (stop["name"], stop["variants"], stop["scenario_digest"], stop["paper_distance_m"], _repeated(stop))
            for stop in content["stops"]
        ]
        name, description = str(content["name"]), str(content["description"])
        permitted = content.get("permitted_distance_m")
    except FileNotFoundError as problem:
        raise RecordError(f"{path}: there is no such file; `railgrip campaign FILE --out DIR` makes one") from problem
    except (OSError, ValueError, KeyError, TypeError) as problem:
        raise RecordError(f"{path}: is not the description of a campaign ({problem})") from problem
    results: list[Result] = []
    missing: list[str] = []
    for stop, variants, digest, paper, conditioning in plan:
        if not (directory / stop / STOP_FILE).exists():
            missing.append(stop)
            continue
        record = read_stop(directory / stop)
        if record.digest != digest:
            missing.append(stop)
            continue
        results.append(
            Result(name=stop, variants=variants, record=record, paper_distance=paper, conditioning=conditioning)
        )
    return Results(
        name=name,
        description=description,
        stops=tuple(results),
        missing=tuple(missing),
        permitted_distance=permitted,
    )


def clear_campaign(directory: Path, name: str) -> None:
    """Remove the report on earlier results of a campaign from its folder; the results themselves stay.

    Raises:
        RecordError: The folder holds another campaign or the result of a stop.
    """
    if (directory / STOP_FILE).exists():
        raise RecordError(f"{directory}: holds the result of a stop; name another folder for campaign '{name}'")
    path = directory / CAMPAIGN_FILE
    try:
        earlier = json.loads(path.read_text(encoding="utf-8"))["name"]
    except FileNotFoundError:
        return
    except (OSError, ValueError, KeyError, TypeError):
        earlier = name  # it is written anew
    if earlier != name:
        raise RecordError(f"{directory}: holds campaign '{earlier}'; name another folder for campaign '{name}'")
    figures = (f"figures/{figure.name}" for figure in (directory / "figures").glob("*.*"))
    remove(directory, "index.html", f"{name}.json", f"{name}.md", *figures)


def _repeated(stop: Mapping[str, Any]) -> Repeated | None:
    return Repeated.model_validate(stop["conditioning"]) if stop.get("conditioning") else None


OURS = "railgrip"
"""How the built-in compiler's name begins, in FMUs and results."""


def makers(versions: Mapping[str, str]) -> dict[str, str]:
    """Return FMU → tool that made it, of the versions in a result."""
    return {name: tool for name, tool in versions.items() if name.endswith(".fmu")}


def by_compiler(stops: Sequence[Result]) -> list[str]:
    """Return a sentence for each tool that made FMUs of these stops, ours or another."""
    fmus: dict[str, set[str]] = {}
    for stop in stops:
        for name, tool in makers(stop.record.versions).items():
            fmus.setdefault(tool or "an unnamed tool", set()).add(name)
    return [f"FMUs by {tool}: {', '.join(sorted(names))}." for tool, names in sorted(fmus.items())]


def from_elsewhere(stops: Sequence[Result]) -> list[str]:
    """Return a sentence for each FMU that another compiler than ours made; none when all are ours."""
    counts = Counter(pair for stop in stops for pair in makers(stop.record.versions).items())
    return [
        f"{name} was made by {tool or 'an unnamed tool'} in {count} of {len(stops)} stops."
        for (name, tool), count in sorted(counts.items())
        if not tool.startswith(OURS)
    ]


def provenance(record: StopRecord) -> dict[str, str]:
    """Return seed, digests, versions and FMUs of a result, and when it was written."""
    path = record.directory / STOP_FILE
    written = datetime.fromtimestamp(path.stat().st_mtime, UTC).strftime("%Y-%m-%d %H:%M UTC") if path.exists() else ""
    return {
        "seed": str(record.scenario["seed"]),
        "scenario digest": record.digest,
        "trace digest (SHA-256)": record.trace_digest or "samples were not kept",
        "result written": written,
        **{name: version for name, version in record.versions.items() if name not in record.fmus},
        **{
            name: f"{record.versions.get(name) or 'unnamed tool'}, SHA-256 {digest}"
            for name, digest in record.fmus.items()
        },
    }
