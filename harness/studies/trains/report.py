"""What the study of trains found: two JSON files, figures and a page."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from railgrip.files import write_json
from railgrip.report import style
from railgrip.report.page import image, write_page
from railgrip.report.table import Table
from railgrip.rolling_stock.drawing import drawing
from railgrip.studies.trains.sanders import Comparison, Trial
from railgrip.studies.trains.stops import FILLING, PROPAGATION, DryStop, ProtectedStop

HAND = "EN 14531-1 by hand"


def row_of(stop: DryStop) -> dict[str, object]:
    """Return a train as trains.json has it; the reference is the calculation by hand."""
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
            {"speed_km_h": 3.6 * one.speed, "distance_m": one.distance, "limit": one.limit, "source": one.source}
            for one in stop.train.reference
        ],
        "coupler_force_N": stop.coupler_force.tolist(),
        "coupler_bound_N": np.abs(stop.hand.coupler_force).tolist() if stop.coupler_force.size else [],
        "coupler_chain_N": stop.chain.tolist(),
        "filling_s": None if stop.filling is None else stop.filling.filling.tolist(),
        "propagation_m_s": None if stop.filling is None else stop.filling.propagation,
    }


def write_report(
    stops: Sequence[DryStop],
    series: Sequence[DryStop],
    protected_stops: Sequence[ProtectedStop],
    trial: Trial,
    density: float,
    comparisons: Sequence[Comparison],
    directory: Path,
) -> Path:
    """Write trains.json, sanders.json, figures and index.html into a folder; return the page.

    Args:
        series: Of trains of one, two, four … equal cars.
        protected_stops: What the stop with estimator and valves costs.
        density: Of sand, fitted [kg/m].
    """
    real_time = [
        {
            "estimator_period_s": one.estimator_period,
            "simulated_s": one.simulated,
            "processor_s": one.processor,
            "times_real_time": one.times_real_time,
        }
        for one in protected_stops
    ]
    write_json(
        directory / "trains.json",
        {"trains": [row_of(stop) for stop in (*stops, *series)], "protected_stop": real_time},
    )
    rows = [
        {"sanders": one.sanders, "distance_m": one.distance, "measured_m": one.measured, "fitted": one.fitted}
        | ({"at_least": True} if one.at_least else {})
        for one in comparisons
    ]
    law = {"mu0": trial.law.mu0, "left": trial.law.left, "density_kg_m": density, "source": trial.source}
    write_json(directory / "sanders.json", {"rows": rows, "law": law})
    figures = directory / "figures"
    drawings = {
        one.train.name: image(style.save(drawing(one.train), figures / f"{one.train.name}.png")) for one in stops
    }
    return write_page(
        directory / "index.html",
        "studies/trains/trains.html.jinja",
        distances=table_of(stops),
        published=_published(stops),
        filling=_filling(stops),
        forces=_forces(stops),
        costs=_costs([*stops, *series]),
        protected=table_of_protected(protected_stops),
        cost_figure=image(style.save(_cost_figure(series), figures / "cost.png")) if series else "",
        sanders=table_of_sanders(comparisons),
        sander_figure=image(style.save(_sander_figure(comparisons), figures / "sanders.png")),
        trial=trial,
        density=1e3 * density,
        drawings=drawings,
    )


def table_of(stops: Sequence[DryStop]) -> Table:
    """Return the dry stops beside the calculation by hand."""
    rows = [
        {
            "train": stop.train.name,
            "from": 3.6 * stop.speed,
            "simulated": stop.distance,
            "by hand": stop.hand.distance,
            "difference": 100 * (stop.distance / stop.hand.distance - 1),
        }
        for stop in stops
    ]
    forms = {"from": "{:.0f} km/h", "simulated": "{:.1f} m", "by hand": "{:.1f} m", "difference": "{:+.1f} %"}
    return Table(rows, forms, ("train",))


def table_of_protected(stops: Sequence[ProtectedStop]) -> Table:
    """Return how much faster than real time the stop with estimator and valves runs."""
    rows = [
        {
            "estimator every": f"{1e3 * one.estimator_period:g} ms",
            "simulated": one.simulated,
            "processor": one.processor,
            "times real time": one.times_real_time,
            "target": ">= 20",
        }
        for one in stops
    ]
    forms = {"simulated": "{:.1f} s", "processor": "{:.2f} s", "times real time": "{:.1f}"}
    return Table(rows, forms, ("estimator every", "target"))


def table_of_sanders(comparisons: Sequence[Comparison]) -> Table:
    """Return the distances of the trial beside ours."""
    rows = [
        {
            "sanders": one.sanders,
            "measured": f"{'> ' if one.at_least else ''}{one.measured:.0f} m",
            "simulated": "no stop" if one.distance is None else f"{one.distance:.0f} m",
            "difference": "" if one.off is None else f"{100 * one.off:+.1f} %",
            "": "fitted" if one.fitted else "predicted",
        }
        for one in comparisons
    ]
    return Table(rows, {}, ("sanders", ""))


def _published(stops: Sequence[DryStop]) -> Table:
    rows = [
        {
            "train": stop.train.name,
            "from": 3.6 * one.speed,
            "published": f"{'≤ ' if one.limit else ''}{one.distance:g} m",
            "simulated": stop.distance,
            "source": one.source,
        }
        for stop in stops
        for one in stop.train.reference
        if one.speed == stop.speed
    ]
    return Table(rows, {"from": "{:.0f} km/h", "simulated": "{:.1f} m"}, ("train", "source"))


def _filling(stops: Sequence[DryStop]) -> Table:
    least, most = FILLING
    rows = [
        {
            "train": stop.train.name,
            "filling to 95 %": f"{stop.filling.filling.min():.2f} to {stop.filling.filling.max():.2f} s",
            "UIC 540, P": f"{least:g} to {most:g} s",
            "front": f"{stop.filling.propagation:.0f} m/s",
            "UIC 540": f"≥ {PROPAGATION:g} m/s",
            "last car begins": f"{stop.filling.begin.max():.2f} s",
        }
        for stop in stops
        if stop.filling is not None
    ]
    return Table(rows, {}, ("train",))


def _forces(stops: Sequence[DryStop]) -> Table:
    rows = [
        {
            "train": stop.train.name,
            "largest in a coupler": stop.coupler_force.max() / 1e3,
            "quasi-static": np.abs(stop.hand.coupler_force).max() / 1e3,
            "chain": stop.chain.max() / 1e3,
            "strength": min(coupler.strength for coupler in stop.train.couplers.values()) / 1e3,
        }
        for stop in stops
        if stop.coupler_force.size
    ]
    return Table(
        rows, dict.fromkeys(("largest in a coupler", "quasi-static", "chain", "strength"), "{:.1f} kN"), ("train",)
    )


def _costs(stops: Sequence[DryStop]) -> Table:
    rows = [
        {
            "train": stop.train.name,
            "cars": len(stop.train.cars),
            "axles": len(stop.train.axles),
            "states": stop.states,
            "build": stop.build_s,
            "plant step": stop.plant_step_us,
            "cycle": stop.cycle_us,
        }
        for stop in stops
    ]
    return Table(rows, {"build": "{:.1f} s", "plant step": "{:.1f} µs", "cycle": "{:.1f} µs"}, ("train",))


def _cost_figure(series: Sequence[DryStop]) -> Figure:
    figure, axes = style.panels(6.4, 3.4)
    cars = [len(stop.train.cars) for stop in series]
    axes.plot(cars, [stop.plant_step_us for stop in series], "o-", color=style.BLUE, label="plant step")
    axes.plot(cars, [stop.cycle_us for stop in series], "s-", color=style.ORANGE, label="cycle of the loop")
    axes.legend(frameon=False)
    axes.set_ylim(bottom=0)
    style.dress(axes, x="cars of four axles", y="time of 1 ms [µs]")
    return figure


def _sander_figure(comparisons: Sequence[Comparison]) -> Figure:
    figure, axes = style.panels(6.4, 3.4)
    places = np.arange(len(comparisons))
    axes.bar(places - 0.2, [one.measured for one in comparisons], 0.4, color=style.GREY, label="measured")
    colours = [style.ORANGE if one.fitted else style.BLUE for one in comparisons]
    axes.bar(places + 0.2, [one.distance or 0.0 for one in comparisons], 0.4, color=colours, label="simulated")
    for place, one in zip(places, comparisons, strict=True):
        words = "at least" if one.at_least else "fitted" if one.fitted else f"{100 * (one.off or 0.0):+.0f} %"
        axes.annotate(
            words, (float(place), max(one.measured, one.distance or 0.0)), ha="center", va="bottom", fontsize=8
        )
    axes.set_xticks(places, [one.sanders for one in comparisons], fontsize=8)
    axes.legend(frameon=False)
    style.dress(axes, y="distance [m]")
    return figure
