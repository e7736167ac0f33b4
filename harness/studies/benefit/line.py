"""The line of `study benefit`: its rails with their probabilities, its signalling, and measures of the user."""

from collections.abc import Iterator, Mapping
from math import isclose, isfinite
from pathlib import Path
from typing import Annotated, cast

from pydantic import Field, StrictBool

from railgrip.base.errors import InputError
from railgrip.base.names import did_you_mean
from railgrip.base.registry import ANALYSES, names
from railgrip.base.tables import TomlTable
from railgrip.base.units import short
from railgrip.scenario.file import OtherFileString, is_file
from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import Name, Table, table_error
from railgrip.supervision.headway import SignallingLayout
from railgrip.supervision.national import NationalValues

LIBRARY = Path(__file__).parent / "library"

_OF_ALL = ("name", "seed", "vehicle", "start", "limits")
"""Keys of a scenario that are the same in all stops on a rail, so that these can be compared."""

_Share = Annotated[float, UnitRange("1", above=0, at_most=1)]
_Level = Annotated[float, UnitRange("1", above=0, at_most=10)]


class Measure(Table):
    """What is added to a train: tables of its stops, and of its train file."""

    description: str = Field(min_length=3, description="what is added, in a line")
    source: str = Field(min_length=3, description="publication of the numbers, or that they are estimates")
    scenario: TomlTable = Field(default={}, description="tables laid over each stop, as in a scenario file")
    bogie: TomlTable = Field(
        default={}, description="keys of every bogie; bogies that have them lose them without the measure"
    )
    train: TomlTable = Field(default={}, description="tables of the train file, unless the train has its own")

    def _check(self) -> None:
        adhesion = self.scenario.get("adhesion", {})
        if not isinstance(adhesion, Mapping):
            raise table_error(f"scenario.adhesion is {short(adhesion)}, but a table is expected, as in a scenario file")
        for name in ("scenario", "bogie", "train"):
            if odd := next(_odd_values(name, getattr(self, name)), None):
                raise table_error(f"{odd} is neither a text, a finite number, true nor false")
        taken = [key for key in self.scenario if key in _OF_ALL]
        taken += ["adhesion.level"] if "level" in adhesion else []
        if taken:
            raise table_error(f"scenario has {', '.join(taken)}, which is the same with and without a measure; omit it")


def _odd_values(key: str, entry: object) -> Iterator[str]:
    """Yield the keys of dates, times, infinities and NaN, which no quantity of a file is."""
    if isinstance(entry, Mapping | list):
        table = cast("Mapping[str, object]", entry if isinstance(entry, Mapping) else dict(enumerate(entry, start=1)))
        for name, value in table.items():
            yield from _odd_values(f"{key}.{name}", value)
    elif not isinstance(entry, str | int | float) or (isinstance(entry, float) and not isfinite(entry)):
        yield key


class SeasonalRail(Table):
    """The rail of a part of the year, and its share of all stops."""

    season: str = Field(min_length=1, description="part of the year")
    weather: str = Field(min_length=1, description="weather or contamination")
    probability: _Share = Field(description="share of the stops of a year; all rails together have 1")
    dry: StrictBool = Field(default=False, description="whether K_wet leaves the rail out, as dry")
    level: tuple[_Level, _Level] = Field(
        default=(1.0, 1.0), description="factor on its friction in a stop, uniform between two values"
    )
    adhesion: TomlTable = Field(description="table [adhesion] of a scenario file, of any kind")
    source: str = Field(min_length=3, description="publication of the numbers, or that they are estimates")

    @property
    def name(self) -> str:
        """Season and weather."""
        return f"{self.season}, {self.weather}"


class LineOfStudy(SignallingLayout):
    """A line in the direction of travel."""

    name: Name = Field(description="name of the line; that of its file unless given")
    rail: tuple[SeasonalRail, ...] = Field(min_length=1, max_length=50, description="rails of the line")
    cover: _Share = Field(
        default=0.95, description="share of all stops that M_NVAVADH has to cover, where national leaves it out"
    )
    national: NationalValues = Field(default=NationalValues(), description="national values, as in their file")
    measure: dict[Name, Measure] = Field(default={}, description="further measures, by name")

    def _check(self) -> None:
        total = sum(rail.probability for rail in self.rail)
        if not isclose(total, 1.0, abs_tol=1e-6):
            raise table_error(f"rail: the probabilities add up to {total:g}; they must add up to 1")
        if all(rail.dry for rail in self.rail):
            raise table_error("rail: all rails are dry; K_wet needs at least one that is not")
        for rail in self.rail:
            if rail.level[0] > rail.level[1]:
                raise table_error(f"rail: level of {rail.name} falls from {rail.level[0]:g} to {rail.level[1]:g}")
            if "level" in rail.adhesion:
                raise table_error(f"rail: adhesion of {rail.name} has a level; give [[rail]] level instead")
        labels = [rail.name for rail in self.rail]
        if len(set(labels)) < len(labels):
            raise table_error("rail: two rails have the same season and weather")


def load_study_line(entry: Path) -> LineOfStudy:
    """Return the line of a file, or of this package by its name.

    Raises:
        ScenarioError: The file cannot be read or is wrong; one sentence for each problem, with file and key.
    """
    ours = {path.stem.removeprefix("line_"): path for path in LIBRARY.glob("line_*.toml")}
    path = entry if is_file(entry) else ours.get(str(entry), entry)
    if path is entry and not entry.suffix and not is_file(entry):
        raise InputError(f"there is no line '{entry}'; there is {', '.join(sorted(ours))}, or give the path of a file")
    # Paths in it are relative to its folder, and not to that of the train, where stops are put together.
    table = {"name": path.stem.removeprefix("line_")} | OtherFileString.within(read_toml(path), path.parent)
    return validate_table(LineOfStudy, table, directory=path.parent, origin=path.name)


def measures_of(text: str, line: LineOfStudy) -> dict[str, Measure]:
    """Return measures by their names, separated by commas: of the line, of this package, or a control law.

    Raises:
        InputError: A name is unknown or given twice, or two measures change the same table.
    """
    shipped = read_toml(LIBRARY / "measures.toml")
    laws = [law for law in names("controllers") if law not in ("fmu", *ANALYSES)]
    known = sorted({*line.measure, *shipped}) + laws
    found: dict[str, Measure] = {}
    for name in filter(None, (part.strip() for part in text.split(","))):
        if name in found:
            raise InputError(f"--measures: '{name}' is given twice")
        if name in line.measure:
            found[name] = line.measure[name]
        elif name in shipped:
            found[name] = validate_table(Measure, shipped[name], directory=LIBRARY, origin=f"measures.toml [{name}]")
        elif name in laws:
            found[name] = _law(name)
        else:
            raise InputError(
                f"--measures: there is no measure '{name}'; there is {', '.join(known)}{did_you_mean(name, known)}"
            )
    if not found:
        raise InputError(f"--measures names no measure; there is {', '.join(known)}")
    changed = [(name, key) for name, measure in found.items() for key in _changes(measure)]
    for number, (name, key) in enumerate(changed):
        for other, same in changed[:number]:
            if same == key:
                raise InputError(f"--measures: '{other}' and '{name}' both change {key}; ask for one at a time")
    return found


def _law(name: str) -> Measure:
    return Measure(
        description=f"control law {name} with the estimator of the train",
        source="railgrip",
        scenario={
            "controller": {"kind": name},
            "estimator": {"kind": "decentralised", "noise": "service"},
            "periods": {"estimator": 10e-3},
        },
    )


def _changes(measure: Measure) -> set[str]:
    tables = {"[estimator]": "[controller]"}  # an estimator belongs to its law
    inner: TomlTable = measure.scenario.get("adhesion", {})
    keys = {f"[{key}]" for key in measure.scenario if key != "adhesion"} | {f"[adhesion] {key}" for key in inner}
    return {tables.get(key, key) for key in keys - {"[periods]"}} | {f"[bogies] {key}" for key in measure.bogie}
