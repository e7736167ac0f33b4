"""What a K factor study found: JSON, a page, a figure and rows for the screen."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from railgrip.assemble.files import plant_description
from railgrip.assemble.parties import versions
from railgrip.campaign.sources import sources_digest
from railgrip.files import write_json
from railgrip.report.page import write_page
from railgrip.report.style import band, dress, figure, lead_to_trail, legend, save
from railgrip.report.table import Table
from railgrip.studies.k_factors.rare import estimates, pooled
from railgrip.studies.k_factors.study import PROBABILITIES, Study, plain

_LEVELS = (0, 3, 6, 9)
"""EBCL whose convergence is drawn."""

_HALF_HEIGHT = 0.012  # of the panels of convergence, in K

_METHOD = "exact enumeration of failure states, importance sampling about the worst points within each"

FILES = ("k_factors.json", "k_factors.png", "k_factors.md")


def table(study: Study) -> Table:
    """Return one row for each EBCL: probability, and K with its interval for each output."""
    rows = [
        [str(level), f"{probability:g}", *(_text(plain(k[level])) for k in study.quasi_static.k)]
        for level, probability in enumerate(PROBABILITIES)
    ]
    return Table.of(("EBCL", "P(less)", *study.brake.outputs), rows, left=0)


def sentences(study: Study) -> list[str]:
    """Return what else the study has to say."""
    brake, result, loop = study.brake, study.quasi_static, study.loop
    nominal = ", ".join(f"{output} {a:.3f}" for output, a in zip(brake.outputs, brake.nominal, strict=True))
    lines = [
        f"Nominal deceleration [m/s²]: {nominal}; equivalent time {brake.equivalent_time:.2f} s.",
        f"Nominal stop: {brake.distance:.1f} m quasi-static, {study.plant_distance:.1f} m in the loop "
        f"({100 * (brake.distance / study.plant_distance - 1):+.1f} %).",
        f"{result.draws} draws of {len(result.states)} failure states; all others have a probability of "
        f"{result.neglected:.1e} together.",
    ]
    if loop is not None:
        seconds = loop["seconds"]["stop"]
        cost = [
            f"{p} {stops} stops, {stops * seconds / study.workers / 60:.0f} min"
            for p, stops in loop["estimated_stops"].items()
        ]
        lines += [
            f"With the controller in the loop: K = {_text(loop)} at {loop['probability']:g}, quasi-static "
            f"{_text(loop['quasi_static'])}; {loop['samples']} stops, failure states sampled {loop['states']}, all "
            f"others {loop['neglected_probability']:.1e}; a stop takes a core {seconds:.2f} s.",
            f"The same samples and runs for less likely decelerations, estimated for {study.workers} cores: "
            f"{'; '.join(cost)}. Intervals half as wide take four times as many.",
        ]
    return lines


def write(study: Study, folder: Path) -> Path:
    """Write k_factors.json, k_factors.png and k_factors.md; return the page.

    The same file gives the same bytes, but for times: what is under `seconds`, and the page's sentences on stops.
    """
    specification, brake, result, loop = study.specification, study.brake, study.quasi_static, study.loop
    plant = plant_description(study.scenario)
    content: dict[str, Any] = {
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
            "plant_distance_m": study.plant_distance,
        },
        "k_dry": [
            {"output": output, "ebcl": level, "probability": PROBABILITIES[level], **plain(one)}
            for output, of in zip(brake.outputs, result.k, strict=True)
            for level, one in enumerate(of)
        ],
        "specification": specification.model_dump(mode="json"),
        "scenario_digest": study.scenario.digest(),
        "versions": versions() | {"sources": sources_digest(), plant.file.name: plant.generator},
        "fmus": {plant.file.name: plant.digest},
        "seconds": {"quasi_static": round(result.seconds, 2)},
    }
    if loop is not None:
        content["loop"] = {name: value for name, value in loop.items() if name != "seconds"}
        content["seconds"] |= loop["seconds"]
    write_json(folder / FILES[0], content)
    save(draw(study), folder / FILES[1])
    return write_page(
        folder / FILES[2],
        "studies/k_factors/k_factors.md.jinja",
        specification=specification,
        table=table(study),
        sentences=sentences(study),
        picture=FILES[1],
    )


def draw(study: Study) -> Figure:
    """Return the figure: K over probability for each output, and how K of the whole stop settles with the draws."""
    brake, result = study.brake, study.quasi_static
    drawing = figure(11.0, 5.4)
    grid = drawing.add_gridspec(len(_LEVELS), 2)
    left = drawing.add_subplot(grid[:, 0])
    colours = lead_to_trail(len(brake.outputs))
    levels = np.geomspace(0.5, PROBABILITIES[-1], 120).tolist()
    for output, runs, colour in zip(brake.outputs, result.runs, colours, strict=True):
        whole = pooled(runs, [1 / len(runs)] * len(runs))
        left.semilogy([whole.quantile(p) for p in levels], levels, color=colour, lw=1.2, label=output)
    stop = result.k[-1]
    spread = np.array([[one.value - one.low, one.high - one.value] for one in stop]).T
    left.errorbar([one.value for one in stop], PROBABILITIES, xerr=spread, fmt="o", ms=3, color=colours[-1], capsize=3)
    dress(left, x="K, deceleration over nominal", y="probability of less", title="EBCL 0 to 9, dry")
    legend(left)
    runs = result.runs[-1]
    counts = np.arange(2, len(runs) + 1)
    courses = [estimates(runs[:n], [PROBABILITIES[level] for level in _LEVELS], result.neglected) for n in counts]
    for number, level in enumerate(_LEVELS):
        right = drawing.add_subplot(grid[number, 1])
        k, low, high = (np.array([getattr(one[number], of) for one in courses]) for of in ("value", "low", "high"))
        draws = counts * len(runs[0].values) / 1e3
        right.plot(draws, k, color=colours[-1], lw=1.2)
        band(right, draws, low, high, colours[-1], 0.25)
        right.set_ylim(k[-1] - _HALF_HEIGHT, k[-1] + _HALF_HEIGHT)
        title = "" if number else f"Estimate and 95 % interval, {brake.outputs[-1]}"
        dress(right, x="thousand draws" if level == _LEVELS[-1] else "", y=f"K, EBCL {level}", title=title)
        right.tick_params(labelbottom=level == _LEVELS[-1])
    return drawing


def _text(one: Mapping[str, float]) -> str:
    return f"{one['k']:.4f} ({one['low']:.4f}–{one['high']:.4f})"
