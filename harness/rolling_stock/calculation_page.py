"""The page of a brake calculation, its PDF, and its values as plain data."""

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import accumulate, chain
from pathlib import Path
from typing import Any, cast

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from railgrip.base.errors import ScenarioError
from railgrip.base.files import replacing
from railgrip.base.tables import JsonObject
from railgrip.report.page import Page
from railgrip.report.style import Drawing, advance, panels
from railgrip.report.table import ReportTable
from railgrip.rolling_stock.calculation import PARKING_ADHESION, PARKING_SLOPE, RANGES, MeanStop, parking
from railgrip.rolling_stock.check import findings
from railgrip.rolling_stock.scatter import Scatter
from railgrip.rolling_stock.schema import BogieInTrain, SourcedTable, Train
from railgrip.rolling_stock.stopping import response_times, rotating_masses
from railgrip.rolling_stock.tables import plain_stop

_A4 = (8.27, 11.69)  # in
_LEFT, _BOTTOM, _LINE = 0.06, 0.05, 0.0125  # shares of the sheet
_SIZE = 7  # of the font
_WIDTH = (1 - 2 * _LEFT) * _A4[0] * 72 / _SIZE  # of a line, in sizes of the font
_GAP = 1.2  # between two columns, likewise
_ROUNDING = 1e-9  # of a width
_TITLE = 13  # size of the font of the title
_BOLD = 1.25  # width of bold letters over that of others, at most
_TOGETHER = 10  # lines of a row up to which it is on one sheet


_REMARKED = 0.03
"""Difference of the distances by mean values and by time steps, as a share, that is remarked."""


def calculation_page(
    train: Train, stops: Sequence[MeanStop], drawn: Sequence[Scatter] = (), *, origin: str, digest: str
) -> Page:
    """Return the page of a brake calculation, with its PDF.

    Args:
        train: The train.
        stops: Its stops by mean values, at least one.
        drawn: Its stops with drawn brakes, if any.
        origin: Name of the file of the train.
        digest: Digest of that file.
    """
    fastest = max(stops, key=lambda stop: stop.speed)
    first = (
        f"{train.name} stops from {_km_h(fastest.speed)} in {fastest.distance:.1f} m by mean values and in "
        f"{fastest.time_steps.distance:.1f} m by time steps."
    )
    second = (
        f"Its equivalent deceleration is {fastest.deceleration:.3f} m/s² after {fastest.equivalent_time:.2f} s, and it "
        f"requires an adhesion of up to {fastest.adhesion.max():.3f} (axle {int(fastest.adhesion.argmax()) + 1})."
    )
    tables = {
        "data": _data(train),
        "stops": table_of_stops(stops),
        "scatter": _scatter(drawn),
        "axles": _axles(train, fastest),
        "dynamic": _dynamic(train, fastest),
        "rail": _rail(train, fastest),
        "steps": _steps(fastest),
        "sources": ReportTable.of(["table", "source"], _sources(train), left=2),
        "signatures": ReportTable(
            [{"": step, "name": "", "date": "", "signature": ""} for step in ("calculated", "checked", "released")],
            left=("", "name", "date", "signature"),
        ),
    }
    parts = {name.capitalize(): table for name, table in tables.items() if table}
    page = Page(
        title=f"Brake calculation of {train.name}",
        question=f"How far does {train.name} travel to a stop, and what must its brakes and the rail provide?",
        answer=f"{first} {second}",
        template="rolling_stock/calculation.md.jinja",
        values={
            **tables,
            "fastest": _km_h(fastest.speed),
            "lambda_note": f"{LAMBDA_NOTE} {' '.join(remarks_on(stops))}",
            "findings": [str(finding) for finding in findings(train)],
        },
        figures={"figures/deceleration.png": _figure(fastest)},
        provenance={"train": origin, "digest of its file": digest},
        tables={f"{name}.csv": tables[name] for name in ("stops", "scatter", "axles", "steps") if tables[name]},
        data={"calculation.json": plain_calculation(train, stops, drawn)},
        screen=[
            first,
            second,
            tables["stops"],
            *remarks_on(stops),
            *([tables["scatter"]] if drawn else []),
            tables["axles"],
            tables["steps"],
        ],
    )
    _require_glyphs(page, parts.values())
    return replace(page, files={"calculation.pdf": lambda path: _write_pdf(path, page, parts)})


_RANGES_OF_LAMBDA = (
    f"{RANGES[True][0]:g} to {RANGES[True][1]:g} % from 100 km/h and {RANGES[False][0]:g} to {RANGES[False][1]:g} % "
    "from other speeds"
)
LAMBDA_NOTE = (
    "Braked weight percentage λ = C/s − D by UIC 544-1, with C and D as published in "
    "RailProfAC/RailwayBrakeCalculation; verify them in the leaflet. There are values for trains from 100, 120, 140, "
    "150, 160, 180 and 200 km/h and for single vehicles from 100, 120, 140 and 160 km/h, with λ of "
    f"{_RANGES_OF_LAMBDA}; elsewhere the cell is empty. λ of a train is the smallest of its column."
)


def remarks_on(stops: Sequence[MeanStop]) -> list[str]:
    """Return sentences on distances by mean values that differ from the time steps, and on empty cells of λ."""
    remarks = [
        f"From {_km_h(stop.speed)} the distance by time steps differs by {100 * error:+.1f} % from that by mean "
        f"values, from which λ is formed: the brakes build up in {stop.equivalent_time:.1f} s of "
        f"{stop.time_steps.duration:.0f} s."
        for stop in stops
        if abs(error := stop.time_steps.distance / stop.distance - 1) > _REMARKED
    ]
    percentages = [(each.braked_weight_percentage_train, each.braked_weight_percentage_vehicle) for each in stops]
    if empty := [_km_h(stop.speed) for stop, pair in zip(stops, percentages, strict=True) if None in pair]:
        remarks.append(
            f"Cells of λ are empty from {', '.join(empty)}: UIC 544-1 has no values for this speed, or λ is outside of "
            f"{_RANGES_OF_LAMBDA}."
        )
    return remarks


def table_of_stops(stops: Sequence[MeanStop]) -> ReportTable:
    """Return one row for each stop."""
    rows = [
        {
            "from": 3.6 * stop.speed,
            "mean values": stop.distance,
            "time steps": stop.time_steps.distance,
            "difference": 100 * (stop.time_steps.distance / stop.distance - 1),
            "te": stop.equivalent_time,
            "ae": stop.deceleration,
            "brakes": float(stop.force.sum() + stop.force_dynamic.sum() + stop.force_rail_brakes.sum()) / 1e3,
            "dynamic": float(stop.force_dynamic.sum()) / 1e3,
            "without dynamic": stop.distance_without_dynamic,
            "resistance": stop.resistance / 1e3,
            "adhesion": float(stop.adhesion.max()),
            "λ train": stop.braked_weight_percentage_train,
            "λ vehicle": stop.braked_weight_percentage_vehicle,
        }
        for stop in stops
    ]
    forms = {
        "from": "{:g} km/h", "mean values": "{:.1f} m", "time steps": "{:.1f} m", "difference": "{:+.1f} %",
        "te": "{:.2f} s", "ae": "{:.3f} m/s²", "brakes": "{:.1f} kN", "dynamic": "{:.1f} kN",
        "without dynamic": "{:.1f} m", "resistance": "{:.1f} kN",
        "adhesion": "{:.3f}", "λ train": "{:.0f} %", "λ vehicle": "{:.0f} %",
    }  # fmt: skip
    table = ReportTable(rows, forms)
    return table if rows[0]["without dynamic"] is not None else table.without({"dynamic", "without dynamic"})


def plain_calculation(train: Train, stops: Sequence[MeanStop], drawn: Sequence[Scatter] = ()) -> JsonObject:
    """Return a calculation as plain values in SI units."""
    _, turning, _ = rotating_masses(train)
    times, rail_times = response_times(train)
    return {
        "train": train.name,
        "mass": train.mass,
        "rotating_mass": float(turning.sum()),
        "parking": asdict(parking(train)) if train.parking_brakes else None,
        "scatter": [{"speed": each.speed, "draws": each.distances.size, **each.figures} for each in drawn],
        "remarks": remarks_on(stops),
        "response_time": times.tolist(),
        "response_time_rail_brakes": rail_times.tolist(),
        "stops": [
            {
                name: value.tolist() if isinstance(value, np.ndarray) else value
                for name, value in asdict(stop).items()
                if name != "full_force"
            }
            | {
                "steps": [dict(zip(("from", "to", "deceleration"), step, strict=True)) for step in stop.steps],
                "time_steps": plain_stop(stop.speed, stop.time_steps),
            }
            for stop in stops
        ],
    }


def _km_h(speed: float) -> str:
    return f"{3.6 * speed:g} km/h"


def _data(train: Train) -> ReportTable:
    _, turning, _ = rotating_masses(train)
    command = "immediately" if train.command is None else train.command.kind.replace("_", " ")
    rows = [
        ("description", train.description),
        ("cars, axles", f"{len(train.cars)}, {len(train.axles)}"),
        ("length over couplers", f"{train.length:.1f} m"),
        ("mass on the rail", f"{train.mass / 1e3:.1f} t"),
        ("rotating mass", f"{turning.sum() / 1e3:.2f} t, {100 * turning.sum() / train.mass:.1f} %"),
        ("command of the emergency brake", command),
    ]
    if train.parking_brakes:
        held = parking(train)
        rows += [
            (
                "parking brake",
                f"{held.force / 1e3:.1f} kN, {held.usable / 1e3:.1f} kN of it up to {PARKING_ADHESION:g}",
            ),
            ("steepest gradient held", f"{1e3 * held.slope:.1f} ‰"),
            (f"adhesion on {1e3 * PARKING_SLOPE:g} ‰", f"{held.adhesion:.3f}"),
        ]
    return ReportTable.of(["datum", "value"], rows, left=2)


def _axles(train: Train, stop: MeanStop) -> ReportTable:
    times, _ = response_times(train)
    rows = [
        {
            "axle": number + 1,
            "car": train.cars[axle.car].name,
            "brake": bogie.data.brake,
            "units": round(axle.units),
            "pad force": bogie.brake.full_force / 1e3,
            "friction": _mean_friction(float(stop.full_force[number]), axle.units, bogie),
            "force": float(stop.force[number]) / 1e3,
            "te": float(times[number]),
            "load": axle.mass / 1e3,
            "adhesion": float(stop.adhesion[number]),
            "energy": float(stop.energy[number]) / 1e6,
            "power": float(stop.power[number]) / 1e3,
        }
        for number, axle in enumerate(train.axles)
        for bogie in [train.bogies_in_train[axle.bogie]]
    ]
    forms = {
        "pad force": "{:.2f} kN", "friction": "{:.3f}", "force": "{:.3f} kN", "te": "{:.2f} s", "load": "{:.2f} t",
        "adhesion": "{:.3f}", "energy": "{:.2f} MJ", "power": "{:.0f} kW",
    }  # fmt: skip
    return ReportTable(rows, forms, ("car", "brake"))


def _dynamic(train: Train, stop: MeanStop) -> ReportTable:
    rows = [
        {
            "axle": number + 1, "car": train.cars[axle.car].name, "dynamic brake": bogie.data.dynamic_brake,
            "blending": getattr(bogie.dynamic_brake, "blending", None),
            "force": float(stop.force_dynamic[number]) / 1e3, "energy": float(stop.energy_dynamic[number]) / 1e6,
        }
        for number, axle in enumerate(train.axles)
        for bogie in [train.bogies_in_train[axle.bogie]]
        if stop.force_dynamic[number] > 0
    ]  # fmt: skip
    return ReportTable(rows, {"force": "{:.3f} kN", "energy": "{:.2f} MJ"}, ("car", "dynamic brake", "blending"))


def _mean_friction(force: float, units: float, bogie: BogieInTrain) -> float | None:
    at_rim = units * bogie.brake.full_force * bogie.brake.friction_radius / bogie.data.wheel_radius
    return force / at_rim if at_rim > 0 else None


def _rail(train: Train, stop: MeanStop) -> ReportTable:
    _, times = response_times(train)
    rows = [
        {
            "car": train.cars[bogie.cars[0]].name, "bogie": bogie.kind, "track brake": name,
            "force": force / 1e3, "te": time,
        }
        for (bogie, name, _), force, time in zip(
            train.rail_brakes, stop.force_rail_brakes.tolist(), times.tolist(), strict=True
        )
    ]  # fmt: skip
    return ReportTable(rows, {"force": "{:.2f} kN", "te": "{:.2f} s"}, ("car", "bogie", "track brake"))


def _steps(stop: MeanStop) -> ReportTable:
    rows = [{"from": 3.6 * upper, "to": 3.6 * lower, "deceleration": each} for upper, lower, each in stop.steps]
    return ReportTable(rows, {"from": "{:.0f} km/h", "to": "{:.0f} km/h", "deceleration": "{:.3f} m/s²"})


def _sources(train: Train) -> Iterator[tuple[str, str]]:
    for name in type(train).model_fields:
        value = getattr(train, name)
        tables = {f"[{name}]": value}
        if isinstance(value, dict):
            tables = {f"[{name}.{key}]": table for key, table in cast("dict[str, object]", value).items()}
        elif isinstance(value, tuple):
            tables = {f"[{name}[{number}]]": table for number, table in enumerate(cast("tuple[Any, ...]", value), 1)}
        for where, table in tables.items():
            if isinstance(table, SourcedTable):
                keys = table.estimated if isinstance(table.estimated, tuple) else ()
                estimated = f"estimated: {', '.join(keys)}" if keys else "estimated" * (table.estimated is True)
                yield where, "; ".join(filter(None, (table.source, estimated)))


def _scatter(drawn: Sequence[Scatter]) -> ReportTable:
    rows = [{"from": 3.6 * each.speed, "draws": each.distances.size, **each.figures} for each in drawn]
    forms = {name: "{:.2f} m" for each in drawn for name in each.figures}
    return ReportTable(rows, {"from": "{:.0f} km/h", **forms}, title="Distances with drawn brakes")


def _figure(stop: MeanStop) -> Figure:
    figure, axes = panels(7, 3)
    edges = [3.6 * upper for upper, _, _ in stop.steps] + [0.0]
    axes.stairs([each for *_, each in stop.steps][::-1], edges[::-1], baseline=None)
    axes.set(xlabel="speed [km/h]", ylabel="deceleration [m/s²]", ylim=(0, None))
    return figure


def _require_glyphs(page: Page, tables: Iterable[ReportTable]) -> None:
    """Raise an error for texts that the PDF would not show as they are written."""
    rows = [row.values() for table in tables for row in table.texts]
    for text in chain([page.title, page.answer, page.provenance["train"]], *rows):
        bad = [c for c in text if not c.isspace() and advance(c) is None]
        if bad:
            raise ScenarioError(
                f"{page.provenance['train']}: calculation.pdf cannot show {bad[0]!r} (U+{ord(bad[0]):04X}) of "
                f"'{textwrap.shorten(text, 60, placeholder='…')}': its font, DejaVu Sans, is for Latin, Greek, "
                "Cyrillic, Armenian and Georgian letters; write the text in one of these."
            )


def _width(text: str) -> float:
    return sum(advance(c) or 0.0 for c in text)


def _wrapped(text: str, width: float) -> list[str]:
    """Return the lines of a text, at most `width` sizes of the font wide; words that are wider are broken."""
    lines: list[str] = []
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines else word
        if _width(joined) <= width + _ROUNDING:
            lines[-1:] = [joined]
            continue
        lines.append("")
        for character in word:
            if lines[-1] and _width(lines[-1] + character) > width:
                lines.append("")
            lines[-1] += character
    return lines or [""]


def _write_pdf(path: Path, page: Page, parts: Mapping[str, ReportTable]) -> None:
    """Write the tables of a page on sheets of A4, one below the other."""
    with replacing(path) as partial, PdfPages(partial, metadata={"CreationDate": None, "Title": page.title}) as pdf:
        sheet = _Sheet(page, pdf)
        for title, table in parts.items():
            sheet.draw(title, table)
            if title == "Stops":
                sheet.write(page.values["lambda_note"])
        pdf.savefig(sheet.figure)


class _Sheet:
    """A sheet of A4 that is filled from the top, and replaced by a new one where it is full."""

    def __init__(self, page: Page, pdf: PdfPages) -> None:
        self._page, self._pdf = page, pdf
        self._begin()

    def _begin(self) -> None:
        self.figure, self._top = Drawing(figsize=_A4), 0.96
        for line in _wrapped(self._page.title, _WIDTH * _SIZE / _TITLE / _BOLD):
            self.figure.text(_LEFT, self._top, line, fontsize=_TITLE, weight="bold", va="top")
            self._top -= 1.6 * _LINE
        self._top -= _LINE
        self.write(self._page.answer)
        self.write(f"Train file {self._page.provenance['train']}")

    def write(self, text: str) -> None:
        """Write a text below what is on the sheet."""
        lines = _wrapped(text, _WIDTH)
        self._require(1 + len(lines))
        self._top -= 0.5 * _LINE
        self.figure.text(_LEFT, self._top, "\n".join(lines), fontsize=_SIZE, va="top", linespacing=1.2)
        self._top -= _LINE * len(lines)

    def draw(self, title: str, table: ReportTable) -> None:
        """Draw a table below what is on the sheet; a column is as wide as its longest text, as far as there is room.

        A table with an empty column is one to fill in by hand: its columns have the same width.
        """
        rows = [list(row.values()) for row in table.texts]
        columns = zip(table.columns, *rows, strict=True)
        widths = [max(_BOLD * _width(name), *map(_width, texts)) + _GAP for name, *texts in columns]
        while sum(widths) > _WIDTH + _ROUNDING:  # the widest become as wide as the next, or as there is room
            widest = [i for i, width in enumerate(widths) if width == max(widths)]
            rest = [width for i, width in enumerate(widths) if i not in widest]
            room = (_WIDTH - sum(rest)) / len(widest)
            widths = [max(room, max(rest, default=0.0)) if i in widest else width for i, width in enumerate(widths)]
        if any(not any(column) for column in zip(*rows, strict=True)):  # for handwriting
            widths = [_WIDTH / len(widths)] * len(widths)
        places = [_LEFT + (1 - 2 * _LEFT) * place / _WIDTH for place in accumulate(widths[:-1], initial=0)]
        self._require(5)
        self._top -= _LINE
        self.figure.text(_LEFT, self._top, title, fontsize=_SIZE + 2, weight="bold", va="top")
        self._top -= 2 * _LINE
        self._row([[name] for name in table.columns], places, weight="bold")
        for row in rows:
            cells = [_wrapped(text, width - _GAP) for text, width in zip(row, widths, strict=True)]
            while any(cells):
                if self._require(1 + min(max(map(len, cells)), _TOGETHER)):
                    self._row([[name] for name in table.columns], places, weight="bold")
                room = int((self._top - _BOTTOM) / _LINE) - 1
                self._row([lines[:room] for lines in cells], places)
                cells = [lines[room:] for lines in cells]

    def _row(self, row: Sequence[Sequence[str]], places: Sequence[float], weight: str = "normal") -> None:
        for lines, place in zip(row, places, strict=True):
            for number, line in enumerate(lines):
                self.figure.text(place, self._top - (0.8 + number) * _LINE, line, fontsize=_SIZE, weight=weight)
        self._top -= _LINE * (0.3 + max(map(len, row)))
        self.figure.add_artist(Line2D((_LEFT, 1 - _LEFT), [self._top + 0.2 * _LINE] * 2, color="0.8", linewidth=0.5))

    def _require(self, lines: int) -> bool:
        """Begin a new sheet, and return True, if there is no room for some lines."""
        if self._top - _LINE * lines > _BOTTOM:
            return False
        self._pdf.savefig(self.figure)
        self._begin()
        return True
