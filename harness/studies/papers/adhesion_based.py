"""Schwarz, Posielek and Goetjes (2021): their table and figure 4 with the law as printed, beside ours."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

from railgrip.api import Scenario
from railgrip.report import palette, style
from railgrip.report.figures import draw_adhesion, draw_wheelsets
from railgrip.report.table import Table
from railgrip.simulate.run import run_stop
from railgrip.studies.papers.creep_curves import CreepCurve
from railgrip.studies.papers.lyapunov import course_of, violations
from railgrip.studies.papers.pages import Compared
from railgrip.studies.papers.schematic import arrow, box, canvas
from railgrip.studies.papers.table1 import ABC, BOUNDS, DEFAULT, EQUAL, SBC, SCENARIOS, Candidate, Fitted, stop_of
from railgrip.trace.stop import Stop

LIBRARY = Path(__file__).parent / "library"
FITS, IDENTIFIED = LIBRARY / "table1_fits.csv", LIBRARY / "table1_identified.csv"

LIMIT = 0.15
"""Adhesion that the paper allows, after the TSI."""


def distances(identified: Fitted) -> Table:
    """Return the six distances: published, identified, and their differences."""
    rows = [
        (f"{title}, {who}", *(f"{value:.1f} m" for value in values))
        for title, paper, ours in (
            ("slip-based control", SBC, identified.sbc),
            ("adhesion-based control as printed", ABC, identified.abc),
        )
        for who, values in (("paper", paper.values()), ("identified", ours.values()))
    ]
    errors = identified.errors
    rows += [
        (f"difference, {title}", *(f"{100 * error:+.1f} %".replace("-", "−") for error in part))
        for title, part in (("slip-based", errors[:3]), ("adhesion-based", errors[3:]))
    ]
    return Table.of(("", *(name.replace("_", " ") for name in SCENARIOS)), rows)


def parameters(identified: Fitted) -> Table:
    """Return what was identified, beside the published shape that the scenarios have and the bounds of the search."""
    rows = [
        (
            name,
            *(f"{_value(candidate, name):.3g}" for candidate in (identified.candidate, DEFAULT)),
            f"{low:g} – {high:g}",
        )
        for name, (low, high) in BOUNDS.items()
    ]
    rows += [
        (f"level, {name.replace('_', ' ')}", f"{identified.levels[name]:.3f}", "", "0.5 – 2.5") for name in SCENARIOS
    ]
    return Table.of(("number", "identified", "dry", "bounds"), rows)


def profile(fits: Sequence[Fitted]) -> Table:
    """Return, for quarters of the bounds of each number, the least of the largest errors of all fits in them.

    Quarters whose errors are alike are those that six distances do not tell apart.
    """
    rows: list[tuple[str, ...]] = []
    for name, (low, high) in BOUNDS.items():
        edges = np.geomspace(low, high, 5) if name != "A" else np.linspace(low, high, 5)
        cells: list[str] = []
        for begin, end in pairwise(edges):
            # Values are rounded to four digits, so that one at a bound may lie beyond it.
            inside = [fit.largest for fit in fits if begin * 0.999 <= _value(fit.candidate, name) <= end * 1.001]
            cells.append(f"{begin:.2g} – {end:.2g}: {100 * min(inside):.1f} %" if inside else "none tried")
        rows.append((name, *cells))
    return Table.of(("number", "lowest quarter", "second", "third", "highest quarter"), rows)


def alternatives(fits: Sequence[Fitted]) -> Table:
    """Return fits with errors up to twice `EQUAL`, the best first.

    Each differs from those before it in some number by a quarter of its bounds.
    """
    chosen: list[Fitted] = []
    for fit in sorted(fits, key=lambda fit: fit.largest):
        if fit.largest <= 2 * EQUAL and all(_apart(fit, other) >= 0.25 for other in chosen):
            chosen.append(fit)
    rows = [
        (*(f"{_value(fit.candidate, name):.3g}" for name in BOUNDS), f"{100 * fit.largest:.1f} %",
         " / ".join(f"{distance:.0f}" for distance in fit.abc.values()))
        for fit in chosen
    ]  # fmt: skip
    return Table.of((*BOUNDS, "largest error", "adhesion-based [m]"), rows, left=0)


def profile_figure(fits: Sequence[Fitted]) -> Figure:
    """Draw the largest error of every fit over each number."""
    drawing, panels = style.panels(10, 5.6, 2, 3, sharey=True)
    for panel, name in zip(panels.flat, BOUNDS, strict=True):
        shown = [fit for fit in fits if np.isfinite(fit.largest)]
        panel.plot(
            [_value(fit.candidate, name) for fit in shown],
            [100 * fit.largest for fit in shown],
            ".",
            color=palette.BLUE,
        )
        panel.axhline(100 * EQUAL, color=palette.GREY, linestyle="--", linewidth=1)
        style.dress(panel, x=name, y="largest error of six [%]" if panel in panels[:, 0] else "")
        panel.set_yscale("log")
        panel.set_xscale("linear" if name == "A" else "log")
    return drawing


LAWS = ("ABC, as printed", "ABC, ours")
"""Both forms of adhesion-based control."""


def stops_of(identified: Fitted) -> dict[str, Stop]:
    """Return the stops of figures 3 and 4: slip-based control on each rail, on the trapezoid both laws, too.

    "library NAME": On the rail as the scenarios of the library have it, for another creep curve.
    """
    curve, levels = identified.candidate, identified.levels
    trapezoid = {"adhesion.polach": curve.polach, "adhesion.level": levels["trapezoid"]}
    slip_based = {"controller.kind": "slip_two_state", "estimator.kind": "none"}
    scenarios = {name: stop_of(name, curve, levels[name], "sbc") for name in SCENARIOS}
    scenarios |= {f"library {name}": Scenario.load(name, slip_based) for name in SCENARIOS}
    laws = (
        stop_of("trapezoid", curve, levels["trapezoid"], "abc"),
        Scenario.load("trapezoid", trapezoid),
    )
    return {name: run_stop(scenario) for name, scenario in (scenarios | dict(zip(LAWS, laws, strict=True))).items()}


def block_diagram() -> Figure:
    """Draw plant, adhesion estimator and controller, and what each is written in (figure 2)."""
    drawing, axes = canvas(9, 3.9)
    box(
        axes,
        (0.4, 2.4),
        (2.3, 1.1),
        "controller",
        "$u = L\\,\\mathrm{sgn}(\\dot s\\,\\dot\\alpha)$ or ours\nCasADi formula as C",
    )
    box(axes, (3.5, 2.4), (2.3, 1.1), "plant", "train, contact, brakes\nModelica, FMU", "--")
    box(axes, (6.6, 2.4), (1.9, 1.1), "sensors", "noise, faults, sampling\nC")
    box(axes, (3.5, 0.35), (5.0, 1.2), "adhesion estimator", "extended Kalman filter\nC")
    axes.texts[-2].set_x(7.35)
    axes.texts[-1].set_x(7.35)
    box(axes, (3.7, 0.5), (2.3, 0.9), "prediction", "f, h, Jacobians\nModelica, FMU", "--")
    arrow(axes, (2.7, 2.95), (3.5, 2.95), "$p_{1\\ldots4}$", (3.1, 3.12))
    arrow(axes, (5.8, 2.95), (6.6, 2.95), "$y$", (6.2, 3.1))
    arrow(axes, (7.55, 2.4), (7.55, 1.55), "$v, \\omega, \\Delta z, \\dot v$", (7.65, 1.97), ha="left")
    axes.plot([3.5, 1.55], [0.95, 0.95], color=palette.BLACK, linewidth=1.3)
    arrow(axes, (1.55, 0.95), (1.55, 2.4), "$\\hat\\alpha$, $\\hat s$", (1.65, 1.6), ha="left")
    arrow(axes, (4.65, 3.85), (4.65, 3.5), "friction $\\mu_0$ of the rail", (4.75, 3.72), ha="left")
    axes.text(0.4, 0.25, "dashed: Modelica\nsolid: C, in the paper Matlab", fontsize=8.5, va="center")
    return drawing


def rail_figure(stops: Mapping[str, Stop]) -> Figure:
    """Draw maximum friction of the rails over time (figure 3)."""
    drawing, panels = style.panels(9, 6.6, len(SCENARIOS), 1, sharex=True)
    for panel, name in zip(panels, SCENARIOS, strict=True):
        trace = stops[f"library {name}"].trace
        draw_wheelsets(panel, trace["time"].values, trace["mu0"].values)
        style.dress(panel, y="maximum friction $\\mu_0$", title=name.replace("_", " "))
        panel.set_ylim(bottom=0)
    panels[0].axvline(LAST_RISE, color=palette.BLACK, linestyle="--", linewidth=1)
    panels[0].text(LAST_RISE - 0.15, 0.1, "published:\nlast rise", fontsize=8, ha="right")
    style.legend(panels[0], ncols=4, loc="lower left")
    panels[-1].set_xlabel("time since the brake demand [s]")
    panels[-1].set_xlim(0, None)
    return drawing


def adhesion_figure(stops: Mapping[str, Stop]) -> Figure:
    """Draw adhesion of the first wheelset with SBC and each law, with statements of the text (figure 4)."""
    sbc = stops["trapezoid"]
    drawing, panels = style.panels(9, 6, len(LAWS), 1, sharex=True, sharey=True)
    for panel, law in zip(panels, LAWS, strict=True):
        draw_adhesion(panel, {"SBC": sbc.trace, law: stops[law].trace}, LIMIT)
        for begin, end, place, words in (
            (*COUPLED, COUPLED[0] + 0.15, "published: below the greatest"),
            (LAST_RISE, 40, LAST_RISE + 2.0, "published:\nchattering"),
        ):
            panel.axvspan(begin, end, color=palette.SKY, alpha=0.2, linewidth=0)
            panel.text(place, 0.008, words, fontsize=8)
        ours, slip_based = (stop.metrics.distance for stop in (stops[law], sbc))
        style.dress(panel, y="adhesion of wheelset 1", title=f"{law}: {ours:.1f} m; SBC: {slip_based:.1f} m")
        panel.set_ylim(0, 0.24)
        style.legend(panel, ncols=3, loc="upper left")
    panels[-1].set_xlabel("time since the brake demand [s]")
    return drawing


COUPLED, LAST_RISE = (9.0, 16.0), 25.0
"""When adhesion is below the greatest possible, and when friction rises last, after the text of the paper [s]."""


def measures(stops: Mapping[str, Stop], lines: Sequence[CreepCurve]) -> dict[str, Any]:
    """Return what is measured in our figures, by name; the table of the page is made of it.

    `minima`: of friction, by stop and wheelset; `maxima`: slips, by creep curve; `rise`: when friction begins its last
    rise [s]; `violations`: see `lyapunov`. By stop of figure 4: `duration` [s]; `used`: adhesion over the greatest
    possible up to the limit, means before, in and after `COUPLED`; `chatter`: rms deviation of adhesion from its mean
    over 0.2 s, before and after `LAST_RISE`.
    """
    rail = stops["trapezoid"].trace
    mu0, time = rail["mu0"].values[:, 0], rail["time"].values
    before = time < 26.0
    found: dict[str, Any] = {
        "minima": {
            name: stop.trace["mu0"].values.min(axis=0).tolist() for name, stop in stops.items() if name not in LAWS
        },
        "maxima": {line.label: [slip for slip, _ in line.maxima] for line in lines},
        "rise": float(time[before][np.flatnonzero(np.diff(mu0[before]) <= 0)[-1] + 1]),
        "violations": violations({law: course_of(stops[law]) for law in LAWS}),
    }
    for name in ("trapezoid", *LAWS):
        found[name] = _course_of_adhesion(stops[name])
    return found


def _course_of_adhesion(stop: Stop) -> dict[str, Any]:
    """Return duration, used adhesion and chatter of a stop; see `measures`."""
    trace = stop.trace
    time, adhesion, greatest = trace["time"].values, trace["adhesion"].values[:, 0], trace["peak_adhesion"].values[:, 0]
    window = round(0.2 / float(time[1] - time[0]))
    deviation = adhesion - uniform_filter1d(adhesion, window)
    used = adhesion / np.minimum(greatest, LIMIT)
    parts = {"before": time < COUPLED[0], "coupled": (time >= COUPLED[0]) & (time < COUPLED[1])}
    parts["after"] = (time >= COUPLED[1]) & (time < LAST_RISE)
    return {
        "duration": stop.metrics.duration,
        "used": {name: float(np.mean(used[there])) for name, there in parts.items()},
        "chatter": [float(np.sqrt(np.mean(deviation[there] ** 2))) for there in (time < LAST_RISE, time >= LAST_RISE)],
    }


def compared(identified: Fitted, found: Mapping[str, Any]) -> list[Compared]:
    """Return the published quantities beside ours; `found` are `measures`."""
    rows = [
        Compared("Fig. 1", f"slip of maxima, {name}", "two distinct maxima, no numbers",
                 ", ".join(f"{100 * slip:.1f} %" for slip in slips))
        for name, slips in found["maxima"].items()
    ]  # fmt: skip
    rows += [
        Compared("Fig. 3", f"minimum of μ0 from front to rear, {_rail(name)}", "rises",
                 f"{minima[0]:.3f} to {minima[-1]:.3f}", difference="" if minima[-1] > minima[0] else "does not rise")
        for name, minima in found["minima"].items()
    ]  # fmt: skip
    rows += [
        Compared("Table 1", f"{title}, {_rail(name)}", paper[name], ours[name], "{:.1f} m")
        for title, paper, ours in (("SBC", SBC, identified.sbc), ("ABC as printed", ABC, identified.abc))
        for name in SCENARIOS
    ]
    rows.append(Compared("Fig. 4", "begin of the last rise of μ0", LAST_RISE, found["rise"], "{:.1f} s"))
    for law in LAWS:
        course, longer = found[law], found["trapezoid"]["duration"] - found[law]["duration"]
        rows += [
            Compared("Fig. 4", f"{law}: SBC takes longer by", 2.0, longer, "{:.1f} s"),
            Compared("Fig. 4", f"{law}: adhesion over the greatest possible, before / in / after {COUPLED[0]:g} to "
                     f"{COUPLED[1]:g} s", "very close / suboptimal / very close",
                     " / ".join(f"{100 * used:.0f} %" for used in course["used"].values())),
            Compared("Fig. 4", f"{law}: rms of fast changes of adhesion, before / after {LAST_RISE:g} s",
                     "significant chattering after 25 s",
                     " / ".join(f"{deviation:.4f}" for deviation in course["chatter"])),
        ]  # fmt: skip
    return rows


def _rail(name: str) -> str:
    """Return the name of a rail of `stops_of` for people."""
    library, _, shape = name.rpartition("library ")
    level = "library" if shape != name else "identified level"
    return f"{library}{shape.replace('_', ' ')}, {level}"


def _value(candidate: Candidate, name: str) -> float:
    return candidate.k_S / candidate.k_A if name == "k_S/k_A" else float(getattr(candidate, name))


def _apart(fit: Fitted, other: Fitted) -> float:
    """Return the greatest distance of two fits in a number, as a share of its bounds."""
    shares: list[float] = []
    for name, (low, high) in BOUNDS.items():
        first, second = _value(fit.candidate, name), _value(other.candidate, name)
        shares.append(
            abs(first - second) / (high - low) if name == "A" else abs(np.log(first / second) / np.log(high / low))
        )
    return max(shares)
