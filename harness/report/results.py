"""Read the results in the folder of a campaign as one value, and the compilers of their FMUs."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from pydantic import Field, FiniteFloat, ValidationError, field_validator

from railgrip.base.errors import RecordError
from railgrip.base.groups import gather
from railgrip.base.records import inside, read_json, words_of
from railgrip.report.stop import CAMPAIGN_FILE, STOP_FILE, Digest, Stop, Stored, read_stop
from railgrip.scenario.campaign import DRAW
from railgrip.scenario.conditioning import RepeatedDistances
from railgrip.scenario.table import Name, table_error


class StoredPlan(Stored):
    """A stop in campaign.json."""

    name: Annotated[Name, Field(max_length=255)]
    variants: dict[str, str]
    scenario_digest: Digest
    paper_distance_m: Annotated[FiniteFloat, Field(gt=0)] | None = None
    conditioning: Annotated[RepeatedDistances, Field(strict=False)] | None = None

    @field_validator("variants")
    @classmethod
    def _number_of_draw(cls, variants: dict[str, str]) -> dict[str, str]:
        if not re.fullmatch("[0-9]{1,19}", variants.get(DRAW, "0")):
            raise table_error(f"{DRAW} is not a number")
        return variants


class StoredCampaign(Stored):
    """The content of campaign.json."""

    name: Name
    description: str
    permitted_distance_m: Annotated[FiniteFloat, Field(gt=0)] | None = None
    published: tuple[str, ...] = Field(default=(), strict=False)
    stops: list[StoredPlan]

    @field_validator("stops")
    @classmethod
    def _of_one_campaign(cls, stops: list[StoredPlan]) -> list[StoredPlan]:
        if len({stop.name for stop in stops}) < len(stops):
            raise table_error("two stops have the same name")
        if len({frozenset(stop.variants.keys() - {DRAW}) for stop in stops}) > 1:
            raise table_error("stops have variants of different axes")
        return stops


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """A campaign with the stops that have a result.

    Attributes:
        missing: Stops without a result, or with one of another scenario.
        permitted_distance: Maximum permitted distance of a stop [m], or None.
        published: Sources of the published distances.
    """

    name: str
    description: str
    stops: tuple[Stop, ...]
    missing: tuple[str, ...]
    permitted_distance: float | None = None
    published: tuple[str, ...] = ()


def read_results(directory: Path) -> Results:
    """Return the results in a campaign's folder.

    Raises:
        RecordError: The folder is not that of a campaign, or a result in it is unreadable.
    """
    path = directory / CAMPAIGN_FILE
    try:
        campaign = read_campaign(directory)
    except FileNotFoundError as problem:
        raise RecordError(f"{path}: there is no such file; `railgrip campaign FILE --out DIR` makes one") from problem
    results: list[Stop] = []
    missing: list[str] = []
    for planned in campaign.stops:
        folder = inside(directory, planned.name)
        stop = read_stop(folder) if (folder / STOP_FILE).exists() else None
        if stop is None or stop.digest != planned.scenario_digest:
            missing.append(planned.name)
            continue
        results.append(
            replace(
                stop,
                name=planned.name,
                variants=planned.variants,
                paper_distance=planned.paper_distance_m,
                conditioning=planned.conditioning,
            )
        )
    return Results(
        name=campaign.name,
        description=campaign.description,
        stops=tuple(results),
        missing=tuple(missing),
        permitted_distance=campaign.permitted_distance_m,
        published=campaign.published,
    )


def read_campaign(directory: Path) -> StoredCampaign:
    """Return the content of the campaign.json in a folder.

    Raises:
        FileNotFoundError: The file does not exist.
        RecordError: The file is not the description of a campaign.
    """
    try:
        return StoredCampaign.model_validate(read_json(directory, CAMPAIGN_FILE))
    except ValidationError as problem:
        path = directory / CAMPAIGN_FILE
        raise RecordError(f"{path}: is not the description of a campaign ({words_of(problem)})") from problem


def require_campaign(directory: Path, name: str) -> None:
    """Check that a folder, which need not exist, may hold the results of a campaign.

    Raises:
        RecordError: The folder holds another campaign or the result of a stop.
    """
    if (directory / STOP_FILE).exists():
        raise RecordError(f"{directory}: holds the result of a stop; name another folder for campaign '{name}'")
    try:
        earlier = read_campaign(directory).name
    except FileNotFoundError:
        return
    if earlier != name:
        raise RecordError(f"{directory}: holds campaign '{earlier}'; name another folder for campaign '{name}'")


OURS = "railgrip"
"""Prefix of the built-in compiler's name in FMUs and results."""
_MOST_REMARKS = 20
"""Number of remarks that a page of a campaign lists."""


def fmu_tools(versions: Mapping[str, str]) -> dict[str, str]:
    """Return FMU → tool that made it, from the versions in a result."""
    return {name: tool for name, tool in versions.items() if name.endswith(".fmu")}


def by_compiler(stops: Sequence[Stop]) -> list[str]:
    """Return a sentence for each tool, built-in or not, that made FMUs of these stops."""
    made = {pair for stop in stops for pair in fmu_tools(stop.versions).items()}
    fmus = gather((tool or "an unnamed tool", name) for name, tool in sorted(made))
    return [f"FMUs by {tool}: {', '.join(names)}." for tool, names in sorted(fmus.items())]


def from_elsewhere(stops: Sequence[Stop]) -> list[str]:
    """Return a sentence for each FMU that the built-in compiler did not make."""
    counts = Counter(pair for stop in stops for pair in fmu_tools(stop.versions).items())
    return [
        f"{name} was made by {tool or 'an unnamed tool'} in {count} of {len(stops)} stops."
        for (name, tool), count in sorted(counts.items())
        if not tool.startswith(OURS)
    ]


def remarks_on(stops: Sequence[Stop]) -> list[str]:
    """Return each remark and each warning of an FMU once, with the number of stops that it belongs to."""
    counts = Counter(
        sentence for stop in stops for sentence in dict.fromkeys((*stop.remarks, *stop.warning_sentences()))
    )
    sentences = [
        f"{sentence} (In {count} of {len(stops)} stops.)" if len(stops) > 1 else sentence
        for sentence, count in counts.items()
    ]
    hidden = len(sentences) - _MOST_REMARKS
    return [
        *sentences[:_MOST_REMARKS],
        *([f"There are {hidden} further remarks; each stop has its own."] * (hidden > 0)),
    ]


def provenance(stop: Stop) -> dict[str, str]:
    """Return seed, digests, versions and FMUs of a result, and its date."""
    written = ""
    if stop.directory is not None and (path := stop.directory / STOP_FILE).exists():
        written = datetime.fromtimestamp(path.stat().st_mtime, UTC).strftime("%Y-%m-%d %H:%M UTC")
    return {
        "seed": str(stop.inputs["seed"]),
        "scenario digest": stop.digest,
        "trace digest (SHA-256)": stop.trace_digest or "samples were not kept",
        "result written": written,
        **{name: version for name, version in stop.versions.items() if name not in stop.fmus},
        **{
            name: f"{stop.versions.get(name) or 'unnamed tool'}, SHA-256 {digest}" for name, digest in stop.fmus.items()
        },
    }
