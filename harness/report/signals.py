"""The signals of a stop as panels of lines, and as an interactive figure of wheelsets with the axles at a cursor."""

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Literal

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray

from railgrip.base.tables import JsonObject
from railgrip.report.palette import BLACK, SHADES, of_groups
from railgrip.trace.recorder import formation_in

Role = Literal["train", "group", "wheelset", "optimum", "demand", "estimate"]
"""What a line is of; optimum, demand and estimate have a value for each group."""


@dataclass(frozen=True, slots=True)
class SignalLine:
    """A signal in a panel.

    Attributes:
        label: Name in a legend.
        role: What it is of.
        values: Shape (samples,) for the train, else (samples, groups) or (samples, wheelsets).
        deviation: Standard deviation of an estimate, in the shape of `values`, if it is known.
    """

    label: str
    role: Role
    values: NDArray[np.float64]
    deviation: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True)
class SignalPanel:
    """Signals of one quantity.

    Attributes:
        label: The quantity and its unit.
        lines: Signals that the trace has; later ones cover earlier ones.
        limits: Ends of the scale; without them it starts at zero.
        log_ticks: Ticks of a logarithmic scale.
    """

    label: str
    lines: Sequence[SignalLine]
    limits: tuple[float, float] | None = None
    log_ticks: tuple[float, ...] = ()


def signal_panels(trace: xarray.Dataset) -> list[SignalPanel]:
    """Return panels of speed, slip, adhesion, friction and pressure.

    Signals that a plant does not output and that are not estimated have no line.
    """

    def lines(label: str, role: Role, name: str, factor: float = 1.0) -> list[SignalLine]:
        if not has_values(trace, name):
            return []
        deviation = trace[f"{name}_sd"].values if f"{name}_sd" in trace else None
        return [SignalLine(label, role, factor * trace[name].values, deviation)]

    speed = lines("train", "train", "speed", 3.6)
    if has_values(trace, "slip"):
        speed += [SignalLine("wheelset", "group", speed[0].values[:, None] * (1 - trace["slip"].values))]
    slip = [*lines("slip", "group", "slip", 100), *lines("maximum adhesion", "optimum", "peak_slip", 100)]
    adhesion = [
        *lines("maximum adhesion", "optimum", "peak_adhesion"),
        *lines("true", "wheelset", "adhesion"),
        *lines("true", "group", "group_adhesion"),
        *lines("estimated", "estimate", "estimate_adhesion"),
    ]
    friction = [*lines("true", "group", "pad_friction"), *lines("estimated", "estimate", "estimate_pad_friction")]
    cylinder = lines("cylinder", "group", "cylinder_pressure", 1e-5)
    return [
        SignalPanel("speed [km/h]", speed),
        # The optimum slip is 1 to 10 %, a locked wheel 100 %: only a logarithmic axis resolves both.
        SignalPanel("slip [%]", slip, (0.1, 120), (0.1, 1, 10, 100)),
        SignalPanel("adhesion", adhesion),
        SignalPanel("maximum friction μ₀", lines("rail", "wheelset", "mu0")),
        # The estimate before the first brake application may be very uncertain; it must not determine the scale.
        SignalPanel("pad friction", friction, (0.2, 0.6)),
        SignalPanel("cylinder pressure [bar]", [*cylinder, *lines("demanded", "demand", "demand", 1e-5)]),
    ]


def has_values(trace: xarray.Dataset, name: str) -> bool:
    """Return whether a trace has a finite value of a variable."""
    return name in trace and bool(np.isfinite(trace[name].values).any())


_POINTS = 250_000
"""Maximum number of points in all lines; with more a browser becomes too slow."""

_ROW = 195  # pixels, a panel and the gap below it; no panel is lower than 150 on any screen
_GAP = 0.2  # of a row
TICKS = {"ticks": "outside", "ticklen": 5, "tickcolor": "rgba(0,0,0,0)"}
"""Invisible ticks, which keep the labels of both axes apart in the corner."""

_DASHES = {"optimum": "dash", "demand": "dash", "estimate": "dot"}
_HIDDEN = {"maximum adhesion", "demanded", "±2σ"}
"""Lines that are drawn after a click on their name in the legend."""


def array(values: ArrayLike) -> dict[str, str]:
    """Return numbers in plotly.js's binary format, with seven digits, the resolution of a screen."""
    with np.errstate(over="ignore"):  # a diverged value is infinite
        numbers = np.ascontiguousarray(np.ravel(values), dtype="<f4")
    return {"dtype": "f4", "bdata": base64.b64encode(numbers.tobytes()).decode()}


def signals_plot(trace: xarray.Dataset, cars: Sequence[tuple[float, float]] = ()) -> JsonObject:
    """Return the panels of `signal_panels` over time or distance, a line for each wheelset, for plotly.js.

    Wheelsets have the colour of their group. For a long train only each n-th sample is drawn; trace.nc has all.

    Args:
        trace: Trace of a stop.
        cars: Both ends of each car behind the leading wheelset [m]; empty if they are unknown.
    """
    group = formation_in(trace).group_of_wheelset
    panels = [panel for panel in signal_panels(trace) if panel.lines]
    curves = [
        (number, *curve)
        for number, panel in enumerate(panels, start=1)
        for line in panel.lines
        if line.role != "group" or all(other.role != "wheelset" for other in panel.lines)
        for curve in _curves(line, group)
    ]
    every = max(1, ceil(len(curves) * trace.sizes["time"] / _POINTS))
    places = np.unique(np.append(np.arange(0, trace.sizes["time"], every), trace.sizes["time"] - 1))
    colours = [of_groups(trace.sizes["group"])[number] for number in group]
    named: set[str] = set()
    data: list[JsonObject] = []
    for number, name, wheelset, dash, values in curves:
        data.append(
            {
                "type": "scatter",
                "mode": "lines",
                "y": array(values[places]),
                "yaxis": f"y{number}" if number > 1 else "y",
                "name": name,
                "legendgroup": name,
                "showlegend": name not in named,
                "visible": "legendonly" if name in _HIDDEN else True,
                "line": {
                    "color": BLACK if wheelset is None else colours[wheelset],
                    "dash": dash,
                    "width": 1.4 if dash == "solid" else 1.2,
                },
            }
        )
        named.add(name)
    return {"data": data, "layout": {**_layout(panels), "meta": {"train": _train(trace, places, cars, colours)}}}


def _curves(line: SignalLine, group: NDArray[np.intp]) -> Iterator[tuple[str, int | None, str, NDArray[np.float64]]]:
    """Return name, wheelset, dash and values of each curve of a line."""
    if line.role == "train":
        yield line.label, None, "solid", line.values
    elif line.role in ("group", "wheelset"):
        columns = line.values if line.role == "wheelset" else line.values[:, group]
        for wheelset, values in enumerate(columns.T):
            yield f"wheelset {wheelset + 1}", wheelset, "solid", values
    else:
        for number, values in enumerate(line.values.T):
            wheelset = int(np.argmax(group == number))
            yield line.label, wheelset, _DASHES[line.role], values
            if line.deviation is not None:
                half_width = 2 * line.deviation[:, number]
                yield "±2σ", wheelset, "dot", values - half_width
                yield "±2σ", wheelset, "dot", values + half_width


def _layout(panels: Sequence[SignalPanel]) -> JsonObject:
    axes = ["y", *(f"y{number}" for number in range(2, len(panels) + 1))]
    layout: JsonObject = {
        "grid": {"rows": len(panels), "columns": 1, "subplots": [[f"x{axis}"] for axis in axes], "ygap": _GAP},
        "height": _ROW * len(panels) + 55,
        "margin": {"l": 70, "r": 10, "t": 20, "b": 50},
        "hovermode": "x unified",
        "hoversubplots": "axis",
        "legend": {"groupclick": "togglegroup", "tracegroupgap": 0},
        "xaxis": {"title": {"text": "time since the brake demand [s]"}, "anchor": axes[-1], **TICKS},
        "shapes": [
            {"type": "line", "xref": "x", "yref": "paper", "x0": 0, "x1": 0, "y0": 0, "y1": 1, "line": {"width": 1}}
        ],
    }
    for axis, panel in zip(axes, panels, strict=True):
        scale: JsonObject = {"rangemode": "tozero"} if panel.limits is None else {"range": panel.limits}
        if panel.log_ticks:
            scale = {"type": "log", "range": np.log10(scale["range"]).tolist(), "tickvals": panel.log_ticks}
        layout[axis.replace("y", "yaxis")] = {"title": {"text": panel.label}, **scale, **TICKS}
    return layout


_OVERHANG = 1.0
"""Length of a car before its first and behind its last wheelset, if it is unknown [m]."""


def _train(
    trace: xarray.Dataset, places: NDArray[np.intp], cars: Sequence[tuple[float, float]], colours: Sequence[str]
) -> JsonObject:
    group, wheelsets = formation_in(trace).group_of_wheelset, trace.sizes["wheelset"]
    signals: JsonObject = {}
    for name, low, high, factor, unit in (("slip", 0.001, 1.0, 100, "%"), ("adhesion", 0.01, 0.2, 1, "")):
        if has_values(trace, name):
            each = trace[name].values[places]
            each = each if trace[name].dims[1] == "wheelset" else each[:, group]
            values = [array(column) for column in each.T]
            signals[name] = {"values": values, "low": low, "high": high, "unit": unit, "factor": factor,
                             "colours": SHADES}  # fmt: skip
    # A foreign plant may not declare the positions of its wheelsets.
    known = trace["wheelset_position"].values if "wheelset_position" in trace else 2.5 * np.arange(wheelsets)
    car_of = trace["car_of_wheelset"].values if "car_of_wheelset" in trace else np.ones(wheelsets, dtype=int)
    of_cars = (known[car_of == car] for car in np.unique(car_of))
    return {
        "positions": [float(position) for position in known],
        "cars": list(cars)
        or [(float(of_car.min()) - _OVERHANG, float(of_car.max()) + _OVERHANG) for of_car in of_cars],
        "colours": list(colours),
        "time": array(trace["time"].values[places]),
        "distance": array(trace["distance"].values[places]),
        "signals": signals,
    }
