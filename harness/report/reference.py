"""What a controller is called in tables, and which slip-based control (SBC) the others are compared with.

There are two: the published one, two-state at slips of 10 and 15 %, which the paper compares with; and the best of
those with other thresholds, for 10/15 % was not chosen for the creep curve at hand.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

from railgrip.units import to_si

CONTROLLERS = {
    "full_brake": "full brake",
    "slip_two_state": "SBC, two-state",
    "slip_three_state": "SBC, three-state",
    "slip_two_state_read": "SBC, two-state, searched, read slip",
    "slip_three_state_read": "SBC, three-state, searched, read slip",
    "slip_two_state_estimated": "SBC, two-state, searched, estimated slip",
    "slip_three_state_estimated": "SBC, three-state, searched, estimated slip",
    "adhesion_based": "ABC",
    "adhesion_literal": "ABC, the law as printed",
    "slope_seeking": "slope-seeking control",
    "ideal_bound": "ideal bound",
    "fmu": "FMU",
}
"""Kind of controller → name for people; with searched levels, the kind and how it knows the slip."""

PUBLISHED = (0.10, 0.15)
"""Slips at which SBC fills and vents; Schwarz, Posielek and Goetjes (2021), section 4."""

_SLIP_BASED = {"slip_two_state", "slip_three_state"}

_Stop = TypeVar("_Stop")


def label(scenario: Mapping[str, Any]) -> str:
    """Return what the controller of a resolved scenario is called; one of slip-based control says its thresholds."""
    controller, kind = scenario["controller"], controller_of(scenario)
    name = CONTROLLERS.get(kind, kind) + (", of the type test" if controller.get("tuning") == "type_test" else "")
    if kind not in _SLIP_BASED:
        return name
    return f"{name} {'/'.join(f'{100 * threshold:.3g}' for threshold in _thresholds(controller))} %"


def is_published(controller: Mapping[str, Any]) -> bool:
    """Return whether this is the SBC of the paper."""
    return (
        controller["kind"] == "slip_two_state" and not _is_searched(controller) and _thresholds(controller) == PUBLISHED
    )


def is_tuned(controller: Mapping[str, Any]) -> bool:
    """Return whether this is SBC with thresholds of its own."""
    kind, is_searched = controller["kind"], _is_searched(controller)
    return kind in _SLIP_BASED and (is_searched or _thresholds(controller) != PUBLISHED)


def controller_of(scenario: Mapping[str, Any]) -> str:
    """Return the key in `CONTROLLERS` of the controller of a resolved scenario."""
    table = scenario["controller"]
    if not _is_searched(table):
        return table["kind"]
    return f"{table['kind']}_{'read' if scenario['estimator']['kind'] == 'none' else 'estimated'}"


def best(stops: Sequence[_Stop], law: Callable[[_Stop], str], distance: Callable[[_Stop], float | None]) -> list[_Stop]:
    """Return the stops of the law that stops shortest: whose mean ln(distance) is least.

    Every stop counts by the share of its own distance that a law saves. One law is chosen for all the stops, not the
    best for each: nobody knows beforehand which that is. A stop without a distance is endless.
    """
    laws: dict[str, list[_Stop]] = {}
    for stop in stops:
        laws.setdefault(law(stop), []).append(stop)

    def mean(stops: Iterable[_Stop]) -> float:
        logarithms = [math.inf if (own := distance(stop)) is None else math.log(own) for stop in stops]
        return sum(logarithms) / len(logarithms)

    return min(laws.values(), key=mean, default=[])


def law_of(scenario: Mapping[str, Any]) -> str:
    """Return what tells controllers with their estimators apart."""
    return json.dumps([scenario["controller"], scenario["estimator"]], sort_keys=True)


def _is_searched(controller: Mapping[str, Any]) -> bool:
    return controller["kind"] in _SLIP_BASED and controller.get("tuning", "paper") != "paper"


def _thresholds(controller: Mapping[str, Any]) -> tuple[float, float]:
    parameters = controller.get("parameters", {})
    low, high = (parameters.get(name, value) for name, value in zip(("low", "high"), PUBLISHED, strict=True))
    return _ratio(low), _ratio(high)


def _ratio(value: float | str) -> float:
    return to_si(value, "1") if isinstance(value, str) else float(value)
