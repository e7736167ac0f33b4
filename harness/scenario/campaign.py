"""A campaign file: scenarios, and axes of variants; every combination is a stop."""

import itertools
import json
import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field, StrictBool

from railgrip.base.errors import ScenarioError
from railgrip.base.names import did_you_mean, known_names
from railgrip.base.tables import TomlTable
from railgrip.base.units import cut, place
from railgrip.scenario.file import is_file, locate, nest, read_overrides
from railgrip.scenario.load import Tables, read_scenario, read_toml, require_kind, validate_table
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Name, Seed, Table, table_error

_AXIS_OF_SCENARIOS = "scenario"
_LONGEST_NAME = 200  # characters; file systems take 255
LARGEST: Final = 100_000
"""Limit of the combinations of a campaign, including excluded ones; and of the stops, each of which is a folder."""
DRAW = "draw"
"""The axis of `draws`: stops that differ only along it form one distribution."""

Panels = Literal["all", "abc", "none"]
"""Stops that get a page with panels, 3 MB each.

These are all that keep samples, those with adhesion-based control, or no stops.
"""


class PublishedDistance(Table):
    """A distance that another author published for some of the stops."""

    match: dict[str, str] = Field(description="axis → variant of the stops it is for; `scenario` is an axis, too")
    distance: Annotated[float, UnitRange("m", above=0)] = Field(description="braking distance")
    source: str = Field(description="who published it, and where")


class ExpectedOutcome(Table):
    """The documented outcome of some of the stops, if it is not standstill."""

    match: dict[str, str] = Field(description="axis → variant of the stops it is for; `scenario` is an axis, too")
    outcome: Outcome = Field(description="how the stop ends")


class Draws(Table):
    """The seeds `first` to `last`, inclusive, for the stops that match."""

    first: Seed = Field(description="first seed")
    last: Seed = Field(description="last seed")
    match: dict[str, str] = Field(default={}, description="axis → variant of the stops that are drawn; all without it")
    traces: StrictBool = Field(default=False, description="whether their samples are kept, some 2 MB each")

    def _check(self) -> None:
        if self.last < self.first:
            raise table_error(f"last is {self.last}, before first, {self.first}")

    def seeds(self) -> range:
        """Return all seeds."""
        return range(self.first, self.last + 1)


class CampaignFile(Table):
    """A campaign as written.

    Every combination of a scenario and one variant of each axis is a stop, except those that `exclude` matches. A
    variant has tables of a scenario, which override those of the scenario, or names a file of such tables. `sweep` is a
    short form of an axis of one key: `"start.speed" = ["80 km/h", "120 km/h"]`. With `draws` each matching combination
    is run once with each of its seeds, which override all other seeds, and tables and figures present the distribution.
    """

    name: Name = Field(description="of the campaign and of the folder of its results")
    description: str = Field(default="", description="subject, for the page")
    scenarios: Annotated[
        tuple[str, ...],
        Field(min_length=1, description="files relative to the folder of this file, or names of the package"),
    ]
    axes: dict[str, dict[str, TomlTable | str]] = Field(
        default={},
        description="axis → variant → tables, a file of them from the folder of this file, or a name of equipment",
    )
    sweep: dict[str, Annotated[tuple[Any, ...], Field(min_length=1)]] = Field(default={}, description="key → values")
    draws: Draws | None = Field(default=None, description="seeds with each of which stops are made")
    exclude: tuple[dict[str, str | tuple[str, ...]], ...] = Field(
        default=(),
        max_length=1000,
        description="axis → variant or variants; a stop that matches all of one entry is left out",
    )
    reference: tuple[PublishedDistance, ...] = Field(
        default=(), max_length=1000, description="published distances of some of the stops"
    )
    expected: tuple[ExpectedOutcome, ...] = Field(
        default=(),
        max_length=1000,
        description="outcomes of stops that do not end with a standstill; of several that match, the first",
    )
    conditioning: str | None = Field(
        default=None, description="file of repeated stops, as `make conditioning` writes, from this one's folder"
    )
    permitted_distance: Annotated[float, UnitRange("m", above=0)] | None = Field(
        default=None, description="greatest distance of a stop; the page has the share of draws that exceed it"
    )
    panels: Panels = Field(default="all", description="which stops get a page with their panels")


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedStop:
    """One stop of a campaign.

    Attributes:
        name: Name of the combination, unique in the campaign, and of the folder of its result.
        variants: Axis → variant, `scenario` first.
        scenario: Scenario to run.
        keep_trace: Whether its samples are kept in addition to its figures.
        expected: The outcome that the campaign expects; a different one is a failure.
    """

    name: str
    variants: Mapping[str, str]
    scenario: Scenario
    keep_trace: bool = True
    expected: Outcome = Outcome.STANDSTILL


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """A named set of stops, published results for some of them, and the selection of stops that get a page with panels.

    Attributes:
        conditioning: File with the changes of their distances under perturbations in the seventh digit.
        permitted_distance: Maximum permitted distance of a stop [m].
    """

    name: str
    description: str
    stops: tuple[PlannedStop, ...]
    references: tuple[PublishedDistance, ...]
    panels: Panels = "all"
    conditioning: Path | None = None
    permitted_distance: float | None = None

    def only(self, keep: Callable[[PlannedStop], bool]) -> "Campaign":
        """Return the same campaign with the stops that `keep` selects."""
        return replace(self, stops=tuple(filter(keep, self.stops)))

    def reference_for(self, stop: PlannedStop) -> PublishedDistance | None:
        """Return the first published distance for this stop, or None."""
        return next((reference for reference in self.references if _matches(reference.match, stop.variants)), None)


def load_campaign(path: Path, overrides: Sequence[str] = ()) -> Campaign:
    """Return the stops of a campaign file; overrides are applied to every scenario, last.

    Raises:
        ScenarioError: There is an error in the file, a scenario, or a combination; one sentence each.
    """
    path = locate(path, "campaigns")
    return campaign_of(read_toml(path), path, overrides)


def selection_of(campaign: Campaign, choices: Sequence[str]) -> Campaign:
    """Return a campaign with the stops of some variants.

    Args:
        campaign: The whole campaign.
        choices: Texts AXIS=VARIANT,VARIANT…, all of which a stop must satisfy; `scenario` is an axis, too.

    Raises:
        ScenarioError: A text has another form, the campaign has no such axis or variant, or no stop is left.
    """
    selected = campaign
    for choice in choices:
        axis, is_choice, names = choice.partition("=")
        if not (is_choice and names):
            raise ScenarioError(f"--only {cut(choice)}: expects AXIS=VARIANT or AXIS=VARIANT,VARIANT")
        axes = dict.fromkeys(axis for stop in campaign.stops for axis in stop.variants)
        if axis not in axes:
            raise ScenarioError(
                f"--only {cut(choice)}: the campaign {campaign.name} has no axis '{cut(axis)}'; it has "
                + known_names(axes, axis)
            )
        variants = dict.fromkeys(stop.variants[axis] for stop in campaign.stops if axis in stop.variants)
        wanted = names.split(",")
        for name in wanted:
            if name not in variants:
                raise ScenarioError(
                    f"--only {cut(choice)}: the campaign {campaign.name} has no {axis} '{cut(name)}'; it has "
                    + ", ".join(list(variants)[:20]) + did_you_mean(name, variants, before="; ")
                )  # fmt: skip
        selected = selected.only(lambda stop, axis=axis, wanted=wanted: stop.variants.get(axis) in wanted)
    if not selected.stops:
        raise ScenarioError(f"--only: no stop of the campaign {campaign.name} has all of {', '.join(choices)}")
    return selected


def campaign_of(table: Mapping[str, Any], path: Path, overrides: Sequence[str] = ()) -> Campaign:
    """Return the campaign of tables that have been read; see `load_campaign`.

    Args:
        table: Tables as read from TOML.
        path: Path of the campaign's file, which is not read.
        overrides: As for `load_campaign`.

    Raises:
        ScenarioError: See `load_campaign`.
    """
    require_kind(table, "campaign", path)
    campaign = validate_table(CampaignFile, table, directory=path.parent, origin=path.name)
    _require_countable(path, campaign)
    axes = {
        axis: {
            variant: _variant_file(path, axis, variant, tables) if isinstance(tables, str) else tables
            for variant, tables in variants.items()
        }
        for axis, variants in campaign.axes.items()
    }
    if _AXIS_OF_SCENARIOS in axes:
        raise ScenarioError(f"{path.name}: [axes] cannot be named '{_AXIS_OF_SCENARIOS}', the files are that axis")
    if DRAW in axes:
        raise ScenarioError(f"{path.name}: [axes] cannot be named '{DRAW}', [draws] is that axis")
    for key, values in campaign.sweep.items():
        axes[key] = {_spell(value): nest({key: value}) for value in values}
        if len(axes[key]) < len(values):
            raise ScenarioError(f"{path.name}: [sweep] {key} has a value twice; each value is a separate stop")
    _require_variants(path, campaign, axes)
    last = read_overrides(overrides)
    stops = _with_expected(path, campaign.expected, tuple(_stops(path, campaign, _combine(path, campaign, axes), last)))
    # Each name is a folder, and some file systems are not case-sensitive.
    _require_unique(path, [stop.name for stop in stops])
    return Campaign(
        name=campaign.name,
        description=campaign.description,
        stops=stops,
        references=campaign.reference,
        panels=campaign.panels,
        permitted_distance=campaign.permitted_distance,
        conditioning=path.parent / campaign.conditioning if campaign.conditioning else None,
    )


def _variant_file(path: Path, axis: str, variant: str, name: str) -> TomlTable:
    file = locate(name, "equipment", path.parent, f"{path.name}: [axes.{axis}] {variant}: ")
    if not is_file(file):
        raise ScenarioError(
            f"{path.name}: [axes.{axis}] {variant} names '{cut(name)}', but there is no file {place(file)}; the "
            "path starts at the folder of the campaign."
        )
    return read_toml(file)


def _require_countable(path: Path, campaign: CampaignFile) -> None:
    # Before any combination is built: the number may exceed the memory.
    counts = {
        "scenarios": len(campaign.scenarios),
        **{axis: len(variants) for axis, variants in campaign.axes.items()},
        **{key: len(values) for key, values in campaign.sweep.items()},
    }
    number = math.prod(counts.values())
    if number > LARGEST:
        product = " × ".join(f"{count} of {cut(axis)}" for axis, count in list(counts.items())[:12])
        raise _too_many(path, f"has {_count(number)} combinations ({product}{' × …' if len(counts) > 12 else ''})")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Combination:
    """A scenario with one variant of each axis.

    Attributes:
        name: Name of the stop.
        base: Tables of the scenario.
        variants: Axis → variant, `scenario` first.
        changes: Tables of the variants.
        seeds: Seeds of its stops; None for the scenario's own.
    """

    name: str
    base: Tables
    variants: Mapping[str, str]
    changes: Sequence[Mapping[str, Any]]
    seeds: range | None


def _combine(
    path: Path, campaign: CampaignFile, axes: Mapping[str, Mapping[str, Mapping[str, Any]]]
) -> list[_Combination]:
    combinations: list[_Combination] = []
    draws = campaign.draws
    for file in campaign.scenarios:
        base = read_scenario(locate(file, "scenarios", path.parent, f"{path.name}: scenarios: "))
        for combination in itertools.product(*(variants.items() for variants in axes.values())):
            choice = dict(zip(axes, (name for name, _ in combination), strict=True))
            variants = {_AXIS_OF_SCENARIOS: str(base.table["name"]), **choice}
            if any(_matches(entry, variants) for entry in campaign.exclude):
                continue
            name = "-".join(re.sub(r"[^A-Za-z0-9_.]+", "_", variant) for variant in variants.values())
            # The name is a folder: `--set name=…` may correct the scenario's name, but not this one.
            if not re.fullmatch(r"[A-Za-z0-9].*", name) or len(name) > _LONGEST_NAME:
                raise ScenarioError(
                    f"{path.name}: a stop of {base.origin} would be named '{cut(name)}'; the name of its folder must "
                    f"begin with a letter or digit and have {_LONGEST_NAME} characters at most"
                )
            seeds = draws.seeds() if draws and _matches(draws.match, variants) else None
            changes = [change for _, change in combination]
            combinations.append(_Combination(name=name, base=base, variants=variants, changes=changes, seeds=seeds))
    if not combinations:
        raise ScenarioError(f"{path.name}: [[exclude]] matches every combination, so that there is no stop; remove one")
    number = sum(each.seeds.stop - each.seeds.start if each.seeds else 1 for each in combinations)
    if number > LARGEST:
        raise _too_many(path, f"has {_count(number)} stops")
    _require_unique(path, [each.name for each in combinations])
    return combinations


def _too_many(path: Path, found: str) -> ScenarioError:
    return ScenarioError(
        f"{path.name}: {found}; a campaign may have {LARGEST:,}: remove axes, variants or draws, or divide the campaign"
    )


def _count(number: int) -> str:
    return f"{number:,}" if number < 10**9 else f"more than 10^{(number.bit_length() - 1) * 3 // 10}"


def _require_unique(path: Path, stops: Sequence[str]) -> None:
    counts = Counter(name.casefold() for name in stops)
    twice = next((name for name in stops if counts[name.casefold()] > 1), None)
    if twice is not None:
        raise ScenarioError(f"{path.name}: two stops are named '{twice}'; rename a scenario or a variant")


def _stops(
    path: Path, campaign: CampaignFile, combinations: Sequence[_Combination], last: Mapping[str, Any]
) -> Iterator[PlannedStop]:
    for each in combinations:
        tables = each.base.rename(f"{path.name}, stop {each.name} ({each.base.origin})")
        for change in (*each.changes, last):
            tables = tables.overlay(tables.origin, change)
        stop = PlannedStop(name=each.name, variants=each.variants, scenario=tables.value(Scenario))
        lot = getattr(stop.scenario.sensors, "seed", None)
        if each.seeds and lot is not None:
            raise ScenarioError(
                f"{tables.origin}: [sensors] seed is {lot}, so that all draws would have the same sensors and noise; "
                "remove it: [draws] has the seeds of rail and sensors"
            )
        yield from _draw_stops(stop, campaign.draws) if campaign.draws and each.seeds else (stop,)


def _draw_stops(stop: PlannedStop, draws: Draws) -> Iterator[PlannedStop]:
    # Only the seed changes, so the scenario is not validated again.
    for seed in draws.seeds():
        yield PlannedStop(
            name=f"{stop.name}-{seed}",
            variants={**stop.variants, DRAW: str(seed)},
            scenario=stop.scenario.model_copy(update={"seed": seed}),
            keep_trace=draws.traces,
        )


def _with_expected(
    path: Path, entries: Sequence[ExpectedOutcome], stops: tuple[PlannedStop, ...]
) -> tuple[PlannedStop, ...]:
    idle = next((entry for entry in entries if not any(_matches(entry.match, stop.variants) for stop in stops)), None)
    if idle is not None:
        raise ScenarioError(f"{path.name}: [[expected]] match {idle.match} is none of the stops; correct or remove it")
    return tuple(
        next((replace(stop, expected=entry.outcome) for entry in entries if _matches(entry.match, stop.variants)), stop)
        for stop in stops
    )


def _matches(entry: Mapping[str, str | tuple[str, ...]], variants: Mapping[str, str]) -> bool:
    return all(
        variants.get(axis) == choice if isinstance(choice, str) else variants.get(axis) in choice
        for axis, choice in entry.items()
    )


def _require_variants(path: Path, campaign: CampaignFile, axes: Mapping[str, Mapping[str, Any]]) -> None:
    matches: dict[str, Sequence[Mapping[str, str | tuple[str, ...]]]] = {
        "exclude": campaign.exclude,
        "reference": [reference.match for reference in campaign.reference],
        "expected": [
            {axis: variant for axis, variant in expected.match.items() if axis != DRAW}
            for expected in campaign.expected
        ],
        "draws": [campaign.draws.match] if campaign.draws else [],
    }
    for table, entries in matches.items():
        for axis, choice in (pair for entry in entries for pair in entry.items()):
            if axis == _AXIS_OF_SCENARIOS:
                continue
            if axis not in axes:
                raise ScenarioError(
                    f"{path.name}: [{table}] names the axis '{axis}'; there is {known_names(axes, axis)}"
                )
            for variant in (choice,) if isinstance(choice, str) else choice:
                if variant not in axes[axis]:
                    names = ", ".join(axes[axis])
                    raise ScenarioError(f"{path.name}: [{table}] names '{variant}' of axis '{axis}'; it has {names}")


def _spell(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, default=str)  # a date of TOML, as written
