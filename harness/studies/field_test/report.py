"""The page of the field test: the track recovered, case 6 with each set of noises, and what tuning cannot see."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from railgrip.report import style
from railgrip.report.page import write_page
from railgrip.report.table import Table
from railgrip.scenario.schema import Scenario
from railgrip.scenario.track import CurveLaw, curve_coefficient
from railgrip.studies.field_test.figures import (
    degeneracy_figure,
    friction_figure,
    readings_figure,
    speed_figure,
    track_figure,
)
from railgrip.studies.field_test.filtering import filter_of, follow, lost, prediction, task_of
from railgrip.studies.field_test.noise import LIBRARY, NAMES, PHYSICAL, UNITS, Noise, load_noise
from railgrip.studies.field_test.objective import terms_of
from railgrip.studies.field_test.runs import TEST, TUNING, runs
from railgrip.studies.field_test.score import (
    SEEDS,
    Figures,
    common_factor,
    over_seeds,
    readings_trusted,
    score,
    track_score,
)
from railgrip.trace.samples import truth_of

TUNED = {"equation (14)": "paper", "with consistency": "consistent"}
PHYSICAL_NAME = "sensors and physics"


def write_report(
    scenarios: Mapping[str, Scenario],
    out: Path,
    tell: Callable[[str], None] = lambda what: None,
    import_from: Sequence[Path] = (),
) -> Path:
    """Run the six cases, recover their track, filter case 6, and write figures and `field.md`.

    Raises:
        EstimationError: A set of noises or a case is missing, or a case cannot be run.
    """
    noises = {title: load_noise(LIBRARY / f"{name}.toml") for title, name in TUNED.items()}
    noises[PHYSICAL_NAME] = PHYSICAL
    model = prediction()
    cases = runs(scenarios, (*TUNING, TEST), tell, import_from)
    tasks = {case: task_of(run.braking, model) for case, run in cases.items()}
    test, run = tasks[TEST], cases[TEST]
    braking, filter_ = run.braking, filter_of(model, test.period)
    estimates = {title: follow(test, filter_, noise) for title, noise in noises.items()}
    tell("sweeps")
    others = [tasks[case] for case in TUNING]
    common = common_factor(others, filter_, PHYSICAL)
    trusted = readings_trusted(others, filter_, PHYSICAL)
    track_spread, score_spread = over_seeds(scenarios[TEST], noises, SEEDS, tell, import_from)
    tell("figures")
    style.save(track_figure(run), out / "track.png")
    style.save(speed_figure(run.recording), out / "speed.png")
    style.save(readings_figure(braking), out / "readings.png")
    style.save(friction_figure(test, estimates), out / "friction.png")
    style.save(degeneracy_figure(common, trusted), out / "degeneracy.png")
    worst = {
        title: max(terms_of(task, follow(task, filter_, noise)).deviation for task in others)
        for title, noise in noises.items()
    }

    def pads_of(noise: Noise) -> list[float]:
        scores = [score(task, follow(task, filter_, noise)) for task in tasks.values()]
        return [one["pad_friction"] / one["pad_friction_constant"] for one in scores]

    scores = {title: score(test, estimate) for title, estimate in estimates.items()}
    instants = {title: lost(test, estimate) for title, estimate in estimates.items()}
    return write_page(
        out / "field.md",
        "studies/field_test/field.md.jinja",
        tracks=Table.of(
            ("case", "distance", "curvature RMSE [1/km]", "slope RMSE [‰]", "track force RMSE [N]"),
            [(case, *_track(track_score(one))) for case, one in cases.items()],
        ),
        seconds=(braking.recording.sizes["time"] - 1 - braking.brake) * test.period,
        force=-float(truth_of(braking.recording, "track_force").mean()),
        bends={name: float(curve_coefficient(1 / 600, law)) * 84e3 * 9.81 for name, law in _LAWS.items()},
        case=_case(scores, worst),
        groups=Table.of(
            ("noises", "MB 1", "JTB front", "JTB rear", "MB 2"),
            [
                (title, *(f"{a:.4f} / {m:.4f}" for a, m in zip(s["adhesion_of"], s["pad_friction_of"], strict=True)))
                for title, s in scores.items()
            ],
        ),
        lost={title: instant for title, instant in instants.items() if instant is not None},
        pads=Table.of(("noises", *tasks), [(title, *pads_of(noise)) for title, noise in noises.items()], "{:.2f}"),
        sets=len(track_spread),
        track_spread=Table.of(
            tuple(_TRACK_SPREAD), [[_spread(track_spread, *of) for of in _TRACK_SPREAD.values()]], left=0
        ),
        score_spread=_score_spread(score_spread),
        noises=Table.of(
            ("entry", *noises),
            [
                (f"{name} [{unit}]", *(noise.values[i] for noise in noises.values()))
                for i, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True))
            ],
            "{:.2e}",
        ),
        common=common,
        trusted=trusted,
    )


_LAWS: Mapping[str, CurveLaw] = {"equation (7)": "bogie", "Röckl": "roeckl", "Protopapadakis": "protopapadakis"}


def _track(score: Figures) -> tuple[str, ...]:
    return tuple(
        f"{factor * score[name]:{form}}{' %' if name == 'distance' else ''}"
        for name, form, factor in _TRACK_SPREAD.values()
    )


def _case(scores: Mapping[str, Figures], worst: Mapping[str, float]) -> Table:
    rows = [
        {
            "noises": title, "(14), cases 1–5 [m/s]": worst[title], "O_6 [m/s]": s["deviation"], "NIS": s["nis"],
            "NEES": s["nees"], "speed RMSE [m/s]": s["speed"], "distance": 100 * s["distance"],
            "adhesion RMSE": s["adhesion"], "pad friction RMSE": s["pad_friction"],
            "mean pad friction RMSE": s["mean_pad_friction"],
        }
        for title, s in scores.items()
    ]  # fmt: skip
    constant = next(iter(scores.values()))
    best = {
        "noises": "the best constant", "adhesion RMSE": constant["adhesion_constant"],
        "pad friction RMSE": constant["pad_friction_constant"],
        "mean pad friction RMSE": constant["mean_pad_friction_constant"],
    }  # fmt: skip
    forms = {
        **dict.fromkeys(rows[0], "{:.2e}"), **dict.fromkeys(("NIS", "NEES"), "{:.3g}"), "distance": "{:+.3f} %",
        **dict.fromkeys(best, "{:.4f}"),
    }  # fmt: skip
    return Table([*rows, dict.fromkeys(rows[0]) | best], forms, left=("noises",))


_TRACK_SPREAD: Mapping[str, tuple[str, str, float]] = {
    "distance [%]": ("distance", "+.4f", 100.0), "curvature RMSE [1/km]": ("curvature", ".3f", 1e3),
    "slope RMSE [‰]": ("slope", ".2f", 1e3), "track force RMSE [N]": ("force", ".0f", 1.0),
}  # fmt: skip

_SCORE_SPREAD: Mapping[str, tuple[str, str, float]] = {
    "braking distance [%]": ("distance", "+.3f", 100.0), "adhesion RMSE": ("adhesion", ".4f", 1.0),
    "pad friction RMSE": ("pad_friction", ".4f", 1.0), "mean pad friction RMSE": ("mean_pad_friction", ".4f", 1.0),
    "NEES": ("nees", ".2g", 1.0),
}  # fmt: skip


def _score_spread(spread: Mapping[str, Sequence[Figures]]) -> Table:
    rows = [
        {"noises": title} | {name: _spread(scores, *of) for name, of in _SCORE_SPREAD.items()}
        for title, scores in spread.items()
    ]
    scores = next(iter(spread.values()))
    best = {name: _spread(scores, f"{of}_constant", form) for name, (of, form, *_) in _SCORE_SPREAD.items()
            if name.endswith("RMSE")}  # fmt: skip
    return Table([*rows, dict.fromkeys(rows[0]) | {"noises": "the best constant"} | best], left=("noises",))


def _spread(scores: Sequence[Figures], name: str, form: str, factor: float = 1.0) -> str:
    """Return mean (least … largest) of a figure over seeds."""
    values = factor * np.array([one[name] for one in scores])
    return f"{values.mean():{form}} ({values.min():{form}} … {values.max():{form}})"
