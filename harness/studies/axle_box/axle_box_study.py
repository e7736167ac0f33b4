"""Friction learned from axle-box accelerations: the paper's study, a user's runs, and headline numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Final

import numpy as np
from typer import Argument, Option

from railgrip.base.errors import ScenarioError
from railgrip.base.files import replacing
from railgrip.base.names import did_you_mean
from railgrip.campaign.work import Work, call
from railgrip.estimators.learned.preprocessing import COMBINATIONS
from railgrip.estimators.learned.trained import Trained, save
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack
from railgrip.report.baseline import Finding
from railgrip.report.page import Page
from railgrip.report.table import write_tables
from railgrip.studies.axle_box.bench import bench_tables
from railgrip.studies.axle_box.evaluate import TrainingRecipe, average, exchange_labels, within_runs, without_each
from railgrip.studies.axle_box.instrumented_car import CHANNELS, MPH, SPECTRAL, run_of, spectral_features
from railgrip.studies.axle_box.recordings import judge_recordings, read_folder, read_recordings_file
from railgrip.studies.axle_box.results import acceleration_figure, compare_with_paper, draw, tables_of
from railgrip.studies.axle_box.training import (
    FULL,
    QUICK,
    AxleBoxResults,
    Size,
    campaign,
    dry_or_not,
    estimators_of,
    passes,
    simulate_and_judge,
)
from railgrip.studies.papers.pages import write_results
from railgrip.studies.study import Study

WRITTEN: Final = ("compared", "table3", "inputs", "neurons", "statements", "apart", "slip_rate", "honest", "general")
"""Tables of the page in docs/papers."""
COMPARED: Final = Path("docs/estimators_compared.md")
"""Page of the comparison of estimators, from the folder of the project."""
_SPEED: Final = 60
"""Speed of the shortest runs, mph."""
_LENGTH: Final = 200.0
"""Length of a run, half of the paper's, m."""
_TRAINED: Final = 0.5
"""Relative tolerance of errors of networks, because rounding may lead training to another minimum; a changed plant,
filter or split changes them by more."""
_LEVEL: Final = 1e-3
"""Relative tolerance of means over signals, without training."""


@dataclass(frozen=True)
class AxleBox(Study, quick="short runs at one speed, and small networks"):
    """Learn friction from axle-box accelerations: train, judge, report, and export as FMUs."""

    file: Annotated[
        Path | None, Argument(metavar="[FILE.toml]", help="Your own runs, see studies/axle_box/recordings.py.")
    ] = None
    inputs: Annotated[
        str | None, Option(help="Motions for the paper's networks, such as 'left, right'; longitudinal unless given.")
    ] = None
    write: Annotated[bool, Option("--write", help="Write tables and figures into docs/papers.")] = False
    bench: Annotated[
        bool, Option("--bench", help="Only the family of the comparison of estimators, and slip against friction.")
    ] = False

    def __post_init__(self) -> None:
        if self.inputs is not None and self.inputs not in COMBINATIONS:
            raise ScenarioError(
                f"--inputs is '{self.inputs}'; there is {'; '.join(COMBINATIONS)}"
                + did_you_mean(self.inputs, COMBINATIONS, before="; ")
            )
        if self.file is not None and self.quick:
            raise ScenarioError("--quick is for the simulated runs of the study; leave it out with your own runs.")
        if self.bench and (self.file is not None or self.inputs is not None):
            raise ScenarioError("--bench is for the runs of the study; leave out FILE.toml and --inputs.")
        if self.write and self.file is not None:
            raise ScenarioError("--write is for the simulated runs of the study; leave out FILE.toml.")

    @property
    def place(self) -> str:
        """Folder of a user's runs, after their name, and of the comparison of estimators."""
        if self.bench:
            return "bench"
        return "" if self.file is None else read_recordings_file(self.file).name

    def page(self, work: Work) -> Page:
        """Return the report on the simulated campaign or on a user's runs, with the estimators trained on them."""
        if self.file is not None:
            return self._page_of_recordings(self.file, work)
        size = QUICK if self.quick else FULL
        if self.bench:
            return self._page_of_bench(size, work)
        results = simulate_and_judge(
            size, TrainingRecipe(inputs=self.inputs or "longitudinal", starts=size.starts), work
        )
        tables, figures = tables_of(results), draw(results)
        tables["compared"] = compare_with_paper(results)
        if self.write:
            named = {name: tables[name] for name in WRITTEN}
            numbered = {
                f"axle_box_{n}.png": acceleration_figure({speed: runs})
                for n, (speed, runs) in enumerate(results.runs.items(), start=5)
            }
            numbered |= {"axle_box_9.svg": figures["network.svg"], "axle_box_10.png": figures["within_runs.png"]}
            write_results("axle_box.md", named, numbered)
        return Page(
            title="Friction from axle-box accelerations",
            question="Can friction be estimated from the accelerations of an axle box on runs that no training saw?",
            answer=_answer(results),
            template="studies/axle_box/report.md.jinja",
            values=tables,
            figures=figures,
            files=_files(estimators_of(results.ensemble, results.networks, results.recipe)),
        )

    def _page_of_bench(self, size: Size, work: Work) -> Page:
        tables = bench_tables(size, TrainingRecipe(), work)
        if self.write:
            write_results("axle_box.md", {"slip_regression": tables["slip_regression"]}, {})
            write_tables(COMPARED, {"axle_box": tables["family"]})
        return Page(
            title="Friction from axle-box accelerations: estimators and slip",
            question="Are learned estimators better than a constant on new runs, and does slip depend on friction?",
            answer="The first table has the errors of friction; the second has the exponents of friction in slip.",
            template="studies/axle_box/bench.md.jinja",
            values=dict(tables),
            tables={f"{name}.csv": table for name, table in tables.items()},
            screen=tuple(tables.values()),
        )

    def _page_of_recordings(self, file: Path, work: Work) -> Page:
        specification = read_recordings_file(file)
        network = specification.network
        if self.inputs is not None:
            network = network.model_copy(update={"inputs": self.inputs})
        folder, labels = file.parent / specification.runs.folder, file.parent / specification.runs.labels
        runs, remarks = read_folder(folder, labels, specification.data, work.notify)
        tables, trained = judge_recordings(runs, network.recipe(), work)
        return Page(
            title=f"Friction from axle-box accelerations: {len(runs)} runs",
            question="Can friction be estimated from these accelerations of an axle box, on runs that no training saw?",
            answer="The tables have the mean absolute error with each run left out once, in brackets that of always "
            "estimating the mean label. A network that was trained on a part of the same run only recognises it.",
            template="studies/axle_box/recordings.md.jinja",
            values={**tables, "count": len(runs), "remarks": remarks},
            files=_files(trained),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return errors of the paper's networks at one speed, and levels and features of their training data."""
        recipe = TrainingRecipe(starts=3)
        runs = work.map(run_of, [run for run in campaign(length=_LENGTH) if run.speed == _SPEED * MPH])
        training = {
            "bias inside": partial(within_runs, runs, recipe),
            "bias outside": partial(within_runs, runs, replace(recipe, bias="outside")),
            "labels exchanged": partial(within_runs, exchange_labels(runs), recipe),
            "a run left out": partial(without_each, runs, replace(recipe, starts=1)),
        }
        scores = dict(zip(training, work.map(call, training.values()), strict=True))
        who = f"learn {_SPEED} mph"
        findings = [
            Finding(f"{who}, {name}: MAE", score.mae, "1", _TRAINED * score.mae) for name, score in scores.items()
        ]
        mean = scores["bias inside"].mae_of_mean
        findings.append(Finding(f"{who}, always the mean: MAE", mean, "1", _LEVEL * mean))
        sets = passes(FULL)
        reports = dry_or_not(sets)["campaign"]
        rule = float(np.mean([abs(run.friction - reports[run.name]) for run in sets["campaign"]]))
        findings.append(Finding("learn, dry or not: MAE", rule, "1", _LEVEL * rule))
        for motion in COMBINATIONS["longitudinal, lateral, yaw"]:
            level = float(np.mean([run.blocks[:, CHANNELS[motion]].mean() for run in runs]))
            findings.append(Finding(f"{who}, {motion}: mean of blocks", level, "m/s2", _LEVEL * level))
        features = np.mean([spectral_features(run)[-1] for run in runs], axis=0)
        for name in ("lateral over yaw leading, 2 Hz", "quadrature leading, 4 Hz"):
            value = float(features[SPECTRAL.names.index(name)])
            findings.append(Finding(f"{who}, {name}", value, "1", _LEVEL))
        return findings


STUDY = AxleBox


def _answer(results: AxleBoxResults) -> str:
    words: list[str] = []
    for rows in (results.scores["honest"], results.scores["general"]):
        errors = [average(row.values()) for row in rows.values()]
        mae, of_mean = [error.mae for error in errors], [error.mae_of_mean for error in errors]
        words.append(
            f"{min(mae):.3f} to {max(mae):.3f}, and {min(of_mean):.3f} to {max(of_mean):.3f} of the mean label"
        )
    return (
        "On runs that no training saw, the mean absolute error of friction is "
        f"{words[0]}, with networks of the paper's kind. With one estimator for all speeds it is {words[1]}."
    )


def _files(trained: Mapping[str, Trained]) -> dict[str, Callable[[Path], object]]:
    files: dict[str, Callable[[Path], object]] = {}
    for name, network in trained.items():
        files[f"{name}.json"] = partial(_write_numbers, network)
        files[f"{name}.fmu"] = partial(pack, sources(network.online()))
    return files


def _write_numbers(network: Trained, path: Path) -> None:
    with replacing(path) as partial_file:
        save(network, partial_file)
