"""The command `bench`; `add_to` puts it on the command line."""

import sys

import typer
from rich.console import Console
from rich.table import Table

from harness.engine import Engine

_out = Console(width=None if sys.stdout.isatty() else 140)
_err = Console(stderr=True)


def bench() -> None:
    """Measure speed: medians, and ratios of what ran in turn. Times are shown beside their targets, never judged."""
    from fmus.build import fmu
    from harness.bench.estimation import estimation_cost
    from harness.bench.fmi import step_cost
    from harness.bench.rig_filter import rig_filter_cost
    from harness.bench.stop import build_cost, filter_cost, machine, stop_costs

    table = Table(box=None, header_style="bold", title=machine(), title_justify="left")
    for column in ("what", "measured", "target"):
        table.add_column(column, overflow="fold")
    with _err.status("measuring") as status:
        status.update("cold build of all FMUs")
        built = build_cost()
        table.add_row(
            f"cold build of {built.recipes} FMUs", f"{built.wall:.1f} s ({built.cpu:.1f} s of processor)", "10 s"
        )
        for name in ("TwoPartTrain", "TwoPartTrainPneumatic"):
            status.update(f"steps of {name}")
            cost = step_cost(fmu(name))
            table.add_row(f"{name}: set + step of 1 ms + get, ours", f"{cost.ours:.1f} µs", "")
            table.add_row("  the same in a loop in C", f"{cost.c:.1f} µs", "10 µs")
            table.add_row("  FMPy's FMU2Slave over ours", f"{cost.fmpy_over_ours:.2f}", "")
            table.add_row("  fmpy.simulate_fmu over ours", f"{cost.simulate_fmu_over_ours:.2f}", "")
            table.add_row("  ours over C", f"{cost.ours_over_c:.2f}", "")
        for model, noise, target in (
            ("TrainPrediction", "train_ideal", "15 µs"),
            ("TrainPredictionReduced", "reduced_ideal", "5 µs"),
        ):
            status.update(f"filter over {model}")
            filtering = filter_cost(model, noise)
            what = f"compiled filter, {filtering.states} states, a step in place as in the loop"
            table.add_row(what, f"{filtering.advance:.1f} µs", target)
            table.add_row("  on values", f"{filtering.step:.1f} µs", "")
            table.add_row("  filter in numpy over compiled", f"{filtering.reference / filtering.step:.0f}", "")
        status.update("filter of the roller rig")
        table.add_row("compiled filter of the roller rig, in place", f"{rig_filter_cost().advance:.1f} µs", "3 µs")
        status.update("filter of the field test over a recording")
        estimating = estimation_cost()
        table.add_row(
            f"13-state filter over a recording of {estimating.samples} samples, a sample",
            f"{estimating.step:.1f} µs",
            "5 µs",
        )
        table.add_row("  estimate of that recording", f"{1e3 * estimating.estimate:.0f} ms", "")
        table.add_row("  track and track force from the run before", f"{estimating.course:.1f} s", "")
        whole = 2 * 48 * 61 * estimating.evaluation / 60
        table.add_row(
            "tuning: a value over five brakings, one core",
            f"{1e3 * estimating.evaluation:.0f} ms",
            f"both objectives: {whole:.1f} min of 30",
        )
        for what, overrides in {
            "adhesion-based control": (),
            "slip-based control": ("controller.kind=slip_two_state", "estimator.kind=none"),
        }.items():
            status.update(f"whole stops, {what}")
            costs = stop_costs(*overrides)
            python, compiled = costs[Engine.PYTHON], costs[Engine.COMPILED]
            table.add_row(f"{what}: a cycle of the Python engine, figures included", f"{python.cycle:.0f} µs", "60 µs")
            table.add_row(f"  whole stop of {python.simulated:.1f} s", f"{python.wall:.2f} s", "2.5 s for 35 s")
            table.add_row("  a cycle of the compiled engine, figures included", f"{compiled.cycle:.0f} µs", "")
            table.add_row("  Python over compiled", f"{python.cycle / compiled.cycle:.1f}", "")
    _out.print(table)


def add_to(app: typer.Typer) -> None:
    """Put the command on the command line."""
    app.command()(bench)
