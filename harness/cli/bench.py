"""How fast everything is."""

from railgrip.cli.app import app
from railgrip.console import progress, show_table
from railgrip.engine import Engine


@app.command()
def bench() -> None:
    """Measure speed: medians, and ratios of what ran in turn. Times are shown beside their targets, never judged."""
    from railgrip.bench.consist import consist_costs
    from railgrip.bench.estimation import estimation_cost
    from railgrip.bench.fmi import step_cost
    from railgrip.bench.rig_filter import rig_filter_cost
    from railgrip.bench.stop import bare_cost, build_cost, decentralised_cost, filter_cost, machine, stop_costs
    from railgrip.fmus.build import fmu
    from railgrip.report.table import Table

    rows: list[tuple[str, str, str]] = []

    def add(what: str, measured: str, target: str) -> None:
        rows.append((what, measured, target))

    with progress("measuring") as shown:
        shown.update(doing="cold build of all FMUs")
        built = build_cost()
        add(f"cold build of {built.recipes} FMUs", f"{built.wall:.1f} s ({built.cpu:.1f} s of processor)", "10 s")
        for name in ("TwoPartTrain", "TwoPartTrainPneumatic"):
            shown.update(doing=f"steps of {name}")
            cost = step_cost(fmu(name))
            add(f"{name}: set + step of 1 ms + get, ours", f"{cost.ours:.1f} µs", "")
            add("  the same in a loop in C", f"{cost.c:.1f} µs", "10 µs")
            add("  FMPy's FMU2Slave over ours", f"{cost.fmpy_over_ours:.2f}", "")
            add("  fmpy.simulate_fmu over ours", f"{cost.simulate_fmu_over_ours:.2f}", "")
            add("  ours over C", f"{cost.ours_over_c:.2f}", "")
        shown.update(doing="trains of 1 to 16 cars")
        for train in consist_costs():
            what = f"train of {train.cars} four-axle cars, {train.states} states: step of 1 ms in a loop in C"
            add(what, f"{train.step:.1f} µs", "25 µs for four cars" if train.cars == 4 else "")
            add("  build of its FMU", f"{train.build:.1f} s", "30 s for eight cars" if train.cars == 8 else "")
        for model, noise, target in (
            ("TrainPrediction", "train_ideal", "15 µs"),
            ("TrainPredictionReduced", "reduced_ideal", "5 µs"),
        ):
            shown.update(doing=f"filter over {model}")
            filtering = filter_cost(model, noise)
            what = f"compiled filter, {filtering.states} states, a step in place as in the loop"
            add(what, f"{filtering.advance:.1f} µs", target)
            add("  on values", f"{filtering.step:.1f} µs", "")
            add("  filter in numpy over compiled", f"{filtering.reference / filtering.step:.0f}", "")
        for groups in (4, 8, 16, 32):
            shown.update(doing=f"decentralised filter, {groups} groups")
            cost = f"{decentralised_cost(groups):.1f} µs"
            add(f"decentralised filter, {groups} wheelsets that turn apart", cost, "40 µs" if groups == 16 else "")
            add("  with suspension", f"{decentralised_cost(groups, suspension=True):.1f} µs", "")
        shown.update(doing="filter of the roller rig")
        add("compiled filter of the roller rig, in place", f"{rig_filter_cost().advance:.1f} µs", "3 µs")
        shown.update(doing="filter of the field test over a recording")
        estimating = estimation_cost()
        add(
            f"13-state filter over a recording of {estimating.samples} samples, a sample",
            f"{estimating.step:.1f} µs",
            "5 µs",
        )
        add("  estimate of that recording", f"{1e3 * estimating.estimate:.0f} ms", "")
        add("  track and track force from the run before", f"{estimating.course:.1f} s", "")
        whole = 2 * 48 * 61 * estimating.evaluation / 60
        add(
            "tuning: a value over five brakings, one core",
            f"{1e3 * estimating.evaluation:.0f} ms",
            f"both objectives: {whole:.1f} min of 30",
        )
        for what, overrides in {
            "adhesion-based control": (),
            "slip-based control": ("controller.kind=slip_two_state", "estimator.kind=none"),
        }.items():
            shown.update(doing=f"whole stops, {what}")
            costs = stop_costs(*overrides)
            python, compiled = costs[Engine.PYTHON], costs[Engine.COMPILED]
            add(f"{what}: a cycle of the Python engine, figures included", f"{python.cycle:.0f} µs", "60 µs")
            add(f"  whole stop of {python.simulated:.1f} s", f"{python.wall:.2f} s", "2.5 s for 35 s")
            add("  a cycle of the compiled engine, figures included", f"{compiled.cycle:.0f} µs", "")
            add("  the same without a trace", f"{bare_cost(*overrides):.1f} µs", "10 µs")
            add("  Python over compiled", f"{python.cycle / compiled.cycle:.1f}", "")
    show_table(Table.of(("what", "measured", "target"), rows, title=machine()))
