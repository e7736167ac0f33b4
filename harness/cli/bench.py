"""How fast everything is."""

from railgrip.cli.app import app
from railgrip.console import progress, show_table


@app.command()
def bench() -> None:
    """Measure speed: medians, and ratios of what ran in turn. Times are shown beside their targets, never judged."""
    from railgrip.bench import Row, machine
    from railgrip.bench.cases import CASES
    from railgrip.report.table import Table

    rows: list[Row] = []
    with progress("measuring") as bar:
        for doing, case in CASES.items():
            bar.update(doing=doing)
            rows += case()
    show_table(Table.of(("what", "measured", "target"), rows, title=machine()))
