"""Command for one stop."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from railgrip.cli.app import AsJson, File, ImportFrom, Overrides, With, fail, print_json
from railgrip.report.console import progress, remark, say
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome

if TYPE_CHECKING:
    from railgrip.campaign.run import Runner
    from railgrip.report.stop import Stop


def run(
    file: File,
    equipment: With = None,
    overrides: Overrides = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the result; build/runs/NAME-DIGEST, of the scenario, unless given.")
    ] = None,
    import_from: ImportFrom = None,
    as_json: AsJson = False,
) -> None:
    """Run one scenario and print its figures.

    The exit code is 0 for a standstill, 2 for a scenario that cannot be run and 3 for a stop that ended otherwise.
    """
    scenario = load(file, overrides or [], equipment or [])
    # Imported here: xarray and pandas take half a second, which a wrong scenario need not wait for.
    from railgrip.campaign.run import run as run_scenario
    from railgrip.campaign.run import run_folder
    from railgrip.report.results import by_compiler, from_elsewhere
    from railgrip.report.stop import require_no_campaign

    directory = out or run_folder(scenario)
    require_no_campaign(directory)
    with progress(scenario.name, "preparing", scenario.start.speed) as bar:
        stop = run_scenario(
            scenario,
            directory,
            runner(import_from or ()),
            lambda speed: bar.update(phase="stop", amount=scenario.start.speed - speed),
            remark,
        )
    metrics = stop.metrics
    for sentence in stop.warning_sentences():
        remark(sentence)
    if as_json:
        print_json(
            {
                "scenario": scenario.name,
                "digest": scenario.digest(),
                "folder": str(directory),
                "outcome": stop.outcome.value,
                "reason": stop.reason,
                "braking_distance": metrics.distance if stop.outcome is Outcome.STANDSTILL else None,
                "metrics": metrics.to_plain(),
                "doubts": list(metrics.doubts()),
                "fmu_warnings": stop.fmu_warnings,
                "remarks": list(stop.remarks),
            }
        )
        _require_standstill(scenario.name, stop)
        return
    # A foreign plant may not output its adhesion, and then has no utilisation.
    share = f", {used}" if (used := metrics.use_of_adhesion()) else ""
    over = max(metrics.time_over_alpha_max)
    if metrics.utilisation > 1.001 and over > 0.0:  # possible: the bound is also limited by the operator's limit
        share += f" ([limits] alpha_max {scenario.limits.alpha_max:g} exceeded for {over:.2f} s)"
    travelled = f"{metrics.distance_travelled:.2f} m in {metrics.duration:.2f} s"
    say(f"{scenario.name}: {stop.outcome.value}, {travelled}{share}")
    for sentence in metrics.doubts():
        say(f"{scenario.name}: {sentence}")
    if stop.limited_demands:
        say(f"{scenario.name}: {stop.reason}")
    for sentence in from_elsewhere([stop]) and by_compiler([stop]):
        say(f"{scenario.name}: {sentence}")
    say(f"{directory}/stop.json")
    _require_standstill(scenario.name, stop)


def _require_standstill(name: str, stop: "Stop") -> None:
    if stop.outcome is not Outcome.STANDSTILL:
        fail(f"{name}: no braking distance, the stop ended with {stop.outcome.value}: {stop.reason}")


def runner(import_from: Sequence[Path] = ()) -> "Runner":
    """Return the function that runs a scenario; it can be pickled."""
    # Imported here: CasADi and the FMU loader take a second, which a wrong scenario need not wait for.
    from railgrip.simulate.run import run_stop

    if not import_from:
        return run_stop
    from railgrip.simulate.user_parts import CustomParts

    return partial(run_stop, objects=CustomParts(folders=tuple(import_from)))
