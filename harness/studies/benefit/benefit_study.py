"""What measures against low adhesion buy on a line: metres, seconds of headway, sand, air and wear."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from matplotlib.figure import Figure
from typer import Argument, Option

from railgrip.base.errors import InputError
from railgrip.base.files import scratch
from railgrip.campaign.work import Work
from railgrip.report import palette, style
from railgrip.report.baseline import Finding
from railgrip.report.page import Page
from railgrip.report.statistics import FEWEST_DRAWS
from railgrip.report.table import Form, ReportTable, bulleted, share, with_interval
from railgrip.rolling_stock.check import checked_train
from railgrip.rolling_stock.schema import Train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.file import locate
from railgrip.studies.benefit.chain import (
    FIGURES,
    Array,
    BenefitChain,
    figures_of,
    model_for,
    scenario_for,
    variants_of,
)
from railgrip.studies.benefit.line import load_study_line, measures_of
from railgrip.studies.study import Study
from railgrip.supervision.headway import headways
from railgrip.supervision.line import doubts_of
from railgrip.supervision.trains import maximum_speed, read_train

_SYSTEMS = ("fixed blocks", "moving block")
_COLOURS = {
    "signalling": palette.GREY, "approach": palette.BLUE, "block": palette.SKY, "clearing": palette.GREEN,
    "dwell": palette.ORANGE,
}  # fmt: skip


@dataclass(frozen=True)
class Benefit(Study, quick="the first measure, and 2 stops on the last rail of the line", sizes={"draws": 2}):
    """Find out what sand, a control law or track brakes buy on a line: metres, seconds of headway, and their cost.

    What does sanding buy for a train that leaves at .05 from 120 km/h?
    `railgrip study benefit my_train.toml --measures sand --line leaves`
    """

    documentation = Path("docs/benefit.md")

    train: Annotated[Path, Argument(metavar="TRAIN", help="A train file, or the name of a train.")] = Path("emu387")
    measures: Annotated[
        str, Option(help="Measures, separated by commas: sand, magnetic, a control law, or one of the line file.")
    ] = "sand,two_maxima,magnetic"
    line: Annotated[
        Path, Option(help="File of the line, or one of: commuter, leaves (friction of .05 from 120 km/h).")
    ] = Path("commuter")
    controller: Annotated[str, Option(help="Slide protection of the train without measures.")] = "slip_three_state"
    draws: Annotated[
        int, Option(help="Stops on each rail of the line; more of them narrow the intervals.", min=2, max=10_000)
    ] = FEWEST_DRAWS
    write: Annotated[bool, Option("--write", help="Write its tables into docs/benefit.md.")] = False

    def page(self, work: Work) -> Page:
        """Return benefit and cost of each measure.

        Raises:
            InputError: A file or a name is wrong, or the train does not stop on a rail.
        """
        chain = chain_of(self, work)
        gains, costs, by_rail, deciding = gain_table(chain), cost_table(chain), rail_table(chain), deciding_table(chain)
        sentences = sentences_of(chain)
        tables = {"gains": gains, "costs": costs, "rails": by_rail, "deciding": deciding}
        return Page(
            title=f"Benefit of measures for {self.train.stem} on the line {chain.line.name}",
            question="How many metres and seconds of headway do measures against low adhesion buy, and at what cost?",
            answer=sentences[0],
            template="studies/benefit/benefit.md.jinja",
            values=tables | {"sentences": sentences[1:]},
            figures={"benefit.png": draw(chain)},
            tables={f"{name}.csv": table for name, table in tables.items()},
            documented=tables | {"sentences": bulleted(sentences)},
            files={"stops.csv": partial(stop_table(chain).write_csv)},
            screen=(gains, costs, deciding, *sentences),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return the headways of a train on the line `commuter` with the K_wet of its data, without stops."""
        line = load_study_line(Path("commuter"))
        found = headways(line, model_for(locate("vt642", "trains"), line.national), line.national)
        # Draws are seeded: a thousandth is enough for the arithmetic of another machine.
        return [
            Finding(f"vt642: headway, {name}", each.seconds, "s") for name, each in zip(_SYSTEMS, found, strict=True)
        ]


STUDY = Benefit


def chain_of(study: Benefit, work: Work) -> BenefitChain:
    """Run the stops of a study, and return what follows from them.

    Raises:
        InputError: A file or a name is wrong, or the train does not stop on a rail.
    """
    line, measures = load_study_line(study.line), study.measures
    if study.quick:
        line = line.model_copy(update={"rail": (line.rail[-1].model_copy(update={"probability": 1.0}),)})
        measures = measures.partition(",")[0]
    file = locate(study.train, "trains")
    train = read_train(file)
    if not isinstance(train, Train):
        raise InputError(f"{file.name}: is a file of brake curves; stops need a train file")
    speed = min(max(section.speed for section in line.speed), maximum_speed(train))
    draws = study.draws
    rails = [None, *(rail for rail in line.rail for _ in range(draws))]
    seeds = [0, *list(range(1, draws + 1)) * len(line.rail)]
    with scratch("study") as folder:
        variants = variants_of(file, measures_of(measures, line), study.controller, folder)
        cases = [
            scenario_for(variant, line, rail, draw, speed)
            for variant in variants
            for rail, draw in zip(rails, seeds, strict=True)
        ]
        stops = work.map(figures_of, cases)
        work.notify("K_dry")
        trains = list(dict.fromkeys(variant.train for variant in variants))
        found = work.map(partial(model_for, national=line.national), trains, keep=False)
        times = {path: by_hand(checked_train(path), speed).equivalent_time for path in trains}
    models = dict(zip(trains, found, strict=True))
    values = {name: np.array([stop[name] for stop in stops]).reshape(len(variants), -1) for name in FIGURES}
    chain = BenefitChain(
        line=line,
        variants=variants,
        speed=speed,
        models=[models[variant.train] for variant in variants],
        dry=values["distance"][:, 0],
        times=np.array([times[variant.train] for variant in variants]),
        figures={name: of[:, 1:].reshape(len(variants), len(line.rail), draws) for name, of in values.items()},
    )
    chain.require_stops()
    return chain


def gain_table(chain: BenefitChain) -> ReportTable:
    """Return distances, factors and headways of each variant, and what measures gain, with intervals."""
    forms: dict[str, Form] = {"measure": ""}
    columns: list[Iterable[str | float]] = [[variant.name for variant in chain.variants]]

    def add(values: Array, form: str, unit: str, name: str, gain: str) -> None:
        forms.update({name: f"{form}{unit}", gain: ""})
        columns.append(values[:, 0].tolist())
        columns.append(_gain(chain, values, number, form, unit) for number in range(len(values)))

    for level in (0.5, 0.95):
        add(chain.quantile(level), "{:.0f}", " m", f"P{100 * level:.0f}", f"P{100 * level:.0f} shorter by")
    forms |= {"K_wet": "{:.3f}", "safe factor": "{:.3f}", "longer stops": share}
    columns += [chain.k_wet[:, 0].tolist(), chain.factors[:, 0].tolist(), chain.beyond().tolist()]
    for name, values in zip(_SYSTEMS, chain.seconds, strict=True):
        add(values, "{:.1f}", " s", f"headway, {name}", f"gain, {name}")
    return ReportTable.of(forms, zip(*columns, strict=True), title="Gains")


def _gain(chain: BenefitChain, values: Array, number: int, form: str, unit: str) -> str:
    """Return by how much values are below those without measures, in pairs, with the interval."""
    return _with_interval(chain, values[0] - values[number], form, unit, without=0.0) if number else ""


def _with_interval(
    chain: BenefitChain, values: Array, form: str, unit: str = "", *, without: float | None = None
) -> str:
    return with_interval(values[0], chain.interval(values), form, unit, without=without)


def cost_table(chain: BenefitChain) -> ReportTable:
    """Return the means over a year of sand, air and energy at the wheels of a stop, with intervals."""
    units = {"sand": (1.0, "{:.2f}", " kg"), "air": (1e3, "{:.0f}", " l"), "energy": (1e-6, "{:.2f}", " MJ")}
    means = {figure: chain.mean(figure) for figure in units}
    rows = [
        (variant.name, *(_with_interval(chain, means[figure][number] * scale, *form)
                         for figure, (scale, *form) in units.items()))
        for number, variant in enumerate(chain.variants)
    ]  # fmt: skip
    return ReportTable.of(("measure", "sand in a stop", "air in a stop", "wheel energy in a stop"), rows, title="Cost")


def rail_table(chain: BenefitChain) -> ReportTable:
    """Return the median distance of each variant on each rail."""
    medians = np.median(chain.figures["distance"], axis=2)
    names = [variant.name for variant in chain.variants]
    rows = [(rail.name, rail.probability, *of) for rail, of in zip(chain.line.rail, medians.T.tolist(), strict=True)]
    forms = {"rail": "", "share of stops": share, **dict.fromkeys(names, "{:.0f} m")}
    return ReportTable.of(forms, rows, title="Median distances")


def deciding_table(chain: BenefitChain) -> ReportTable:
    """Return the parts of each headway, and place and curve of the end of authority that decides it."""
    rows = [
        (variant.name, system, headway.place, headway.limit, *map(headway.parts.__getitem__, _COLOURS), headway.seconds)
        for system, of_system in zip(_SYSTEMS, zip(*chain.deciding, strict=True), strict=True)
        for variant, headway in zip(chain.variants, of_system, strict=True)
    ]
    forms = {"measure": "", "signalling system": "", "decided at": "{:.0f} m", "curve": ""}
    forms |= dict.fromkeys((*_COLOURS, "headway"), "{:.1f} s")
    left = ("measure", "signalling system", "curve")
    return ReportTable.of(forms, rows, left=left, title="What decides the headway")


def sentences_of(chain: BenefitChain) -> list[str]:
    """Return the conclusions from the results, a sentence each; the first one is the answer with what limits it."""
    line = chain.line
    last, without = chain.variants[-1].name, chain.deciding[0]
    gains = " and by ".join(
        f"{_gain(chain, values, len(chain.variants) - 1, '{:.1f}', ' s')} ({name})"
        for name, values in zip(_SYSTEMS, chain.seconds, strict=True)
    )
    few = f", and {chain.draws} draws on each rail are too few for intervals" if chain.draws < FEWEST_DRAWS else ""
    lines = [
        f"{share(max(chain.beyond()[[0, -1]]))} of the stops are longer than the safe factor behind these seconds "
        f"assumes{few}: on the line {line.name}, from {3.6 * chain.speed:.0f} km/h, '{last}' shortens the headway by "
        f"{gains}."
    ]
    for name, headway, now in zip(_SYSTEMS, without, chain.deciding[-1], strict=True):
        part = max(headway.parts, key=lambda each: headway.parts[each])
        changes = {each: headway.parts[each] - now.parts[each] for each in headway.parts}
        most = max(changes, key=lambda each: changes[each])
        lines.append(
            f"{name.capitalize()}: the largest part is {part}, {headway.parts[part]:.1f} s of {headway.seconds:.1f} s, "
            f"by the curve {headway.limit}; the part that '{last}' shortens most is {most}, by {changes[most]:.1f} s."
        )
    origin = "of the line file" if "M_NVAVADH" in line.national.model_fields_set else "of the train without measures"
    m_nvavadh = _with_interval(chain, chain.m_nvavadh, "{:.3f}")
    lines.append(
        f"Each rail has {chain.draws} draws; intervals need {FEWEST_DRAWS}, and narrow with more --draws, as one over "
        "their square root."
    )
    lines.append(f"M_NVAVADH {origin}: {m_nvavadh}, the same for all measures.")
    lines += [f"Line {line.name}: {words}." for words in doubts_of(line, chain.models[0].maximum_speed)]
    return lines


def stop_table(chain: BenefitChain) -> ReportTable:
    """Return a row for each stop, in SI units."""
    rows = [
        {"measure": variant.name, "season": rail.season, "weather": rail.weather, "draw": draw + 1}
        | {name: float(values[number, place, draw]) for name, values in chain.figures.items()}
        for number, variant in enumerate(chain.variants)
        for place, rail in enumerate(chain.line.rail)
        for draw in range(chain.draws)
    ]
    return ReportTable(rows)


def draw(chain: BenefitChain) -> Figure:
    """Draw the distribution of distances over a year, and the parts of both headways."""
    drawing = style.figure(13.0, 4.6)
    grid = drawing.add_gridspec(1, 4, width_ratios=(1.3, 1.0, 1.0, 0.35))
    left = drawing.add_subplot(grid[0])
    colours = (palette.BLACK, *itertools.islice(itertools.cycle(palette.LINES[:6]), len(chain.variants) - 1))
    for number, (variant, colour) in enumerate(zip(chain.variants, colours, strict=True)):
        distances = chain.figures["distance"][number].ravel()
        order = np.argsort(distances)
        shares = np.cumsum(chain.weights[order])
        left.step(
            distances[order][[0, *range(order.size)]], [0.0, *shares], where="post", color=colour, label=variant.name
        )
    style.dress(left, x="braking distance [m]", y="share of the stops", title=f"from {3.6 * chain.speed:.0f} km/h")
    names = [variant.name.replace("_", " ") for variant in chain.variants]
    panels = [drawing.add_subplot(grid[number + 1]) for number in range(2)]
    for number, (panel, system) in enumerate(zip(panels, _SYSTEMS, strict=True)):
        begin = np.zeros(len(names))
        for part, colour in _COLOURS.items():
            seconds = np.array([of_variant[number].parts[part] for of_variant in chain.deciding])
            panel.barh(range(len(names)), seconds, left=begin, color=colour, label=part)
            begin += seconds
        panel.set_yticks(range(len(names)), [""] * len(names) if number else names)
        panel.invert_yaxis()
        style.dress(panel, x="headway [s]", title=system)
    panels[1].set_xlim(panels[0].get_xlim())
    legend_panel = drawing.add_subplot(grid[3])
    legend_panel.set_axis_off()
    handles = [(handle, name) for panel in (left, panels[0]) for handle, name in
               zip(*panel.get_legend_handles_labels(), strict=True)]  # fmt: skip
    style.legend(legend_panel, *zip(*handles, strict=True), loc="center left")
    return drawing
