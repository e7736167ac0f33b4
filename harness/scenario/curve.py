"""Read users' curves and lines from files.

A curve is a CSV file with one axis, and one column of a quantity or one for each wheelset or group. A line is a CSV
file with chainages and slopes or heights, or a GPX track.
"""

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal
from xml.parsers import expat

import numpy as np

from railgrip.base.arrays import Array
from railgrip.base.errors import InputError
from railgrip.base.files import read_text
from railgrip.base.units import conversion, unit

Direction = Literal["rising", "falling"]
"""Of chainages in the direction of travel."""

_HEADER: Final = re.compile(r"\s*(.*?)\s*(?:\[(.*)\]|\((.*)\))?\s*")
"""Name of a column, and its unit in brackets if it has one."""
_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")
_LARGEST: Final = 64 << 20  # bytes; a point every 0.1 m over 100 km takes a third of it
_BEGINS_EARLY: Final = 0.1
"""Share of the shortest possible stop; a curve that ends earlier probably has another unit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TabulatedQuantity:
    """A quantity over a rising axis, in SI units; linear between points, constant beyond.

    Attributes:
        axis: Name of the axis, such as time.
        unit: SI unit of the axis.
        has_unit: Whether the file states the unit of the axis.
        points: Points of the axis, rising, shape (n,), n ≥ 2.
        values: Values of the quantity, shape (n, 1) for all, or (n, columns).
        direction: Of the axis in the file, which is that of chainages in the direction of travel.
    """

    axis: str
    unit: str
    has_unit: bool
    points: Array
    values: Array
    direction: Direction = "rising"

    def doubt(self, shortest: float, longest: float) -> str:
        """Return the reason to doubt the unit of the axis, in words that follow the name of the file, or ''.

        Args:
            shortest: Time [s] or distance [m] of the shortest possible stop.
            longest: Time or distance of the longest one.
        """
        first, last, name = self.points[1], self.points[-1], self.unit
        if self.has_unit:
            return ""
        if last < _BEGINS_EARLY * shortest:
            fact = f"ends at {last:g} {name}, but the stop takes {shortest:.3g} {name} or more"
            other = {"m": "km", "s": "min"}[name]
        elif first > longest:
            fact = f"has its second point at {first:g} {name}, but the stop ends before {longest:.3g} {name}"
            other = {"m": "mm", "s": "ms"}[name]
        else:
            return ""
        return f"{fact}; if the column has another unit, state it in the first line, such as '{self.axis} [{other}]'"


def read_curve(path: Path, origin: float | None = None) -> TabulatedQuantity:
    """Read the columns time or distance, and mu0 or mu0_1 … mu0_n; without a unit in s, m and 1.

    Args:
        path: Path of the file.
        origin: Chainage at which the leading wheelset is at the brake demand [m], if the distances are chainages; in
            the order of the rows they rise or fall.

    Raises:
        ValueError: The file is wrong; the message has the line, but not the file's name.
    """
    columns = read_columns(
        path, axes={"time": "s", "distance": "m"}, name="mu0", si="1", span=(0.0, 1.0), above=True, example="%",
        if_falling="chainages that fall in the direction of travel need the key origin" if origin is None else None,
    )  # fmt: skip
    if origin is not None:
        if columns.axis == "time":
            raise ValueError("has a column time, and origin is a place on the rail; leave origin out")
        columns = replace(columns, points=along(columns.points, origin), direction=direction_of(columns.points))
    return columns


def direction_of(chainages: Array) -> Direction:
    """Return the direction of chainages in the direction of travel, from their order."""
    return "rising" if chainages[-1] > chainages[0] else "falling"


def along(chainages: Array, origin: float) -> Array:
    """Return the distances of a train [m], rising, at chainages in its direction of travel, rising or falling."""
    return chainages - origin if direction_of(chainages) == "rising" else origin - chainages


def read_columns(
    path: Path,
    *,
    axes: Mapping[str, str],
    name: str,
    si: str,
    span: tuple[float, float],
    above: bool = False,
    if_falling: str | None = "",
    example: str,
) -> TabulatedQuantity:
    """Read a quantity over a rising axis.

    A column may state its unit, as `distance [km]` or `pressure (psi)`; without one it is in SI units.

    Args:
        path: Path of a CSV file whose first line names its columns.
        axes: Name → SI unit of the possible axes; the file has one of them.
        name: Name of the quantity: one column, or name_1 … name_n.
        si: SI unit of the quantity.
        span: Minimum and maximum of the values in it.
        above: Whether the minimum is excluded.
        if_falling: Remedy for an axis that falls throughout, if there is one; None if it may fall.
        example: Another unit of the quantity, for a message.

    Raises:
        ValueError: The file is wrong; the message has the line, but not the file's name.
    """
    try:
        lines = read_text(path, _LARGEST).splitlines()
        head = next((line for line in lines if line.strip()), "")
        separator = next((mark for mark in ";\t" if mark in head), ",")
        numbered = enumerate(csv.reader(lines, delimiter=separator), start=1)
        rows = [(line, row) for line, row in numbered if any(cell.strip() for cell in row)]
    except (InputError, csv.Error) as problem:
        raise ValueError(f"is not a table of text, as csv files are ({problem})") from problem
    if not rows:
        raise ValueError(f"is empty; the first line names the columns, such as time,{name}")
    cells = [_HEADER.fullmatch(cell) for cell in rows[0][1]]
    header = [cell[1] if cell else "" for cell in cells]
    stated = [(cell[2] or cell[3] or "").strip() if cell else "" for cell in cells]
    each = [f"{name}_{number}" for number in range(1, len(header))]
    reserved_names = {*axes, name, *each}
    axes_in_header = [axis for axis in axes if axis in header]
    columns = next((expected for expected in ([name], each) if set(header) == {*axes_in_header, *expected}), None)
    if len(axes_in_header) != 1 or columns is None or len(header) != 1 + len(columns):
        expected = " or ".join(f"{axis} [{unit_of_axis}]" for axis, unit_of_axis in axes.items())
        raise ValueError(
            f"has {len(header)} columns; its first line must name {expected}, and {name} for all or {name}_1, "
            f"{name}_2 … for each, with a unit in brackets unless it is in SI units; names of these: "
            f"{', '.join(sorted({*header} & reserved_names)) or 'none'}"
        )
    if len(rows) < 3:
        raise ValueError(f"has {len(rows) - 1} rows of numbers; a curve takes two or more")
    axis = axes_in_header[0]
    values = _numbers(rows[1:] if separator == "," else _with_points(rows[1:]), len(header))
    for place, (column, text) in enumerate(zip(header, stated, strict=True)):
        if text:
            try:
                gain, shift = conversion(unit(text), unit(axes[axis] if column == axis else si))
            except ValueError as problem:
                raise ValueError(f"column {column}: {problem}") from problem
            values[:, place] = gain * values[:, place] + shift
    points = values[:, header.index(axis)]
    quantity = values[:, [header.index(column) for column in columns]]
    steps = np.diff(points)
    falls = axis == "distance" and bool(np.all(steps < 0))
    if not (np.all(steps > 0) or (falls and if_falling is None)):
        line = rows[1:][int(np.argmin(steps > 0)) + 1][0]
        raise ValueError(f"line {line}: {axis} does not rise" + (f"; {if_falling}" if falls and if_falling else ""))
    least, most = span
    inside = np.all(((quantity > least) if above else (quantity >= least)) & (quantity <= most), axis=1)
    if not np.all(inside):
        line = rows[1:][int(np.argmin(inside))][0]
        suffix = "" if si == "1" else f" {si}"
        raise ValueError(
            f"line {line}: {name} must be {'above' if above else 'at least'} {least:g} and at most {most:g}{suffix}; "
            f"a column in another unit states it in the first line, such as '{name} [{example}]'"
        )
    return TabulatedQuantity(
        axis=axis, unit=axes[axis], has_unit=bool(stated[header.index(axis)]), points=points, values=quantity
    )


def _with_points(rows: Sequence[tuple[int, list[str]]]) -> list[tuple[int, list[str]]]:
    """Return rows with decimal points in place of commas, unless these may separate thousands."""
    commas = [(line, cell.strip()) for line, row in rows for cell in row if "," in cell]
    if commas and all(_THOUSANDS.fullmatch(cell) for _, cell in commas):
        raise ValueError(
            f"line {commas[0][0]}: the comma may be a decimal sign or separate thousands; write decimal points, and no "
            "separators of thousands"
        )
    return [(line, [cell.replace(",", ".") for cell in row]) for line, row in rows]


def _numbers(rows: Sequence[tuple[int, list[str]]], count: int) -> Array:
    try:
        values = np.array([row for _, row in rows], dtype=np.float64)
        if (
            values.shape[1:] == (count,)
            and np.isfinite(values).all()
            and not any("_" in cell for _, row in rows for cell in row)  # Python reads "50_000" as a number
        ):
            return values
    except ValueError:  # a cell is not a number, or rows differ in length
        pass
    if len(rows) > 1:
        for row in rows:
            _numbers([row], count)  # raises the error of the first wrong one
    # The content is not repeated: in a scenario from elsewhere the path may point to a private file.
    raise ValueError(f"line {rows[0][0]}: {count} finite numbers are expected")


_SORT = (
    "sort the rows by rising chainage, since a slope holds from its row to the next, and give direction = 'falling' "
    "for a train that runs to lower chainages"
)
_CLOSEST = 1.0
"""Distance [m] below which two points of a GPX track are one: receivers repeat their position at rest."""


@dataclass(frozen=True, slots=True)
class LineProfile:
    """Slopes of a line, constant between chainages.

    Attributes:
        chainages: Ends of the sections, rising, shape (k + 1,) [m].
        slopes: Tangent of the gradient of each section, positive where the line rises with the chainage, shape (k,).
    """

    chainages: Array
    slopes: Array


def read_line(path: Path, steepest: float) -> LineProfile:
    """Read a line from a file.

    A CSV file has the columns distance and slope: distances rise, each slope holds up to the next one, and the last row
    ends the line. Or it has distance and height, with distances that rise or fall. A GPX track has its chainage from
    its first point, over the ellipsoid; its points are connected by straight grades.

    Args:
        path: Path of the file; GPX if it ends so, else CSV.
        steepest: Maximum magnitude of a slope.

    Raises:
        ValueError: The file is wrong; the message has the line or the point, but not the file's name.
    """
    if path.suffix.casefold() == ".gpx":
        lines, chainages, heights = _gpx_points(path)
        return _between(chainages, heights, [f"line {line}" for line in lines], steepest)
    name = "height" if "height" in read_text(path, _LARGEST).partition("\n")[0] else "slope"
    span = (-steepest, steepest) if name == "slope" else (-500.0, 6000.0)
    table = read_columns(
        path, axes={"distance": "m"}, name=name, si="1" if name == "slope" else "m", span=span,
        if_falling=None if name == "height" else _SORT, example="permille" if name == "slope" else "ft",
    )  # fmt: skip
    if table.values.shape[1] != 1:
        raise ValueError(f"has several columns of {name}; a line has one")
    values = table.values[:, 0]
    if name == "height":
        is_rising = bool(table.points[-1] > table.points[0])
        places = [f"row {number}" for number in range(1, len(values) + 1)]
        order = slice(None) if is_rising else slice(None, None, -1)
        return _between(table.points[order], values[order], places[order], steepest)
    return LineProfile(table.points, values[:-1])


def _between(chainages: Array, heights: Array, places: list[str], steepest: float) -> LineProfile:
    slopes = np.diff(heights) / np.diff(chainages)
    wrong = np.flatnonzero(np.abs(slopes) > steepest)
    if len(wrong):
        first = int(wrong[0])
        raise ValueError(
            f"{places[first + 1]}: the height changes by {heights[first + 1] - heights[first]:.4g} m over "
            f"{chainages[first + 1] - chainages[first]:.4g} m, which is steeper than {steepest:g}; smooth heights of "
            "receivers first, and state the unit of a column in the first line"
        )
    return LineProfile(chainages, slopes)


def _gpx_points(path: Path) -> tuple[list[int], Array, Array]:
    """Return line in the file, distance from the first point [m] and height [m] of each point of a GPX track."""
    points: list[tuple[int, float, float, float]] = []
    open_point: dict[str, Any] = {}
    parser = expat.ParserCreate()
    tracks = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal tracks
        name = tag.rpartition(":")[2]
        tracks += name == "trk"
        if tracks > 1:
            raise ValueError(
                f"line {parser.CurrentLineNumber}: a second track (trk) begins; a line is one, remove others"
            )
        if name == "trkpt":
            if "line" in open_point:
                raise ValueError(
                    f"line {parser.CurrentLineNumber}: a point (trkpt) begins within a point; close it first"
                )
            open_point.update(attributes | {"line": parser.CurrentLineNumber, "ele": "", "inside": False})
        open_point["inside"] = name == "ele" and "line" in open_point

    def text(characters: str) -> None:
        if open_point.get("inside"):
            open_point["ele"] += characters

    def end(tag: str) -> None:
        open_point["inside"] = False
        if tag.rpartition(":")[2] == "trkpt":
            line = open_point["line"]
            try:
                latitude, longitude, height = (float(open_point[key]) for key in ("lat", "lon", "ele"))
            except (KeyError, ValueError):
                raise ValueError(f"line {line}: a point of the track needs numbers for lat, lon and ele") from None
            if not (abs(latitude) <= 89 and abs(longitude) <= 180 and -500 <= height <= 6000):
                raise ValueError(f"line {line}: latitude, longitude or height of the point is not that of a railway")
            points.append((line, latitude, longitude, height))
            open_point.clear()

    def refuse(*_: object) -> None:
        raise ValueError(f"line {parser.CurrentLineNumber}: a GPX file has no document type declaration")

    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = begin, end, text
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(read_text(path, _LARGEST), True)
    except (expat.ExpatError, InputError) as problem:
        raise ValueError(f"is not XML, as GPX files are ({problem})") from problem
    if len(points) < 2:
        raise ValueError(f"has {len(points)} points of a track (trkpt); a line takes two or more")
    kept, way = _apart(points)
    if len(kept) < 2:
        raise ValueError("has a track whose points are at one place")
    return [points[number][0] for number in kept], np.array(way), np.array([points[number][3] for number in kept])


def _apart(points: list[tuple[int, float, float, float]]) -> tuple[list[int], list[float]]:
    """Return the points that lie apart, by number, and the horizontal distance along them from the first [m].

    Each is compared with the last one that is kept: steps between readings at rest would add up.
    """
    import pymap3d  # takes a fifth of a second

    _, latitude, longitude, height = np.array(points).T
    places = np.stack(pymap3d.geodetic2ecef(latitude, longitude, height), axis=-1)
    phi, turn = np.radians(latitude), np.radians(longitude)
    upward = np.stack([np.cos(phi) * np.cos(turn), np.cos(phi) * np.sin(turn), np.sin(phi)], axis=-1)
    kept, way = [0], [0.0]
    for number, place in enumerate(places):
        offset = place - places[kept[-1]]
        step = math.sqrt(max(offset @ offset - (offset @ upward[kept[-1]]) ** 2, 0.0))
        if step >= _CLOSEST:
            kept.append(number)
            way.append(way[-1] + step)
    return kept, way
