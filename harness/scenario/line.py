"""Gradients of a line from a user's file: CSV with chainages and slopes or heights, or a GPX track."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import InputError
from railgrip.base.files import read_text
from railgrip.scenario.curve import read_columns

Array = NDArray[np.float64]

_CLOSEST = 1.0
"""Distance [m] below which two points of a GPX track are one: receivers repeat their position at rest."""
_LARGEST = 64 << 20  # bytes


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
        falling=name == "height", example="permille" if name == "slope" else "ft",
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

    def begin(tag: str, attributes: dict[str, str]) -> None:
        name = tag.rpartition(":")[2]
        if name == "trkpt":
            open_point.update(line=parser.CurrentLineNumber, ele="", inside=False, **attributes)
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
    lines, latitude, longitude, height = (np.array(column) for column in zip(*points, strict=True))
    way = _lengths(latitude, longitude, height)
    kept = [0]
    for number in range(1, len(way)):
        if way[number] - way[kept[-1]] >= _CLOSEST:
            kept.append(number)
    if len(kept) < 2:
        raise ValueError("has a track whose points are at one place")
    return [int(lines[number]) for number in kept], way[kept], height[kept]


def _lengths(latitude: Array, longitude: Array, height: Array) -> Array:
    """Return the horizontal distance of each point from the first, along the points [m]."""
    from railgrip.scenario.track_geometry import Place, local  # takes a fifth of a second

    steps = [0.0]
    for i in range(len(latitude) - 1):
        place = Place(latitude=float(latitude[i]), longitude=float(longitude[i]), height=float(height[i]))
        north, east, _ = local(latitude[i + 1], longitude[i + 1], height[i], place)
        steps.append(float(np.hypot(north, east)))
    return np.cumsum(steps)
