"""The tables of the onboard equipment: sensors, estimator, controller, actuation, limits and periods."""

import math
from collections.abc import Collection
from fractions import Fraction
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, StrictBool, ValidationInfo, field_validator

from railgrip.base import registry
from railgrip.base.arrays import generator
from railgrip.base.limits import FMU_LIMITS, FmuLimits
from railgrip.base.names import did_you_mean, known_names
from railgrip.base.units import short
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import Number, UnitRange
from railgrip.scenario.table import (
    ByKind,
    Custom,
    Duration,
    Friction,
    MapEntry,
    Parameters,
    Period,
    Seed,
    Table,
    by_kind,
    optional,
    table_error,
)


class Actuation(Table):
    """Kind of command to the plant: cylinder pressures (ideal) or valve positions (pneumatic)."""

    kind: Literal["ideal", "pneumatic"] = Field(description="ideal: cylinder pressures; pneumatic: positions of valves")


class NoEstimator(Table):
    """No estimator: the controller gets readings only."""

    kind: Literal["none"]


class KalmanFilter(Table):
    """An extended Kalman filter over a prediction model.

    `fmu` evaluates a prediction FMU through FMI 2.0; `compiled` has the equations of the same class as C in the filter,
    the fastest form, for campaigns of thousands of stops; `python` is the reference in numpy; `decentralised` has a
    separate filter for each bogie or group, at a linear cost. `iterated`, `unscented`, `cubature`, `particle`,
    `moving_horizon`, `sage_husa` and `interacting` are other filters in numpy; the force balance and the disturbance
    observer are references.
    """

    kind: str = Field(description="a module of `railgrip.estimators.filters`")
    model: str | None = optional(
        "prediction class, such as TrainPrediction or TrainPredictionReduced; without one it is made from "
        "the vehicle's nominal data"
    )
    library: NamedFile | None = optional("for a user-defined model: the package.mo of its library, or its .mo file")
    file: NamedFile | None = optional(
        "a user-defined prediction as an FMU 2.0, for kind fmu: states v, w, mu_b and alpha, or speed, "
        "wheelset_speed, pad_friction and group_adhesion; inputs "
        "cylinder_pressure and optionally track_force, outputs named as readings, all in SI"
    )
    interface: Literal["model_exchange", "co_simulation"] = optional(
        "of the prediction FMU, for kind fmu: model_exchange, and the filter integrates; or co_simulation, and the FMU "
        "integrates",
        default="model_exchange",
    )
    trust: StrictBool = optional("load that FMU into this process, where its code runs", default=False)
    noise: str | None = optional(
        "name of the noise set; with a library its full name, such as train_ideal. Without one it is ideal where the "
        "sensors are, else service"
    )
    parameters: Parameters = Field(default={}, description="the prediction's parameters that differ from its own")
    outlier_limit: dict[str, Annotated[Number, Field(gt=0.0)]] = optional(
        "from how many standard deviations of what was expected on a reading is left out, by its name", default={}
    )
    free_wheels: StrictBool = optional(
        "use the speed of a rolling, unbraked wheel as that of the train while the radar is silent", default=False
    )
    load_deviation: Annotated[float, UnitRange("1", between=(0, 1))] = optional(
        "standard deviation of the load of a wheelset over the load that the filter assumes; no reading shows it, and "
        "it counts in the deviation of the estimated adhesion",
        default=0.0,
    )

    def _check(self) -> None:
        if self.model is None and self.library is not None:
            raise table_error("has no model; name the class of the prediction")
        if self.model is not None and self.kind == "decentralised":
            raise table_error(
                "makes its prediction from the vehicle's nominal data when it is decentralised; leave out model"
            )
        if self.file is not None and (self.kind != "fmu" or self.model is not None):
            raise table_error("has a file: set kind = 'fmu' and leave out model, or leave out file")
        if self.interface == "co_simulation" and self.kind != "fmu":
            raise table_error(
                f"has interface 'co_simulation' with kind '{self.kind}'; set kind = 'fmu', or leave out interface"
            )
        if self.file is not None and not self.trust:
            raise table_error(
                f"file: the code of {self.file.entry} would run in this process; if you know where it comes from, "
                "set trust = true"
            )


def _estimators() -> dict[str, type[Table]]:
    return {"none": NoEstimator, **dict.fromkeys(registry.modules(registry.FILTERS), KalmanFilter)}


Estimator = Annotated[NoEstimator | KalmanFilter | Custom, ByKind(_estimators, "estimators")]


class TrainLevelTable(Table):
    """Keys that apply to groups under any law."""

    redistribute: StrictBool = optional(
        "ask of groups with adhesion left what others cannot give of the driver's demand", default=False
    )
    shared_valve: Literal["lowest", "mean"] = optional(
        "how groups that share a valve agree: the lowest demand or the mean", default="lowest"
    )
    release_max: Duration | None = optional(
        "a group that is released for longer is braked for 1 s as the driver demands, whatever the law demands; "
        "without it there is no limit"
    )


class BuiltInLaw(TrainLevelTable):
    """A built-in control law, with changes of its parameter set."""

    kind: str = Field(description="a law of `railgrip list controllers`")
    tuning: str | None = Field(
        default=None,
        exclude_if=lambda tuning: tuning is None,
        validate_default=True,
        description="set of parameters: paper, where a publication gives them; searched, on training rails for this "
        "actuation; type_test and type_test_2, on the training cases of a version of the type test, with valves; or "
        "another file of the law. Those "
        "of slip-based control are for slip as read, where the estimator is 'none', or else as estimated",
    )
    parameters: Parameters = Field(default={}, description="what differs from that set")

    @field_validator("tuning")
    @classmethod
    def _set_of_the_law(cls, tuning: str | None, info: ValidationInfo) -> str | None:
        kind, files = info.data.get("kind", ""), registry.files(registry.LAWS)
        sets = {"paper": f"{kind}.paper", "searched": kind, "type_test": f"{kind}.type_test"}
        sets |= {file.removeprefix(f"{kind}."): file for file in files if file.startswith(f"{kind}.")}
        names = [name for name, file in sets.items() if file in files]
        if tuning is not None and tuning not in names:
            raise table_error(f"is {short(tuning)}; {kind} has {known_names(names, tuning) or 'no set of parameters'}")
        if "paper" in names:
            return tuning or "paper"
        return None if tuning == "searched" else tuning


class ControllerFmu(TrainLevelTable):
    """A user-defined controller, as a co-simulation FMU 2.0.

    Its inputs may be speed, acceleration, wheelset_speed, slip, adhesion, pad_friction, pressure and driver_demand; its
    output is demand, the pressures of the groups, or command, the valves' positions. Speed and slip are NaN until a
    sensor has read the speed.
    """

    kind: Literal["fmu"]
    file: NamedFile = Field(description="the FMU")
    parameters: Parameters = Field(default={}, description="the FMU's parameters that differ from its own values")
    map: dict[str, MapEntry] = Field(
        default={}, description="our name → variable of the FMU: text with {i} for arrays, list, or table"
    )
    trust: StrictBool = Field(
        default=False, description="load it into this process: faster, but a crash in it ends the run"
    )


class CustomLaw(Custom, TrainLevelTable):
    """A control law that is a user-defined class."""


def _controllers() -> dict[str, type[Table]]:
    return {**dict.fromkeys((*registry.modules(registry.LAWS), *registry.ANALYSES), BuiltInLaw), "fmu": ControllerFmu}


Controller = Annotated[BuiltInLaw | ControllerFmu | CustomLaw, ByKind(_controllers, "controllers", CustomLaw)]

_ADHESION_LIMITS = {"tsi": 0.15, "tsi_short_formation": 0.13}


class ForeignFmus(FmuLimits, frozen=True):
    """Limits on the resources that a foreign FMU may use."""

    patience: Duration = Field(default=FMU_LIMITS.patience, description="real time one call may last")
    budget: Duration = optional(
        "real time that all calls of a run may last, trial runs included", default=FMU_LIMITS.budget
    )


class Limits(Table):
    """Limits of a stop and of the adhesion that may be used."""

    horizon: Duration | None = optional(
        "a stop that takes longer ends here, with that outcome; without it twice the time that locked wheels would "
        "take on the lowest friction, at least 2 and at most 10 min"
    )
    stop_speed: Annotated[
        float,
        UnitRange(
            "m/s",
            between=(0, 2),
            usual=(0.0, 1.0),
            because="a train that moves faster does not stand: up to 4 m are missing",
        ),
    ] = Field(default=0.1, description="speed that counts as standstill")
    alpha_max: Friction = Field(
        default=_ADHESION_LIMITS["tsi"],
        description="most adhesion that may be used: a number, 'tsi' (0.15) or 'tsi_short_formation' (0.13); "
        "LOC&PAS TSI 4.2.4.6.1",
    )
    fmu: ForeignFmus = ForeignFmus()

    @field_validator(
        "alpha_max", mode="before", json_schema_input_type=Friction | Literal["tsi", "tsi_short_formation"]
    )
    @classmethod
    def _preset(cls, entry: Any) -> Any:
        if not isinstance(entry, str):
            return entry
        if entry in _ADHESION_LIMITS:
            return _ADHESION_LIMITS[entry]
        if question := did_you_mean(entry, _ADHESION_LIMITS):
            raise table_error(f"is '{entry}'; {question}")
        return entry


def _communication(before: dict[str, Any]) -> float:
    # Pydantic passes the fields that precede this one.
    return before.get("communication", 1e-3)


class Periods(Table):
    """Periods of the parts of the loop.

    A part is due at the first communication step at or after each multiple of its period: at whole multiples exactly,
    otherwise up to one step late but never less often. A period shorter than `communication` becomes that.
    """

    communication: Period = Field(default=1e-3, description="of the plant")
    estimator: Period = Field(
        default_factory=_communication, description="of the estimator; that of the plant without it"
    )
    controller: Period = Field(
        default_factory=_communication, description="of the controller; that of the plant without it"
    )
    trace: Period = Field(
        default_factory=lambda before: _communication(before) * max(round(10e-3 / _communication(before)), 1),
        description="of the rows that are kept, rounded to a whole multiple of communication; 10 ms without it",
    )

    @field_validator("estimator", "controller", "trace", mode="after")
    @classmethod
    def _not_shorter_than_a_step(cls, period: float, info: ValidationInfo) -> float:
        return max(period, _communication(info.data))

    @field_validator("trace", mode="after")
    @classmethod
    def _whole_multiple(cls, period: float, info: ValidationInfo) -> float:
        every = steps_between(period, _communication(info.data))
        return period if every.denominator == 1 else round(every) * _communication(info.data)

    def steps_of(self, name: Literal["estimator", "controller", "trace"]) -> Fraction:
        """Return the number of communication steps in a period of this part; 1 or more, not always whole."""
        return steps_between(getattr(self, name), self.communication)


def steps_between(period: float, step: float) -> Fraction:
    """Return the number of steps [s] in a period [s] as the exact ratio of their decimal values; at least 1."""
    ratio = period / step
    # 1e-9 is far above the rounding of decimal fractions of a second, and five orders below any real mismatch.
    if math.isclose(ratio, round(ratio), rel_tol=1e-9):
        return Fraction(max(round(ratio), 1))
    return max(Fraction(period).limit_denominator(10**9) / Fraction(step).limit_denominator(10**9), Fraction(1))


class SensorModel(Table):
    """Sensors of one kind: their table, which also creates the implementation.

    Each kind is a subclass in a module of `railgrip.simulate.sensors`.
    """

    kind: Any  # each class lists its name as a literal

    @property
    def pulses(self) -> int:
        """Teeth of each pole wheel; 0 for sensors without pole wheels."""
        return 0

    @property
    def pressure_lag(self) -> float:
        """Time constant of the readings of the cylinder pressure [s]."""
        return 0.0

    def sampled_every(self, communication: float) -> int:
        """Return the communication steps [s] between two readings."""
        return 1

    def extra_readings(self, outputs: Collection[str]) -> tuple[Any, ...]:
        """Return the signals that they read from a plant with `outputs`, in addition to those of all sensors.

        Raises:
            ScenarioError: A named quantity does not exist, or is not an output of the plant.
        """
        return ()

    def open(self, scenario: Any, layout: Any, wheel_radius: float) -> Any:
        """Return the sensors of a stop, with `read(sample, truth)`.

        Errors that are constant over a stop are drawn here.
        """
        raise NotImplementedError


class SampledSensors(SensorModel):
    """Sensors with errors and a sampling period."""

    period: Period | None = optional(
        "at which all are sampled and their noise is drawn, a whole multiple of the communication step, or shorter: "
        "then the loop reads one of several samples; without it that step itself, or of service sensors 1 ms"
    )
    seed: Seed | None = optional(
        "seed of the lot and the noise of the sensors, to repeat a stop on the same rail with other sensors of the "
        "same kind; without it the seed of the scenario"
    )

    def random(self, seed: int, purpose: str) -> np.random.Generator:
        """Return the stream of random numbers for one purpose of these sensors, in a scenario with a seed."""
        return generator(seed if self.seed is None else self.seed, f"sensors.{purpose}")

    def sampled_every(self, communication: float) -> int:
        """Return the communication steps [s] between two readings."""
        return max(round((self.period or 0.0) / communication), 1)

    def samples_in(self, communication: float) -> int:
        """Return the number of samples that the instruments take per communication step [s], of which the loop reads
        one.
        """
        return max(round(communication / (self.period or communication)), 1)


def _sensors() -> dict[str, type[Table]]:
    return by_kind(*registry.parts(registry.SENSORS, SensorModel))


class OwnSensors(Custom, SensorModel):
    """Sensors that are a user-defined class, read in every communication step."""


Sensors = Annotated[SensorModel, ByKind(_sensors, "sensors", OwnSensors)]
