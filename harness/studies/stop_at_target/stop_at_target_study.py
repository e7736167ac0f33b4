"""Error of the stopping point over draws of rail, load, gradient, pads and faults, for three ways to stop."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import pandas
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.stats.qmc import LatinHypercube
from typer import Option

from railgrip.base.registry import shelf
from railgrip.base.tables import TomlTable
from railgrip.campaign.searches import evolve, parameters_of
from railgrip.campaign.work import Work
from railgrip.report import palette, style
from railgrip.report.baseline import Finding
from railgrip.report.frame import Frame
from railgrip.report.page import Page
from railgrip.report.statistics import bootstrap_interval, draws_for_interval, on_common
from railgrip.report.table import ReportTable, bulleted, with_interval
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import trace_of
from railgrip.studies.study import Study
from railgrip.studies.type_test.design import FAULTS, at

LIBRARY = Path(__file__).parent / "library"

DRAWS, HEADLINE = 500, 3
SETS, TRAINING = 16, 12
"""Sets of parameters that are tried for each system, and draws of the training on which they are compared."""
_POPULATION = 5
"""The smallest that differential evolution takes."""
TRAINING_SEED, TEST_SEED = 7021, 25595

DECELERATION = 0.6
"""Deceleration of the curve to the target [m/s2], the same for all systems."""
FAR = 5.0
"""Error [m] from which a stop counts as short or long."""
GROUPS = 4

RAILS: Final = {"good": (0.25, 0.5), "slippery": (0.04, 0.15)}
"""Kind of rail → range of its mean friction, of which the logarithm is even.

Below 0.04 not even magnets and the rail together reach the deceleration of the curve."""
SLIPPERY = 0.8
"""Share of draws on a slippery rail."""
CURVES: Final = ("wet", "low", "leaf", "poor_wheelset_study")


SYSTEMS: Final[TomlTable] = read_toml(LIBRARY / "systems.toml")
"""Ways to stop at a target: table `controller`, and `ranges` in which its parameters are searched."""
MANAGED: Final = "with adhesion management"


@dataclass(frozen=True, slots=True, kw_only=True)
class Draw:
    """Conditions of one stop, the same for all systems.

    Attributes:
        rail: Key of `RAILS`.
        curve: Creep curve.
        friction: Mean of the maximum friction.
        correlation: Length over which it varies [m].
        patch: Begin [m], length [m] and friction of a worse stretch.
        speed: At the start [m/s].
        ahead: Distance from the start to the begin of the curve to the target [m].
        load, pads: Factors on mass and pad friction.
        gradient: Slope, positive uphill.
        fault: Key of `railgrip.studies.type_test.design.FAULTS`.
        group: Group with the fault, from 1 on.
        seed: Seed of sensors and rail.
    """

    rail: str
    curve: str
    friction: float
    correlation: float
    patch: tuple[float, float, float]
    speed: float
    ahead: float
    load: float
    pads: float
    gradient: float
    fault: str
    group: int
    seed: int

    @property
    def target(self) -> float:
        """Distance of the target from the start [m]."""
        return self.ahead + 0.5 * self.speed**2 / DECELERATION


def draws_of(count: int, seed: int) -> list[Draw]:
    """Return draws by Latin hypercube sampling; half of them have a fault."""
    points = LatinHypercube(14, rng=np.random.default_rng(seed)).random(count)
    return [_draw(point, seed + number) for number, point in enumerate(points)]


def _draw(u: NDArray[np.float64], seed: int) -> Draw:
    rail = "slippery" if u[0] < SLIPPERY else "good"
    friction, speed, ahead = _log(u[1], *RAILS[rail]), _even(u[2], 60 / 3.6, 100 / 3.6), _even(u[3], 20.0, 80.0)
    length = ahead + 0.5 * speed**2 / DECELERATION
    faults = [name for name in FAULTS if name != "none"]
    return Draw(
        rail=rail, curve=at(CURVES, u[4]), friction=friction, correlation=_log(u[5], 5.0, 100.0),
        patch=(_even(u[6], 0.0, length), _log(u[7], 20.0, 150.0), friction * _even(u[8], 0.5, 0.9)),
        speed=speed, ahead=ahead, load=_even(u[9], 0.95, 1.25), pads=_even(u[10], 0.85, 1.15),
        gradient=_even(u[11], -0.015, 0.015), fault=at(faults, 2.0 * u[12] % 1.0) if u[12] < 0.5 else "none",
        group=1 + int(GROUPS * u[13]), seed=seed,
    )  # fmt: skip


def _even(u: float, low: float, high: float) -> float:
    return float(low + u * (high - low))


def _log(u: float, low: float, high: float) -> float:
    return float(low * (high / low) ** u)


Case = tuple[str, Mapping[str, float], Draw, bool]
"""System, values of its parameters, draw, whether the train has magnets."""


@cache
def _base() -> TomlTable:
    table = dict(read_toml(shelf("equipment")["service"]))
    del table["vehicle"]
    return merge(table, read_toml(LIBRARY / "stop.toml"))


def scenario_of_case(case: Case) -> Scenario:
    """Return the stop of a case."""
    system, values, draw, has_magnets = case
    begin, length, friction = draw.patch
    own = {name: value for name, value in values.items() if name != "full_deceleration"}
    aim = {
        "distance": draw.target,
        "deceleration": DECELERATION,
        "full_deceleration": values.get("full_deceleration", 1.1),
    }
    faults = [{**row, "group": draw.group} if "group" in row else row for row in FAULTS[draw.fault].get("faults", ())]
    changes: TomlTable = {
        "seed": draw.seed,
        "start": {"speed": draw.speed},
        "adhesion": {
            "polach": draw.curve, "mean": draw.friction, "deviation": 0.3 * draw.friction,
            "minimum": 0.4 * draw.friction, "maximum": min(2.0 * draw.friction, 0.9), "correlation": draw.correlation,
            "patch": [{"begin": begin, "length": length, "mu0": friction, "edge": 1.0}],
        },
        "demand": {"phases": [{"stop_at": aim}]},
        "controller": merge(dict(SYSTEMS[system]["controller"]), {"parameters": own}),
        "truth": {"load": draw.load, "pad_friction": draw.pads, "gradient": draw.gradient},
        "faults": faults,
        **({} if has_magnets else {"vehicle": {"train": "vt642"}}),
    }  # fmt: skip
    return scenario_of(merge(dict(_base()), changes), directory=LIBRARY, origin="stop.toml")


def stop_row(case: Case) -> dict[str, float]:
    """Return the figures of a stop in SI units: error of the stopping point, duration, sand, air, time of magnets."""
    scenario = scenario_of_case(case)
    trace = trace_of(scenario)
    step = np.diff(trace["time"].values, append=trace["time"].values[-1])
    braked = np.maximum.accumulate(trace["driver_demand"].values.max(axis=1) > 0.0)
    on = trace["law_sand"].values > 0.5 if "law_sand" in trace else braked
    (sander,) = scenario.sanders
    rate = np.minimum(sander.rate, (sander.density or np.inf) * trace["speed"].values)
    magnets = trace["magnets"].values if "magnets" in trace else np.zeros(step.size)
    return {
        "error": float(trace["distance"].values[-1]) - case[2].target,
        "duration": float(trace["time"].values[-1]),
        "sand": float(2.0 * (rate * on * step).sum()),
        "air": float(trace["air_used"].values[-1]),
        "magnets": float((magnets * step).sum()),
    }


def objective(errors: Iterable[float]) -> float:
    """Return the mean of ln(1 + |e|/0.1 m): metres count on good rails, and no single overrun decides."""
    return float(np.mean(np.log1p(np.abs(np.array(list(errors))) / 0.1)))


def search(system: str, work: Work, sets: int) -> dict[str, float]:
    """Return the best of a number of sets of parameters of a system on the draws of the training; none for 0 sets."""
    if not sets:
        return {}
    draws = draws_of(TRAINING, TRAINING_SEED)
    ranges = SYSTEMS[system]["ranges"]

    def objectives(points: Iterable[NDArray[np.float64]]) -> list[float]:
        values = [parameters_of(tuple(ranges), point) for point in points]
        rows = work.map(stop_row, [(system, one, draw, True) for one in values for draw in draws])
        errors = [row["error"] for row in rows]
        count = len(draws)
        return [objective(errors[i * count : (i + 1) * count]) for i in range(len(values))]

    return parameters_of(tuple(ranges), evolve(objectives, ranges, (max(sets // 2, _POPULATION), 1)))


def frame_of(
    systems: Mapping[str, Mapping[str, float]], draws: Sequence[Draw], work: Work, *, has_magnets: bool
) -> Frame:
    """Return a row for each system and draw: `system`, `rail`, `draw`, `fault`, and the figures of `stop_row`."""
    cases = [(system, values, draw, has_magnets) for system, values in systems.items() for draw in draws]
    rows = work.map(stop_row, cases)
    keys = [{"system": case[0], "rail": case[2].rail, "draw": case[2].seed, "fault": case[2].fault} for case in cases]
    return pandas.DataFrame([key | row for key, row in zip(keys, rows, strict=True)])


def table_of(frame: Frame, title: str) -> ReportTable:
    """Return quantiles of the error, shares of short and long stops, and means of sand and air, by rail and system."""
    rows: list[tuple[str | float | None, ...]] = []
    for (rail, system), here in on_common(frame, "system", ["rail", "draw", "fault"], "error").groupby(
        ["rail", "system"], sort=False
    ):
        error, count = here["error"].to_numpy(), len(here)
        # A quantile needs a draw beyond it.
        quantiles = (
            np.quantile(np.abs(error), share / 100) if count * (100 - share) >= 100 else None for share in (50, 95, 99)
        )
        farthest, shares = error[np.argmax(np.abs(error))], ((error > FAR).mean(), (error < -FAR).mean())
        means = (here[name].mean() for name in ("duration", "sand", "air", "magnets"))
        rows.append((rail, system, count, *quantiles, farthest, *shares, *means))
    rows.sort(key=lambda row: list(RAILS).index(str(row[0])))
    return ReportTable.of(_FORMS, rows, left=2, title=title)


def ratio_of(frame: Frame) -> tuple[str, float, tuple[float, float] | None]:
    """Return the better baseline on slippery rails, and the ratio of P95 with its paired bootstrap interval."""
    slippery = on_common(frame[frame["rail"] == "slippery"], "system", ["rail", "draw", "fault"], "error")
    slippery = slippery.pivot_table(index="draw", columns="system", values="error").abs()
    baselines = [name for name in SYSTEMS if name != MANAGED]
    better = min(baselines, key=lambda name: slippery[name].quantile(0.95))
    pairs = slippery[[MANAGED, better]].to_numpy()

    def ratio(draws: NDArray[np.float64]) -> NDArray[np.float64]:
        ends = np.quantile(draws, 0.95, axis=-2)
        return ends[..., 0] / ends[..., 1]

    return better, float(ratio(pairs)), bootstrap_interval(pairs, ratio, fewest=draws_for_interval(0.95))


def knowledge_of(draws: Sequence[Draw]) -> str:
    """Return a sentence on what the driver is assumed to know, and how the errors depend on it."""
    target = float(np.mean([draw.target for draw in draws]))
    return (
        "The driver knows speed and place of the train exactly, so that the errors are those of brakes and rail alone. "
        "An error of the place adds in full: counted from the start by wheels whose radius is off by 1 %, it is "
        f"{0.01 * target:.1f} m at the mean target, {target:.0f} m away."
    )


def figure_of(frames: Mapping[str, Frame]) -> Figure:
    """Return the share of stops on slippery rails beyond an error, over that error; a panel for each frame with any."""
    frames = {title: frame for title, frame in frames.items() if (frame["rail"] == "slippery").any()}
    drawing, panels = style.panels(9, 4, 1, len(frames), sharey=True)
    for panel, (title, frame) in zip(np.ravel(panels), frames.items(), strict=True):
        for colour, system in zip((palette.GREY, palette.ORANGE, palette.BLUE), SYSTEMS, strict=True):
            chosen = (frame["system"] == system) & (frame["rail"] == "slippery")
            errors = np.sort(np.abs(frame.loc[chosen, "error"].to_numpy()))
            panel.step(np.maximum(errors, 1e-2), 1.0 - np.arange(errors.size) / errors.size, label=system, color=colour)
        panel.set_xscale("log")
        panel.set_yscale("log")
        style.dress(panel, x="error of the stopping point [m]", title=title)
    np.ravel(panels)[0].set_ylabel("share of stops with a larger error")
    np.ravel(panels)[0].legend()
    return drawing


def values_table(found: Mapping[str, Mapping[str, float]]) -> ReportTable:
    """Return the parameters that the search found."""
    rows = [
        (system, ", ".join(f"{name} {value:g}" for name, value in values.items())) for system, values in found.items()
    ]
    return ReportTable.of(("system", "parameters"), rows, left=2)


@dataclass(frozen=True)
class StopAtTarget(Study, quick="2 draws, and no search of parameters", sizes={"draws": 2, "sets": 0}):
    """Stop at a target with a driver, deceleration control, and adhesion management, over draws of everything."""

    documentation = Path("docs/stop_at_target.md")

    draws: Annotated[int, Option(min=1, help="Draws with magnets; a fifth as many without.")] = DRAWS
    sets: Annotated[int, Option(min=0, help="Sets of parameters for each system; 0 keeps those of the laws.")] = SETS
    write: Annotated[bool, Option("--write", help="Write the tables into docs/stop_at_target.md.")] = False

    def page(self, work: Work) -> Page:
        """Search the parameters, run the draws, and return the errors; the small form has few draws and no search."""
        count, sets = self.draws, self.sets
        systems = {name: search(name, work, sets) for name in SYSTEMS}
        draws = draws_of(count, TEST_SEED)
        frames = {
            "with magnets": frame_of(systems, draws, work, has_magnets=True),
            "without magnets": frame_of(systems, draws[: max(count // 5, 1)], work, has_magnets=False),
        }
        tables = {title: table_of(frame, title) for title, frame in frames.items()}
        parameters = values_table(systems)
        answers = {title: _answer(frame) for title, frame in frames.items()}
        known = knowledge_of(draws)
        ratios = bulleted(f"{title.capitalize()}: {answer}" for title, answer in answers.items())
        return Page(
            title="Stops at a target",
            question="How far from its target does a train stop, and what does adhesion management gain?",
            answer=f"{known} {answers['with magnets']}",
            template="studies/stop_at_target/stop_at_target.md.jinja",
            values={"tables": tables, "parameters": parameters, "answers": answers, "sets": sets, "training": TRAINING},
            figures={"errors.png": figure_of(frames)},
            tables={"errors.csv": tables["with magnets"], "without_magnets.csv": tables["without magnets"]},
            documented={**tables, "parameters": parameters, "ratios": ratios, "knowledge": known},
            screen=(*tables.values(), parameters, *answers.values()),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return the mean deceleration to the stop of a few draws with adhesion management."""
        frame = frame_of({MANAGED: {}}, draws_of(HEADLINE, TEST_SEED), work, has_magnets=True)
        # Deviations of a stop on a slippery rail grow: a second in forty covers another machine.
        return [
            Finding(f"draw {number}: duration", float(row["duration"]), "s", 1.0) for number, row in frame.iterrows()
        ]


STUDY = StopAtTarget


def _answer(frame: Frame) -> str:
    if (frame["rail"] == "slippery").sum() < 2 * len(SYSTEMS):
        return "there are too few draws on slippery rails."
    better, ratio, interval = ratio_of(frame)
    slippery = frame[frame["rail"] == "slippery"]
    long = (slippery["error"] > FAR).groupby(slippery["system"]).mean()
    managed = slippery[slippery["system"] == MANAGED]
    farthest = managed.loc[managed["error"].abs().idxmax()]
    same = slippery[(slippery["system"] == better) & (slippery["draw"] == farthest["draw"])]
    return (
        f"The ratio of P95 of the error on slippery rails to that of the better baseline, {better}, is "
        f"{with_interval(ratio, interval, '{:.2f}', without=1.0)}{_verdict(ratio, interval)}. "
        f"{100 * long[MANAGED]:.1f} % of the stops there are long by more than {FAR:g} m, against "
        f"{100 * long[better]:.1f} %. In the stop that misses farthest (fault: {farthest['fault']}) the error is "
        f"{farthest['error']:+.2f} m; that of {better} in the same draw is {same['error'].iloc[0]:+.2f} m."
    )


def _verdict(ratio: float, interval: tuple[float, float] | None) -> str:
    if ratio > 1 / 3:
        return "; the aim of a third is missed"
    if interval is not None and interval[1] <= 1 / 3:
        return "; the aim of a third is reached"
    return "; whether the aim of a third is reached is not shown"


_FORMS: Final = {
    "rail": "",
    "system": "",
    "draws": "{:.0f}",
    **dict.fromkeys(("P50", "P95", "P99"), "{:.2f} m"),
    "farthest": "{:+.2f} m",
    **dict.fromkeys((f"long by > {FAR:g} m", f"short by > {FAR:g} m"), lambda share: f"{100 * share:.1f} %"),
    "duration": "{:.1f} s",
    "sand": "{:.2f} kg",
    "air": lambda air: f"{1000 * air:.0f} l",
    "magnets": "{:.1f} s",
}
