"""Repeats of the stops of a campaign: with perturbed parameters of the plant, and with different sensor errors.

Perturbations in the seventh digit identify distances that depend on rounding. A lot of sensors is one draw of their
errors and noise; a distance with one lot is one draw, too. The file of a campaign is written by `make conditioning`.
"""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BeforeValidator, Field, PlainSerializer

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.files import read_bytes
from railgrip.base.records import LARGEST_JSON, parse_json
from railgrip.scenario.load import validate_table
from railgrip.scenario.quantity import NotNegative, Number
from railgrip.scenario.table import Table

SPREAD = 1e-3
"""Relative range above which a distance is given as a range: the tolerance of a baseline for other arithmetic."""

SMOOTH = 0.02
"""Range of the repeats [m] up to which a distance is smooth: the accepted distance then has the same tolerance."""

CERTAINTY = 0.99
"""Probability that a figure of one more repeat is inside the interval."""

ROUNDING = 1e-4
"""Relative tolerance of a figure whose repeats agree: `SMOOTH` over some 200 m."""

NOTHING = 1e-9
"""Tolerance of a figure that is zero in every repeat."""

LOOSEST = 5e-3
"""Relative tolerance above which a figure is not compared: it would hide a change of one per cent."""


_Distance = Annotated[
    NotNegative,
    Field(allow_inf_nan=True),
    BeforeValidator(lambda entry: math.inf if entry is None else entry),
    PlainSerializer(lambda distance: None if distance == math.inf else distance),
]
"""Distance of a repeat [m]; infinite without standstill, which is null in a file."""


class RepeatedDistances(Table):
    """The distances of one stop."""

    digest: str = Field(description="of the scenario of the stop")
    distances: tuple[_Distance, ...] = Field(min_length=1, description="[m], from the shortest on")
    compilers: dict[str, tuple[_Distance, ...]] = Field(
        default={}, description="other compiler → distances [m] with its FMUs, from the shortest on, parameters moved"
    )
    figures: dict[str, tuple[Number, ...]] = Field(
        default={}, description="figure of `Metrics.compared` → its value in each of the first repeats"
    )
    lots: tuple[_Distance, ...] = Field(
        default=(), description="[m], with lots 1, 2, … of the sensors; empty if sensors have no errors"
    )

    steps: dict[int, tuple[_Distance, ...]] = Field(
        default={}, description="divisor of the communication step → distances [m] with it, parameters moved as well"
    )

    tolerances: dict[float, tuple[_Distance, ...]] = Field(
        default={}, description="tolerance of the plant's solver → distances [m] with it, parameters moved as well"
    )

    @property
    def lowest(self) -> float:
        """The shortest distance [m]."""
        return float(np.min(self.distances))

    @property
    def median(self) -> float:
        """Median distance [m]."""
        return float(np.median(self.distances))

    @property
    def highest(self) -> float:
        """The longest distance [m]."""
        return float(np.max(self.distances))

    @property
    def spreads(self) -> bool:
        """Whether the distance depends on rounding, so that it is given as a range."""
        return self.highest - self.lowest > SPREAD * self.lowest

    @property
    def is_smooth(self) -> bool:
        """Whether the range of the distance is `SMOOTH` or less."""
        return self.highest - self.lowest <= SMOOTH

    def tolerance_of(
        self, figure: str, value: float, certainty: float = CERTAINTY, loosest: float = LOOSEST
    ) -> float | None:
        """Return the tolerance of a figure in another run, relative to its accepted value.

        The repeats give the prediction interval of one more, t s √(1 + 1/n) about their mean; the offset of the
        accepted value from the mean is added. None without repeats, or if the relative interval is wider than
        `loosest`.
        """
        repeats = np.asarray(self.figures.get(figure, ()))
        count = len(repeats)
        if count < 2:
            return None
        from scipy.special import stdtrit  # takes a tenth of the start of a stop, and few have repeats

        quantile = float(stdtrit(count - 1, (1.0 + certainty) / 2.0))
        reach = quantile * float(np.std(repeats, ddof=1)) * math.sqrt(1.0 + 1.0 / count)
        tolerance = max(abs(float(np.mean(repeats)) - value) + reach, ROUNDING * abs(value), NOTHING)
        return tolerance if tolerance <= max(loosest * abs(value), NOTHING) else None

    def moved_by_step(self, divisor: int) -> float:
        """Return the relative change of the median with a divided communication step; infinite without standstill."""
        return _moved(self.distances, self.steps[divisor])

    def noise_of_step(self, divisor: int) -> float:
        """Return the half width of the 95 % interval of `moved_by_step` if the step has no effect.

        Both medians are of normal draws with the deviation of the undivided repeats; the median's standard error is
        √(π/2) σ/√n (Kendall and Stuart, The Advanced Theory of Statistics 1, 1969, §14.12).
        """
        return _noise(len(self.distances), len(self.steps[divisor]), _deviation(self.distances)) / self.median

    def error_at(self, tolerance: float | None) -> tuple[float, float]:
        """Return the relative error of the median distance at a tolerance, against the tightest one of `tolerances`.

        Args:
            tolerance: Tolerance of the plant's solver; None for that of the plant.

        Returns:
            Error, and the half width of its 95 % interval, with the deviation of the repeats at either tolerance.
        """
        tightest = self.tolerances[min(self.tolerances)]
        repeats = self.distances if tolerance is None else self.tolerances[tolerance]
        spread = math.hypot(_deviation(tightest), _deviation(repeats)) / math.sqrt(2.0)
        noise = _noise(len(tightest), len(repeats), spread)
        return _moved(tightest, repeats), noise / float(np.median(tightest))

    @property
    def margin(self) -> float:
        """Tolerance beyond the range for another run [m]: a quarter of it, so that 20 normal draws span ±2.8 σ.

        20 normal draws span 3.73 σ on average (Tippett, Biometrika 17, 1925). Without a spread, it is the tolerance of
        a baseline for other arithmetic.
        """
        return 0.25 * (self.highest - self.lowest) if self.spreads else SPREAD * self.lowest

    def belongs(self, digest: str, distance: float | None) -> bool:
        """Return whether these are repeats of a stop of this scenario with this distance [m].

        A digest does not cover the controllers; the distance does, because another controller changes it.
        """
        length = math.inf if distance is None else distance
        return digest == self.digest and self.lowest - self.margin <= length <= self.highest + self.margin

    def ends_of(self, compiler: str) -> tuple[float, float]:
        """Shortest and longest distance with the FMUs of another compiler [m]."""
        return min(self.compilers[compiler]), max(self.compilers[compiler])

    @property
    def lots_text(self) -> str:
        """Median and range of the distance over the lots of sensors; empty without lots."""
        return f"{np.median(self.lots):.1f} m ({min(self.lots):.1f} – {max(self.lots):.1f} m)" if self.lots else ""


def _moved(before: Sequence[float], after: Sequence[float]) -> float:
    return float(np.median(after)) / float(np.median(before)) - 1.0


def _noise(first: int, second: int, deviation: float) -> float:
    return 1.96 * math.sqrt(0.5 * math.pi * (1.0 / first + 1.0 / second)) * deviation


def _deviation(distances: Sequence[float]) -> float:
    if not np.isfinite(distances).all():
        return math.inf
    return float(np.std(distances, ddof=1)) if len(distances) > 1 else 0.0


class ConditioningFile(Table):
    """Content of the file."""

    relative: Number = Field(gt=0, description="most that a parameter of the plant moved by, as a share of its value")
    stops: dict[str, RepeatedDistances]


def read_conditioning(path: Path) -> ConditioningFile:
    """Return the conditioning in a file.

    Raises:
        ScenarioError: The file is missing or has other content.
    """
    hint = "; `make conditioning` writes those of this project"
    try:
        table = parse_json(path, read_bytes(path, LARGEST_JSON, if_missing=hint))
    except InputError as problem:
        raise ScenarioError(str(problem)) from problem
    return validate_table(ConditioningFile, table, directory=path.parent, origin=path.name)


def text_of(conditioning: ConditioningFile) -> str:
    """Return the text of the file, one line per stop."""
    stops = ",\n  ".join(
        f"{json.dumps(name)}: {stop.model_dump_json()}" for name, stop in sorted(conditioning.stops.items())
    )
    return f'{{\n "relative": {conditioning.relative!r},\n "stops": {{\n  {stops}\n }}\n}}\n'
