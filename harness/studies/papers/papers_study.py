"""Schwarz, Posielek and Goetjes (2021): table and figures, published and reproduced with the law as printed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from matplotlib.figure import Figure
from typer import Option

from railgrip.api import Scenario
from railgrip.campaign.work import Work, call
from railgrip.report import palette, style
from railgrip.report.figures import draw_adhesion, draw_wheelsets
from railgrip.report.page import Page
from railgrip.report.stop import Stop
from railgrip.report.table import ReportTable
from railgrip.simulate.run import run_stop
from railgrip.studies.papers.courses import (
    COUPLED,
    LAST_RISE,
    LIMIT,
    LOCK_SPEED,
    course_of,
    course_of_adhesion,
    offset_of,
    offset_table,
    used_by_wheelset,
    used_table,
    violations,
    violations_table,
    wheelset_figure,
)
from railgrip.studies.papers.creep_curves import CreepCurve, causes, figure_1, rails
from railgrip.studies.papers.pages import PaperRow, arrow, box, canvas, comparison, write_results
from railgrip.studies.papers.table1 import (
    ABC,
    ADHESION_SMALL,
    BOUNDS,
    CHATTERING,
    CLOSE,
    DEFAULT,
    FINAL,
    HOLDS,
    LOAD,
    LOCK,
    LONGER,
    LOW,
    OVER,
    REQUIRED,
    SAVING,
    SBC,
    SCENARIOS,
    SIMILAR,
    SLIPS,
    SPEED,
    SUBOPTIMAL,
    CandidateFit,
    creep_curve,
    is_suboptimal,
    mean_friction,
    point_of,
    pressures_of,
    rail_of,
    read_fits,
    refine,
    repeat,
    search,
    share_of,
    stop_of,
    value_of,
    write_fits,
)
from railgrip.studies.study import Study

LIBRARY = Path(__file__).parent / "library"
FITS, IDENTIFIED = LIBRARY / "table1_fits.csv", LIBRARY / "table1_identified.csv"


def distances(identified: CandidateFit, found: Mapping[str, Any]) -> ReportTable:
    """Return the six distances: published, identified with range and locks of the repeats, and their differences.

    `found` are `measures`.
    """
    repeats = [found["repeats"][name] for name in SCENARIOS]
    metres = [sorted(course["distance"] for course in courses) for courses in repeats]
    locks = [[course["lock"] for course in courses] for courses in repeats]
    rows = [
        ("slip-based control, paper", *(f"{value:.1f} m" for value in SBC.values())),
        ("slip-based control, identified", *(f"{value:.1f} m" for value in identified.sbc.values())),
        ("ABC (paper), paper", *(f"{value:.1f} m" for value in ABC.values())),
        ("ABC (paper), identified: median of repeats", *(f"{value:.1f} m" for value in identified.abc.values())),
        ("range", *(f"{one[0]:.1f} – {one[-1]:.1f} m" for one in metres)),
        (f"a wheelset locks above {LOCK_SPEED:g} m/s for longer than {LOCK:g} s",
         *(f"{sum(lock > LOCK for lock in one)} of {len(one)}, longest {max(one):.1f} s" for one in locks)),
    ]  # fmt: skip
    errors = identified.errors
    rows += [
        (f"difference, {title}", *(_format_signed(100 * error) for error in part))
        for title, part in (("slip-based", errors[:3]), ("ABC (paper)", errors[3:]))
    ]
    return ReportTable.of(("", *(name.replace("_", " ") for name in SCENARIOS)), rows)


_AT_BOUND: Final = 0.02
"""Share of the bounds within which a searched number counts as at its bound."""


def parameters(identified: CandidateFit) -> ReportTable:
    """Return the free numbers, next to those of the library's scenarios and the bounds of the search."""
    point = dict(zip(BOUNDS, point_of(identified.candidate), strict=True))
    rows = [
        (
            name,
            *(f"{value_of(candidate, name):.3g}" for candidate in (identified.candidate, DEFAULT)),
            f"{low:.3g} – {high:.3g}",
            "" if _AT_BOUND < point[name] < 1 - _AT_BOUND else "at its bound",
        )
        for name, (low, high) in BOUNDS.items()
    ]
    rows += [
        (f"level, {name.replace('_', ' ')}", f"{identified.levels[name]:.3f}", "", "0.5 – 2.5", "solved for")
        for name in SCENARIOS
    ]
    return ReportTable.of(("number", "identified", "library", "bounds", "remark"), rows)


def choices(identified: CandidateFit) -> ReportTable:
    """Return every other quantity on which the six distances depend and that the paper does not give.

    They are read from the scenarios: changes there appear here.
    """
    rows: list[tuple[str, str]] = []
    for name in SCENARIOS:
        scenario = stop_of(name, identified.candidate, identified.levels[name], "sbc")
        adhesion = dict(scenario.resolved()["adhesion"])
        conditioning = adhesion.pop("conditioning")
        course: dict[str, Any] = {
            key: value for key, value in adhesion.items() if key not in _NOT_CHOSEN and value is not None
        }
        if name == "trapezoid":
            course = {"low": f"{LOW:g}", "falls begin at": "4, 12 and 20 s", "rises at": "9, 17 and 25 s"}
        course |= {f"conditioning {key}": value for key, value in conditioning.items()}
        course["seed"] = scenario.seed
        rows.append(
            (
                f"friction over time, {name.replace('_', ' ')}",
                ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in course.items()),
            )
        )
    scenario = Scenario.load("trapezoid")
    periods, limits = scenario.periods, scenario.limits
    rows += [
        ("lag of the cylinder pressure", "20 ms (plant parameter T_pressure)"),
        ("periods of loop, filter and law", " / ".join(f"{1e3 * period:g} ms" for period in
         (periods.communication, periods.estimator, periods.controller))),
        ("end of the stop", f"{limits.stop_speed:g} m/s"),
        ("sensors", "exact"),
        ("noises of the filter", "set 'ideal' of TrainPrediction"),
        ("adhesion_small of the law", f"{ADHESION_SMALL:g}"),
        ("guards of the law", "rolling and hold, see the validation page; not the one below 0.5 m/s"),
        ("train", "masses, inertias, suspension and running resistance of TwoPartTrain"),
        ("highest cylinder pressures", " / ".join(f"{pressure / 1e5:.2f} bar" for pressure in
         pressures_of(identified.candidate.brake)) + ", from the brake of the table above"),
        ("pad friction", "first-order law of this project, not that of Ehret (2021)"),
        ("slip-based control", "releases above 15 %, applies below 10 %, at once in each period"),
        ("second and later wheelsets", "the friction of the first one at the same time, conditioned"),
    ]  # fmt: skip
    return ReportTable.of(("quantity", "chosen"), rows, left=2)


_NOT_CHOSEN: Final = frozenset(
    {"kind", "polach", "polach_of_wheelset", "level", "calibrated", "over", "patch", "deviation"}
)
"""Keys of [adhesion] that are free numbers of the fit, or that the scenarios do not use."""


def _format_signed(share: float) -> str:
    return f"{share:+.1f} %".replace("-", "−")


def curve_figure(identified: CandidateFit) -> Figure:
    """Draw the identified creep curve and the dry one at the mean friction of the trapezoid."""
    drawing, panel = style.panels(8, 3.8)
    friction = mean_friction(identified.candidate, identified.levels["trapezoid"])
    for candidate, color, name, below in (
        (identified.candidate, palette.BLUE, "identified", 0),
        (DEFAULT, palette.GREY, "dry, library", 1),
    ):
        curve = creep_curve(candidate, friction)
        best, share = int(np.argmax(curve)), share_of(candidate, friction)
        panel.plot(100 * SLIPS, curve, color=color, label=f"{name}, μ0 = {friction:.3f}")
        for slip, adhesion, words, offset in (
            (SLIPS[best], curve[best], f"{name}: {100 * SLIPS[best]:.1f} %", (10, 12 if below else 1)),
            (0.15, share * curve[best], f"{100 * share:.0f} % of the greatest", (6, -24 if below else 6)),
        ):
            panel.plot(100 * slip, adhesion, "o", color=color)
            panel.annotate(
                words, (100 * slip, adhesion), xytext=offset, textcoords="offset points", fontsize=8, color=color
            )
    panel.axvspan(10, 15, color=palette.ORANGE, alpha=0.25, linewidth=0, label="slip-based control")
    style.dress(
        panel, x="slip [%]", y="adhesion",
        title=f"creep curves at {SPEED * style.KMH:.0f} km/h and {LOAD / 1e3:.0f} kN, mean friction of the trapezoid",
    )  # fmt: skip
    panel.set_xlim(0, 50)
    panel.set_ylim(0, 1.1 * friction)
    style.legend(panel, loc="upper right")
    return drawing


def sentences(identified: CandidateFit, found: Mapping[str, Any]) -> ReportTable:
    """Return the statements of the paper about its results, whether the search required them, and how often they hold.

    `found` are `measures`. Statements about the trapezoid are judged in each of its repeats; the numbers are medians.
    """
    repeats, sbc = found["repeats"]["trapezoid"], found["trapezoid"]
    rises = {name: found["minima"][name] for name in SCENARIOS}
    chosen, searched, implied, free = "chosen", "required", "follows", "not required"

    def median(name: str) -> float:
        return float(np.median([course[name] for course in repeats]))

    def used(course: Mapping[str, float]) -> float:
        return float(np.mean([course[f"used_{part}"] for part in sbc["used"]]))

    slip_based = float(np.mean(list(sbc["used"].values())))
    parts = " / ".join(f"{100 * median(f'used_{part}'):.0f} %" for part in sbc["used"])
    of_stops: list[tuple[str, str, str, Callable[[Mapping[str, float]], bool]]] = [
        (f"adhesion very close to the greatest possible (at least {100 * CLOSE:.0f} %) before 9 s and after 16 s",
         searched, f"{parts} before / in / after", REQUIRED["close"]),
        (f"suboptimal from 9 to 16 s (by at least {100 * SUBOPTIMAL:.0f} %)", free, f"{parts}", is_suboptimal),
        (f"no wheelset locks above {LOCK_SPEED:g} m/s (for longer than {LOCK:g} s)", searched,
         f"longest lock {median('lock'):.2f} s", REQUIRED["unlocked"]),
        (f"strict adherence to the limit of {LIMIT:g} (at most {OVER:g} s above)", searched,
         f"{median('over'):.2f} s above, greatest adhesion {median('peak'):.3f}", REQUIRED["limited"]),
        ("the limit becomes active after the last rise of μ0", searched,
         f"greatest adhesion {median('peak'):.3f}", REQUIRED["active"]),
        (f"significant chattering after 25 s (at least {CHATTERING:g} times that before)", searched,
         f"{median('chatter_before'):.4f} before, {median('chatter_after'):.4f} after", REQUIRED["chattering"]),
        (f"SBC takes approximately 2 s longer ({LONGER[0]:g} to {LONGER[1]:g} s)", searched,
         f"{median('longer'):.2f} s", REQUIRED["longer"]),
        ("SBC has considerably lower adhesion than ABC (by at least 5 %)", implied,
         f"{100 * slip_based:.0f} % against {100 * float(np.median([*map(used, repeats)])):.0f} %",
         lambda course: used(course) - slip_based >= 0.05),
        (f"other wheelsets are qualitatively similar (at least {100 * SIMILAR:.0f} % used by each group)", searched,
         f"{100 * median('lowest_group'):.0f} % in the lowest group", REQUIRED["similar"]),
    ]  # fmt: skip
    once = [
        ("minimum of μ0 rises from front to rear in all scenarios", chosen,
         ", ".join(f"{minima[0]:.3f} to {minima[-1]:.3f}" for minima in rises.values()),
         all(minima[-1] > minima[0] for minima in rises.values())),
        ("ABC saves at least 8.8 %, by medians", implied,
         " / ".join(f"{100 * saving:.1f} %" for saving in identified.savings), min(identified.savings) >= SAVING),
    ]  # fmt: skip
    rows = [(*row, "yes" if holds else "no") for *row, holds in once]
    rows += [(*row, f"{sum(map(holds, repeats))} of {len(repeats)}") for *row, holds in of_stops]
    return ReportTable.of(("sentence", "in the search", "here", "holds in"), rows, left=3)


def alternatives(fits: Sequence[CandidateFit], count: int = 8) -> ReportTable:
    """Return the best fits of the search: their numbers and distances, and the required sentences that fail.

    A sentence fails if it does not hold in most of the repeats; the best comes first.
    """
    rows = [
        (*(f"{value_of(fit.candidate, name):.3g}" for name in BOUNDS), f"{100 * fit.largest:.1f} %",
         " / ".join(f"{distance:.0f}" for distance in fit.abc.values()),
         ", ".join(name for name in REQUIRED if fit.holds[name] < HOLDS) or "none")
        for fit in sorted(fits, key=lambda fit: fit.cost)[:count]
    ]  # fmt: skip
    return ReportTable.of((*BOUNDS, "largest error", "ABC (paper) [m]", "sentences that fail"), rows, left=0)


LAWS = ("ABC (paper)", "peak seeking (railgrip)")
"""Both forms of adhesion-based control."""


def median_seed(repeats: Sequence[Mapping[str, float]]) -> int:
    """Return the seed of the repeat with the median distance: repeat 1 has the seed 1."""
    order = np.argsort([course["distance"] for course in repeats], kind="stable")
    return int(order[len(order) // 2]) + 1


def stops_of(identified: CandidateFit, seed: int) -> dict[str, Stop]:
    """Return the stops of figures 3 and 4: slip-based control on each rail, on the trapezoid both laws, too.

    The stop with the law as printed is that of a seed.

    "library NAME": the rail of the library's scenarios, with another creep curve.
    """
    curve, levels = identified.candidate, identified.levels
    slip_based = {"controller.kind": "slip_two_state", "estimator.kind": "none"}
    scenarios = {name: stop_of(name, curve, levels[name], "sbc") for name in SCENARIOS}
    scenarios |= {f"library {name}": Scenario.load(name, slip_based) for name in SCENARIOS}
    laws = (
        stop_of("trapezoid", curve, levels["trapezoid"], "abc", seed),
        Scenario.load("trapezoid", rail_of("trapezoid", curve, levels["trapezoid"])),
    )
    return {name: run_stop(scenario) for name, scenario in (scenarios | dict(zip(LAWS, laws, strict=True))).items()}


def block_diagram() -> Figure:
    """Draw plant, adhesion estimator and controller, and the language of each (figure 2)."""
    drawing, axes = canvas(9, 3.9)
    law = "$u = L\\,\\mathrm{sgn}(\\dot s\\,\\dot\\alpha)$ or own\nCasADi formula as C"
    box(axes, (0.4, 2.4), (2.3, 1.1), "controller", law)
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
        style.dress(panel, y="maximum friction μ₀", title=name.replace("_", " "))
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
            (LAST_RISE, 40, LAST_RISE + 3.1, "published:\nchattering"),
        ):
            panel.axvspan(begin, end, color=palette.SKY, alpha=0.2, linewidth=0)
            panel.text(place, 0.008, words, fontsize=8)
        ours, slip_based = (stop.metrics.distance for stop in (stops[law], sbc))
        style.dress(panel, y="adhesion of wheelset 1", title=f"{law}: {ours:.1f} m; SBC: {slip_based:.1f} m")
        panel.set_ylim(0, 0.24)
        style.legend(panel, ncols=3, loc="upper left")
    panels[-1].set_xlabel("time since the brake demand [s]")
    return drawing


def measures(stops: Mapping[str, Stop], lines: Sequence[CreepCurve]) -> dict[str, Any]:
    """Return the numbers measured in the reproduced figures, by name, from which the table of the page is made.

    `minima`: of friction, by stop and wheelset; `maxima`: slips, by creep curve; `rise`: when friction begins its last
    rise [s]; `violations`, `offsets`: see `lyapunov`. By stop of figure 4 the numbers of `course_of_adhesion`.
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
        "offsets": {law: offset_of(stops[law]) for law in LAWS},
    }
    for name in ("trapezoid", *LAWS):
        found[name] = course_of_adhesion(stops[name])
    return found


def compare_with_paper(identified: CandidateFit, found: Mapping[str, Any]) -> list[PaperRow]:
    """Return published and reproduced quantities; `found` are `measures`. The levels are solved for SBC."""
    rows = [
        PaperRow("Fig. 1", f"slip of maxima, {name}", "two distinct maxima, no numbers",
                 ", ".join(f"{100 * slip:.1f} %" for slip in slips))
        for name, slips in found["maxima"].items()
    ]  # fmt: skip
    rows += [
        PaperRow("Fig. 3", f"minimum of μ0 from front to rear, {_rail(name)}", "rises",
                 f"{minima[0]:.3f} to {minima[-1]:.3f}", difference="" if minima[-1] > minima[0] else "does not rise")
        for name, minima in found["minima"].items()
    ]  # fmt: skip
    rows += [
        PaperRow("Table 1", f"SBC, {_rail(name)}", SBC[name], identified.sbc[name], "{:.1f} m", is_chosen=True)
        for name in SCENARIOS
    ]
    rows += [
        PaperRow("Table 1", f"ABC (paper), {_rail(name)}", ABC[name], identified.abc[name], "{:.1f} m",
                 f"{_format_signed(100 * (identified.abc[name] / ABC[name] - 1))}, fitted; {_range(found, name)}")
        for name in SCENARIOS
    ]  # fmt: skip
    rows.append(
        PaperRow("Fig. 4", "begin of the last rise of μ0", LAST_RISE, found["rise"], "{:.1f} s", is_chosen=True)
    )
    for law in LAWS:
        course, longer = found[law], found["trapezoid"]["duration"] - found[law]["duration"]
        rows += [
            PaperRow("Fig. 4", f"{law}: SBC takes longer by", 2.0, longer, "{:.1f} s"),
            PaperRow("Fig. 4", f"{law}: adhesion over the greatest possible, before / in / after {COUPLED[0]:g} to "
                     f"{COUPLED[1]:g} s", "very close / suboptimal / very close",
                     " / ".join(f"{100 * used:.0f} %" for used in course["used"].values())),
            PaperRow("Fig. 4", f"{law}: rms of fast changes of adhesion, before / after {LAST_RISE:g} s",
                     "significant chattering after 25 s",
                     " / ".join(f"{deviation:.4f}" for deviation in course["chatter"])),
        ]  # fmt: skip
    return rows


def _range(found: Mapping[str, Any], name: str) -> str:
    metres, locks = zip(*((course["distance"], course["lock"]) for course in found["repeats"][name]), strict=True)
    return f"{min(metres):.1f} – {max(metres):.1f} m, longest lock {max(locks):.1f} s"


def _rail(name: str) -> str:
    library, _, shape = name.rpartition("library ")
    level = "library" if shape != name else "identified level"
    return f"{library}{shape.replace('_', ' ')}, {level}"


PAGE = "adhesion_based.md"


def tables_of(
    fits: Sequence[CandidateFit], identified: CandidateFit, found: Mapping[str, Any]
) -> dict[str, ReportTable]:
    """Return the tables of the page on adhesion-based control by name; `found` are `measures` of the figures."""
    return {
        "published": comparison(compare_with_paper(identified, found)),
        "sentences": sentences(identified, found),
        "distances": distances(identified, found),
        "parameters": parameters(identified),
        "choices": choices(identified),
        "alternatives": alternatives(fits),
        "lyapunov": violations_table(found["violations"]),
        "offset": offset_table(found["offsets"]),
        "wheelsets": used_table(found["used_by_wheelset"]),
    }


@dataclass(frozen=True)
class Papers(Study, quick="one repeat of the law as printed on each rail", whole=("fit",)):
    """Draw figures and tables of the paper on adhesion-based control, with its Table 1 identified."""

    fit: Annotated[
        bool, Option("--fit", help="Go on with the search for the fit of Table 1 (a quarter of an hour of a core).")
    ] = False
    write: Annotated[
        bool,
        Option("--write", help="Keep the fit in the study's library, and write its numbers into docs/papers."),
    ] = False

    def page(self, work: Work) -> Page:
        """Return figures and tables of the paper."""
        known = read_fits(FITS)
        fits = search(work, known[:KNOWN]) if self.fit else known
        identified = refine(work, fits) if self.fit else read_fits(IDENTIFIED)[0]
        work.notify("figures")
        count = 1 if self.quick else FINAL["abc"]
        cases = [partial(repeat, name, identified.candidate, identified.levels[name], count) for name in SCENARIOS]
        repeats = dict(zip(SCENARIOS, work.map(call, cases), strict=True))
        of_causes, of_rails = causes(), rails()
        stops = stops_of(identified, median_seed(repeats["trapezoid"]))
        drawn = {"SBC": stops["trapezoid"], **{law: stops[law] for law in LAWS}}
        found = measures(stops, of_rails) | {"repeats": repeats}
        found["used_by_wheelset"] = {law: used_by_wheelset(stop, LIMIT) for law, stop in drawn.items()}
        tables = tables_of(fits, identified, found)
        figures = {
            "adhesion_based_4.png": adhesion_figure(stops),
            "adhesion_based_4_others.png": wheelset_figure(stops["trapezoid"], stops[LAWS[0]], LAWS[0], LIMIT),
            "adhesion_based_1.svg": figure_1(of_causes, of_rails),
            "adhesion_based_3.png": rail_figure(stops),
            "adhesion_based_curve.svg": curve_figure(identified),
        }
        if self.write:
            write_fits(FITS, fits)
            write_fits(IDENTIFIED, [identified])
            diagram = {"adhesion_based_2.svg": block_diagram()}
            write_results(PAGE, tables, figures | diagram, found)
        return Page(
            title="Adhesion-based control: published figures and those of railgrip",
            question="Which creep curve, friction and parameters of the printed law reproduce Table 1 of the paper?",
            answer=f"The numbers below reproduce all six distances within {100 * identified.largest:.1f} %; they are "
            f"the best of {len(fits)} fits. Other values do so within a few percent: six distances do not determine "
            f"{len(BOUNDS) + len(SCENARIOS)} numbers.",
            template="studies/papers/papers.md.jinja",
            values=tables,
            figures=figures,
            screen=(tables["published"], tables["sentences"], tables["lyapunov"], tables["alternatives"]),
        )


KNOWN = 8
"""Best fits of the last search, from which a new one continues."""

STUDY = Papers
