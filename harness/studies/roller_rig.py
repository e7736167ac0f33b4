"""The tests of Schwarz and Keck (2020), §4, on a simulated rig: their filter and railgrip's, against true values."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import xarray
from matplotlib.figure import Figure
from numpy.typing import NDArray
from typer import Option

from railgrip.base.arrays import Mask
from railgrip.campaign.work import Work
from railgrip.estimation.judgement import errors, judge, rms
from railgrip.estimation.models import units_of
from railgrip.estimation.run import by_name, estimate
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import (
    LIBRARY,
    Specification,
    equations_for,
    estimate_of,
    load_specification,
    prediction_for,
    settings_for,
)
from railgrip.estimators.observability import along
from railgrip.recording.samples import evenly, period_of, reading_of, samples, truth_of, with_signals
from railgrip.report import palette, style
from railgrip.report.baseline import Finding, extreme, mean
from railgrip.report.page import Page
from railgrip.report.table import Form, ReportTable, yes_no
from railgrip.scenario.load import load
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import run_stop
from railgrip.simulate.sensors.white import White
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.papers import adhesion_and_brake_friction as published
from railgrip.studies.papers.adhesion_and_brake_friction import LIMIT, RECOVERY
from railgrip.studies.papers.pages import write_results
from railgrip.studies.study import Study


def outside_events(recording: xarray.Dataset, settled: float) -> Mask:
    """Return the samples outside protection events, shape (k,).

    An event lasts while the protection reduces the driver's demand, and `RECOVERY` longer. The first `settled` seconds
    are omitted, in which the estimate converges from its start value.
    """
    time = recording["time"].values
    busy = reading_of(recording, "protecting") > 0.5
    last = np.where(busy, time, -np.inf)
    since = time - np.maximum.accumulate(last)
    return (since > RECOVERY) & (time >= time[0] + settled)


def excursions(recording: xarray.Dataset, estimates: xarray.Dataset, settled: float) -> dict[str, float]:
    """Return measures of an estimate of adhesion outside `LIMIT`, named as in `Row`.

    `adhesion_largest`: error anywhere after the start has settled; `adhesion_outside`: outside protection events;
    `samples_outside`: over the limit outside events; `excursions`: stretches over the limit, anywhere; `longest` of
    them [s]; `kept`: whether the paper's statement holds, within the limit outside events, corrected in time in them.
    """
    time = recording["time"].values
    after = time >= time[0] + settled
    error = np.abs(errors(recording, estimates, "group_adhesion"))
    outside = outside_events(recording, settled)
    # A filter that ended early counts as lost: NaN is over the limit.
    over = ~(error <= LIMIT) & after
    edges = np.flatnonzero(np.diff(np.concatenate([[0], over.astype(int), [0]])))
    lengths = (edges[1::2] - edges[::2]) * period_of(recording)
    outside_and_over, longest = int(np.sum(over & outside)), float(np.max(lengths, initial=0.0))
    return {
        "adhesion_largest": float(np.max(error[after], initial=0.0)),
        "adhesion_outside": float(np.max(error[outside], initial=0.0)),
        "samples_outside": outside_and_over,
        "excursions": lengths.size,
        "longest": longest,
        "kept": outside_and_over == 0 and longest <= RECOVERY,
    }


FILTERS = ("rig_paper", "rig_own")
SCENARIOS: tuple[str, ...] = ("rig_slide", "rig_sand")
WRONG_START = ("start.mean.group_adhesion=0.1", "start.deviation.group_adhesion=0.1")
"""Both filters assume an adhesion of 0.1 at the start, where the wheelset rolls: the paper shows how a wrong start is
corrected, but not which."""
SETTLED = 0.5
"""Seconds after the start in which estimates are not judged."""
SAME_PROTECTION = ("controller.parameters.low=0.10", "controller.parameters.high=0.20")
"""Thresholds of the sliding test, used in the sanding test to separate the effect of sand on interventions."""
PERIODS = (5e-3, 10e-3, 20e-3)
SPEED_NOISES = (0.5e-4, 1e-4, 3.2e-4)
"""Standard deviations of the roller's encoder [m/s]; the last is that of R in equation (20), the root of 1e-7."""


R_OF_SPEED = 1e-7
"""Variance of the roller's speed that equation (20) states [m²/s²]."""

ENCODERS = ("no error", "white noise of R", "steps of variance R")
"""Encoders of the roller: without error, with noise of variance R, and with rounding of variance R."""

DRAWS = 10
"""Number of draws of the noise, or of the offset of the rounding grid."""

FIT_PERIODS = (5e-3, 10e-3, 12e-3, 16e-3, 20e-3, 30e-3)
"""Periods at which equation (20) as printed is tried with each encoder [s]."""

FIRST = "adhesion_and_brake_friction_4.png"
"""Figure by which filters are compared."""

Row = dict[str, Any]
"""One filter on one run, as the files have it; errors against the truth, after the start has settled.

scenario, filter: Of the rig, and name of the estimation; period, speed_noise: of the samples [s], and 1σ of the
roller's speed [m/s]; adhesion_…, pad_friction_…: of adhesion and pad friction, see `judge`; adhesion_largest,
adhesion_outside, samples_outside, excursions, longest, kept: see `excursions`; ended: why the filter ended early, or
nothing."""


def recording_of_rig(scenario: Scenario) -> xarray.Dataset:
    """Return a run on the rig, with `protecting`: 1 while the protection reduces the demanded brake.

    Raises:
        PlantFailed: The plant refused a step.
    """
    trace = evenly(run_stop(scenario).stored_trace, scenario.name)
    # A row has the decision before it; its own decision is in the next row.
    protection = (trace["demand"] < trace["driver_demand"]).values[:, 0]
    return with_signals(trace, {"protecting": (np.append(protection[1:], protection[-1:]), "1")})


def row_of(scenario: Scenario, name: str, recording: xarray.Dataset, estimates: xarray.Dataset) -> Row:
    """Return the errors of a filter on a run."""
    assert isinstance(scenario.sensors, White)
    after = recording["time"].values >= SETTLED
    adhesion, pads = (asdict(judge(recording, estimates, state, after)) for state in ("group_adhesion", "pad_friction"))
    return {
        "scenario": scenario.name,
        "filter": name,
        "period": scenario.periods.trace,
        "speed_noise": scenario.sensors.noise["speed"].si("m/s"),
        **{f"adhesion_{figure}": adhesion[figure] for figure in ("rmse", "bias", "nees", "sd")},
        **excursions(recording, estimates, SETTLED),
        **{f"pad_friction_{figure}": pads[figure] for figure in ("rmse", "bias", "largest", "nees")},
        "pad_friction_covered": pads["coverage"],
        "pad_friction_sd": pads["sd"],
        "ended": str(estimates.attrs["ended"]),
    }


def run_test(scenario: Scenario) -> tuple[xarray.Dataset, dict[str, xarray.Dataset]]:
    """Return a run on the rig, and the estimates of each filter."""
    recording = recording_of_rig(scenario)
    return recording, {name: estimate_of(filter_, recording) for name, filter_ in _filters().items()}


def with_encoder(scenario: Scenario) -> list[Row]:
    """Return the results of both filters on a run, possibly with another encoder of the roller.

    The filter of railgrip gets the noise of the encoder; equation (20) is used as printed.
    """
    assert isinstance(scenario.sensors, White)
    recording, noise = recording_of_rig(scenario), scenario.sensors.noise["speed"].si("m/s")
    rows: list[Row] = []
    for name, filter_ in _filters().items():
        settings = settings_for(filter_, scenario.periods.trace)
        if name == "rig-own":
            settings = replace(settings, readings={**settings.readings, "speed": noise**2})
        estimates = estimate(
            recording, prediction_for(filter_), settings, units=units_of(filter_.model.prediction.model)
        )
        rows.append(row_of(scenario, name, recording, estimates))
    return rows


def fit_of(case: tuple[str, float]) -> Row:
    """Return errors of equation (20) as printed on a test of the rig at a period, with each encoder of the roller.

    For an encoder: median of the errors outside protection events over `DRAWS`, and the number of draws within the
    claim. The bound is the deviation to which `RECOVERY` seconds of readings with the noises of R determine adhesion at
    their
    start, with an exact model: the Cramér-Rao bound of a filter that corrects an error in that time, median over
    windows.
    """
    name, period = case
    specification = _filters()["rig-paper"]
    recording = recording_of_rig(resample(name, period, 1e-9))
    speed, settings = recording["reading_speed"], settings_for(specification, period)
    prediction, equations = prediction_for(specification), equations_for(specification)
    row: Row = {"test": name, "period": f"{1e3 * period:g} ms"}
    for encoder in ENCODERS:
        found: list[dict[str, float]] = []
        for draw in range(1 if encoder == ENCODERS[0] else DRAWS):
            read = with_signals(recording, {"speed": (encode(speed.values, encoder, draw), "m/s")})
            estimates = estimate(read, prediction, settings, units=units_of(specification.model.prediction.model))
            found.append(excursions(read, estimates, SETTLED))
        kept = sum(bool(each["kept"]) for each in found)
        row[encoder] = f"{np.median([each['adhesion_outside'] for each in found]):.4f}, kept {kept} of {len(found)}"
    states = np.stack([truth_of(recording, state) for state in equations.states], axis=1)
    inputs = samples(recording, equations.inputs)
    window = round(RECOVERY / period)
    noise = by_name("readings", settings.readings, equations.outputs)
    _, _, deviation = along(
        equations, states, inputs, period, noise, np.ones(len(equations.states)), window, 10 * window
    )
    known = float(np.median(deviation[:, equations.states.index("group_adhesion")]))
    return row | {"bound of 0.1 s": known}


TRUSTS: tuple[tuple[float, float], ...] = ((1e-9, 1e1), (1e1, 1e1), (1e-9, 1e-9), (1e1, 1e-9), (1e-9, 1e-5))
"""R11 and Q11 of equation (20), of the wheelset's speed: as printed, the other end of the paper's range for each alone
and for both, and a value between."""


def trust_of(case: tuple[float, float]) -> Row:
    """Return errors of adhesion in the sanding test with R11 and Q11 of `TRUSTS` in equation (20), else as printed.

    They are the rms error and the largest in the slide, the range of figure 6, and the rms error after the start.
    """
    reading, process = case
    changes = (f"noise.readings.wheelset_speed={reading}", f"noise.process.wheelset_speed={process}")
    specification = load_specification(LIBRARY / "rig_paper.toml", (*WRONG_START, *changes))
    recording = recording_of_rig(load(Path("rig_sand")))
    error = errors(recording, estimate_of(specification, recording), "group_adhesion")
    time = recording["time"].values
    slide = error[(time >= published.DEEP_SLIDE[0]) & (time <= published.DEEP_SLIDE[1])]
    found = rms(slide), float(np.max(np.abs(slide))), rms(error[time >= time[0] + SETTLED])
    return {"R11": reading, "Q11": process} | dict(zip(TRUST_ERRORS, found, strict=True))


TRUST_ERRORS: Final = ("α rms, 4 to 11 s", "α largest, 4 to 11 s", "α rms, whole test")


WAGONS: Mapping[str, Mapping[str, float]] = {
    "corrected": {},
    "as printed": {"adhesion_share": 0.5, "resistance_transfer": 1.0, "adhesion_transfer": 0.0},
}
"""Parameters of `WagonPrediction` with equations (4), (5) and (12) corrected, and as printed."""
WAGON_STATES: Final = {"α": "group_adhesion", "μ_B front": "pad_friction[1]", "μ_B rear": "pad_friction[2]"}


def wagon_of(name: str) -> Row:
    """Return the biases of adhesion and pad friction of the wagon's filter in its stop, for one of `WAGONS`."""
    changes = tuple(f"model.parameters.{parameter}={value}" for parameter, value in WAGONS[name].items())
    wagon = load_specification(LIBRARY / "wagon.toml", changes)
    recording = recording_of_estimation(wagon)
    estimates = estimate_of(wagon, recording)
    judged = {word: judge(recording, estimates, state) for word, state in WAGON_STATES.items()}
    return {"equations (4), (5), (12)": name} | {
        f"{word} {figure}": getattr(one, figure) for word, one in judged.items() for figure in ("bias", "rmse")
    }


def encode(speed: NDArray[np.float64], encoder: str, draw: int) -> NDArray[np.float64]:
    """Return speeds as one of `ENCODERS` reads them [m/s]."""
    random = np.random.default_rng([20, draw])
    if encoder == "white noise of R":
        return speed + np.sqrt(R_OF_SPEED) * random.standard_normal(speed.shape)
    if encoder == "steps of variance R":
        step, place = np.sqrt(12 * R_OF_SPEED), random.random()
        return step * (np.round(speed / step + place) - place)
    return speed


def _filters() -> dict[str, Specification]:
    return {
        specification.name: specification
        for specification in (load_specification(LIBRARY / f"{name}.toml", WRONG_START) for name in FILTERS)
    }


def resample(name: str, period: float, noise: float) -> Scenario:
    """Return a test of the rig with a sampling period [s] and a standard deviation of the roller's encoder [m/s]."""
    periods = dict.fromkeys(("estimator", "trace"), period) | {"controller": max(period, 0.01)}
    # The plant takes equal steps of at most 10 ms from sample to sample: longer ones miss how the wheelset slides.
    periods["communication"] = period / math.ceil(round(period / _LONGEST_STEP, 9))
    changes = [f'periods.{who}="{each:.12g} s"' for who, each in periods.items()]
    return load(Path(name), [*changes, f'sensors.noise.speed="{noise} m/s"'])


_LONGEST_STEP: Final = 10e-3


@dataclass(frozen=True)
class RollerRig(Study, quick="one other period and encoder, fit and trust each"):
    """Run the roller-rig tests of Schwarz and Keck (2020) with both filters; write figures and tables."""

    write: Annotated[
        bool, Option("--write", help="Write figures and tables into docs/papers/adhesion_and_brake_friction.md.")
    ] = False

    def page(self, work: Work) -> Page:
        """Return both tests with both filters, and the sliding test with other periods and encoders."""
        part = slice(-1, None) if self.quick else slice(None)
        scenarios = [load(Path(name)) for name in SCENARIOS]
        tests = dict(zip(SCENARIOS, work.map(run_test, scenarios), strict=True))
        others = [resample("rig_slide", period, noise) for period in PERIODS[part] for noise in SPEED_NOISES[part]]
        sensitivity = [row for rows in work.map(with_encoder, others) for row in rows]
        rows = _rows(scenarios, list(tests.values()))
        of_fits = work.map(fit_of, [(name, period) for name in SCENARIOS for period in FIT_PERIODS[part]])
        fits = ReportTable(of_fits, {"bound of 0.1 s": "±{:.1e}"}, ("test",), _OF_FITS)
        slide = published.points_of_slide(tests["rig_sand"][0], VehicleData(scenarios[-1]).contact)
        (same_protection,) = work.map(recording_of_rig, [load(Path("rig_sand"), SAME_PROTECTION)])
        found = published.measures(tests, rows, slide, same_protection)
        scores = table_of(rows, scenario="scenario")
        tables = {
            "published": published.table(found),
            "scores": scores,
            "sensitivity": table_of(sensitivity, period="period", **{"σ of v": "speed_noise"}),
            "fits": fits,
            "trust": ReportTable(work.map(trust_of, TRUSTS[part]), _FORMS),
            "wagon": ReportTable(work.map(wagon_of, list(WAGONS)), _FORMS, ("equations (4), (5), (12)",)),
        }
        figures = published.figures(tests, slide)
        if self.write:
            write_results(published.PAGE, tables, figures, found)
        charts = dict(list(figures.items())[2:])  # without the schematic drawings of wagon and rig
        errors_of_tests = {f"{name}_tunings.png": tunings(*test) for name, test in tests.items()}
        rmse = {
            name: [row["adhesion_rmse"] for row in rows if row["filter"] == name] for name in ("rig-paper", "rig-own")
        }
        paper, own = (f"{min(errors):.4f} to {max(errors):.4f}" for errors in rmse.values())
        return Page(
            title="Roller rig: adhesion and pad friction estimated",
            question="How well do the filter of Schwarz and Keck (2020) and ours estimate adhesion on a roller rig?",
            answer=f"In the sliding and the sanding test the RMSE of adhesion is {paper} with Q and R of the paper, "
            f"and {own} with noises that follow from sensors and physics. The figure shows the sliding test.",
            template="studies/roller_rig.md.jinja",
            values=tables,
            figures={FIRST: figures[FIRST], **charts, **errors_of_tests},
            tables={"scores.csv": ReportTable(rows), "sensitivity.csv": ReportTable(sensitivity)},
            screen=(
                tables["published"],
                scores.without(("α bias", "α largest", "α NEES", "μ sd claimed")),
                fits,
            ),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return errors of adhesion and pad friction in both tests, with both filters, and of the goods wagon."""
        scenarios = [load(Path(name)) for name in SCENARIOS]
        findings: list[Finding] = []
        for row in _rows(scenarios, work.map(run_test, scenarios)):
            who = f"{row['scenario']}, {row['filter']}"
            findings += [
                extreme(f"{who}: adhesion error outside protection events", row["adhesion_outside"]),
                Finding(f"{who}: longest adhesion error above 0.02", row["longest"], "s", 1.01 * row["period"]),
                mean(f"{who}: adhesion RMSE", row["adhesion_rmse"]),
                mean(f"{who}: pad friction RMSE", row["pad_friction_rmse"]),
            ]
        wagon = load_specification(LIBRARY / "wagon.toml")
        recording = recording_of_estimation(wagon)
        estimates = estimate_of(wagon, recording)
        findings += [
            mean(f"wagon: {state} RMSE", judge(recording, estimates, state).rmse) for state in WAGON_STATES.values()
        ]
        return findings


STUDY = RollerRig


def _rows(
    scenarios: Sequence[Scenario], tests: Sequence[tuple[xarray.Dataset, dict[str, xarray.Dataset]]]
) -> list[Row]:
    return [
        row_of(scenario, name, recording, estimate)
        for scenario, (recording, estimates) in zip(scenarios, tests, strict=True)
        for name, estimate in estimates.items()
    ]


def table_of(rows: Sequence[Row], **first: str) -> ReportTable:
    """Return rows for readers, after the given columns: title → column of the files."""
    return ReportTable(
        [{title: row[name] for title, name in (first | _COLUMNS).items()} for row in rows],
        _FORMS,
        left=("scenario", "filter", "kept"),
        title="Adhesion and pad friction against the truth",
    )


_COLUMNS = {
    "filter": "filter", "α rmse": "adhesion_rmse", "α bias": "adhesion_bias", "α largest": "adhesion_largest",
    "outside events": "adhesion_outside", "longest > 0.02": "longest", "kept": "kept", "α NEES": "adhesion_nees",
    "μ rmse": "pad_friction_rmse", "μ bias": "pad_friction_bias", "μ NEES": "pad_friction_nees",
    "μ sd claimed": "pad_friction_sd",
}  # fmt: skip

_FORMS: Mapping[str, Form] = {
    **dict.fromkeys(("α rmse", "outside events", "μ rmse"), "{:.4f}"),
    **dict.fromkeys(("α bias", "μ bias"), "{:+.4f}"),
    **dict.fromkeys(("α NEES", "μ NEES", "μ sd claimed"), "{:.2g}"),
    "α largest": "{:.3f}",
    "longest > 0.02": "{:.3f} s",
    "kept": yes_no,
    "period": lambda period: f"{1e3 * period:g} ms",
    "σ of v": "{:.1e} m/s",
    **dict.fromkeys(TRUST_ERRORS, "{:.4f}"),
    **dict.fromkeys(("R11", "Q11"), "{:.0e}"),
    **{f"{state} bias": "{:+.4f}" for state in WAGON_STATES},
    **{f"{state} rmse": "{:.4f}" for state in WAGON_STATES},
}
_OF_FITS: Final = "Equation (20) as printed: adhesion error outside protection events"


def tunings(recording: xarray.Dataset, estimates: Mapping[str, xarray.Dataset]) -> Figure:
    """Draw errors of adhesion and pad friction with claimed standard deviations, one column for each filter."""
    drawing, axes = style.panels(10, 6, 2, len(estimates), sharex=True, squeeze=False)
    time = recording["time"].values
    for column, (name, estimated) in enumerate(estimates.items()):
        for row, (state, word) in enumerate((("group_adhesion", "adhesion"), ("pad_friction", "pad friction"))):
            at = axes[row, column]
            error = estimated["mean"].sel(state=state).values - truth_of(recording, state)
            half_width = 2.0 * estimated["sd"].sel(state=state).values
            reach = max(1.3 * float(np.nanmax(np.abs(error[time >= time[0] + 0.5]))), 1e-3)
            style.band(at, time, -half_width, half_width, palette.SKY, 0.35, label="±2σ claimed")
            at.plot(time, error, color=palette.VERMILION, lw=0.6, label="error")
            at.set_ylim(-reach, reach)
            style.dress(
                at,
                x="time [s]" if row else "",
                y=f"error of {word}" if column == 0 else "",
                title=published.NAMES[name],
            )
            style.legend(at, loc="upper right")
    return drawing
