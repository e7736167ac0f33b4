"""What decides the runs of the field test, as a TOML file; `library/field.toml` is the one of Schwarz et al."""

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from railgrip.errors import EstimationError
from railgrip.scenario.load import read_toml, validated
from railgrip.scenario.quantity import Unit
from railgrip.scenario.table import Duration, Friction, Length, Mass, Name, Parameters, Seed, Speed, Table
from railgrip.scenario.track import CurveLaw
from railgrip.scenario.valves import ValveStep
from railgrip.track.geodesy import Place
from railgrip.track.laid import Element, LaidTrack, course_of, grades_of
from railgrip.twins.load import LIBRARY

Slope = Annotated[float, Unit("1", above=-0.2, below=0.2)]
Metres = Annotated[float, Unit("m")]
Deviation = Annotated[float, Unit("m", at_least=0)]


class TrackTable(Table):
    """[track]: where it lies and how it was laid, in the direction "fw"."""

    latitude: Annotated[float, Field(ge=-89.0, le=89.0)]
    longitude: Annotated[float, Field(ge=-180.0, le=180.0)]
    height: Metres
    middle: Length
    heading: Annotated[float, Unit("rad")]
    course: list[tuple[Length, Metres]]
    slope: Slope
    grades: list[tuple[Length, Slope, Length]]
    curve_law: CurveLaw

    def laid(self) -> LaidTrack:
        """Return the track.

        Raises:
            EstimationError: Roundings overlap.
        """
        elements = tuple(Element(length=long, curvature=1.0 / end if end else 0.0) for long, end in self.course)
        try:
            slope = grades_of(self.slope, tuple(self.grades))
        except ValueError as problem:
            raise EstimationError(f"[track] grades: {problem}.") from problem
        return LaidTrack(
            origin=Place(latitude=self.latitude, longitude=self.longitude, height=self.height),
            middle=self.middle,
            length=math.fsum(element.length for element in elements),
            heading=self.heading,
            curvature=course_of(elements),
            slope=slope,
        )


class TrainTable(Table):
    """[train]: the plant's parameters where they differ, its drive and its driver."""

    mass: Mass
    traction: Annotated[float, Unit("N", above=0)]
    power: Annotated[float, Unit("W", above=0)]
    traction_rate: Annotated[float, Unit("N/s", above=0)]
    margin: Speed
    first_drive: Duration
    second_drive: Duration
    fill_time: dict[Literal["FSB", "EB"], Duration]
    parameters: Parameters = Field(default_factory=dict)


class SurfaceTable(Table):
    """[surface]: what lies on the rail."""

    k_A: Annotated[float, Unit("1", above=0, at_most=1)]  # noqa: N815 - Polach's name, as in the plant
    k_S: Annotated[float, Unit("1", above=0, at_most=1)]  # noqa: N815
    A_falling: Annotated[float, Unit("1", at_least=0, at_most=1)]
    B_falling: Annotated[float, Unit("s/m", at_least=0)]
    mu0: Friction


class SensorTable(Table):
    """[sensors]: standard deviations; the wander of GNSS is a Gauss–Markov process, the rest is white or constant."""

    wheelset_speed: Annotated[float, Unit("rad/s", at_least=0)]
    speed: Annotated[float, Unit("m/s", at_least=0)]
    speed_scale: Annotated[float, Unit("1", at_least=0)]
    acceleration: Annotated[float, Unit("m/s**2", at_least=0)]
    acceleration_bias: Annotated[float, Unit("m/s**2", at_least=0)]
    pressure: Annotated[float, Unit("Pa", at_least=0)]
    gnss_every: Duration
    gnss_horizontal: Deviation
    gnss_height: Deviation
    gnss_horizontal_wander: Deviation
    gnss_height_wander: Deviation
    gnss_wander_time: Duration


class Patch(Table):
    """A slippery place for the first bogie, `after` the place where braking began."""

    after: Length
    length: Length
    mu0: Friction
    cleaned: Friction
    edge: Length


class Case(Table):
    """[cases.NAME]: one braking; `start` is the distance on the track where the train starts from rest."""

    speed: Speed
    direction: Literal["fw", "bw"]
    brake: Literal["FSB", "EB"]
    start: Length
    patch: Patch | None = None


class FieldScenario(Table):
    """Everything that decides the runs of a field test."""

    name: Name
    description: str = ""
    seed: Seed
    period: Duration
    step: ValveStep
    track: TrackTable
    train: TrainTable
    surface: SurfaceTable
    sensors: SensorTable
    cases: dict[str, Case]

    def case(self, name: str) -> Case:
        """Return a case by its name.

        Raises:
            EstimationError: There is none.
        """
        if name not in self.cases:
            raise EstimationError(f"{self.name}: there is no case '{name}'; there is {', '.join(self.cases)}.")
        return self.cases[name]


def field_scenario(path: Path | None = None) -> FieldScenario:
    """Return the scenario of a file, that of the library when None.

    Raises:
        ScenarioError: The file is missing or not a field test; each problem in one sentence.
    """
    chosen = path or LIBRARY / "field.toml"
    return validated(FieldScenario, read_toml(chosen), directory=chosen.parent, origin=chosen.name)


def field_case(name: str) -> tuple[FieldScenario, str]:
    """Return field test and case of a name: `c6` of the library's, or `mine.toml:c6`.

    Raises:
        ScenarioError: The file is missing or not a field test.
        EstimationError: There is no such case.
    """
    file, colon, case = name.rpartition(":")
    scenario = field_scenario(Path(file) if colon else None)
    scenario.case(case)
    return scenario, case
