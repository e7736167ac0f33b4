"""The page of the field test: the track recovered, case 6 with each set of noises, and what tuning cannot see."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from railgrip.errors import EstimationError
from railgrip.estimation.recording import truth_of
from railgrip.record.atomic import write_text
from railgrip.report import style
from railgrip.scenario.track import CurveLaw, curve_coefficient
from railgrip.studies.field.degeneracy import Sweep, common_factor, readings_trusted
from railgrip.studies.field.figures import (
    degeneracy_figure,
    friction_figure,
    readings_figure,
    speed_figure,
    track_figure,
)
from railgrip.studies.field.filtering import filter_of, follow, lost, prediction, task_of
from railgrip.studies.field.noise import LIBRARY, NAMES, PHYSICAL, UNITS, Noise, load_noise
from railgrip.studies.field.objective import terms_of
from railgrip.studies.field.runs import TEST, TUNING, brakings
from railgrip.studies.field.score import Score, TrackScore, score, track_score
from railgrip.studies.field.seeds import SEEDS, Spread, over_seeds
from railgrip.track.braking import Braking
from railgrip.twins.field_scenario import FieldScenario

TUNED = {"equation (14)": "paper", "with consistency": "consistent"}
PHYSICAL_NAME = "sensors and physics"


def write_report(scenario: FieldScenario, out: Path, tell: Callable[[str], None] = lambda what: None) -> Path:
    """Run the six cases, recover their track, filter case 6, and write figures and `field.md`.

    Args:
        scenario: The field test.
        out: Folder.
        tell: Called with what is done next.

    Raises:
        EstimationError: A set of noises is missing, or a case cannot be run.
    """
    missing = [case for case in (*TUNING, TEST) if case not in scenario.cases]
    if missing:
        raise EstimationError(f"{scenario.name}: the report wants the cases {', '.join((*TUNING, TEST))}; "
                              f"there is no {', '.join(missing)}.")  # fmt: skip
    noises = {title: load_noise(LIBRARY / f"{name}.toml") for title, name in TUNED.items()}
    noises[PHYSICAL_NAME] = PHYSICAL
    model = prediction()
    made = brakings(scenario, (*TUNING, TEST), lambda case: tell(f"case {case}"))
    tasks = {case: task_of(braking, model) for case, (_, braking) in made.items()}
    filter_ = filter_of(model, scenario.period)
    test, (run, braking) = tasks[TEST], made[TEST]
    followed = {title: follow(test, filter_, noise) for title, noise in noises.items()}
    tell("sweeps")
    others = [tasks[case] for case in TUNING]
    common = common_factor(others, filter_, PHYSICAL)
    trusted = readings_trusted(others, filter_, PHYSICAL)
    spread = over_seeds(scenario, noises, SEEDS, tell)
    tell("figures")
    style.save(track_figure(run, braking, scenario.track.laid().plan()), out / "track.png")
    style.save(speed_figure(run), out / "speed.png")
    style.save(readings_figure(braking), out / "readings.png")
    style.save(friction_figure(test, followed), out / "friction.png")
    style.save(degeneracy_figure(common, trusted), out / "degeneracy.png")
    worst = {
        title: max(terms_of(task, follow(task, filter_, noise)).deviation for task in others)
        for title, noise in noises.items()
    }

    def pads_of(noise: Noise) -> dict[str, float]:
        scores = {case: score(task, follow(task, filter_, noise)) for case, task in tasks.items()}
        return {case: found.pad_friction / found.pad_friction_constant for case, found in scores.items()}

    text = "\n".join(
        (
            "# Field test: friction of a train from pressures and speeds",
            "",
            "After Schwarz, Lüdicke and Heckmann. A twin stands for the train, so that errors are known.",
            "",
            *_track({case: track_score(*pair) for case, pair in made.items()}, made[TEST][1]),
            *_case({title: score(test, told) for title, told in followed.items()}, worst),
            *_lost({title: lost(test, told) for title, told in followed.items()}),
            *_brakes({title: pads_of(noise) for title, noise in noises.items()}),
            *_seeds(spread),
            *_noises(noises),
            *_degeneracy(common, trusted),
        )
    )
    page = out / "field.md"
    write_text(page, text)
    return page


def _track(scores: dict[str, TrackScore], braking: Braking) -> list[str]:
    rows = [
        (case, f"{100 * s.distance:+.4f} %", f"{1e3 * s.curvature:.3f}", f"{1e3 * s.slope:.2f}", f"{s.force:.0f}")
        for case, s in scores.items()
    ]
    weight = 84e3 * 9.81
    laws: tuple[tuple[str, CurveLaw], ...] = (
        ("equation (7)", "bogie"), ("Röckl", "roeckl"), ("Protopapadakis", "protopapadakis"),
    )  # fmt: skip
    bends = ", ".join(f"{name} {float(curve_coefficient(1 / 600, law)) * weight:.0f} N" for name, law in laws)
    force = truth_of(braking.recording, "track_force")
    seconds = (force.size - 1 - braking.brake) * float(braking.recording.attrs["period"])
    return [
        "## Track from GNSS, speed and accelerometers",
        "",
        *_table(("case", "distance", "curvature RMSE [1/km]", "slope RMSE [‰]", "track force RMSE [N]"), rows),
        "",
        f"Case 6 brakes for {seconds:.1f} s, in the paper for 22 s. While it does, the track holds with "
        f"{-force.mean():.0f} N on average. Curve resistance at R = 600 m: "
        f"{bends}.",
        "",
        "![track](track.png)",
        "",
        "![speed](speed.png)",
        "",
    ]


def _case(scores: dict[str, Score], worst: dict[str, float]) -> list[str]:
    rows = [
        (
            title,
            f"{worst[title]:.2e}", f"{s.deviation:.2e}", f"{s.nis:.3g}", f"{s.nees:.3g}",
            f"{s.speed:.2e}", f"{100 * s.distance:+.3f} %", f"{s.adhesion:.4f}", f"{s.pad_friction:.4f}",
            f"{s.mean_pad_friction:.4f}",
        )
        for title, s in scores.items()
    ]  # fmt: skip
    best = next(iter(scores.values()))
    rows.append(("the best constant", "", "", "", "", "", "", f"{best.adhesion_constant:.4f}",
                 f"{best.pad_friction_constant:.4f}", f"{best.mean_pad_friction_constant:.4f}"))  # fmt: skip
    names = (
        "noises", "(14), cases 1–5 [m/s]", "O_6 [m/s]", "NIS", "NEES", "speed RMSE [m/s]", "distance",
        "adhesion RMSE", "pad friction RMSE", "mean pad friction RMSE",
    )  # fmt: skip
    groups = [
        (title, *(f"{a:.4f} / {m:.4f}" for a, m in zip(s.adhesion_of, s.pad_friction_of, strict=True)))
        for title, s in scores.items()
    ]
    return [
        "## Case 6, which no tuning saw",
        "",
        *_table(names, rows),
        "",
        "RMSE of adhesion / pad friction by group:",
        "",
        *_table(("noises", "MB 1", "JTB front", "JTB rear", "MB 2"), groups),
        "",
        "Five rates (of v and four ω) stand against eight unknown frictions. What the train as a whole brakes with is "
        "observed; how four groups share it is not, but for the start and for what changes. The mean pad friction is "
        "therefore better than that of single groups, and no choice of noises can change that.",
        "",
        "![readings](readings.png)",
        "",
        "![friction](friction.png)",
        "",
    ]


def _brakes(shares: dict[str, dict[str, float]]) -> list[str]:
    cases = next(iter(shares.values()))
    rows = [(title, *(f"{share:.2f}" for share in of.values())) for title, of in shares.items()]
    return [
        "Error of the pad friction of single groups over that of the best constant for all, which is known afterwards; "
        "below 1 the filter tells brakes apart:",
        "",
        *_table(("noises", *cases), rows),
        "",
    ]


def _lost(instants: dict[str, float | None]) -> list[str]:
    found = [f"{title} from {instant:.2f} s on" for title, instant in instants.items() if instant is not None]
    return [f"Lost, by its innovations: the filter with the noises {', '.join(found)}.", ""] if found else []


def _seeds(spread: Spread) -> list[str]:
    def told(values: Sequence[float], form: str, factor: float = 1.0) -> str:
        found = factor * np.array(values)
        return f"{found.mean():{form}} ({found.min():{form}} … {found.max():{form}})"

    track = [
        told([s.distance for s in spread.tracks], "+.4f", 100.0),
        told([s.curvature for s in spread.tracks], ".3f", 1e3),
        told([s.slope for s in spread.tracks], ".2f", 1e3),
        told([s.force for s in spread.tracks], ".0f"),
    ]
    rows = [
        (
            title,
            told([s.distance for s in scores], "+.3f", 100.0),
            told([s.adhesion for s in scores], ".4f"),
            told([s.pad_friction for s in scores], ".4f"),
            told([s.mean_pad_friction for s in scores], ".4f"),
            told([s.nees for s in scores], ".2g"),
        )
        for title, scores in spread.scores.items()
    ]
    every = next(iter(spread.scores.values()))
    rows.append(
        (
            "the best constant", "", told([s.adhesion_constant for s in every], ".4f"),
            told([s.pad_friction_constant for s in every], ".4f"),
            told([s.mean_pad_friction_constant for s in every], ".4f"), "",
        )
    )  # fmt: skip
    return [
        f"## Case 6 with {len(spread.tracks)} sets of sensors",
        "",
        "The same run measured by other sensors: mean (least … largest) over seeds of their noise, bias and scale.",
        "",
        *_table(("distance [%]", "curvature RMSE [1/km]", "slope RMSE [‰]", "track force RMSE [N]"), [track]),
        "",
        *_table(
            (
                "noises", "braking distance [%]", "adhesion RMSE", "pad friction RMSE", "mean pad friction RMSE",
                "NEES",
            ),
            rows,
        ),
        "",
    ]  # fmt: skip


def _noises(noises: dict[str, Noise]) -> list[str]:
    rows = [
        (f"{name} [{unit}]", *(f"{noise.values[i]:.2e}" for noise in noises.values()))
        for i, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True))
    ]
    return ["## The twelve noises", "", *_table(("entry", *noises), rows), ""]


def _degeneracy(common: Sweep, trusted: Sweep) -> list[str]:
    return [
        "## What equation (14) cannot see",
        "",
        "A factor on R, Q and the first covariance leaves every gain, hence every mean, as it is: over "
        f"{common.factor.max() / common.factor.min():.0e} of it, (14) moves by "
        f"{common.deviation.max() / common.deviation.min() - 1:.1e} relative, NEES from {common.nees.max():.2g} to "
        f"{common.nees.min():.2g}. One of the twelve numbers is free.",
        "",
        "A factor on R alone, down to zero, makes the filter repeat its readings: (14) falls from "
        f"{trusted.deviation[-1]:.1e} to {trusted.deviation[0]:.1e} m/s, while the RMSE of adhesion goes from "
        f"{trusted.adhesion[-1]:.4f} to {trusted.adhesion[0]:.4f} and that of pad friction from "
        f"{trusted.pad_friction[-1]:.4f} to {trusted.pad_friction[0]:.4f}, with their best, "
        f"{trusted.adhesion.min():.4f} and {trusted.pad_friction.min():.4f}, wherever they are. The bounds of "
        "the search, not the data, decide the "
        "optimum of (14), as the table of noises shows. The objective with consistency takes the readings before "
        "they were seen, and asks NIS and NEES to be 1.",
        "",
        "![degeneracy](degeneracy.png)",
        "",
    ]


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [
        f"| {' | '.join(head)} |",
        f"|{'|'.join('---' for _ in head)}|",
        *(f"| {' | '.join(row)} |" for row in rows),
    ]
