"""The page of a stop: distance, signals, scenario, metrics and provenance."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from railgrip.report.comparison import flat, unit_of, without_numbers
from railgrip.report.page import Page
from railgrip.report.reference import label
from railgrip.report.results import provenance
from railgrip.report.signals_plot import signals_plot
from railgrip.report.stop import Stop, metrics_table, value_text
from railgrip.report.table import ReportTable
from railgrip.scenario.keys import meanings_of_keys
from railgrip.scenario.outcome import Outcome


def stop_page(stop: Stop, *, back: str = "") -> Page:
    """Return the page of a stop; without samples it has no figure of the signals.

    Args:
        stop: The stop.
        back: Address of the page of its campaign.

    Raises:
        RecordError: The samples do not belong to the figures of the stop.
    """
    scenario = stop.inputs
    return Page(
        title=f"Stop {stop.name}",
        question=question(scenario),
        answer=answer(stop),
        template="report/stop.md.jinja",
        values={
            "back": back,
            "doubts": [*stop.metrics.doubts(), *stop.remarks, *stop.warning_sentences()],
            "reason": stop.reason,
            "description": scenario.get("description", ""),
            "scenario": scenario_table(scenario),
            "metrics": metrics_table(stop.figures),
        },
        plots={"signals": signals_plot(stop.trace)} if stop.has_trace else {},
        provenance=provenance(stop),
    )


def question(scenario: Mapping[str, Any]) -> str:
    """Return the question of a scenario, one sentence."""
    estimator, speed = scenario["estimator"]["kind"], 3.6 * scenario["start"]["speed"]
    return (
        f"How far does the train travel from {speed:.0f} km/h on the rail “{scenario['name'].replace('_', ' ')}” under "
        f"{label(scenario)}, with {scenario['actuation']['kind']} actuation, {scenario['sensors']['kind']} sensors and "
        f"{'no estimator' if estimator == 'none' else f'estimator {estimator}'}?"
    )


def answer(stop: Stop) -> str:
    """Return distance and duration, and the utilisation of the adhesion, in two sentences."""
    metrics = stop.metrics
    way = f"{metrics.distance_travelled:.1f} m in {metrics.duration:.1f} s"
    first = (
        f"The train stops in {way}."
        if stop.outcome is Outcome.STANDSTILL
        else f"The train does not come to a standstill: the stop ends with {stop.outcome.value} after {way}."
    )
    share = f"It uses {100 * metrics.utilisation:.1f} % of the possible adhesion, and its"
    second = (
        f"{share if isfinite(metrics.utilisation) else 'Its'} longest lock lasts {max(metrics.longest_lock):.2f} s."
    )
    if isfinite(metrics.adhesion_allowed):
        second += f" The creep curve allows an adhesion α of {metrics.adhesion_allowed:.4f}, a mean for v²/(2 g α)."
    return f"{first} {second}"


def scenario_table(scenario: Mapping[str, Any]) -> ReportTable:
    """Return every key of a scenario in SI units, with its meaning."""
    rows = [
        {"key": key, "value": ", ".join(map(value_text, value)) if isinstance(value, list) else value_text(value),
         "unit": unit_of(key), "meaning": meanings_of_keys().get(without_numbers(key), "")}
        for key, value in flat(scenario).items()
    ]  # fmt: skip
    return ReportTable(rows, left=("key", "value", "unit", "meaning"))
