"""The scenario file as a type: every table, key, unit and range; unknown keys are rejected.

A quantity is a string with a unit ("80 km/h", "3.4 bar", "10 ms") or a bare number in the SI unit of its field. Train,
speed, friction and controller have no default. The other defaults are ideal sensors and actuation, no estimator,
periods of 1 ms, and straight level track.
"""

import hashlib
import json
import math
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from fractions import Fraction
from typing import Annotated, Any, Final, Self

from pydantic import Field

from railgrip.base.errors import FmuError, ScenarioError
from railgrip.base.tables import TomlTable
from railgrip.base.units import GRAVITY
from railgrip.scenario.demand import Demand
from railgrip.scenario.faults import Fault, Truth, kinds_of_faults
from railgrip.scenario.file import NamedFile, merge
from railgrip.scenario.onboard import (
    Actuation,
    Controller,
    Estimator,
    Limits,
    NoEstimator,
    Periods,
    Sensors,
    steps_between,
)
from railgrip.scenario.profile import LONGEST_RAIL, Adhesion, FromTable, Points
from railgrip.scenario.surface import Sander
from railgrip.scenario.table import ByKind, Name, Seed, Table, optional, table_error
from railgrip.scenario.track import Track, steepest_fall
from railgrip.scenario.vehicle_table import LibraryPlant, Start, Vehicle

SAMPLES: Final = Fraction("0.0005"), Fraction("0.002")
"""First sample of the valves' dead times in the built-in plants, and the time between two samples [s].

They are offset and period of RailBraking.Pneumatics.ValveDelay.
"""


def begin_off_the_samples(step: float) -> float:
    """Return the time at which a plant with valves starts [s], so that no communication step [s] ends on their samples.

    If they coincide, rounding decides whether a command acts before or after the sample, and a solver may have to
    integrate over the rounding error, where that of OpenModelica's FMUs fails. The start is 0 if no multiple of the
    step is a sample, as for whole milliseconds; otherwise it is half of the greatest common divisor of the step and the
    samples' period, by which commands then act earlier: 0.25 ms for a step of 0.5 ms.
    """
    first, interval = SAMPLES
    exact = Fraction(step).limit_denominator(10**9)
    # n step = first + k interval has integer solutions if the common divisor of step and interval also divides first.
    common = Fraction(
        math.gcd(exact.numerator * interval.denominator, interval.numerator * exact.denominator),
        exact.denominator * interval.denominator,
    )
    return float(common / 2) if (first / common).denominator == 1 else 0.0


_MAX_ROWS = 1_000_000
"""Maximum number of samples of a stop: a quarter of an hour in milliseconds, some 0.8 GB."""

_LONGEST_STEP, _LONGEST_STEP_OF_FULL_BRAKE = 10e-3, 50e-3
"""Maximum communication step of a built-in plant [s], with a controller and without.

With 20 ms the sampled acceleration of a wheel that locks no longer adds up to the change of speed. The step is also the
shortest period of estimator and controller, so that a longer one is another loop: on the trapezoid, periods of 10 ms in
place of 1 ms change distances of two- and three-state control by 1 % or less, those of adhesion-based control by +2 %
with simple and by -6 % with detailed mechanics, whether or not the step is 1 ms. With full brake wheels lock once; with
50 ms distances change by 0.3 %.
"""

_MIN_HORIZON, _MAX_HORIZON = 120.0, 600.0
"""Bounds of the default horizon [s]."""

_FEWEST_PERIODS = 10
"""Minimum number of periods in a horizon, so that rounding to whole periods changes it by 5 % or less."""


class Scenario(Table):
    """All inputs of a stop."""

    name: Name = Field(description="of the scenario and of the folder of its results; that of the file without it")
    description: str = Field(default="", description="subject in a line, for tables and pages")
    seed: Seed = Field(default=1, description="of all random draws: rail, sensors, faults")
    vehicle: Vehicle
    start: Start
    demand: Demand | None = optional()
    track: Track = Track()
    adhesion: Adhesion = Field(description="friction between wheel and rail, over time or distance")
    sensors: Sensors = Field(
        default={"kind": "ideal"}, validate_default=True, description="sensors between the plant and the parts on board"
    )
    actuation: Actuation = Actuation(kind="ideal")
    estimator: Estimator = Field(
        default=NoEstimator(kind="none"), description="estimator of the train's states from the readings"
    )
    controller: Controller = Field(description="the law that demands brake pressures")
    periods: Periods = Periods()
    limits: Limits = Limits()
    sanders: tuple[Sander, ...] = optional("who lays sand on the rail, and when", default=(), max_length=256)
    faults: tuple[Annotated[Fault, ByKind(kinds_of_faults)], ...] = optional(
        "what is broken, and when", default=(), max_length=100
    )
    truth: Truth = optional(default=Truth())

    def _check(self) -> None:
        if self.sanders and self.adhesion.sand is None:
            raise table_error("[[sanders]] needs [adhesion.sand], the effect of sand on friction: mu0, density, left")
        if self.demand is not None and self.controller.kind == "ideal_bound":
            raise table_error("[controller] ideal_bound uses all adhesion from the start: leave out [demand]")
        if getattr(self.sensors, "gnss", None) is not None and self.track.plan is None:
            raise table_error("[sensors.gnss] reads positions on a [track.plan], and there is none")
        sampling = getattr(self.sensors, "period", None)
        if sampling is not None and steps_between(sampling, self.periods.communication).denominator != 1:
            raise table_error(
                f"[sensors] period must be a whole multiple of [periods] communication, got {sampling:g} s over "
                f"{self.periods.communication:g} s"
            )
        step, longest = self.periods.communication, self._longest_step
        if step > longest:
            raise table_error(
                f"[periods] communication must be at most {longest:g} s with a built-in plant under [controller] kind "
                f"'{self.controller.kind}', got {step:g} s: command and friction are constant during a step, and "
                "longer ones miss how wheels lock and release; give a shorter one, the other periods may stay"
            )
        rows = self.horizon / self.periods.communication
        if rows > _MAX_ROWS:
            raise table_error(
                f"[limits] horizon {self.horizon:g} s over [periods] communication "
                f"{self.periods.communication:g} s is {rows:.3g} samples; a stop holds {_MAX_ROWS:g} at most"
            )
        factor_a, factor_s = (self.truth.creep.get(name, 1.0) for name in ("k_A", "k_S"))
        for curve in self.adhesion.curves:
            if factor_s * curve.k_S > factor_a * curve.k_A * (1.0 + 1e-9):
                raise table_error(
                    f"[truth] creep raises k_S to {factor_s * curve.k_S:g}, above k_A of {factor_a * curve.k_A:g} of "
                    f"[adhesion] polach '{curve.name}', with which the wheel would use more than mu0; change both by "
                    "the same factor"
                )
        if self.limits.stop_speed >= self.start.speed and not self.has_traction:
            raise table_error(
                f"[limits] stop_speed {self.limits.stop_speed:g} m/s is not below [start] speed "
                f"{self.start.speed:g} m/s; a train that starts so slowly needs traction in [[demand.phases]]"
            )
        slowest = max(
            ("communication", "estimator", "controller", "trace"), key=lambda name: getattr(self.periods, name)
        )
        period = getattr(self.periods, slowest)
        if self.horizon < _FEWEST_PERIODS * period:
            raise table_error(
                f"[limits] horizon {self.horizon:g} s is shorter than {_FEWEST_PERIODS} periods of [periods] "
                f"{slowest}, {period:g} s each; give a longer horizon or a shorter period"
            )
        self._require_one_chainage()

    def _require_one_chainage(self) -> None:
        adhesion, line = self.adhesion, self.track.line
        if line is None or line.is_gpx or not isinstance(adhesion, Points | FromTable) or adhesion.origin is None:
            return
        places = [(adhesion.origin, adhesion.direction or line.direction), (line.origin, line.direction)]
        if places[0] != places[1]:
            file = f" file {adhesion.file.entry}" if isinstance(adhesion, FromTable) else ""
            (here, way), (there, other) = places
            raise table_error(
                f"[adhesion]{file} has origin {here:.10g} m and chainages that are {way} in the direction of travel, "
                f"[track.line] file {line.file.entry} has origin {there:.10g} m and direction '{other}': a train is at "
                "one chainage and runs one way; correct origin or direction, or reverse the order of the points of "
                "friction"
            )

    @property
    def _longest_step(self) -> float:
        """Maximum communication step [s]: of a built-in plant one that is validated, of others any."""
        if not isinstance(self.vehicle.source, LibraryPlant):
            return math.inf
        return _LONGEST_STEP_OF_FULL_BRAKE if self.controller.kind == "full_brake" else _LONGEST_STEP

    @property
    def horizon(self) -> float:
        """Maximum duration of a stop [s]: as given, or derived from speed, friction and gradient.

        A locked wheel keeps the share A of the friction or more, its limit at infinite slip velocity (Polach, Wear 258,
        2005, 992). The deceleration that follows from the lowest friction of the rail, minus the steepest
        gradient, is halved to allow for cylinders that fill and controllers that vent; `_MIN_HORIZON` allows for brakes
        and a driver who demand less than friction permits. If the gradient exceeds the friction, no time suffices and
        the horizon is `_MAX_HORIZON`. A train cannot go beyond the range of tabulated friction.
        """
        if self.limits.horizon is not None:
            return self.limits.horizon
        lowest = self.adhesion.lowest * min(curve.A for curve in self.adhesion.curves)
        slowing = GRAVITY * (0.5 * lowest + steepest_fall(self.track) + min(self.truth.gradient, 0.0))
        needed = self.start.speed / slowing if slowing > 0.0 else _MAX_HORIZON
        most = min(_MAX_HORIZON, _MAX_ROWS * self.periods.communication)
        if self.runs_over_distance:
            tabulated = max(_MIN_HORIZON, LONGEST_RAIL // max(self.start.speed, 1.0))
            most = min(most, _MIN_HORIZON if self.has_traction else tabulated)
        # Rounded up to seconds, so that a small change of the friction rarely changes the horizon.
        return min(float(math.ceil(max(needed, _MIN_HORIZON))), most)

    @property
    def plant_begin(self) -> float:
        """Time of the plant at the start of the stop [s]."""
        has_valves = self.actuation.kind == "pneumatic" and isinstance(self.vehicle.source, LibraryPlant)
        return begin_off_the_samples(self.periods.communication) if has_valves else 0.0

    @property
    def has_traction(self) -> bool:
        """Whether the demand pushes the train in one of its phases."""
        return self.demand is not None and self.demand.has_traction

    @property
    def runs_over_distance(self) -> bool:
        """Whether the adhesion is a function of the position."""
        return self.adhesion.over == "distance"

    def files(self) -> tuple[NamedFile, ...]:
        """Return the files outside the scenario file that affect the stop."""
        keys = (
            (self.vehicle, ("plant", "library", "train")), (self.adhesion, ("file",)), (self.track.line, ("file",)),
            (self.controller, ("file",)), (self.estimator, ("library", "file")), (self.demand, ("file",)),
        )  # fmt: skip
        entries = (getattr(table, key, None) for table, names in keys for key in names)
        return tuple(file for file in entries if isinstance(file, NamedFile))

    def resolved(self) -> TomlTable:
        """Return the scenario as plain values in SI units with all defaults; loading them gives an equal scenario."""
        return self.model_dump(mode="json")

    def tables(self) -> TomlTable:
        """Return the values of `resolved` with each file at its place on this machine, so that they can be validated
        again from any folder.
        """
        return self.model_dump()

    def revised(self, change: Mapping[str, Any]) -> Self:
        """Return the scenario with the keys of `change` overlaid, as `railgrip.scenario.file.merge` does.

        Files that the scenario names stay where they are; so they do in `replaced`.
        """
        return self.replaced(merge(self.tables(), change))

    def replaced(self, tables: Mapping[str, Any]) -> Self:
        """Return the scenario with whole tables in place of its own, of which no key remains."""
        return self.model_validate(self.tables() | dict(tables))

    @contextmanager
    def name_errors(self) -> Generator[None]:
        """Put the name of the scenario in front of each line of an error that begins with a table.

        Raises:
            ScenarioError, FmuError: Those of the block.
        """
        try:
            yield
        except (ScenarioError, FmuError) as problem:
            if not str(problem).startswith("["):
                raise
            lines = str(problem).splitlines()
            named = [f"{self.name}: {line}" if line.startswith("[") else line for line in lines]
            raise type(problem)("\n".join(named)) from problem

    def digest(self) -> str:
        """Return a SHA-256 of all inputs of the stop: values, and the content of the files they name."""
        everything = {"scenario": self.resolved(), "files": [file.digest() for file in self.files()]}
        return hashlib.sha256(json.dumps(everything, sort_keys=True).encode()).hexdigest()
