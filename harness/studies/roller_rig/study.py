"""The tests of Schwarz and Keck (2020), §4, on a simulated rig: their filter and ours, judged against the truth."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import xarray

from railgrip.assemble import run_stop
from railgrip.estimation.judge import judge
from railgrip.estimation.run import estimate, units_of
from railgrip.estimation.spec import (
    LIBRARY,
    Specification,
    estimate_of,
    load_specification,
    prediction_for,
    settings_for,
)
from railgrip.report.page import write_page
from railgrip.report.table import Form, Table, yes_no
from railgrip.scenario.load import load
from railgrip.scenario.schema import Scenario
from railgrip.scenario.sensors import WhiteSensors
from railgrip.studies.roller_rig.figures import over_slip, rig_run, tunings
from railgrip.studies.roller_rig.protection import LIMIT, excursions
from railgrip.trace.samples import evenly, with_signals

FILTERS = ("rig_paper", "rig_own")
SCENARIOS = ("rig_slide", "rig_sand")
SETTLED = 0.5
"""Seconds after the start in which estimates are not judged."""
DEEP_SLIDE = (3.0, 11.0)
"""Seconds of the sanding test in which adhesion passes its peak, falls, comes back and goes to zero: figure 6."""

PERIODS = (5e-3, 10e-3, 20e-3)
SPEED_NOISES = (0.5e-4, 1e-4, 3.2e-4)
"""Of the roller's encoder [m/s]; the last is what the R of equation (20) says, the square root of 1e-7."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One filter on one run; errors of adhesion and pad friction against the truth, after the start has settled.

    Attributes:
        scenario: Of the rig.
        filter: Name of the estimation.
        period: Of the samples [s].
        speed_noise: 1σ of the roller's speed [m/s].
        alpha_rmse: Of adhesion; `alpha_bias`, `alpha_nees` and `alpha_sd` likewise.
        alpha_largest: Largest error anywhere.
        alpha_outside: Largest error outside protection events.
        samples_outside: Samples outside events with an error above 0.02.
        excursions: Stretches above 0.02, anywhere.
        longest: Of these [s].
        kept: Whether ≤ 0.02 outside events and ≤ 0.1 s in them holds.
        mu_b_rmse: Of pad friction; `mu_b_bias`, `mu_b_nees`, `mu_b_covered` and `mu_b_sd` likewise.
        ended: Why the filter ended early, or nothing.
    """

    scenario: str
    filter: str
    period: float
    speed_noise: float
    alpha_rmse: float
    alpha_bias: float
    alpha_nees: float
    alpha_sd: float
    alpha_largest: float
    alpha_outside: float
    samples_outside: int
    excursions: int
    longest: float
    kept: bool
    mu_b_rmse: float
    mu_b_bias: float
    mu_b_largest: float
    mu_b_nees: float
    mu_b_covered: float
    mu_b_sd: float
    ended: str


def recording_of_rig(scenario: Scenario) -> xarray.Dataset:
    """Return a run on the rig, with `protecting`: 1 while the protection keeps the brake from giving what is asked for.

    Raises:
        PlantFailed: The plant refused a step.
    """
    trace = evenly(run_stop(scenario).trace, scenario.name)
    # A row holds what was decided before it: the next one what was decided in it.
    protection = (trace["demand"] < trace["driver_demand"]).values[:, 0]
    return with_signals(trace, {"protecting": (np.append(protection[1:], protection[-1:]), "1")})


def row_of(scenario: Scenario, name: str, recording: xarray.Dataset, estimates: xarray.Dataset) -> Row:
    """Return how a filter did on a run."""
    assert isinstance(scenario.sensors, WhiteSensors)
    after = recording["time"].values >= SETTLED
    alpha, pads = (judge(recording, estimates, state, after) for state in ("alpha", "mu_b"))
    left = excursions(recording, estimates, SETTLED)
    return Row(
        scenario=scenario.name,
        filter=name,
        period=scenario.periods.communication,
        speed_noise=scenario.sensors.noise["speed"].si("m/s"),
        alpha_rmse=alpha.rmse,
        alpha_bias=alpha.bias,
        alpha_nees=alpha.nees,
        alpha_sd=alpha.sd,
        alpha_largest=left.largest,
        alpha_outside=left.largest_outside,
        samples_outside=left.outside,
        excursions=left.count,
        longest=left.longest,
        kept=left.kept,
        mu_b_rmse=pads.rmse,
        mu_b_bias=pads.bias,
        mu_b_largest=pads.largest,
        mu_b_nees=pads.nees,
        mu_b_covered=pads.covered,
        mu_b_sd=pads.sd,
        ended=str(estimates.attrs["ended"]),
    )


def study(out: Path, tell: Callable[[str], None] = lambda what: None) -> tuple[Row, ...]:
    """Run both tests with both filters; write figures, `scores.csv`, `sensitivity.csv` and `rig.md` into `out`.

    Raises:
        EstimationError: A file of the library does not fit the models.
        PlantFailed: The rig refused a step.
    """
    filters = {spec.name: spec for spec in (load_specification(LIBRARY / f"{name}.toml") for name in FILTERS)}
    rows: list[Row] = []
    for name in SCENARIOS:
        tell(name)
        scenario = load(Path(name))
        recording = recording_of_rig(scenario)
        estimates_of = {key: estimate_of(spec, recording) for key, spec in filters.items()}
        rows += [row_of(scenario, key, recording, estimates) for key, estimates in estimates_of.items()]
        for key, estimates in estimates_of.items():
            rig_run(recording, estimates, out / f"{name}_{key}.png", title=f"{scenario.description}: {key}")
        tunings(recording, estimates_of, out / f"{name}_tunings.png")
        Table([asdict(row) for row in rows]).write_csv(out / "scores.csv")
        if name == "rig_sand":
            over_slip(recording, estimates_of, out / "rig_sand_over_slip.png", between=DEEP_SLIDE, limit=LIMIT)
    sensitivities = sensitivity(filters, tell)
    Table([asdict(row) for row in sensitivities]).write_csv(out / "sensitivity.csv")
    write_page(
        out / "rig.md",
        "studies/roller_rig/rig.md.jinja",
        scores=table_of(rows, scenario="scenario"),
        sensitivity=table_of(sensitivities, period="period", **{"σ of v": "speed_noise"}),
    )
    return tuple(rows)


def sensitivity(filters: dict[str, Specification], tell: Callable[[str], None] = lambda what: None) -> list[Row]:
    """Return both filters on the sliding test at other sampling periods and other encoders of the roller.

    Our filter is told the noise of the encoder that it has; equation (20) is what it is.
    """
    rows: list[Row] = []
    for period in PERIODS:
        for noise in SPEED_NOISES:
            tell(f"period {1e3 * period:g} ms, speed noise {noise:g} m/s")
            periods = dict.fromkeys(("communication", "estimator", "trace"), period) | {"controller": max(period, 0.01)}
            changes = [f'periods.{who}="{each} s"' for who, each in periods.items()]
            scenario = load(Path("rig_slide"), [*changes, f'sensors.noise.speed="{noise} m/s"'])
            recording = recording_of_rig(scenario)
            for key, spec in filters.items():
                settings = settings_for(spec, period)
                if key == "rig-own":
                    settings = replace(settings, readings={**settings.readings, "speed": noise**2})
                estimates = estimate(recording, prediction_for(spec), settings, units=units_of(spec.model.class_))
                rows.append(row_of(scenario, key, recording, estimates))
    return rows


def table_of(rows: Sequence[Row], **first: str) -> Table:
    """Return rows as people read them, behind columns of their own: name → attribute."""
    columns = {**first, **_COLUMNS}
    records = [{name: getattr(row, attribute) for name, attribute in columns.items()} for row in rows]
    return Table(
        records, _FORMS, left=("scenario", "filter", "kept"), title="Adhesion and pad friction against the truth"
    )


_COLUMNS = {
    "filter": "filter", "α rmse": "alpha_rmse", "α bias": "alpha_bias", "α largest": "alpha_largest",
    "outside events": "alpha_outside", "longest > 0.02": "longest", "kept": "kept", "α NEES": "alpha_nees",
    "μ rmse": "mu_b_rmse", "μ bias": "mu_b_bias", "μ NEES": "mu_b_nees", "μ sd claimed": "mu_b_sd",
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
}
