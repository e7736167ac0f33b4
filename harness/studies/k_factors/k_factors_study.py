"""K factors of a brake: results as JSON, as a page with a figure, and as rows for the screen."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
from matplotlib.figure import Figure
from typer import Argument, Option

from railgrip.base.errors import ScenarioError
from railgrip.base.tables import JsonObject
from railgrip.campaign.run import input_versions
from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding
from railgrip.report.page import Page
from railgrip.report.palette import lead_to_trail
from railgrip.report.style import band, dress, figure, legend
from railgrip.report.table import ReportTable
from railgrip.rolling_stock.check import checked_train
from railgrip.rolling_stock.dispersion import ComponentFailure, FailureProbability, Normal, Uniform
from railgrip.rolling_stock.schema import Train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.schema import Scenario
from railgrip.simulate.named_models import plant_description
from railgrip.simulate.run import braking_distance
from railgrip.studies.k_factors.k_dry import (
    KFactorSpecification,
    KOfStops,
    QuasiStaticBrake,
    brake_of,
    in_the_loop,
    load_specification,
    plain,
    quasi_static,
    scenario_of_draw,
)
from railgrip.studies.study import Study
from railgrip.supervision.dispersed import DispersedBrake
from railgrip.supervision.k_dry import PROBABILITIES, QuasiStatic
from railgrip.supervision.rare import estimates, pool_samples

_LEVELS = (0, 3, 6, 9)
"""EBCL of the panels of convergence."""

_FEW = ("estimate.runs=2", "estimate.samples=100")
_FEW_STOPS = ("loop.runs=2", "loop.samples=20")

_HALF_HEIGHT = 0.012  # of the panels of convergence, in K

_METHOD = "exact enumeration of failure states, importance sampling about the worst points within each"


@dataclass(frozen=True)
class KFactors(Study, quick="2 runs with few samples"):
    """Print K_dry_rst for EBCL 0 to 9 from the dispersion of a brake's components, with intervals of 95 %."""

    documentation = Path("docs/k_factors.md")

    file: Annotated[Path, Argument(metavar="FILE.toml", help="Dispersion and failures.")] = Path("vt642")
    overrides: list[str] | None = None
    loop: Annotated[bool, Option("--loop", help="Also run stops with the controller, see [loop].")] = False
    write: Annotated[bool, Option("--write", help="Write table and sentences into docs/k_factors.md.")] = False
    import_from: list[Path] | None = None

    def page(self, work: Work) -> Page:
        """Return K of the quasi-static brake; with `loop` also in stops.

        Raises:
            ScenarioError: The plant is not such a train, its nominal stop does not end, or the file lacks [loop].
        """
        few = (*_FEW, *(_FEW_STOPS if self.loop else ())) if self.quick else ()
        specification, subject = load_specification(self.file, [*(self.overrides or []), *few])
        folders = self.import_from or []
        if self.loop and specification.loop is None:
            raise ScenarioError(f"{specification.name}: has no [loop], which stops with a controller need")
        brake = brake_of(specification, subject)
        if self.loop and not isinstance(brake, QuasiStaticBrake):
            raise ScenarioError(f"{specification.name}: --loop needs the plant TwoPartTrainPneumatic, not a train file")
        distance, method = _nominal_distance(subject, brake, folders)
        result = quasi_static(specification, brake, work.notify)
        loop = None
        if self.loop and isinstance(subject, Scenario) and isinstance(brake, QuasiStaticBrake):
            loop = in_the_loop(specification, subject, brake, distance, result, work, folders)
        shown = table(brake, result)
        lines = sentences(brake, distance, method, result, loop, work.count)
        return Page(
            title=f"K factors of {specification.name}",
            question="Which share of its nominal deceleration does the train reach with the probability of each EBCL?",
            answer=f"{brake.outputs[-1].capitalize()}: K_dry_rst is "
            f"{', '.join(f'{result.k[-1][level].value:.3f} at EBCL {level}' for level in _LEVELS)}. {lines[1]}",
            template="studies/k_factors/k_factors.md.jinja",
            values={"specification": specification, "table": shown, "sentences": lines, **assumptions(specification)},
            figures={"k_factors.png": draw(brake, result)},
            data={"k_factors.json": content(specification, subject, brake, distance, result, loop)},
            documented={"K": "\n\n".join((str(shown), *lines))},
            screen=(shown, *lines, f"{result.seconds:.1f} s"),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return K of the stop at four EBCL, from fewer samples of each failure state."""
        specification, subject = load_specification(self.file, list(_FEW))
        result = quasi_static(specification, brake_of(specification, subject))
        # Seeds are fixed: a thousandth is enough for the arithmetic of another machine.
        return [Finding(f"vt642: K of the stop, EBCL {level}", result.k[-1][level].value, "1") for level in _LEVELS]


STUDY = KFactors


def _nominal_distance(subject: Scenario | Train, brake: DispersedBrake, folders: Sequence[Path]) -> tuple[float, str]:
    """Return the stopping distance of the nominal train by another method, and the name of that method."""
    if isinstance(subject, Scenario) and isinstance(brake, QuasiStaticBrake):
        whole = [int(np.sum(units)) for units in brake.units]
        distance = braking_distance(scenario_of_draw(subject, brake, whole, None), folders)
        if distance is None:
            raise ScenarioError(
                f"{subject.name}: the nominal train does not stop, and K is a share of its deceleration"
            )
        return distance, "in the loop"
    if isinstance(subject, Scenario):
        assert subject.vehicle.train is not None  # or its brake is that of a plant
        subject = checked_train(subject.vehicle.train.path)
    return by_hand(subject, brake.speeds[0]).distance, "by hand"


def table(brake: DispersedBrake, result: QuasiStatic) -> ReportTable:
    """Return one row for each EBCL: probability, and for each output K, its interval of sampling, and that of rates."""
    of_outputs = list(zip(result.k, result.k_of_rates, strict=True))
    rows = [
        [
            str(level),
            f"{probability:g}",
            *(f"{_text(**plain(k[level]))} [{wide[level].low:.3f}–{wide[level].high:.3f}]" for k, wide in of_outputs),
        ]
        for level, probability in enumerate(PROBABILITIES)
    ]
    return ReportTable.of(("EBCL", "P", *brake.outputs), rows, left=0)


def assumptions(specification: KFactorSpecification) -> dict[str, ReportTable]:
    """Return the dispersions and failures, each value with its source: tables `dispersion` and `failures`."""
    dispersion = [
        (one.quantity.replace("_", " "), one.per, f"{one.kind}, {_extent(one)}", one.source)
        for one in specification.dispersion
    ]
    failures = [
        (name.replace("_", " "), one.probability, one.error_factor, one.source, *_common_cause(one))
        for name, one in specification.failures
        if one is not None
    ]
    columns = ("component", "probability", "error factor", "source", "β", "source of β")
    return {
        "dispersion": ReportTable.of(("quantity", "drawn for each", "distribution", "source"), dispersion, left=4),
        "failures": replace(ReportTable.of(columns, failures, "{:g}"), left=("component", "source", "source of β")),
    }


def _common_cause(failure: FailureProbability) -> tuple[float | None, str]:
    if isinstance(failure, ComponentFailure):
        return failure.common_cause.beta, failure.common_cause.source
    return None, ""


def _extent(dispersion: Normal | Uniform) -> str:
    if isinstance(dispersion, Normal):
        return f"σ {dispersion.deviation.entry}"
    return f"{dispersion.lowest.entry} to {dispersion.highest.entry}"


def sentences(
    brake: DispersedBrake,
    distance: float,
    method: str,
    result: QuasiStatic,
    loop: KOfStops | None,
    workers: int,
) -> list[str]:
    """Return further remarks on the results; `distance` is that of the nominal train by another `method` [m]."""
    nominal = ", ".join(f"{output} {a:.3f}" for output, a in zip(brake.outputs, brake.nominal, strict=True))
    lines = [
        f"Nominal deceleration [m/s²]: {nominal}; equivalent time {brake.equivalent_time:.2f} s.",
        f"Nominal stop: {brake.distance:.1f} m quasi-static, {distance:.1f} m {method} "
        f"({100 * (brake.distance / distance - 1):+.1f} %).",
        f"{result.draws} draws of {len(result.states)} failure states; all others have a probability of "
        f"{result.neglected:.1e} together.",
    ]
    if loop is not None:
        seconds = loop.seconds["stop"]
        cost = [
            f"{p} {stops} stops, {stops * seconds / workers / 60:.0f} min" for p, stops in loop.estimated_stops.items()
        ]
        lines += [
            f"With the controller in the loop: K = {_text(loop.k, loop.low, loop.high)} at {loop.probability:g}, "
            f"quasi-static {_text(**loop.quasi_static)}; {loop.samples} stops, failure states sampled {loop.states}, "
            f"all others {loop.neglected_probability:.1e}; a stop takes a core {seconds:.2f} s.",
            f"The same samples and runs for less likely decelerations, estimated for {workers} cores: "
            f"{'; '.join(cost)}. Intervals half as wide take four times as many.",
        ]
    return lines


def content(
    specification: KFactorSpecification,
    subject: Scenario | Train,
    brake: DispersedBrake,
    distance: float,
    result: QuasiStatic,
    loop: KOfStops | None,
) -> JsonObject:
    """Return the file of results; the same specification gives the same file, except for `seconds`."""
    plant = None if isinstance(subject, Train) else plant_description(subject)
    results: JsonObject = {
        "name": specification.name,
        "method": _METHOD,
        "seed": specification.seed,
        "confidence": 0.95,
        "samples": result.draws,
        "runs": specification.estimate.runs,
        "states": [asdict(state) for state in result.states],
        "neglected_probability": result.neglected,
        "nominal": {
            "deceleration_m_s2": dict(zip(brake.outputs, brake.nominal.tolist(), strict=True)),
            "equivalent_time_s": brake.equivalent_time,
            "distance_m": brake.distance,
            "plant_distance_m": distance,
        },
        "k_dry": [
            {
                "output": output,
                "ebcl": level,
                "probability": PROBABILITIES[level],
                **plain(effort),
                "low_of_rates": wide[level].low,
                "high_of_rates": wide[level].high,
            }
            for output, of, wide in zip(brake.outputs, result.k, result.k_of_rates, strict=True)
            for level, effort in enumerate(of)
        ],
        "specification": specification.model_dump(mode="json"),
        "scenario_digest": None if isinstance(subject, Train) else subject.digest(),
        "versions": input_versions() | ({} if plant is None else {plant.file.name: plant.generator}),
        "fmus": {} if plant is None else {plant.file.name: plant.digest},
        "seconds": {"quasi_static": round(result.seconds, 2)},
    }
    if loop is not None:
        results["loop"] = {name: value for name, value in asdict(loop).items() if name != "seconds"}
        results["seconds"] |= loop.seconds
    return results


def draw(brake: DispersedBrake, result: QuasiStatic) -> Figure:
    """Return the figure: K over probability for each output, and how K of the whole stop settles with the draws."""
    drawing = figure(11.0, 5.4)
    grid = drawing.add_gridspec(len(_LEVELS), 2)
    left = drawing.add_subplot(grid[:, 0])
    colours = lead_to_trail(len(brake.outputs))
    levels = np.geomspace(0.5, PROBABILITIES[-1], 120).tolist()
    for output, runs, colour in zip(brake.outputs, result.runs, colours, strict=True):
        pooled_run = pool_samples(runs, [1 / len(runs)] * len(runs))
        left.semilogy([pooled_run.quantile(p) for p in levels], levels, color=colour, lw=1.2, label=output)
    stop = result.k[-1]
    error_bars = np.array([[value.value - value.low, value.high - value.value] for value in stop]).T
    left.errorbar(
        [value.value for value in stop], PROBABILITIES, xerr=error_bars, fmt="o", ms=3, color=colours[-1], capsize=3
    )
    dress(left, x="K, deceleration over nominal", y="probability P of a smaller K", title="EBCL 0 to 9, dry")
    legend(left)
    runs = result.runs[-1]
    counts = np.arange(2, len(runs) + 1)
    courses = [estimates(runs[:n], [PROBABILITIES[level] for level in _LEVELS], result.neglected) for n in counts]
    for number, level in enumerate(_LEVELS):
        right = drawing.add_subplot(grid[number, 1])
        k, low, high = (
            np.array([getattr(course[number], of) for course in courses]) for of in ("value", "low", "high")
        )
        draws = counts * len(runs[0].values) / 1e3
        right.plot(draws, k, ".-", color=colours[-1], lw=1.2, ms=3)
        band(right, draws, low, high, colours[-1], 0.25)
        right.set_ylim(k[-1] - _HALF_HEIGHT, k[-1] + _HALF_HEIGHT)
        title = "" if number else f"Estimate and 95 % interval, {brake.outputs[-1]}"
        dress(right, x="thousand draws" if level == _LEVELS[-1] else "", y=f"K, EBCL {level}", title=title)
        right.tick_params(labelbottom=level == _LEVELS[-1])
    return drawing


def _text(k: float, low: float, high: float) -> str:
    return f"{k:.4f} ({low:.4f}–{high:.4f})"
