"""Results of a train on a line: limits over speed as a frame and a table, the stops they allow for, and a figure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from railgrip.base.arrays import Vector
from railgrip.base.errors import InputError
from railgrip.base.groups import gather
from railgrip.report import palette, style
from railgrip.report.table import ReportTable
from railgrip.rolling_stock.schema import Train
from railgrip.supervision import fixed
from railgrip.supervision.curve import Steps, braking_curve
from railgrip.supervision.k_dry import QuasiStatic
from railgrip.supervision.limits import (
    BrakingCase,
    Limits,
    brake_on_line,
    limits_of,
    release_speed,
    release_start,
    times_of,
    trip_location,
)
from railgrip.supervision.line import Target, doubts_of, load_line
from railgrip.supervision.model import TrainData, model_of, safe_deceleration
from railgrip.supervision.national import load_national
from railgrip.supervision.trains import data_of, model_of_train, read_train

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

LIMITS = ("EBD", "EBI", "SBD", "SBI1", "SBI2", "W", "P", "GUI", "I")
_ABOVE = {"EBD": "EBI", "EBI": "EBI", "SBD": "SBI", "SBI1": "SBI", "SBI2": "SBI", "W": "W"}
"""Limit → ceiling supervision limit up to which it is drawn; the permitted speed for others."""
_COLOURS = {
    "EBD": palette.BLACK,
    "EBI": palette.VERMILION,
    "SBD": palette.GREY,
    "SBI1": palette.ORANGE,
    "SBI2": palette.ORANGE,
    "W": palette.PURPLE,
    "P": palette.BLUE,
    "GUI": palette.GREEN,
    "I": palette.SKY,
}
_POINTS = 200
_TABLE_STEP = 40 / 3.6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StopOnCurves:
    """A stop of the train that begins on a supervision limit.

    Attributes:
        name: Brake and limit.
        locations: Of points of the stop, rising [m].
        speeds: Speed there [m/s].
        target: Target that the limit protects.
        reserve: Distance from standstill, or from the target speed, to the target; negative behind it [m].
    """

    name: str
    locations: Vector
    speeds: Vector
    target: Target
    reserve: float


@dataclass(frozen=True, eq=False)
class BrakingCurves:
    """Braking curves and supervision limits of a train on a line.

    Attributes:
        case: Train, national values and line.
        basis: The train of a train file, and its K factors.
        remarks: Sentences on values of the files that are unusual, or above the speed of the train.
    """

    case: BrakingCase
    basis: tuple[Train, QuasiStatic] | None = None
    remarks: tuple[str, ...] = ()

    @cached_property
    def limits(self) -> "pd.DataFrame":
        """Location of each limit over speed: columns target, limit, speed_km_h, location_m."""
        import pandas as pd  # takes a third of a second to import

        highest = fixed.ceiling_limits(self.case.ceiling)
        frames: list[pd.DataFrame] = []
        for target in self.case.line.target:
            for name in LIMITS:
                top = highest[_ABOVE.get(name, "P")]
                speeds = np.linspace(target.speed, top, _POINTS)
                if target.speed < top and name in (locations := limits_of(self.case, target, speeds)):
                    columns = {"speed_km_h": 3.6 * speeds, "location_m": locations[name]}
                    frames.append(pd.DataFrame({"target": target.name, "limit": name, **columns}))
        return pd.concat(frames, ignore_index=True)

    @cached_property
    def release(self) -> tuple[float, float] | None:
        """Release speed [m/s] and where its monitoring starts [m]; None without one."""
        speed = release_speed(self.case)
        return None if speed is None else (speed, release_start(self.case, speed))

    @cached_property
    def table(self) -> ReportTable:
        """Distance of each limit to its target at some speeds."""
        steps = np.arange(1, self.case.ceiling / _TABLE_STEP) * _TABLE_STEP
        rows: list[tuple[str | float | None, ...]] = []
        for target in self.case.line.target:
            for speed in (*steps[(steps > target.speed) & (steps < self.case.ceiling - 1)], self.case.ceiling):
                at: Limits = limits_of(self.case, target, float(speed))
                distances = (target.at - float(at[name]) if name in at else None for name in LIMITS)
                rows.append((target.name, 3.6 * float(speed), *distances))
        forms = {"target": "", "from": "{:.0f} km/h", **dict.fromkeys(LIMITS, "{:.1f} m")}
        return ReportTable.of(forms, rows).drop_empty_columns()

    @cached_property
    def decelerations(self) -> ReportTable:
        """The steps of speed with the decelerations and factors that the curves were computed with."""
        model = self.case.model
        safe = safe_deceleration(model, self.case.national)
        parts: Mapping[str, Steps | None] = {
            "A_brake_emergency": model.emergency,
            "K_dry_rst": model.k_dry,
            "K_wet_rst": model.k_wet,
            "A_brake_safe": safe,
            "A_brake_service": model.service,
        }
        starts = np.unique(np.concatenate([part.starts for part in parts.values() if part is not None]))
        rows = [
            (3.6 * start, *(None if part is None else float(part.after(start)) for part in parts.values()))
            for start in starts.tolist()
        ]
        forms = {"above": "{:.0f} km/h", **dict.fromkeys(parts, "{:.3f}")}
        for name in ("A_brake_emergency", "A_brake_safe", "A_brake_service"):
            forms[name] = "{:.3f} m/s²"
        return ReportTable.of(forms, rows, left=0).drop_empty_columns()

    @cached_property
    def stops(self) -> tuple[StopOnCurves, ...]:
        """Stops from the permitted speed that begin on the limits.

        The nominal and the safe emergency brake from the EBI, full service braking after T_driver from P.
        """
        case, v = self.case, self.case.ceiling
        stops: list[StopOnCurves] = []
        for target in case.line.target:
            limits, times = limits_of(case, target, v), times_of(case, target.speed)
            if target.kind == "EoA":
                begin, delay = float(limits["P"]), fixed.DRIVER_TIME + times.service
                stops.append(self._stop("full service brake after P", target, begin, delay, case.model.service))
                continue
            begin, build_up = float(limits["EBI"]), times.build_up
            brakes = {"nominal": case.model.emergency, "safe": safe_deceleration(case.model, case.national)}
            stops += [
                self._stop(f"{name} emergency brake from EBI", target, begin, build_up, brake)
                for name, brake in brakes.items()
            ]
        return tuple(stops)

    def _stop(self, name: str, target: Target, begin: float, delay: float, brake: Steps) -> StopOnCurves:
        v = self.case.ceiling
        braking = begin + v * delay
        curve = braking_curve(brake_on_line(self.case, brake), location=braking, speed=v, foot=target.speed)
        speeds = np.linspace(v, target.speed, _POINTS)
        locations = np.append(begin, curve.location(speeds))
        return StopOnCurves(
            name=f"{name}, {target.name}",
            locations=locations,
            speeds=np.append(v, speeds),
            target=target,
            reserve=target.at - float(locations[-1]),
        )

    @property
    def sentences(self) -> tuple[str, ...]:
        """What the results say, a sentence each."""
        case = self.case
        lines: list[str] = []
        ceiling = fixed.ceiling_limits(case.ceiling)
        margins = ", ".join(f"{name} {3.6 * speed:.1f} km/h" for name, speed in ceiling.items())
        lines.append(f"Ceiling supervision limits: {margins}.")
        for moving in sorted({target.speed > 0 for target in case.line.target}):
            times = times_of(case, float(moving))
            lines.append(
                f"Times for target speeds {'above zero' if moving else 'of zero'}: T_be {times.build_up:.2f} s, T_bs "
                f"{times.service:.2f} s, T_traction {times.traction:.2f} s, T_indication {times.indication:.2f} s."
            )
        for stop in self.stops:
            where = "before" if stop.reserve > -0.05 else "behind"
            what = "standstill" if stop.target.speed == 0 else f"{3.6 * stop.target.speed:g} km/h"
            lines.append(f"{stop.name[0].upper()}{stop.name[1:]}: {what} {abs(stop.reserve):.1f} m {where} the target.")
        if self.release is not None:
            speed, start = self.release
            lines.append(f"Release speed {3.6 * speed:.1f} km/h, monitored from {start:.1f} m on.")
        if case.line.release == "calculated":
            none = "" if self.release else "; from there the train does not stop before the SvL: no release speed"
            lines.append(f"Trip location of the EoA: {trip_location(case):.1f} m{none}.")
        if self.basis is not None:
            lines.append(self._origin(*self.basis))
        return (*lines, *self.remarks)

    def _origin(self, train: Train, factors: QuasiStatic) -> str:
        names = {"etcs": "[etcs]", "dispersion": "[[dispersion]]", "failures": "[failures]"}
        usual = [table for name, table in names.items() if not getattr(train, name)]
        level = self.case.national.M_NVEBCL
        low = factors.k[-1][level]
        words = f"K_dry_rst of the stop at EBCL {level} is {low.value:.3f} ({low.low:.3f} to {low.high:.3f})."
        if usual:
            words += f" {train.name} lacks {', '.join(usual)}: estimates of railgrip, see docs/etcs.md."
        return words

    def figure(self) -> "Figure":
        """Return the figure: limits over location, the stops beneath, and decelerations over speed."""
        drawing = style.figure(11.0, 8.0)
        grid = drawing.add_gridspec(2, 2, height_ratios=(1.5, 1.0), width_ratios=(2.6, 1.0))
        upper = drawing.add_subplot(grid[0, 0])
        seen: set[str] = set()
        for key, rows in self.limits.groupby(["target", "limit"], sort=False):
            name = str(cast("tuple[str, str]", key)[1])
            label = "SBI" if name.startswith("SBI") else name
            upper.plot(
                rows["location_m"],
                rows["speed_km_h"],
                color=_COLOURS[name],
                lw=1.4,
                ls="--" if name in ("EBD", "SBD", "GUI") else "-",
                label=None if label in seen else label,
            )
            seen.add(label)
        for place, kinds in gather(((each.at, 3.6 * each.speed), each.kind) for each in self.case.line.target).items():
            upper.plot(*place, "v", color=palette.BLACK, ms=6, clip_on=False)
            upper.annotate(", ".join(kinds), place, (4, 6), textcoords="offset points", fontsize=8)
        if self.release is not None:
            speed, start = self.release
            ends = [target.at for target in self.case.line.target if target.kind == "SvL"]
            upper.plot([start, *ends], [3.6 * speed] * 2, color=palette.BLACK, lw=1.0, label="release speed")
        style.dress(upper, y="speed [km/h]", title=f"{self.case.model.name}, line {self.case.line.name}")
        legend = drawing.add_subplot(grid[0, 1])
        legend.set_axis_off()
        style.legend(legend, *upper.get_legend_handles_labels(), loc="upper left")
        lower = drawing.add_subplot(grid[1, 0], sharex=upper)
        dashes = {"nominal": ":", "safe": "-", "full": "-."}
        for stop in self.stops:
            first = stop.name.split()[0]
            colour = palette.ORANGE if first == "full" else palette.VERMILION
            lower.plot(stop.locations, 3.6 * stop.speeds, color=colour, ls=dashes[first], lw=1.4, label=stop.name)
        style.dress(lower, x="location [m]", y="speed [km/h]", title="Stops that begin on the limits")
        style.legend(lower, loc="lower left")
        right = drawing.add_subplot(grid[1, 1])
        top = 3.6 * fixed.ceiling_limits(self.case.ceiling)["EBI"]
        model = self.case.model
        for name, steps, colour, dash in (
            ("A_brake_emergency", model.emergency, palette.BLACK, "-"),
            ("A_brake_safe", safe_deceleration(model, self.case.national), palette.VERMILION, "-"),
            ("A_brake_service", model.service, palette.ORANGE, "--"),
        ):
            edges = np.append(3.6 * steps.starts, max(top, 3.6 * steps.starts[-1] + 1))
            corners = np.repeat(edges, 2)[1:-1], np.repeat(steps.values, 2)
            right.plot(*corners, color=colour, ls=dash, lw=1.4, label=name)
        right.set_ylim(bottom=0)
        style.dress(right, x="speed [km/h]", y="deceleration [m/s²]")
        style.legend(right, loc="lower left")
        return drawing

    def to_pandas(self) -> "pd.DataFrame":
        """Return the location of each limit over speed: columns target, limit, speed_km_h, location_m."""
        return self.limits


def braking_curves(
    train: Path,
    national: Path | None = None,
    line: Path | None = None,
    notify: Callable[[str], None] = lambda what: None,
) -> BrakingCurves:
    """Return the braking curves of a train file or a file of curves under national values on a line.

    Args:
        train: File, or name of a train of this package.
        national: File of national values; the defaults of A.3.2 without one.
        line: File of the line; level with EoA and SvL at 0 m without one.
        notify: Receives the progress.

    Raises:
        InputError: Files are wrong, each problem in a sentence; or the brake does not slow the train down.
    """
    problems: list[str] = []
    parsed: list[Any] = []
    for read, file in ((read_train, train), (load_national, national), (load_line, line)):
        try:
            parsed.append(read(file))  # pyright: ignore[reportArgumentType] - a train is always given
        except InputError as problem:
            problems.append(str(problem))
    if problems:
        raise InputError("\n".join(problems))
    content, values, track = parsed
    if isinstance(content, TrainData):
        model, basis = model_of(content), None
    else:
        model, factors = model_of_train(content, values, notify)
        basis = content, factors
    case = BrakingCase(model, values, track)
    limited = {f"target: {target.name}": target.speed for target in track.target}
    limited["release_speed"] = track.release_speed or 0.0
    if above := [name for name, speed in limited.items() if speed >= case.ceiling]:
        rule = f"is not below the permitted speed of {3.6 * case.ceiling:g} km/h; a number without a unit is in m/s"
        raise InputError("\n".join(f"{track.name}: {name} {rule}" for name in above))
    files: list[tuple[Path | None, Any]] = [(national, values), (line, track)]
    files += [(train, content)] if basis is None else []  # `railgrip train check` gives the remarks on a train file
    remarks = [
        f"{file.name}: {words}." for file, table in files if file for words in doubts_of(table, model.maximum_speed)
    ]
    if basis is not None and data_of(basis[0]).etcs.maximum_speed is None:
        origin = "the speed of its fastest [[reference]]" if basis[0].reference else "an assumption"
        remarks.append(
            f"{model.name} has no [etcs] maximum_speed: its curves end at {3.6 * model.maximum_speed:g} km/h, {origin}."
        )
    return BrakingCurves(case, basis, tuple(remarks))
