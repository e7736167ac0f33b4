"""Command that searches the parameters of control laws."""

import tomllib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from railgrip.base.errors import ScenarioError
from railgrip.base.files import write_text
from railgrip.base.names import did_you_mean
from railgrip.base.records import make_folder
from railgrip.campaign import searches as laws
from railgrip.campaign.searches import EQUIPMENT, RANGES, Optimum, set_of, text_of
from railgrip.campaign.workers import workers as processes
from railgrip.cli.app import Workers
from railgrip.controllers.parameters import SlipSource, file_of
from railgrip.report.console import progress, say
from railgrip.studies.type_test.entrants import training


def tune_control(
    law: Annotated[list[str] | None, typer.Option(help="A law to search; all unless given.")] = None,
    out: Annotated[Path, typer.Option(help="Folder of the files of parameters.")] = Path("controllers/laws"),
    budget: Annotated[
        int | None,
        typer.Option(min=5, help="Sets of parameters to try for each law; 24 for each parameter unless given."),
    ] = None,
    cases: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=1000,
            help="Search on this number of short training cases of the type test instead of the rails.",
        ),
    ] = None,
    version: Annotated[int, typer.Option(min=1, max=2, help="Version of the type test, with --cases.")] = 1,
    workers: Workers = 2,
) -> None:
    """Search the parameters of the control laws.

    Parameters that are not searched stay as they are in the file of the law. For a law of the published tables, --cases
    writes `<law>.type_test.toml` or `<law>.type_test_2.toml`, so that the accepted distances do not change.
    """
    unknown = sorted(set(law or ()) - RANGES.keys())
    if unknown:
        raise ScenarioError(
            f"tune-control: --law {unknown[0]} is not searched; there is {', '.join(RANGES)}"
            + did_you_mean(unknown[0], RANGES, before="; ")
        )
    make_folder(out)

    def note(name: str, number: int, best: float) -> None:
        say(f"{name}, generation {number}: {100 * best:+.2f} % against slip-based control")

    stops, kinds = None, frozenset(EQUIPMENT)
    if cases is not None:
        stops, kinds = training(cases, version), frozenset({"pneumatic"})
    options = {"--cases": cases, "--budget": budget, "--version": version if cases and version > 1 else None}
    with processes(workers) as pool:
        for each in law or RANGES:
            optima: dict[tuple[str, SlipSource], Optimum] = {}
            for actuation, slip in (kind for kind in RANGES[each] if kind[0] in kinds):
                name = f"{each}, {actuation} actuation, {slip} slip"
                with progress(name, "searching parameters"):
                    notify = partial(note, name)
                    optima[actuation, slip] = laws.search(
                        each,
                        actuation,
                        slip,
                        notify,
                        pool,
                        rail_stops=stops,
                        version=version if cases else None,
                        budget=budget,
                    )
                say(text_of(each, {(actuation, slip): optima[actuation, slip]}))
            command = " ".join(
                (
                    f"railgrip maintain tune-control --law {each}",
                    *(f"{name} {value}" for name, value in options.items() if value),
                )
            )
            path = out / file_of(each, set_of(each, version if cases else None))
            text = text_of(each, optima, command if any(options.values()) else "make tune-control")
            write_text(path, text + _others(path, optima))


def _others(path: Path, optima: Mapping[tuple[str, SlipSource], Optimum]) -> str:
    sets = tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    lines: list[str] = []
    for actuation, slip in ((a, s) for a, of in sets.items() for s in of if (a, s) not in optima):
        values = sets[actuation][slip]
        lines += ["", "# Not searched then.", f"[{actuation}.{slip}]", *(f"{k} = {v!r}" for k, v in values.items())]
    return "".join(f"{line}\n" for line in lines)
