"""The line ahead of a train: permitted speed, gradients, stretches of low adhesion, and targets."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.quantity import UnitRange, quantities
from railgrip.scenario.table import Length, Name, Speed, Table, table_error
from railgrip.scenario.track import Gradient
from railgrip.supervision.national import StepSpeed


class LowAdhesion(Table):
    """A stretch for which trackside reports reduced adhesion."""

    begin: Length = Field(description="location at which it begins")
    end: Length = Field(description="location at which it ends")

    def _check(self) -> None:
        if self.end <= self.begin:
            raise table_error(f"end {self.end:g} m is not behind begin {self.begin:g} m")


class Target(Table):
    """A target: a location, and the speed to which the train must slow down before it (§3.13.8)."""

    kind: Literal["EoA", "SvL", "LoA", "MRSP"] = Field(
        description="end of authority, supervised location, limit of authority, start of a lower permitted speed"
    )
    at: Length = Field(description="location")
    speed: StepSpeed = Field(default=0.0, description="target speed of LoA and MRSP")

    def _check(self) -> None:
        if (self.kind in ("EoA", "SvL")) != (self.speed == 0):
            raise table_error(
                f"a target of kind {self.kind} has speed {3.6 * self.speed:g} km/h; EoA and "
                f"SvL have 0, LoA and MRSP more"
            )

    @property
    def name(self) -> str:
        """Kind, with location and speed where several targets may have it."""
        return self.kind if self.speed == 0 else f"{self.kind} {3.6 * self.speed:g} km/h at {self.at:g} m"


class Line(Table):
    """A line in the direction of travel; level and with normal adhesion where nothing else is given."""

    name: Name = Field(default="level", description="name of the line in figures and messages")
    speed: Speed | None = Field(default=None, description="permitted speed; that of the train unless given")
    gradient: tuple[Gradient, ...] = Field(default=(), description="gradients; level before the first")
    low_adhesion: tuple[LowAdhesion, ...] = Field(
        default=(), description="stretches of reported low adhesion, in order"
    )
    target: tuple[Target, ...] = Field(min_length=1, description="targets, in any order")
    release: Literal["none", "national", "calculated", "given"] = Field(
        default="none", description="origin of the release speed: V_NVREL, calculated on board, or release_speed"
    )
    release_speed: Annotated[float, UnitRange("m/s", above=0, at_most=40)] | None = Field(
        default=None, description='release speed, with release = "given"'
    )
    balise: Length | None = Field(
        default=None, description="location of the last balise group before the EoA, for a calculated release speed"
    )

    def _check(self) -> None:
        begins = [gradient.begin for gradient in self.gradient]
        if begins != sorted(set(begins)):
            raise table_error(f"gradient must begin at rising locations, got {begins}")
        stretches = [place for stretch in self.low_adhesion for place in (stretch.begin, stretch.end)]
        if stretches != sorted(stretches):
            raise table_error(f"low_adhesion must be in order and not overlap, got {stretches}")
        for kind in ("EoA", "SvL"):
            if sum(target.kind == kind for target in self.target) > 1:
                raise table_error(f"target: there is one {kind} at most; leave out the others")
        eoa, svl = self.one("EoA"), self.one("SvL")
        if eoa is not None and svl is not None and svl.at < eoa.at:
            raise table_error(f"target: the SvL at {svl.at:g} m is in front of the EoA at {eoa.at:g} m")
        if self.release != "none" and (eoa is None or svl is None):
            raise table_error("release needs a target of kind EoA and one of kind SvL")
        if (self.release == "given") != (self.release_speed is not None):
            raise table_error('release = "given" and release_speed need each other')
        if self.release == "calculated" and (self.balise is None or eoa is None or self.balise > eoa.at):
            raise table_error('release = "calculated" needs balise, the last balise group, before the EoA')
        for target in self.target:
            if self.speed is not None and target.speed >= self.speed:
                raise table_error(
                    f"target: {target.name} is not below the permitted speed of {3.6 * self.speed:g} km/h"
                )

    def only(self, kind: str) -> Target:
        """Return the target of kind EoA or SvL of a line with a release speed, which has one of each."""
        return next(target for target in self.target if target.kind == kind)

    def one(self, kind: str) -> Target | None:
        """Return the target of a kind that occurs once; None without it."""
        return next((target for target in self.target if target.kind == kind), None)


def load_line(path: Path | None) -> Line:
    """Return the line of a file; without one, a level line with EoA and SvL at 0 m.

    Raises:
        ScenarioError: The file cannot be read or is wrong; one sentence for each problem, with file and key.
    """
    if path is None:
        return Line(target=(Target(kind="EoA", at=0.0), Target(kind="SvL", at=0.0)))
    return validate_table(Line, {"name": path.stem} | read_toml(path), directory=path.parent, origin=path.name)


def doubts_of(table: Table, fastest: float) -> Iterator[str]:
    """Yield the unusual values of a file, and the speeds in it above the maximum speed of the train [m/s]."""
    for key, span, value in quantities(table):
        if words := span.doubt(value):
            yield f"{key} {words}"
        elif span.unit == "m/s" and value > fastest * (1 + 1e-9):  # rounding of km/h
            yield (
                f"{key} is {3.6 * value:g} km/h ({value:g} m/s), above the maximum speed of the train, "
                f"{3.6 * fastest:g} km/h; a number without a unit is in m/s"
            )
