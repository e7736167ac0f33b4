"""Delay and false alarms of the monitor: many simulated lives, with every stop a run of plant and filter."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import pandas
from scipy.stats import chi2
from typer import Option

from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding
from railgrip.report.frame import Frame
from railgrip.report.page import Page
from railgrip.report.statistics import finite
from railgrip.report.table import ReportTable, share
from railgrip.studies.pad_monitor.evidence import PRESSURE_OFFSET, Evidence, evidence_of, formation
from railgrip.studies.pad_monitor.life import Life, live
from railgrip.studies.pad_monitor.watch import Kind, MonitorDesign, draw, watch
from railgrip.studies.study import Study

SEEDS = 20
STOPS = 200
WORN, STUCK = 100, 160
"""Stops at which faults begin, with a sufficient number of stops before and after."""


def lives(seeds: int = SEEDS, stops: int = STOPS, pressure_offset: float = PRESSURE_OFFSET) -> list[Life]:
    """Return lives in which one group loses 20 % and another sticks later, over all pairs of groups."""
    groups = formation().groups
    worn, stuck = round(WORN * stops / STOPS), round(STUCK * stops / STOPS)
    return [
        Life(
            stops=stops,
            seed=seed,
            worn=worn,
            worn_group=seed % groups,
            stuck=stuck,
            stuck_group=(seed + 1 + seed // groups % (groups - 1)) % groups,
            pressure_offset=pressure_offset,
        )
        for seed in range(1, seeds + 1)
    ]


def evidence_of_life(life: Life) -> list[Evidence]:
    """Run every stop of a life; return the evidence of each."""
    return [evidence_of(*stop) for stop in live(life)]


@dataclass(frozen=True)
class PadMonitor(Study, quick="1 life of 60 stops", sizes={"seeds": 1, "stops": 60}):
    """Simulate lives with a worn and a sticking brake; print delays of alarms and the rate of false ones."""

    seeds: Annotated[int, Option(min=1, help="Lives.")] = SEEDS
    stops: Annotated[int, Option(min=40, help="Stops of each.")] = STOPS
    pressure_offset: Annotated[
        float, Option(min=0.0, help="1σ of what pressure transducers are off for a whole life [Pa].")
    ] = PRESSURE_OFFSET

    def page(self, work: Work) -> Page:
        """Return the verdicts of the monitor on all lives, and a figure of the first."""
        design, plan = MonitorDesign(), lives(self.seeds, self.stops, self.pressure_offset)
        evidence = work.map(evidence_of_life, plan)
        groups = judge_groups(plan, evidence, design)
        table = table_of(groups, plan)
        healthy, false_alarms = groups[["healthy", "false_alarms"]].sum()
        return Page(
            title="The brake monitor in simulated lives",
            question="How soon does the monitor find a group of wheelsets that has lost 20 % of its friction or no "
            "longer releases, and how often does it alarm without cause?",
            answer=f"Stops until the alarm: {_delays(groups, 'friction lost')} for lost friction, "
            f"{_delays(groups, 'does not release')} for a brake that no longer releases. "
            f"False alarms: {false_alarms} in {healthy} stops of healthy groups.",
            template="studies/pad_monitor/pad_monitor.md.jinja",
            values={"table": table},
            figures={"life.png": draw(watch(evidence[0], design), design)},
            screen=(table,),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return delays of alarms and false ones in one short life with a worn and a sticking brake."""
        # 20 stops of reference and 8 before the first fault; ten after each, by which it must be found.
        life = Life(stops=52, seed=1, worn=28, worn_group=1, stuck=40, stuck_group=2)
        groups = judge_groups([life], work.map(evidence_of_life, [life]), MonitorDesign())
        worn, stuck = (finite(float(groups["delay"][group])) for group in (life.worn_group, life.stuck_group))
        # A chart that ends a hair below its threshold alarms with the next stop.
        return [
            Finding("monitor: stops until lost friction is found", worn, "stops", 1.0),
            Finding("monitor: stops until a sticking brake is found", stuck, "stops", 1.0),
            Finding("monitor: false alarms", float(groups["false_alarms"].sum()), "1", 0.5),
        ]


STUDY = PadMonitor


def judge_groups(plan: Sequence[Life], evidence: Sequence[Sequence[Evidence]], design: MonitorDesign) -> Frame:
    """Return the alarms of the monitor in lives with known evidence, a row for each group of each life.

    Columns: `fault`, the kind of alarm that is due, None for a healthy group; `delay`, number of stops from the fault
    to its alarm, NaN without one; `is_right`, whether that is of its kind; `healthy`, number of monitored stops before
    the fault; `false_alarms`, number of alarms in them.
    """
    rows: list[dict[str, object]] = []
    for life, evidences in zip(plan, evidence, strict=True):
        alarms = watch(evidences, design).alarms
        faults = {life.worn_group: (life.worn, "friction lost"), life.stuck_group: (life.stuck, "does not release")}
        for group in range(formation().groups):
            begin, kind = faults.get(group, (None, None))
            end = life.stops if begin is None else begin
            own = [alarm for alarm in alarms if alarm.group == group]
            first = next((alarm for alarm in own if alarm.stop >= end), None)
            rows.append(
                {
                    "fault": None if begin is None else kind,
                    "delay": math.nan if first is None else first.stop - end + 1,
                    "is_right": first is not None and first.kind == kind,
                    "healthy": max(end - design.reference, 0),
                    "false_alarms": sum(alarm.stop < end for alarm in own),
                }
            )
    return pandas.DataFrame(rows)


def rate_bound(false_alarms: int, healthy: int) -> float:
    """Return the 95 % upper confidence bound of a rate, exact for a Poisson count: 3/n when none came."""
    return float(chi2.ppf(0.95, 2 * (false_alarms + 1)) / 2.0 / healthy)


def table_of(groups: Frame, plan: Sequence[Life]) -> ReportTable:
    """Return the figures of the monitor as a table."""
    healthy, false_alarms = groups[["healthy", "false_alarms"]].sum()
    bound = rate_bound(false_alarms, healthy)
    figures = {
        "lives": str(len(plan)),
        "stops in all lives": str(sum(life.stops for life in plan)),
        "stops until the alarm, 20 % of friction lost": _delays(groups, "friction lost"),
        "stops until the alarm, brake no longer releases": _delays(groups, "does not release"),
        "alarms of the right kind": share(groups["is_right"].sum() / max(groups["delay"].count(), 1)),
        "stops of healthy groups": str(healthy),
        "false alarms": str(false_alarms),
        "false alarms per stop and group": f"{false_alarms / healthy:.2g}, below {bound:.2g} at 95 % confidence",
    }
    return ReportTable.of(("figure", "value"), list(figures.items()), left=2)


def _delays(groups: Frame, fault: Kind) -> str:
    delays = groups["delay"][groups["fault"] == fault]
    found = delays.dropna()
    if found.empty:
        return f"none of {len(delays)} found"
    return f"median {found.median():.0f}, at most {found.max():.0f} ({len(found)} of {len(delays)} found)"
