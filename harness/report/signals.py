"""The signals of a stop as panels of lines, drawn by group in `signals_figure` and by wheelset in `signals_plot`."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray
from numpy.typing import NDArray

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
