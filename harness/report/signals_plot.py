"""The signals of a stop as an interactive figure: every wheelset, and the train with its axles at a cursor."""

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Any

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray

from railgrip.report.palette import BLACK, SHADES, lead_to_trail
from railgrip.trace.recorder import formation_in

_POINTS = 250_000
"""Maximum number of points in all lines; with more a browser becomes too slow."""

_PANEL = 140
_GAP = 0.25  # between panels, of the height of one

_Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Line:
    """A line of a panel, for a wheelset or the train.

    Attributes:
        name: Name in the legend, which toggles all lines with that name.
        wheelset: Zero-based number; None for the train.
    """

    name: str
    values: _Values
    wheelset: int | None = None
    dash: str = "solid"
    shown: bool = True


@dataclass(frozen=True, slots=True)
class _Panel:
    label: str
    lines: Sequence[_Line]
    axis: Mapping[str, Any] = field(default_factory=dict[str, Any])


def array(values: ArrayLike) -> dict[str, str]:
    """Return numbers in plotly.js's binary format, with seven digits, the resolution of a screen."""
    with np.errstate(over="ignore"):  # a diverged value is infinite
        numbers = np.ascontiguousarray(np.ravel(values), dtype="<f4")
    return {"dtype": "f4", "bdata": base64.b64encode(numbers.tobytes()).decode()}


def signals_plot(trace: xarray.Dataset) -> dict[str, Any]:
    """Return panels of speed, slip, adhesion, friction and pressure over time or distance, a line for each wheelset.

    Signals that a plant does not output and that are not estimated have no panel. For a long train only each n-th
    sample is drawn; trace.nc has all.
    """
    panels = [panel for panel in _panels(trace) if panel.lines]
    count = sum(len(panel.lines) for panel in panels)
    every = max(1, ceil(count * trace.sizes["time"] / _POINTS))
    places = np.unique(np.append(np.arange(0, trace.sizes["time"], every), trace.sizes["time"] - 1))
    colours = lead_to_trail(trace.sizes["wheelset"])
    data: list[dict[str, Any]] = []
    layout = _layout(panels)
    named: set[str] = set()
    for number, panel in enumerate(panels, start=1):
        for line in panel.lines:
            from_wheelset = line.dash == "solid" and line.wheelset is not None
            data.append(
                {
                    "type": "scatter",
                    "mode": "lines",
                    "y": array(line.values[places]),
                    "yaxis": f"y{number}" if number > 1 else "y",
                    "name": line.name,
                    "legendgroup": line.name,
                    "showlegend": line.name not in named,
                    "visible": True if line.shown else "legendonly",
                    "line": {
                        "color": BLACK if line.wheelset is None else colours[line.wheelset],
                        "dash": line.dash,
                        "width": 1.4 if from_wheelset or line.wheelset is None else 1.2,
                    },
                }
            )
            named.add(line.name)
    layout["meta"] = {"train": _train(trace, places)}
    return {"data": data, "layout": layout}


def _layout(panels: Sequence[_Panel]) -> dict[str, Any]:
    height = 1.0 / (len(panels) + _GAP * (len(panels) - 1))
    layout: dict[str, Any] = {
        "height": round(_PANEL * (len(panels) + _GAP * (len(panels) - 1)) + 90),
        "margin": {"l": 70, "r": 10, "t": 20, "b": 50},
        "hovermode": "x unified",
        "hoversubplots": "axis",
        "legend": {"groupclick": "togglegroup", "tracegroupgap": 0},
        "xaxis": {"title": {"text": "time since the brake demand [s]"}, "anchor": f"y{len(panels)}"},
        "shapes": [
            {"type": "line", "xref": "x", "yref": "paper", "x0": 0, "x1": 0, "y0": 0, "y1": 1, "line": {"width": 1}}
        ],
    }
    for number, panel in enumerate(panels, start=1):
        top = 1 - (number - 1) * (1 + _GAP) * height
        layout[f"yaxis{number if number > 1 else ''}"] = {
            "domain": [max(top - height, 0.0), top],
            "title": {"text": panel.label},
            **panel.axis,
        }
    return layout


def _panels(trace: xarray.Dataset) -> Iterator[_Panel]:
    group = formation_in(trace).group_of_wheelset
    first = [int(np.argmax(group == number)) for number in range(trace.sizes["group"])]

    def of_wheelset(name: str, factor: float = 1.0) -> list[_Line]:
        if not _has(trace, name):
            return []
        values = factor * trace[name].values
        each = values if trace[name].dims[1] == "wheelset" else values[:, group]
        return [_Line(f"wheelset {k + 1}", each[:, k], k) for k in range(each.shape[1])]

    def of_group(name: str, text: str, dash: str, factor: float = 1.0, *, shown: bool = True) -> list[_Line]:
        if not _has(trace, name):
            return []
        values = factor * trace[name].values
        return [_Line(text, values[:, g], first[g], dash, shown) for g in range(values.shape[1])]

    def claimed(name: str) -> list[_Line]:
        if not _has(trace, f"{name}_sd"):
            return of_group(name, "estimated", "dot")
        mean, half_width = trace[name].values, 2 * trace[f"{name}_sd"].values
        edges = [_Line("±2σ", mean[:, g] + sign * half_width[:, g], k, "dot", shown=False)
                 for g, k in enumerate(first) for sign in (-1, 1)]  # fmt: skip
        return [*of_group(name, "estimated", "dot"), *edges]

    speed = 3.6 * trace["speed"].values
    wheels = [_Line(f"wheelset {k + 1}", speed * (1 - trace["slip"].values[:, g]), k)
              for k, g in enumerate(group)] if _has(trace, "slip") else []  # fmt: skip
    yield _Panel("speed [km/h]", [_Line("train", speed), *wheels], {"rangemode": "tozero"})
    # The optimum slip is 1 to 10 %, a locked wheel 100 %: only a logarithmic axis resolves both.
    slip_axis = {"type": "log", "range": [-1, 2.08], "tickvals": [0.1, 1, 10, 100]}
    best = of_group("peak_slip", "greatest possible adhesion", "dash", 100, shown=False)
    yield _Panel("slip [%]", [*of_wheelset("slip", 100), *best], slip_axis)
    peak = of_group("peak_adhesion", "greatest possible adhesion", "dash", shown=False)
    adhesion = [*of_wheelset("adhesion"), *peak, *claimed("estimate_adhesion")]
    yield _Panel("adhesion", adhesion, {"rangemode": "tozero"})
    yield _Panel("maximum friction μ<sub>0</sub>", of_wheelset("mu0"), {"rangemode": "tozero"})
    # The estimate before the first brake application may be very uncertain; it must not determine the scale.
    pads = [*of_wheelset("pad_friction"), *claimed("estimate_pad_friction")]
    yield _Panel("pad friction", pads, {"range": [0.2, 0.6]})
    pressure = [*of_wheelset("cylinder_pressure", 1e-5), *of_group("demand", "demanded", "dash", 1e-5, shown=False)]
    yield _Panel("cylinder pressure [bar]", pressure, {"rangemode": "tozero"})


def _train(trace: xarray.Dataset, places: NDArray[np.intp]) -> dict[str, Any]:
    group, wheelsets = formation_in(trace).group_of_wheelset, trace.sizes["wheelset"]
    signals: dict[str, Any] = {}
    for name, low, high, factor, unit in (("slip", 0.001, 1.0, 100, "%"), ("adhesion", 0.01, 0.2, 1, "")):
        if _has(trace, name):
            each = trace[name].values[places]
            each = each if trace[name].dims[1] == "wheelset" else each[:, group]
            values = [array(column) for column in each.T]
            signals[name] = {"values": values, "low": low, "high": high, "unit": unit, "factor": factor,
                             "colours": SHADES}  # fmt: skip
    # A foreign plant may not declare the positions of its wheelsets.
    known = trace["wheelset_position"].values if "wheelset_position" in trace else 2.5 * np.arange(wheelsets)
    cars = trace["car_of_wheelset"].values if "car_of_wheelset" in trace else np.ones(wheelsets, dtype=int)
    return {
        "positions": [float(position) for position in known],
        "cars": [int(car) for car in cars],
        "time": array(trace["time"].values[places]),
        "distance": array(trace["distance"].values[places]),
        "signals": signals,
    }


def _has(trace: xarray.Dataset, name: str) -> bool:
    return name in trace and bool(np.isfinite(trace[name].values).any())
