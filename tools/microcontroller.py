"""The onboard part on a Cortex-M7: memory, instructions and outputs of cases in an emulator."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer
from target_build import DATA, PACKAGES, Measured, TargetBuild, missing_programs

from railgrip.base.arrays import Matrix
from railgrip.base.errors import BuildFailed, CompilerMissing, InputError
from railgrip.base.files import scratch
from railgrip.base.records import make_folder
from railgrip.report.console import progress, say, show_table
from railgrip.report.table import ReportTable, write_tables
from railgrip.scenario.load import load, read_toml

PAGE: Final = Path("docs/how_to/real_time_target.md")

_VALVES: Final = ("actuation.kind=pneumatic",)
_PLANT: Final = ("vehicle.plant=TwoPartTrainPneumatic", *_VALVES)
CASES: Final[Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "central, 13 states": ("trapezoid", (*_PLANT, "estimator.model=TrainPredictionReduced")),
    "central, 25 states": ("trapezoid", _PLANT),
    "decentralised, 13 states": ("railcar", (f"vehicle.train={DATA / 'single_railcar.toml'}", *_VALVES)),
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


def target(
    write: Annotated[bool, typer.Option("--write", help=f"Write the tables into {PAGE}.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="13 states over 50 ms, to check that it runs.")] = False,
    out: Annotated[Path, typer.Option(help="Folder of the tables.")] = Path("build/target"),
) -> None:
    """Run the onboard part for a Cortex-M7 in QEMU over the readings of a stop; compare its outputs.

    The cases are built and run one after the other. It fails if a case does not compile, or if its code has what the
    page excludes, such as a recursion.
    """
    if write and quick:
        raise InputError("--write: only for all cases; leave out --quick.")
    if missing := missing_programs(*(() if quick else ("cppcheck",))):
        raise CompilerMissing(f"{', '.join(missing)}: not on the PATH; {PACKAGES}.")
    rows, checks = list[tuple[str | float, ...]](), list[tuple[str, str, int]]()
    rules, loops = dict[str, set[tuple[str, str]]](), set[int]()
    for name, (scenario, overrides) in [*CASES.items()][: 1 if quick else None]:
        speed = f"start.speed={10 if quick else 30} km/h"
        with progress("target", name), scratch("study") as folder:
            build = TargetBuild(load(Path(scenario), (*overrides, speed)), folder, 50 if quick else None)
            here = build.run_here()
            for arithmetic, flags in ARITHMETIC.items():
                if flags and (quick or name != next(iter(CASES))):
                    continue
                build.compile(*flags, is_single=arithmetic == "single")
                run = build.run()
                loops.add(round(2e5 * run.of_loop))
                rows.append((name, arithmetic, *_figures(build, run, here)))
                if arithmetic == "double":
                    checks.append((name, *_checks(build)))
                    for rule, places in ({} if quick else build.misra()).items():
                        rules.setdefault(rule, set()).update(places)
    tables = {
        "target": ReportTable.of(COLUMNS, rows, left=2),
        "checks": ReportTable.of(("filter", "functions of libraries", "loops that count"), checks, left=2),
        "misra": _misra(rules),
    }
    counted = f"A loop of 200,000 instructions is counted as {' and '.join(f'{each:,}' for each in loops)}."
    make_folder(out)
    for name, table in tables.items():
        table.write_csv(out / f"{name}.csv")
        show_table(table)
    say(counted)
    if write:
        write_tables(PAGE, {**tables, "counted": counted})


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
    reasons = read_toml(DATA / "misra.toml")
    order = sorted(rules, key=lambda rule: [int(part) for part in rule.split(".")])
    columns = ("rule", "findings", "subject", "why it remains")
    return ReportTable.of(
        columns, [(rule, len(rules[rule]), *reasons.get(rule, ("", "not yet assessed"))) for rule in order], left=4
    )
