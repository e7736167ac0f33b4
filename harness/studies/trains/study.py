"""Comparison of trains with reality: stops, two JSON files, figures, a page, and headline numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from matplotlib.figure import Figure
from typer import Option

from railgrip.base.files import scratch
from railgrip.campaign.work import Work
from railgrip.report import palette, style
from railgrip.report.baseline import Finding
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, percent, write_tables
from railgrip.rolling_stock.drawing import drawing
from railgrip.rolling_stock.schema import NAMED
from railgrip.scenario.file import locate
from railgrip.simulate.run import braking_distance
from railgrip.studies.study import Study
from railgrip.studies.trains.stops import (
    FILLING,
    PROPAGATION,
    DryStop,
    SanderComparison,
    SanderTrial,
    compare,
    dry_scenario,
    dry_stop,
    protected_stop,
    repeat_cars,
    scenario_of_row,
    scenario_tables,
    trial_of,
)

PAGE = Path("docs/train_models.md")
"""Folder relative to that of the project, in which the command runs."""

WRITTEN = ("distances", "published", "filling", "forces")
"""Tables of the page, in addition to that of the sanders."""

HAND = "EN 14531-1 by hand"


@dataclass(frozen=True)
class Trains(Study, quick="without the longest train, and costs of up to four cars"):
    """Stop the built-in trains, compare them with published stops, and fit sand to a trial of sanders."""

    write: Annotated[bool, Option("--write", help="Write its tables into docs/train_models.md.")] = False

    def page(self, work: Work) -> Page:
        """Return all stops; the small form is without the longest train and the cost of more than four cars."""
        names = [name for name in NAMED if not self.quick or name != "loco_coaches"]
        counts = (1, 2, 4) if self.quick else (1, 2, 4, 8, 16)
        trial, model = trial_of(), Path("emu387")
        text = locate(model, "trains").read_text(encoding="utf-8")
        with scratch("study") as folder:
            files = [folder / f"{model}_{count}.toml" for count in counts]
            for file, count in zip(files, counts, strict=True):
                file.write_text(repeat_cars(text, count), encoding="utf-8")
            stops = work.measure_times(dry_stop, [*names, *files])
        protected = work.measure_times(protected_stop, [1e-3, 10e-3])
        density, comparisons = compare(trial)
        page = page_of(stops[: len(names)], stops[len(names) :], protected, trial, density, comparisons)
        if self.write:
            tables = {name: page.values[name] for name in WRITTEN}
            fitted = f"The fitted density of sand is {1e3 * density:.1f} g/m."
            write_tables(PAGE, tables | {"sanders": f"{page.values['sanders']}\n\n{fitted}"})
        return page

    def headlines(self, work: Work) -> list[Finding]:
        """Return dry distances of named trains, and two rows of the trial of sanders with its density of sand."""
        trial = trial_of()
        tables = scenario_tables(trial)
        # Nothing slides in a dry stop: only the solver's steps differ on another machine. Under slip control,
        # parameters moved by 1e-7 move a distance by 2e-4.
        stops = {
            f"trains, {train}: dry distance": (dry_scenario(train, speed), 1e-4)
            for train, speed in (("vt642", 85 / 3.6), ("emu387", 120 / 3.6), ("tram", 50 / 3.6))
        } | {
            f"trains, sanders {row.sanders}: distance": (scenario_of_row(trial, row, _SAND, tables), 2e-3)
            for row in trial.rows
            if row.sanders in ("two fixed", "two variable")
        }
        distances = work.map(braking_distance, [scenario for scenario, _ in stops.values()])
        return [
            Finding(name, distance, "m", relative * (distance or 0.0))
            for (name, (_, relative)), distance in zip(stops.items(), distances, strict=True)
        ]


STUDY = Trains

_SAND = 5.4e-3  # kg/m, what docs/train_models.md has from the fit on one row


def row_of(stop: DryStop) -> dict[str, object]:
    """Return a train in the form of trains.json; the reference is the calculation by hand."""
    return {
        "train": stop.train.name,
        "cars": len(stop.train.cars),
        "axles": len(stop.train.axles),
        "states": stop.states,
        "build_s": stop.build_s,
        "plant_step_us": stop.plant_step_us,
        "cycle_us": stop.cycle_us,
        "speed_km_h": 3.6 * stop.speed,
        "dry_distance_m": stop.distance,
        "reference_m": stop.hand.distance,
        "source": HAND,
        "published": [
            {
                "speed_km_h": 3.6 * reference.speed,
                "distance_m": reference.distance,
                "limit": reference.limit,
                "source": reference.source,
            }
            for reference in stop.train.reference
        ],
        "coupler_force_N": stop.coupler_force.tolist(),
        "coupler_bound_N": np.abs(stop.hand.coupler_force).tolist() if stop.coupler_force.size else [],
        "coupler_chain_N": stop.chain.tolist(),
        "filling_s": None if stop.filling is None else stop.filling.filling.tolist(),
        "propagation_m_s": None if stop.filling is None else stop.filling.propagation,
    }


def page_of(
    stops: Sequence[DryStop],
    series: Sequence[DryStop],
    protected_stops: Sequence[Mapping[str, float]],
    trial: SanderTrial,
    density: float,
    comparisons: Sequence[SanderComparison],
) -> Page:
    """Return the page of the study.

    Args:
        stops: Stops of the built-in trains.
        series: Stops of trains of one, two, four … equal cars.
        protected_stops: Times of the stop with estimator and valves.
        density: Fitted density of sand [kg/m].
    """
    distances, protected = table_of(stops), table_of_protected(protected_stops)
    sanders = table_of_sanders(comparisons)
    drawings = {stop.train.name: f"figures/{stop.train.name}.png" for stop in stops}
    return Page(
        title="Trains against reality",
        question="Do the built-in trains stop in the distances of the hand calculation and of publications?",
        answer=_answer(stops),
        template="studies/trains/trains.md.jinja",
        values={
            "distances": distances,
            "published": _published_table(stops),
            "filling": _filling(stops),
            "forces": _forces(stops),
            "costs": _costs([*stops, *series]),
            "protected": protected,
            "sanders": sanders,
            "trial": trial,
            "density": 1e3 * density,
            "drawings": drawings,
        },
        figures={
            "figures/distances.png": _distance_figure(stops),
            **{drawings[stop.train.name]: drawing(stop.train) for stop in stops},
            **({"figures/cost.png": _cost_figure(series)} if series else {}),
            "figures/sanders.png": _sander_figure(comparisons),
        },
        data={
            "trains.json": {"trains": [row_of(stop) for stop in (*stops, *series)], "protected_stop": protected_stops},
            "sanders.json": {
                "rows": comparisons,
                "law": {"mu0": trial.law.mu0, "left": trial.law.left, "density_kg_m": density, "source": trial.source},
            },
        },
        screen=(distances, protected, sanders),
    )


def _answer(stops: Sequence[DryStop]) -> str:
    differences = [_difference_by_hand(stop) for stop in stops]
    return (
        f"{len(stops)} dry emergency stops differ from the calculation by hand of EN 14531-1 by "
        f"{min(differences):+.1f} to {max(differences):+.1f} %. The tables below also have published distances."
    )


def _difference_by_hand(stop: DryStop) -> float:
    return 100 * (stop.distance / stop.hand.distance - 1)


def table_of(stops: Sequence[DryStop]) -> ReportTable:
    """Return the dry stops and the calculation by hand."""
    rows = [
        (stop.train.name, 3.6 * stop.speed, stop.distance, stop.hand.distance, _difference_by_hand(stop))
        for stop in stops
    ]
    metres = dict.fromkeys(("simulated", "by hand"), "{:.1f} m")
    return ReportTable.of({"train": "", "from": "{:.0f} km/h", **metres, "difference": "{:+.1f} %"}, rows)


def table_of_protected(stops: Sequence[Mapping[str, float]]) -> ReportTable:
    """Return the speed of the stop with estimator and valves relative to real time."""
    rows = [
        {
            "estimator every": f"{1e3 * stop['estimator_period_s']:g} ms",
            "simulated": stop["simulated_s"],
            "processor": stop["processor_s"],
            "times real time": stop["times_real_time"],
            "target": "≥ 20",
        }
        for stop in stops
    ]
    forms = {"simulated": "{:.1f} s", "processor": "{:.2f} s", "times real time": "{:.1f}"}
    return ReportTable(rows, forms, ("estimator every", "target"))


def table_of_sanders(comparisons: Sequence[SanderComparison]) -> ReportTable:
    """Return the distances of the trial and the simulated ones."""
    rows = [
        {
            "sanders": row["sanders"],
            "measured": f"{'> ' if 'at_least' in row else ''}{row['measured_m']:.0f} m",
            "simulated": "no stop" if row["distance_m"] is None else f"{row['distance_m']:.0f} m",
            "difference": percent(_difference(row)),
            "": "fitted" if row["fitted"] else "",
        }
        for row in comparisons
    ]
    return ReportTable(rows, {}, ("sanders", ""))


def _difference(row: SanderComparison) -> float | None:
    # The trial may give only a bound, and the train may not stop.
    return None if "at_least" in row or row["distance_m"] is None else row["distance_m"] / row["measured_m"] - 1


def _published_table(stops: Sequence[DryStop]) -> ReportTable:
    rows = [
        {
            "train": stop.train.name,
            "from": 3.6 * reference.speed,
            "published": f"{'≤ ' if reference.limit else ''}{reference.distance:g} m",
            "simulated": stop.distance,
            "source": reference.source,
        }
        for stop in stops
        for reference in stop.train.reference
        if reference.speed == stop.speed
    ]
    return ReportTable(rows, {"from": "{:.0f} km/h", "simulated": "{:.1f} m"}, ("train", "source"))


def _filling(stops: Sequence[DryStop]) -> ReportTable:
    least, most = FILLING
    rows = [
        (
            stop.train.name,
            f"{filling.filling.min():.2f} to {filling.filling.max():.2f} s",
            f"{least:g} to {most:g} s",
            f"{filling.propagation:.0f} m/s",
            f"≥ {PROPAGATION:g} m/s",
            f"{filling.begin[-1]:.2f} s",
        )
        for stop in stops
        if (filling := stop.filling) is not None
    ]
    return ReportTable.of(("train", "filling to 95 %", "UIC 540, P", "front", "UIC 540", "last car begins"), rows)


def _forces(stops: Sequence[DryStop]) -> ReportTable:
    rows = [
        (
            stop.train.name,
            stop.coupler_force.max() / 1e3,
            np.abs(stop.hand.coupler_force).max() / 1e3,
            stop.chain.max() / 1e3,
            min(coupler.strength for coupler in stop.train.couplers.values()) / 1e3,
        )
        for stop in stops
        if stop.coupler_force.size
    ]
    columns = ("train", "largest in a coupler", "quasi-static", "chain", "strength")
    return ReportTable.of(columns, rows, "{:.1f} kN")


def _costs(stops: Sequence[DryStop]) -> ReportTable:
    rows = [
        (
            *(stop.train.name, len(stop.train.cars), len(stop.train.axles)),
            *(stop.states, stop.build_s, stop.plant_step_us, stop.cycle_us),
        )
        for stop in stops
    ]
    times = {"build": "{:.1f} s", "plant step": "{:.1f} µs", "cycle": "{:.1f} µs"}
    return ReportTable.of(dict.fromkeys(("train", "cars", "axles", "states"), "{}") | times, rows)


def _distance_figure(stops: Sequence[DryStop]) -> Figure:
    figure, axes = style.panels(8.0, 0.9 + 0.5 * len(stops))
    places = np.arange(len(stops))
    axes.barh(places - 0.2, [stop.distance for stop in stops], 0.4, color=palette.BLUE, label="simulated")
    axes.barh(places + 0.2, [stop.hand.distance for stop in stops], 0.4, color=palette.SKY, label="by hand")
    axes.set_yticks(places, [f"{stop.train.name}, {3.6 * stop.speed:.0f} km/h" for stop in stops])
    axes.invert_yaxis()
    style.dress(axes, x="dry emergency stop [m]")
    axes.grid(visible=False, axis="y")
    style.legend(axes, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _cost_figure(series: Sequence[DryStop]) -> Figure:
    figure, axes = style.panels(6.4, 3.4)
    cars = [len(stop.train.cars) for stop in series]
    axes.plot(cars, [stop.plant_step_us for stop in series], "o-", color=palette.BLUE, label="plant step")
    axes.plot(cars, [stop.cycle_us for stop in series], "s-", color=palette.ORANGE, label="cycle of the loop")
    axes.legend(frameon=False)
    axes.set_ylim(bottom=0)
    style.dress(axes, x="cars of four axles", y="time of 1 ms [µs]")
    return figure


def _sander_figure(comparisons: Sequence[SanderComparison]) -> Figure:
    figure, axes = style.panels(6.4, 3.4)
    places = np.arange(len(comparisons))
    measured, simulated = [row["measured_m"] for row in comparisons], [row["distance_m"] or 0.0 for row in comparisons]
    colours = [palette.ORANGE if row["fitted"] else palette.BLUE for row in comparisons]
    axes.bar(places - 0.2, measured, 0.4, color=palette.GREY, label="measured")
    axes.bar(places + 0.2, simulated, 0.4, color=colours, label="simulated")
    for place, row, height in zip(places, comparisons, map(max, measured, simulated), strict=True):
        words = "fitted" if row["fitted"] else f"{100 * (_difference(row) or 0.0):+.0f} %"
        words = "at least" if "at_least" in row else words
        axes.annotate(words, (float(place), height), ha="center", va="bottom", fontsize=8)
    axes.set_xticks(places, [row["sanders"] for row in comparisons], fontsize=8)
    axes.legend(frameon=False)
    style.dress(axes, y="distance [m]")
    return figure
