"""Delay and false alarms of the monitor: many simulated lives, with every stop a run of plant and filter."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from scipy.stats import chi2
from typer import Option

from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, share
from railgrip.studies.pad_monitor.evidence import PRESSURE_OFFSET, Evidence, evidence_of, formation
from railgrip.studies.pad_monitor.life import Life, live
from railgrip.studies.pad_monitor.watch import MonitorDesign, draw, watch
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
        assessment = assessment_of(plan, evidence, design)
        table = assessment.table()
        return Page(
            title="The brake monitor in simulated lives",
            question="How soon does the monitor find a group of wheelsets that has lost 20 % of its friction or no "
            "longer releases, and how often does it alarm without cause?",
            answer=f"Stops until the alarm: {_delays(assessment.worn_delays)} for lost friction, "
            f"{_delays(assessment.stuck_delays)} for a brake that no longer releases. "
            f"False alarms: {assessment.false_alarms} in {assessment.healthy} stops of healthy groups.",
            template="studies/pad_monitor/pad_monitor.md.jinja",
            values={"table": table},
            figures={"life.png": draw(watch(evidence[0], design), design)},
            screen=(table,),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return delays of alarms and false ones in one short life with a worn and a sticking brake."""
        # 20 stops of reference and 8 before the first fault; ten after each, by which it must be found.
        life = Life(stops=52, seed=1, worn=28, worn_group=1, stuck=40, stuck_group=2)
        assessment = assessment_of([life], work.map(evidence_of_life, [life]), MonitorDesign())
        # A chart that ends a hair below its threshold alarms with the next stop.
        return [
            Finding("monitor: stops until lost friction is found", assessment.worn_delays[0], "stops", 1.0),
            Finding("monitor: stops until a sticking brake is found", assessment.stuck_delays[0], "stops", 1.0),
            Finding("monitor: false alarms", float(assessment.false_alarms), "1", 0.5),
        ]


STUDY = PadMonitor


@dataclass(frozen=True, slots=True, kw_only=True)
class Assessment:
    """Performance of the monitor.

    Attributes:
        lives: Number of lives.
        stops: Number of stops in all of them.
        worn_delays: Number of stops from the loss of friction to its alarm in each life; None without an alarm.
        stuck_delays: The same for the sticking brake.
        kinds_right: Share of alarms of the right kind.
        healthy: Number of monitored pairs of stop and healthy group.
        false_alarms: Number of alarms among them.
    """

    lives: int
    stops: int
    worn_delays: tuple[int | None, ...]
    stuck_delays: tuple[int | None, ...]
    kinds_right: float
    healthy: int
    false_alarms: int

    @property
    def rate_bound(self) -> float:
        """95 % upper confidence bound of the rate, exact for a Poisson count: 3/n when none came."""
        return float(chi2.ppf(0.95, 2 * (self.false_alarms + 1)) / 2.0 / self.healthy)

    def table(self) -> ReportTable:
        """Return the figures as a table."""
        rate = f"{self.false_alarms / self.healthy:.2g}, below {self.rate_bound:.2g} at 95 % confidence"
        figures = {
            "lives": str(self.lives),
            "stops in all lives": str(self.stops),
            "stops until the alarm, 20 % of friction lost": _delays(self.worn_delays),
            "stops until the alarm, brake no longer releases": _delays(self.stuck_delays),
            "alarms of the right kind": share(self.kinds_right),
            "stops of healthy groups": str(self.healthy),
            "false alarms": str(self.false_alarms),
            "false alarms per stop and group": rate,
        }
        return ReportTable.of(("figure", "value"), list(figures.items()), left=2)


def _delays(delays: Sequence[int | None]) -> str:
    finite = [delay for delay in delays if delay is not None]
    if not finite:
        return f"none of {len(delays)} found"
    return f"median {np.median(finite):.0f}, at most {max(finite)} ({len(finite)} of {len(delays)} found)"


def assessment_of(plan: Sequence[Life], evidence: Sequence[Sequence[Evidence]], design: MonitorDesign) -> Assessment:
    """Return the performance of the monitor on lives with known evidence: delays and false alarms."""
    worn_delays: list[int | None] = []
    stuck_delays: list[int | None] = []
    healthy = false_alarms = right = alarms_due = 0
    for life, evidences in zip(plan, evidence, strict=True):
        alarms = watch(evidences, design).alarms
        for group, begin, delays, kind in (
            (life.worn_group, life.worn, worn_delays, "friction lost"),
            (life.stuck_group, life.stuck, stuck_delays, "does not release"),
        ):
            end = life.stops if begin is None else begin
            healthy += max(end - design.reference, 0)
            false_alarms += sum(alarm.group == group and alarm.stop < end for alarm in alarms)
            if begin is not None:
                first = next((alarm for alarm in alarms if alarm.group == group and alarm.stop >= begin), None)
                delays.append(None if first is None else first.stop - begin + 1)
                alarms_due += first is not None
                right += first is not None and first.kind == kind
        others = set(range(formation().groups)) - {life.worn_group, life.stuck_group}
        healthy += len(others) * (life.stops - design.reference)
        false_alarms += sum(alarm.group in others for alarm in alarms)
    return Assessment(
        lives=len(plan),
        stops=sum(life.stops for life in plan),
        worn_delays=tuple(worn_delays),
        stuck_delays=tuple(stuck_delays),
        kinds_right=right / max(alarms_due, 1),
        healthy=healthy,
        false_alarms=false_alarms,
    )
