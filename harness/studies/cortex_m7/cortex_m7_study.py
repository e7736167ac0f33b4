"""The onboard part on a Cortex-M7: memory, instructions and outputs of cases in an emulator."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import pandas
from typer import Option

from railgrip.base.arrays import Matrix
from railgrip.base.errors import BuildFailed, CompilerMissing
from railgrip.base.files import scratch
from railgrip.campaign.work import Work
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, write_tables
from railgrip.scenario.load import load, read_toml
from railgrip.studies.cortex_m7.build import PACKAGES, Measured, TargetBuild, missing_programs
from railgrip.studies.study import Study

PAGE: Final = Path("docs/how_to/real_time_target.md")

_LIBRARY: Final = Path(__file__).parent / "library"
_VALVES: Final = ("actuation.kind=pneumatic",)
_PLANT: Final = ("vehicle.plant=TwoPartTrainPneumatic", *_VALVES)
CASES: Final[Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "central, 13 states": ("trapezoid", (*_PLANT, "estimator.model=TrainPredictionReduced")),
    "central, 25 states": ("trapezoid", _PLANT),
    "decentralised, 13 states": ("railcar", (f"vehicle.train={_LIBRARY / 'single_railcar.toml'}", *_VALVES)),
    "decentralised, 25 states": ("railcar", _VALVES),
}
"""Filter → scenario and overrides; all have valve logic."""

ARITHMETIC: Final = {"double": (), "double, contracted": ("-ffp-contract=fast",), "single": ()}
"""Arithmetic of the filter → flags. Law and valves always compute in double precision."""

COLUMNS: Final = {
    "filter": "{}",
    "arithmetic": "{}",
    "flash [kB]": "{:.1f}",
    "state [kB]": "{:.1f}",
    "stack, computed [kB]": "{:.1f}",
    "stack, painted [kB]": "{:.1f}",
    "instructions a step, median": "{:,.0f}",
    "worst": "{:,.0f}",
    "largest difference": lambda value: "none" if value == 0.0 else f"{value:.1e}",
    "of": "{}",
    "steps with other commands": lambda value: "none" if value == 0.0 else f"{100 * value:.2g} %",
    "ends": "{}",
}
"""Column of a run → its form: memory, instructions of a step, the largest difference of an output that is not a command
over its largest value, `of` which output it is, and the step at which the filter diverges."""


@dataclass(frozen=True)
class CortexM7(Study, quick="13 states over 50 ms"):
    """Compile the onboard part for a Cortex-M7, run it in QEMU over the readings of a stop, and compare its outputs."""

    write: Annotated[bool, Option("--write", help=f"Write the tables into {PAGE}.")] = False
    has_cases = False

    def page(self, work: Work) -> Page:
        """Build and run the cases one after the other.

        Raises:
            CompilerMissing: A program is missing.
            BuildFailed: A case does not compile, or its code has what the page excludes, such as a recursion.
        """
        if missing := missing_programs(*(() if self.quick else ("cppcheck",))):
            raise CompilerMissing(f"{', '.join(missing)}: not on the PATH; {PACKAGES}.")
        rows, checks = list[tuple[str | float, ...]](), list[tuple[str, str, int]]()
        rules, loops = dict[str, set[tuple[str, str]]](), set[int]()
        for name, (scenario, overrides) in [*CASES.items()][: 1 if self.quick else None]:
            work.notify(name)
            speed = f"start.speed={10 if self.quick else 30} km/h"
            with scratch("study") as folder:
                build = TargetBuild(load(Path(scenario), (*overrides, speed)), folder, 50 if self.quick else None)
                here = build.run_here()
                for arithmetic, flags in ARITHMETIC.items():
                    if (flags and name != next(iter(CASES))) or (flags and self.quick):
                        continue
                    build.compile(*flags, is_single=arithmetic == "single")
                    run = build.run()
                    loops.add(round(2e5 * run.of_loop))
                    rows.append((name, arithmetic, *_figures(build, run, here)))
                    if arithmetic == "double":
                        checks.append((name, *_checks(build)))
                        if not self.quick:
                            for rule, places in build.misra().items():
                                rules.setdefault(rule, set()).update(places)
        tables: dict[str, ReportTable | str] = {
            "target": ReportTable.of(COLUMNS, rows, left=2),
            "checks": ReportTable.of(("filter", "functions of libraries", "loops that count"), checks, left=2),
            "misra": _misra(rules),
            "counted": f"A loop of 200,000 instructions is counted as {' and '.join(f'{each:,}' for each in loops)}.",
        }
        if self.write:
            write_tables(PAGE, tables)
        runs = pandas.DataFrame(rows, columns=list(COLUMNS))
        worst = runs.loc[runs["worst"].idxmax()]
        return Page(
            title="The onboard part on a Cortex-M7",
            question="How much memory and how many instructions does the onboard part need on a microcontroller?",
            answer=f"At most {worst['worst']:,.0f} instructions a step ({worst['filter']}, {worst['arithmetic']}).",
            template="studies/cortex_m7/cortex_m7.md.jinja",
            values=tables,
            tables={f"{name}.csv": table for name, table in tables.items() if isinstance(table, ReportTable)},
            screen=tuple(tables.values()),
        )


def _figures(build: TargetBuild, run: Measured, here: Matrix) -> tuple[str | float, ...]:
    sizes, here = build.sizes(), here[: run.failed]
    scale = np.maximum(np.nanmax(np.abs(here), axis=0), np.finfo(float).tiny)
    # NaN, for an unknown value, equals only NaN.
    unlike = np.isnan(here) != np.isnan(run.outputs)
    difference = np.where(unlike, np.inf, np.nan_to_num(np.abs(run.outputs - here)) / scale).max(axis=0)
    is_command = np.array([name.startswith("command") for name in build.outputs])
    worst = int(np.argmax(np.where(is_command, -1.0, difference)))
    other = np.any(run.outputs[:, is_command] != here[:, is_command], axis=1)
    return (
        sizes["flash"] / 1e3,
        sizes["state"] / 1e3,
        build.stack() / 1e3,
        run.stack / 1e3,
        float(np.median(run.instructions)),
        float(np.max(run.instructions)),
        float(difference[worst]),
        build.outputs[worst] if difference[worst] else "",
        float(np.mean(other)),
        "" if run.failed is None else f"diverges at step {run.failed}",
    )


def _checks(build: TargetBuild) -> tuple[str, int]:
    counting, others = build.loops()
    if problems := [*build.variables(), *others]:
        raise BuildFailed(f"{build.name}: states share variables, or a loop does not count: {', '.join(problems)}.")
    return ", ".join(build.linked()), counting


def _misra(rules: Mapping[str, set[tuple[str, str]]]) -> ReportTable:
    reasons = read_toml(_LIBRARY / "misra.toml")
    order = sorted(rules, key=lambda rule: [int(part) for part in rule.split(".")])
    columns = ("rule", "findings", "subject", "why it remains")
    return ReportTable.of(
        columns, [(rule, len(rules[rule]), *reasons.get(rule, ("", "not yet assessed"))) for rule in order], left=4
    )


STUDY = CortexM7
