"""The field test: the recovered track, case 6 with each set of noises, and the limits of tuning."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from typer import Option

from railgrip.base.units import GRAVITY
from railgrip.campaign.work import Work
from railgrip.estimators.compiled import CompiledFilter
from railgrip.recording.samples import truth_of
from railgrip.report.baseline import Finding, mean
from railgrip.report.page import Page
from railgrip.report.table import ReportTable
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.track import CurveLaw, curve_coefficient
from railgrip.studies.field_test.figures import (
    GROUP_NAMES,
    compare_with_paper,
    degeneracy_figure,
    friction_figure,
    readings_figure,
    speed_figure,
    track_figure,
    train_figure,
)
from railgrip.studies.field_test.filtering import (
    NAMES,
    NOISES,
    PHYSICAL,
    TEST,
    TUNING,
    UNITS,
    FieldRun,
    FilterTask,
    Noise,
    cases,
    divergence_time,
    filter_of,
    follow,
    load_noise,
    prediction,
    runs,
    task_of,
)
from railgrip.studies.field_test.score import (
    SEEDS,
    Figures,
    case_6,
    common_factor,
    limits,
    over_seeds,
    readings_trusted,
    score,
    terms_of,
    track_score,
)
from railgrip.studies.papers.pages import write_results
from railgrip.studies.study import Study

TRAIN = Path("vt642")
TUNED = {"equation (14)": "paper", "with consistency": "consistent"}
PUBLISHED = "sensors and physics"
"""Noises of figure 5 in addition to the paper's."""


@dataclass(frozen=True)
class FieldTest(Study, quick="2 seeds in place of 12, and one case in the sweeps"):
    """Recover the track, estimate friction in case 6 with each set of noises, and draw figures 1 to 5 of the paper."""

    campaign: Annotated[
        Path | None, Option(metavar="FILE.toml", help="Cases of a field test; field_test unless given.")
    ] = None
    write: Annotated[bool, Option("--write", help="Write tables and figures into docs/papers.")] = False
    import_from: list[Path] | None = None

    def page(self, work: Work) -> Page:
        """Run the six cases, recover their track, and filter case 6.

        Raises:
            EstimationError: A set of noises or a case is missing, or a case cannot be run.
        """
        folders, scenarios = self.import_from or (), cases(self.campaign)
        noises = {title: load_noise(NOISES / f"{name}.toml") for title, name in TUNED.items()}
        noises[PUBLISHED] = PHYSICAL
        model, of_case = prediction(), runs(scenarios, (*TUNING, TEST), work, folders)
        tasks = {case: task_of(run.braking, model) for case, run in of_case.items()}
        test, others = tasks[TEST], [tasks[case] for case in TUNING]
        filter_ = filter_of(model, test.data.period)
        estimates = {title: follow(test, filter_, noise) for title, noise in noises.items()}
        work.notify("sweeps")
        swept = others[:1] if self.quick else others
        common = common_factor(swept, filter_, PHYSICAL)
        trusted = readings_trusted(swept, filter_, PHYSICAL)
        seeds = SEEDS[:2] if self.quick else SEEDS
        track_spread, score_spread = over_seeds(scenarios[TEST], noises, work, folders, seeds)
        scores = {title: score(test, estimate) for title, estimate in estimates.items()}
        train = load_train(TRAIN)
        tables = {
            "compared": compare_with_paper(train, of_case[TEST], test, estimates[PUBLISHED]),
            "tracks": _tracks(of_case),
            "case": _case(scores, _worst(others, filter_, noises)),
            "pads": _pads(tasks, filter_, noises),
            "noises": noise_table(noises),
            "track_spread": ReportTable.of(
                tuple(_TRACK_SPREAD), [[_spread(track_spread, *of) for of in _TRACK_SPREAD.values()]], left=0
            ),
            "score_spread": _score_spread(score_spread),
        }
        figures = {
            "friction.png": friction_figure(test, estimates),
            "track.png": track_figure(of_case[TEST]),
            "speed.png": speed_figure(of_case[TEST].recording),
            "readings.png": readings_figure(test.braking),
        }
        if self.write:
            published = friction_figure(test, {PUBLISHED: estimates[PUBLISHED]})
            named = {"field_test_1.svg": train_figure(train), "field_test_5.png": published}
            drawn = enumerate(("track.png", "speed.png", "readings.png"), start=2)
            named |= {f"field_test_{n}.png": figures[name] for n, name in drawn}
            write_results("field_test.md", tables, named)
        return Page(
            title="Field test: friction of a train from pressures and speeds",
            question="How well are adhesion and pad friction of a braking train known from its pressures and speeds?",
            answer=_answer(scores),
            template="studies/field_test/field.md.jinja",
            values={
                **_conditions(test),
                **tables,
                "groups": _groups(scores),
                "lost": {
                    title: at for title, run in estimates.items() if (at := divergence_time(test, run)) is not None
                },
                "sets": len(track_spread),
                "common": common,
                "trusted": trusted,
            },
            figures={**figures, "degeneracy.png": degeneracy_figure(common, trusted)},
            screen=(tables["compared"], tables["tracks"], tables["case"]),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return the errors of the recovered track and of the tuned filters in case 6."""
        noises = {name: load_noise(NOISES / f"{name}.toml") for name in TUNED.values()} | {"physical": PHYSICAL}
        ((track, scores),) = work.map(partial(case_6, noises=noises), [cases()[TEST]])
        findings = [
            # By the smoothed motion; 1e-5 are 1 cm over the run.
            Finding(f"field {TEST}: distance, relative error", track["distance"], "1", 1e-5),
            mean(f"field {TEST}: curvature RMSE", track["curvature"], "1/m"),
            mean(f"field {TEST}: slope RMSE", track["slope"]),
            mean(f"field {TEST}: track force RMSE", track["force"], "N"),
        ]
        for name, result in scores.items():
            who = f"field {TEST}, noises '{name}'"
            findings += [
                Finding(f"{who}: braking distance, relative error", result["distance"], "1", 5e-5),
                mean(f"{who}: adhesion RMSE", result["adhesion"]),
                mean(f"{who}: pad friction RMSE", result["pad_friction"]),
                mean(f"{who}: mean pad friction RMSE", result["mean_pad_friction"]),
            ]
        best, who = scores["physical"], f"field {TEST}, the best constant"
        return [
            *findings,
            mean(f"{who}: adhesion RMSE", best["adhesion_constant"]),
            mean(f"{who}: pad friction RMSE", best["pad_friction_constant"]),
            mean(f"{who}: mean pad friction RMSE", best["mean_pad_friction_constant"]),
        ]


STUDY = FieldTest


_LAWS: Mapping[str, CurveLaw] = {"equation (7)": "bogie", "Röckl": "roeckl", "Protopapadakis": "protopapadakis"}


def _conditions(test: FilterTask) -> dict[str, Any]:
    recording = test.braking.recording
    return {
        "seconds": (recording.sizes["time"] - 1 - test.braking.brake) * test.data.period,
        "force": float(truth_of(recording, "track_force").mean()),
        "bends": {name: float(curve_coefficient(1 / 600, law)) * 84e3 * GRAVITY for name, law in _LAWS.items()},
    }


def _tracks(of_case: Mapping[str, FieldRun]) -> ReportTable:
    rows: list[tuple[str, ...]] = []
    for case, run in of_case.items():
        of_run = track_score(run)
        distance, *others = (f"{factor * of_run[name]:{form}}" for name, form, factor in _TRACK_SPREAD.values())
        rows.append((case, f"{distance} %", *others))
    return ReportTable.of(("case", "distance", *list(_TRACK_SPREAD)[1:]), rows)


def _groups(scores: Mapping[str, Figures]) -> ReportTable:
    rows = [
        (title, *(f"{a:.4f} / {m:.4f}" for a, m in zip(s["adhesion_of"], s["pad_friction_of"], strict=True)))
        for title, s in scores.items()
    ]
    return ReportTable.of(("noises", *GROUP_NAMES), rows)


def _pads(tasks: Mapping[str, FilterTask], filter_: CompiledFilter, noises: Mapping[str, Noise]) -> ReportTable:
    rows: list[tuple[Any, ...]] = []
    for title, noise in noises.items():
        scores = [score(task, follow(task, filter_, noise)) for task in tasks.values()]
        rows.append((title, *(one["pad_friction"] / one["pad_friction_constant"] for one in scores)))
    return ReportTable.of(("noises", *tasks), rows, "{:.2f}")


def noise_table(noises: Mapping[str, Noise]) -> ReportTable:
    """Return the twelve noises of each set with the bounds of the search; those at a bound are marked."""
    rows: list[tuple[str, ...]] = []
    for i, (name, unit, (low, high)) in enumerate(zip(NAMES, UNITS, limits(), strict=True)):
        values = [noise.values[i] for noise in noises.values()]
        margins = [min(np.log10(value) - low, high - np.log10(value)) for value in values]
        cells = (
            f"{value:.2e}{' (bound)' if margin < _AT_BOUND else ''}"
            for value, margin in zip(values, margins, strict=True)
        )
        rows.append((f"{name} [{unit}]", *cells, f"{10**low:.0e} – {10**high:.0e}"))
    return ReportTable.of(("entry", *noises, "bounds"), rows)


_AT_BOUND = 0.1
"""Decades from a bound of the search within which a noise counts as at the bound; ranges have seven decades or more."""


def _answer(scores: Mapping[str, Figures]) -> str:
    errors = ", ".join(f"{measures['adhesion']:.4f} ({title})" for title, measures in scores.items())
    return (
        f"In case 6, which was not used for tuning, the RMSE of adhesion is {errors}, depending on the noises of the "
        "filter. The mean pad friction is known better than that of single groups, because five accelerations do not "
        "determine eight frictions."
    )


def _worst(tasks: Sequence[FilterTask], filter_: CompiledFilter, noises: Mapping[str, Noise]) -> dict[str, float]:
    return {
        title: max(terms_of(task, follow(task, filter_, noise)).deviation for task in tasks)
        for title, noise in noises.items()
    }


def _case(scores: Mapping[str, Figures], worst: Mapping[str, float]) -> ReportTable:
    errors = {
        "adhesion RMSE": "adhesion", "pad friction RMSE": "pad_friction", "mean pad friction RMSE": "mean_pad_friction",
    }  # fmt: skip
    rows = [
        {
            "noises": title, "(14), cases 1–5 [m/s]": worst[title], "O_6 [m/s]": s["deviation"], "NIS": s["nis"],
            "NEES": s["nees"], "speed RMSE [m/s]": s["speed"], "distance": 100 * s["distance"],
        }
        | {column: s[name] for column, name in errors.items()}
        for title, s in scores.items()
    ]  # fmt: skip
    constant = next(iter(scores.values()))
    best = {"noises": "the best constant"} | {column: constant[f"{name}_constant"] for column, name in errors.items()}
    forms = {
        **dict.fromkeys(rows[0], "{:.2e}"), **dict.fromkeys(("NIS", "NEES"), "{:.3g}"), "distance": "{:+.3f} %",
        **dict.fromkeys(best, "{:.4f}"),
    }  # fmt: skip
    return ReportTable([*rows, dict.fromkeys(rows[0]) | best], forms, left=("noises",))


_TRACK_SPREAD: Mapping[str, tuple[str, str, float]] = {
    "distance [%]": ("distance", "+.4f", 100.0), "curvature RMSE [1/km]": ("curvature", ".3f", 1e3),
    "slope RMSE [‰]": ("slope", ".2f", 1e3), "track force RMSE [N]": ("force", ".0f", 1.0),
}  # fmt: skip

_SCORE_SPREAD: Mapping[str, tuple[str, str, float]] = {
    "braking distance [%]": ("distance", "+.3f", 100.0), "adhesion RMSE": ("adhesion", ".4f", 1.0),
    "pad friction RMSE": ("pad_friction", ".4f", 1.0), "mean pad friction RMSE": ("mean_pad_friction", ".4f", 1.0),
    "NEES": ("nees", ".2g", 1.0),
}  # fmt: skip


def _score_spread(spread: Mapping[str, Sequence[Figures]]) -> ReportTable:
    rows = [
        {"noises": title} | {name: _spread(scores, *of) for name, of in _SCORE_SPREAD.items()}
        for title, scores in spread.items()
    ]
    scores = next(iter(spread.values()))
    best = {name: _spread(scores, f"{of}_constant", form) for name, (of, form, *_) in _SCORE_SPREAD.items()
            if name.endswith("RMSE")}  # fmt: skip
    return ReportTable([*rows, dict.fromkeys(rows[0]) | {"noises": "the best constant"} | best], left=("noises",))


def _spread(scores: Sequence[Figures], name: str, form: str, factor: float = 1.0) -> str:
    values = factor * np.array([one[name] for one in scores])
    return f"{values.mean():{form}} ({values.min():{form}} … {values.max():{form}})"
