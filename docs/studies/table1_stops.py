"""Stops of Table 1 of Schwarz, Posielek and Goetjes (2021) with its identified numbers, and their use of the rail.

The paper publishes neither its creep curve nor brake forces, filter and threshold of its law, and friction only as a
figure. `BOUNDS` are the numbers that were searched; six distances and the sentences on the results are known. For each
candidate three levels of friction, one for each scenario, were solved for, so that slip-based control stops in the
published distances. Candidates were judged by the three distances of the law as printed and by `REQUIRED`, sentences
that must hold in most of the same stops. The law chatters, so that each stop is repeated with perturbed parameters.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

import railgrip as rg
from railgrip.base.arrays import Vector
from railgrip.base.registry import shelf
from railgrip.base.tables import TomlTable
from railgrip.report import palette, style
from railgrip.report.figures import draw_adhesion, draw_wheelsets
from railgrip.report.statistics import endless
from railgrip.report.stop import Stop
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.surface import named_set
from railgrip.simulate.creep_curves import LOAD, SPEED, curves
from railgrip.simulate.creep_curves import SLIPS as STEADY_SLIPS
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.measures import longest_lock

SCENARIOS: tuple[str, ...] = ("trapezoid", "sine_sweep", "random")
SBC, ABC, PEAK_SEEKING = "slip_two_state", "adhesion_literal", "adhesion_based"
LAWS = {SBC: "SBC", ABC: "ABC (paper)", PEAK_SEEKING: "peak seeking (railgrip)"}
"""Slip-based control of the paper, and both forms of adhesion-based control."""
PUBLISHED = {
    (one.match["scenario"].removeprefix("identified_"), one.match["controller"]): one.distance
    for one in load_campaign(shelf("campaigns")["identified"]).references
}
"""Scenario and law → braking distance of Table 1 [m]."""

LIMIT = 0.15
"""Limit of adhesion in the paper, from the TSI."""
COUPLED, LAST_RISE = (9.0, 16.0), 25.0
"""Times of adhesion below the maximum possible, and of the last rise of friction, from the text of the paper [s]."""
SPANS: Mapping[str, tuple[float, float]] = {"before": (0.0, 9.0), "coupled": COUPLED, "after": (COUPLED[1], LAST_RISE)}
"""Spans that the text of the paper distinguishes [s]."""
LOCK_SPEED = 2.0
"""Speed above which no wheelset of the paper's figure locks [m/s]: its adhesion is close to the greatest possible."""
_SMOOTHED = 0.2  # s; slower changes follow the friction of the rail, faster ones are chatter

PERTURBATION = 1e-5
"""Perturbation of all parameters of the plant in repeats: as much as its solver may err in a step, by its tolerance. A
fit that holds only for smaller perturbations depends on the solver."""
REPEATS: Mapping[str, Mapping[str, int]] = {"identified": {SBC: 5, ABC: 21}, "others": {SBC: 1, ABC: 3}}
"""Repeats of a stop with the identified numbers, an odd number, so that the median is a stop, and with other fits."""

Fit = Mapping[str, float]
"""Numbers by name, and levels of friction by scenario.

`k_A`, `k_S`, `A`, `B` of the creep curve, B in s/m; `filter_time`, `slip_small`: filter [s] and threshold of the law;
`contrast`: high over low friction of the trapezoid, before its last rise; `top`: friction after that rise, which levels
do not scale; `ramp`: duration of a rise or fall of the trapezoid [s]; `deviation`: standard deviation of the random
friction; `brake`: adhesion that the full brake of each group demands, at nominal pad friction.
"""

_NUMBERS = ("k_A", "k_S", "A", "B", "filter_time", "slip_small", "contrast", "top", "ramp", "deviation", "brake")
FITS: Mapping[str, Fit] = {
    name: dict(zip((*_NUMBERS, *SCENARIOS), numbers, strict=True))
    for name, numbers in {
        "identified": (1.0, 0.4, 0.595, 1.2, 0.07, 0.002, 23 / 15, 0.158, 2.0, 0.008, 0.15, 0.952, 1.185, 1.159),
        "second": (1.0, 0.4, 0.6, 1.2, 0.07, 0.002, 1.533, 0.16, 2.0, 0.011, 0.15, 0.94481, 1.17783, 1.15692),
        "third": (1.0, 0.35, 0.555, 1.1, 0.085, 0.0015, 1.533, 0.16, 2.0, 0.012, 0.15, 0.99329, 1.2324, 1.21363),
    }.items()
}
"""The best fits of the search that were judged on all three rails, the best first."""
_OF_LIBRARY = (1.0, 0.4, 0.4, 0.6, 0.0042, 0.003, 0.13 / 0.055, 0.13, 1.0, 0.02, 0.134)
LIBRARY: Fit = dict(zip(_NUMBERS, _OF_LIBRARY, strict=True))
"""The library's scenarios: Polach's dry curve, the filter of this project's law, the brakes of the motor bogies."""

# k_A ≤ 1 and the range of k_S/k_A are those of published sets (Polach, 2005; Mal et al., 2020); published A are
# 0.1 to 0.5, B 0.1 to 0.6 s/m, widened on either side. The filter is between one sample of the controller and the
# time in which the rail changes; the threshold below all peaks. Adhesion reaches 0.15 after the last rise, so that
# friction and full brakes are at least about that. Ramps leave two seconds between a rise and the next fall.
BOUNDS: Mapping[str, tuple[float, float]] = {
    "k_A": (0.03, 1.0), "k_S/k_A": (1 / 3, 1.0), "A": (0.05, 0.8), "B": (0.05, 1.5), "filter_time": (1e-3, 0.1),
    "slip_small": (3e-4, 0.02), "contrast": (1.2, 2.5), "top": (0.155, 0.2), "ramp": (0.5, 3.0),
    "deviation": (0.005, 0.03), "brake": (0.145, 0.2),
}  # fmt: skip
"""Bounds of the search."""
LEVELS = (0.5, 2.5)
"""Range in which a level was searched, a factor on the friction of the scenario file."""
LOW = 0.075
"""Low friction of the trapezoid at a level of 1; the level scales it."""
_RISES, _FALL_AND_LOW = (9.0, 17.0, 25.0), 5.0
"""Begins of the rises of the trapezoid, and time from a fall to the next rise [s]: those of the scenario file."""
ADHESION_SMALL = 0.015
"""Estimated adhesion below which the wheel counts as rolling: chosen, not searched."""
_SLIP_BASED = {"controller.kind": SBC, "estimator.kind": "none"}


def value_of(fit: Fit, name: str) -> float:
    """Return one of the numbers of `BOUNDS`."""
    return fit["k_S"] / fit["k_A"] if name == "k_S/k_A" else fit[name]


def polach_of(fit: Fit) -> dict[str, float]:
    """Return the creep curve in the form of scenario files."""
    return {name: fit[name] for name in ("k_A", "k_S", "A", "B")}


def law_of(fit: Fit) -> dict[str, float]:
    """Return the parameters of the law as printed, without the guard at low speed."""
    searched = {name: fit[name] for name in ("filter_time", "slip_small")}
    return searched | {"adhesion_small": ADHESION_SMALL, "speed_min": 0.0}


def rail_of(fit: Fit, scenario: str) -> TomlTable:
    """Return the changes that give a scenario the creep curve, rail and brakes of a fit, and its level of friction.

    The clean rail of the conditioning has the same level, so that wheelsets clean the rail as in the scenario file.
    Controller and plant have the same full brakes: a controller demands at most the pressure that it knows.
    """
    conditioning, level = rg.Scenario.load(scenario).adhesion.conditioning, fit[scenario]
    assert conditioning is not None, "the rises of friction to the rear need it"
    clean = {"fraction": conditioning.fraction, "by": conditioning.by}
    clean["recovered"] = round(level * conditioning.recovered, 5)
    rail: TomlTable = {"polach": polach_of(fit), "level": level, "conditioning": clean}
    if scenario == "trapezoid":
        changes: TomlTable = {"adhesion": rail | {"kind": "points", "over": "time", "points": _steps(fit)}}
    else:
        changes = {f"adhesion.{key}": value for key, value in rail.items()}
    if scenario == "random":
        changes["adhesion.deviation"] = fit["deviation"]
    full = {f"p_max[{group}]": value for group, value in enumerate(pressures_of(fit["brake"]), start=1)}
    return changes | {"vehicle.parameters": full, "controller.parameters": full}


def _steps(fit: Fit) -> list[tuple[str, float]]:
    """Return the points of the trapezoid, whose falls and rises begin at the same instants as in the scenario file."""
    high, ramp = round(fit["contrast"] * LOW, 5), fit["ramp"]
    points = [(0.0, high)]
    for rise in _RISES:
        fall = rise - _FALL_AND_LOW
        after = high if rise < _RISES[-1] else round(fit["top"] / fit["trapezoid"], 5)
        points += [(fall, high), (fall + ramp, LOW), (rise, LOW), (rise + ramp, after)]
    return [(f"{time:g} s", friction) for time, friction in points]


@cache
def pressures_of(brake: float) -> tuple[float, ...]:
    """Return the highest cylinder pressures [Pa] with which each group's full brake demands an adhesion."""
    nominal = VehicleData(rg.Scenario.load("trapezoid")).nominal
    friction = nominal.parameters["mu_b_nominal[1]"]
    pressures: list[float] = []
    for one in nominal.formation.brakes:
        assert one is not None, "the plants of the paper show their brakes"
        force = brake * one.load * one.wheel_radius / (one.units * one.friction_radius * friction)
        pressures.append(round(one.pressure_of(force), -3))
    return tuple(pressures)


def scenario_of(fit: Fit, scenario: str, law: str, seed: int = 0) -> rg.Scenario:
    """Return a scenario with the numbers of a fit and a law of `LAWS`; perturbed by a seed above 0."""
    changes = rail_of(fit, scenario)
    if law == SBC:
        changes |= _SLIP_BASED
    elif law == ABC:
        changes |= {"controller.kind": ABC, "controller.parameters": changes["controller.parameters"] | law_of(fit)}
    if seed:
        changes["vehicle.nudge"] = {"relative": PERTURBATION, "seed": seed}
    return rg.Scenario.load(scenario, changes)


@cache
def stop_of(law: str, seed: int, scenario: str = "trapezoid", rail: str = "identified") -> Stop:
    """Return a stop with one of `FITS`, or on the rail of the library with slip-based control."""
    planned = (
        rg.Scenario.load(scenario, _SLIP_BASED) if rail == "library" else scenario_of(FITS[rail], scenario, law, seed)
    )
    return rg.run(planned)


def cases(quick: bool) -> list[dict[str, Any]]:
    """Return rail, scenario, law and seed of the stops of the page; seed 0 is not perturbed."""
    asked = [("library", scenario, SBC, 0) for scenario in SCENARIOS]
    for rail in list(FITS)[: 1 if quick else None]:
        repeats = REPEATS.get(rail, REPEATS["others"])
        for scenario in SCENARIOS:
            first = 0 if rail == "identified" or scenario == "trapezoid" else 1
            asked += [(rail, scenario, SBC, seed) for seed in range(first, 2 if quick else repeats[SBC] + 1)]
            asked += [(rail, scenario, ABC, seed) for seed in range(1, 2 if quick else repeats[ABC] + 1)]
    asked.append(("identified", "trapezoid", PEAK_SEEKING, 0))
    return [dict(zip(("rail", "scenario", "law", "seed"), one, strict=True)) for one in asked]


def stop_row(rail: str, scenario: str, law: str, seed: int) -> dict[str, float]:
    """Return distance [m] and duration [s] of a stop, and its use of the adhesion of the rail.

    Of wheelset 1: `used_…`, adhesion over the greatest possible up to the limit, means over `SPANS`; `chatter_…`, rms
    deviation of adhesion from its mean over 0.2 s, before and after `LAST_RISE`. Of all groups: `lowest_group`, the
    least of them, used as above until `LAST_RISE`; `peak`, the greatest adhesion; `over`, the longest time that one of
    them has more than `LIMIT` [s]; `lock`, the longest lock of one of them while the train is faster than `LOCK_SPEED`
    [s]. Minimum of μ0 at the first and last wheelset, and when it begins its last rise at the first one [s].
    """
    stop = stop_of.__wrapped__(law, seed, scenario, rail)
    trace = stop.trace
    time, adhesion, mu0 = trace["time"].values, trace["adhesion"].values[:, 0], trace["mu0"].values
    window = round(_SMOOTHED / float(time[1] - time[0]))
    chatter = (adhesion - uniform_filter1d(adhesion, window)) ** 2
    groups = trace["group_adhesion"].values
    shares = groups / np.minimum(trace["peak_adhesion"].values, LIMIT)
    before = time < 26.0
    rising = np.flatnonzero(np.diff(mu0[before, 0]) <= 0)[-1] + 1
    return {
        "distance": endless(stop.braking_distance),
        "duration": stop.metrics.duration,
        **{f"used_{span}": used for span, used in zip(SPANS, used_by_wheelset(stop)[0], strict=True)},
        "chatter_before": float(np.sqrt(np.mean(chatter[time < LAST_RISE]))),
        "chatter_after": float(np.sqrt(np.mean(chatter[time >= LAST_RISE]))),
        "lowest_group": float(shares[time < LAST_RISE].mean(axis=0).min()),
        "peak": float(groups.max()),
        "over": max(stop.metrics.time_over_alpha_max),
        "lock": max(longest_lock(trace, above=LOCK_SPEED)),
        "mu0_front": float(mu0[:, 0].min()),
        "mu0_rear": float(mu0[:, -1].min()),
        "rise": float(time[before][rising]),
    }


def used_by_wheelset(stop: Stop, limit: float = LIMIT) -> list[list[float]]:
    """Return adhesion over the greatest possible up to a limit, means by wheelset and span of `SPANS`."""
    trace = stop.trace
    group = trace["group_of_wheelset"].values - 1
    used = trace["adhesion"].values / np.minimum(trace["peak_adhesion"].values[:, group], limit)
    time = trace["time"].values
    means = [np.mean(used[(time >= begin) & (time < end)], axis=0) for begin, end in SPANS.values()]
    return np.transpose(means).tolist()


def wheelset_rows(law: str, seed: int) -> list[dict[str, float]]:
    """Return the used share of the adhesion in each span, by wheelset."""
    used = used_by_wheelset(stop_of(law, seed))
    return [{"wheelset": number, **dict(zip(SPANS, one, strict=True))} for number, one in enumerate(used, start=1)]


def repeats_of(stops: pd.DataFrame, rail: str, scenario: str) -> pd.DataFrame:
    """Return the repeats with the law as printed, and by how much slip-based control takes longer and uses less."""
    here = stops[(stops["rail"] == rail) & (stops["scenario"] == scenario)]
    repeats, spans = here[here["law"] == ABC].copy(), [f"used_{span}" for span in SPANS]
    for _, sbc in here[(here["law"] == SBC) & (here["seed"] == 0)].iterrows():
        repeats["longer"] = sbc["duration"] - repeats["duration"]
        repeats["used"] = repeats[spans].mean(axis=1)
        repeats["more"] = repeats["used"] - sbc[spans].mean()
    return repeats


def median_seed(repeats: pd.DataFrame) -> int:
    """Return the seed of the repeat with the median distance."""
    ordered = repeats.sort_values("distance", kind="stable")
    return int(ordered["seed"].iloc[len(ordered) // 2])


SHARE = 0.55
"""Minimum adhesion at 15 % slip over the maximum, at 80 km/h and the mean friction of the trapezoid, of a plausible
curve; Polach's dry one has 0.56."""
SAVING = 0.0875
"""The paper's "at least 8.8 %" before it was rounded."""
CLOSE, SIMILAR = 0.85, 0.85
"""Mean use of the possible adhesion that is "very close", and use by each group from which on its wheelsets are like
the first one."""
SUBOPTIMAL, LOWER = 0.02, 0.05
"""Difference of mean uses from which on one is lower than the other, and considerably lower."""
CHATTERING = 1.5
"""Rms of fast changes of adhesion after 25 s over that before, from which on chattering is "significant"."""
OVER, LOCK = 0.1, 0.2
"""Longest time above the limit of adhesion that counts as adherence, as the limit acts after estimate and lag, and time
up to which a wheelset that stands above 2 m/s touches, and does not lock [s]."""
LONGER = (1.5, 2.5)
"""Time by which slip-based control takes longer that is "approximately 2 s" [s]."""
HOLDS = 0.75
"""Share of repeats in which a required sentence must hold."""
REQUIRED = ("close", "limited", "active", "unlocked", "chattering", "longer", "similar")
"""Sentences that the search required."""


def judged(repeats: pd.DataFrame) -> pd.DataFrame:
    """Return whether sentences of the paper on the trapezoid hold, a column for each; `repeats` are `repeats_of`."""
    used = repeats[["used_before", "used_after"]].min(axis=1)
    return pd.DataFrame(
        {
            "close": used >= CLOSE,
            "suboptimal": repeats["used_coupled"] <= used - SUBOPTIMAL,
            "unlocked": repeats["lock"] <= LOCK,
            "limited": repeats["over"] <= OVER,
            "active": repeats["peak"] >= LIMIT,
            "chattering": repeats["chatter_after"] >= CHATTERING * repeats["chatter_before"],
            "longer": repeats["longer"].between(*LONGER),
            "lower": repeats["more"] >= LOWER,
            "similar": repeats["lowest_group"] >= SIMILAR,
        }
    )


RAILS = {"wet": ("wet_two_maxima", 0.15), "leaves": ("leaves_two_maxima", 0.06)}
"""Creep curve and maximum friction of both rails of figure 1."""
SPEEDS = {40: ":", 80: "-", 120: "--"}
"""Line style by speed [km/h]."""
CAUSES = {"heat alone": (palette.GREY, ":"), "cleaning alone": (palette.GREEN, "--"), "cleaning and heat": ("k", "-")}
OWN_WAY = 10.0
"""Distance over which the friction of the first wheelset settles with its own slip [m], which takes 200 strides."""


def curve_rows(rail: str, causes: str, speed: float) -> list[dict[str, float]]:
    """Return adhesion of wheelset 1 over slip on a rail that slip heats, cleans, or both, at a speed [km/h]."""
    name, mu0 = RAILS[rail]
    cold = {key: value for key, value in named_set(name).items() if key != "temperature_loss"}
    polach = cold if causes == "cleaning alone" else name
    constant, cleaned = curves(polach, mu0, speed=speed / 3.6, way=OWN_WAY)
    adhesion = constant if causes == "heat alone" else cleaned[:, 0]
    return [{"slip": slip, "adhesion": one} for slip, one in zip(STEADY_SLIPS.tolist(), adhesion.tolist(), strict=True)]


SLIPS = np.geomspace(1e-3, 1.0, 200)


def creep_curve(fit: Fit, friction: float) -> Vector:
    """Return the adhesion at `SLIPS` for a maximum friction, at `SPEED` and `LOAD`."""
    same = np.ones(SLIPS.size)
    contact = VehicleData(rg.Scenario.load("plain", {"adhesion.polach": polach_of(fit)})).contact
    return contact(SLIPS, SPEED * same, LOAD * same, friction * same)


def share_of(fit: Fit, friction: float) -> float:
    """Return the adhesion at 15 % slip over the maximum."""
    curve = creep_curve(fit, friction)
    return float(np.interp(0.15, SLIPS, curve) / curve.max())


def mean_friction(fit: Fit) -> float:
    """Return the mean of low and high friction of the trapezoid, before its last rise."""
    return fit["trapezoid"] * LOW * (1 + fit["contrast"]) / 2


def rail_figure() -> Figure:
    """Draw maximum friction of the library's rails over time (figure 3)."""
    drawing, panels = style.panels(9, 6.6, len(SCENARIOS), 1, sharex=True)
    for panel, name in zip(panels, SCENARIOS, strict=True):
        trace = stop_of(SBC, 0, name, "library").trace
        draw_wheelsets(panel, trace["time"].values, trace["mu0"].values)
        style.dress(panel, y="maximum friction μ₀", title=name.replace("_", " "), ylim=(0, None))
    panels[0].axvline(LAST_RISE, color=palette.BLACK, linestyle="--", linewidth=1)
    panels[0].text(LAST_RISE - 0.15, 0.1, "published:\nlast rise", fontsize=8, ha="right")
    style.legend(panels[0], ncols=4, loc="lower left")
    panels[-1].set(xlabel="time since the brake demand [s]", xlim=(0, None))
    return drawing


def adhesion_figure(seeds: Mapping[str, int]) -> Figure:
    """Draw adhesion of the first wheelset with SBC and each law, with statements of the text (figure 4)."""
    sbc = stop_of(SBC, seeds[SBC])
    drawing, panels = style.panels(9, 6, 2, 1, sharex=True, sharey=True)
    for panel, law in zip(panels, (ABC, PEAK_SEEKING), strict=True):
        ours = stop_of(law, seeds[law])
        draw_adhesion(panel, {"SBC": sbc.trace, LAWS[law]: ours.trace}, LIMIT)
        for begin, end, place, words in (
            (*COUPLED, COUPLED[0] + 0.15, "published: below the greatest"),
            (LAST_RISE, 40, LAST_RISE + 3.1, "published:\nchattering"),
        ):
            panel.axvspan(begin, end, color=palette.SKY, alpha=0.2, linewidth=0)
            panel.text(place, 0.008, words, fontsize=8)
        title = f"{LAWS[law]}: {ours.metrics.distance:.1f} m; SBC: {sbc.metrics.distance:.1f} m"
        style.dress(panel, y="adhesion of wheelset 1", title=title, ylim=(0, 0.24))
        style.legend(panel, ncols=3, loc="upper left")
    panels[-1].set_xlabel("time since the brake demand [s]")
    return drawing


def wheelset_figure(seeds: Mapping[str, int]) -> Figure:
    """Draw adhesion of all wheelsets but the first with SBC and the law as printed."""
    traces = {LAWS[law]: stop_of(law, seeds[law]).trace for law in (SBC, ABC)}
    numbers = range(1, traces["SBC"].sizes["wheelset"])
    drawing, panels = style.panels(9, 1.7 * len(numbers) + 0.6, len(numbers), 1, sharex=True, sharey=True)
    for panel, number in zip(panels, numbers, strict=True):
        draw_adhesion(panel, traces, LIMIT, wheelset=number)
        style.dress(panel, y="adhesion", title=f"wheelset {number + 1}", ylim=(0, 0.24))
    panels[-1].set_xlabel("time since the brake demand [s]")
    style.legend(drawing, *panels[0].get_legend_handles_labels(), ncols=5, loc="outside upper center")
    return drawing


def chosen() -> pd.DataFrame:
    """Return every other quantity on which the six distances depend and that the paper does not give.

    They are read from the scenarios: changes there appear here.
    """
    fit = FITS["identified"]
    found: dict[str, str] = {}
    # Free numbers of the fit, and keys that the scenarios do not use.
    left_out = ("kind", "polach", "polach_of_wheelset", "level", "calibrated", "over", "patch", "deviation")
    for name in SCENARIOS:
        scenario = scenario_of(fit, name, SBC)
        adhesion = dict(scenario.resolved()["adhesion"])
        conditioning = adhesion.pop("conditioning")
        course = {key: value for key, value in adhesion.items() if key not in left_out and value is not None}
        if name == "trapezoid":
            course = {"low": f"{LOW:g}", "falls begin at": "4, 12 and 20 s", "rises at": "9, 17 and 25 s"}
        course |= {f"conditioning {key}": value for key, value in conditioning.items()}
        texts = [f"{key.replace('_', ' ')} {value}" for key, value in (course | {"seed": scenario.seed}).items()]
        found[f"friction over time, {name.replace('_', ' ')}"] = ", ".join(texts)
    scenario = rg.Scenario.load("trapezoid")
    periods = (scenario.periods.communication, scenario.periods.estimator, scenario.periods.controller)
    pressures = " / ".join(f"{pressure / 1e5:.2f} bar" for pressure in pressures_of(fit["brake"]))
    found |= {
        "lag of the cylinder pressure": "20 ms (plant parameter T_pressure)",
        "periods of loop, filter and law": " / ".join(f"{1e3 * period:g} ms" for period in periods),
        "end of the stop": f"{scenario.limits.stop_speed:g} m/s",
        "sensors": "exact",
        "noises of the filter": "set 'ideal' of TrainPrediction",
        "adhesion_small of the law": f"{ADHESION_SMALL:g}",
        "guards of the law": "rolling and hold, see the validation page; not the one below 0.5 m/s",
        "train": "masses, inertias, suspension and running resistance of TwoPartTrain",
        "highest cylinder pressures": f"{pressures}, from the brake of the table above",
        "pad friction": "first-order law of this project, not that of Ehret (2021)",
        "slip-based control": "releases above 15 %, applies below 10 %, at once in each period",
        "second and later wheelsets": "the friction of the first one at the same time, conditioned",
    }
    return pd.DataFrame(found.items(), columns=["quantity", "chosen"])
