"""Names of controllers in tables, and the slip-based control (SBC) that the others are compared with.

There are two references: the published one, two-state at slips of 10 and 15 %, with which the paper compares; and the
best of those with other thresholds, because 10 and 15 % were not chosen for the creep curve of the scenario.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

import pandas

from railgrip.base.units import to_si
from railgrip.report.statistics import endless, on_common
from railgrip.scenario.load import read_toml

CONTROLLERS: Final[Mapping[str, Any]] = read_toml(Path(__file__).parent / "library" / "controllers.toml")
"""Kind of controller → `name`, and `colour` of `railgrip.report.palette` with `lighter` steps, if it has one.

With searched levels, the kind of slip-based control is followed by the source of the slip."""

PUBLISHED = (0.10, 0.15)
"""Slips at which SBC fills and vents; Schwarz, Posielek and Goetjes (2021), section 4."""

_LOCK = 1.0
"""Longest lock from which a distance states it [s]: shorter ones are touches, mostly near standstill."""

_SLIP_BASED = {"slip_two_state", "slip_three_state"}

_Stop = TypeVar("_Stop")


def label(scenario: Mapping[str, Any]) -> str:
    """Return the name of the controller of a resolved scenario, for slip-based control with the thresholds."""
    controller, kind = scenario["controller"], controller_of(scenario)
    name = CONTROLLERS[kind]["name"] if kind in CONTROLLERS else kind
    name += ", of the type test" if str(controller.get("tuning")).startswith("type_test") else ""
    if kind not in _SLIP_BASED:
        return name
    return f"{name} {'/'.join(f'{100 * threshold:.3g}' for threshold in _thresholds(controller))} %"


def locked_text(longest_lock: float | None) -> str:
    """Return the longest lock [s] of a stop, to follow its distance, or nothing if it is short or unknown.

    A distance with a locked wheelset does not show that a law finds the greatest adhesion.
    """
    return f", locked {longest_lock:.1f} s" if longest_lock is not None and longest_lock >= _LOCK else ""


def is_published(controller: Mapping[str, Any]) -> bool:
    """Return whether this is the SBC of the paper."""
    return (
        controller["kind"] == "slip_two_state" and not _is_searched(controller) and _thresholds(controller) == PUBLISHED
    )


def controller_of(scenario: Mapping[str, Any]) -> str:
    """Return the key in `CONTROLLERS` of the controller of a resolved scenario."""
    table = scenario["controller"]
    if not _is_searched(table):
        return table["kind"]
    return f"{table['kind']}_{'read' if scenario['estimator']['kind'] == 'none' else 'estimated'}"


def creep_curves_of(scenario: Mapping[str, Any]) -> str:
    """Return the names of the creep curves of a resolved scenario."""
    adhesion = scenario["adhesion"]
    of_places = (patch["polach"] for patch in adhesion.get("patch", ()) if patch.get("polach"))
    of_leaves = filter(None, [adhesion.get("polach_of_patches")])
    curves = (adhesion["polach"], *adhesion.get("polach_of_wheelset", ()), *of_leaves, *of_places)
    return ", ".join(dict.fromkeys(curve["name"] for curve in curves))


def setting_of(scenario: Mapping[str, Any]) -> tuple[str, str, str]:
    """Return actuation, sensors and creep curves of a resolved scenario."""
    return scenario["actuation"]["kind"], scenario["sensors"]["kind"], creep_curves_of(scenario)


def references(
    stops: Sequence[_Stop], scenario: Callable[[_Stop], Mapping[str, Any]], distance: Callable[[_Stop], float | None]
) -> list[tuple[_Stop | None, _Stop | None]]:
    """Return for each stop those with the published and with the best tuned SBC under the same conditions.

    Conditions are the whole scenario except controller and estimator. The best tuned SBC is chosen for each setting, on
    the stops that all tuned laws have; there is none if they have no stop in common.

    Args:
        stops: Stops of a campaign.
        scenario: Function that returns the resolved scenario of a stop.
        distance: Function that returns the braking distance of a stop [m], None without one.
    """
    scenarios = [scenario(stop) for stop in stops]
    conditions = [
        json.dumps({key: scenario[key] for key in scenario if key not in ("controller", "estimator")}, sort_keys=True)
        for scenario in scenarios
    ]
    published = {
        here: stop
        for here, stop, scenario in zip(conditions, stops, scenarios, strict=True)
        if is_published(scenario["controller"])
    }
    tuned = pandas.DataFrame(
        [
            (setting_of(resolved), json.dumps([resolved["controller"], resolved["estimator"]], sort_keys=True), here,
             math.log(endless(distance(stop))), stop)
            for stop, resolved, here in zip(stops, scenarios, conditions, strict=True)
            if _is_tuned(resolved["controller"])
        ],
        columns=["setting", "law", "conditions", "logarithm", "stop"],
    )  # fmt: skip
    best: dict[str, _Stop] = {}
    for _, laws in tuned.drop_duplicates(["law", "conditions"], keep="last").groupby("setting", sort=False):
        # One law for all stops of a setting, not the best for each stop, which is not known before the stop. Each stop
        # is weighted by its relative saving.
        common = on_common(laws, "law", ["conditions"], "logarithm")
        if len(common):
            first = common.groupby("law", sort=False)["logarithm"].mean().idxmin()
            best |= dict(laws.loc[laws["law"] == first, ["conditions", "stop"]].itertuples(index=False))
    return [(published.get(here), best.get(here)) for here in conditions]


def _is_tuned(controller: Mapping[str, Any]) -> bool:
    return controller["kind"] in _SLIP_BASED and (_is_searched(controller) or _thresholds(controller) != PUBLISHED)


def _is_searched(controller: Mapping[str, Any]) -> bool:
    return controller["kind"] in _SLIP_BASED and controller.get("tuning", "paper") != "paper"


def _thresholds(controller: Mapping[str, Any]) -> tuple[float, float]:
    parameters = controller.get("parameters", {})
    low, high = (parameters.get(name, value) for name, value in zip(("low", "high"), PUBLISHED, strict=True))
    return _ratio(low), _ratio(high)


def _ratio(value: float | str) -> float:
    return to_si(value, "1") if isinstance(value, str) else float(value)
