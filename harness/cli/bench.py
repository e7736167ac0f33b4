"""Timing of everything that is measured."""

from railgrip.report.console import progress, show_table
from railgrip.report.table import Table
from railgrip.studies.bench import Row, machine
from railgrip.studies.bench.cases import CASES


def bench() -> None:
    """Measure speed, as medians and ratios of cases that run in turn.

    Times are printed beside their targets and are not judged.
    """
    rows: list[Row] = []
    with progress("measuring") as bar:
        for doing, case in CASES.items():
            bar.update(doing=doing)
            rows += case()
    show_table(Table.of(("what", "measured", "target"), rows, title=machine()))
