"""The table [sensors]: what stands between the plant and those who see it."""

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, StrictBool, StrictInt, Tag, model_validator

from railgrip.scenario.custom import CUSTOM, OURS, Custom, whose
from railgrip.scenario.quantity import Magnitude, Unit
from railgrip.scenario.table import Deviation, Duration, Lag, Period, Table, broken, optional

_OFF = "a sensor so far off is none"
SpeedError = Annotated[float, Unit("m/s", at_least=0, at_most=100, because=_OFF)]
AccelerationError = Annotated[float, Unit("m/s2", at_least=0, at_most=1000, because=_OFF)]
TravelError = Annotated[float, Unit("m", at_least=0, at_most=1, because=_OFF)]
PlaceError = Annotated[float, Unit("m", at_least=0, at_most=1000, because=_OFF)]
GNSS = ("latitude", "longitude", "height")
"""What a receiver reads."""
Tick = Annotated[float, Unit("s", above=0, at_most=1, because="a clock that ticks so rarely times no pulse")]


class IdealSensors(Table):
    """Readings are the plant's outputs."""

    kind: Literal["ideal"]


class WheelEncoder(Table):
    """Pulse-timing encoder of each independent wheelset."""

    pulses: Annotated[StrictInt, Field(ge=1, le=10000)] = Field(description="pulses per revolution")
    pitch_error: Deviation = Field(description="1σ error of a tooth's pitch over the pitch; repeats each revolution")
    clock: Tick = Field(description="tick of the clock that times the pulses")
    cut_off: SpeedError = Field(description="speed below which it reads zero")


class SpeedSensor(Table):
    """Speed over ground: Doppler radar or GNSS, which differ by the numbers below."""

    noise: SpeedError = Field(description="1σ, white, each reading")
    scale_error: Deviation = Field(description="1σ of the relative error, drawn once a stop")
    scale_offset: Annotated[float, Unit("1", at_least=-0.5, at_most=0.5, because=_OFF)] = Field(
        default=0.0, description="relative error of every stop, which adds to the drawn one"
    )
    period: Period
    latency: Lag
    drift: Deviation = optional("1σ of a relative error that wanders, a Gauss-Markov process", default=0.0)
    drift_time: Duration | None = optional("over which the autocorrelation of the drift falls to 1/e")
    dropouts: Deviation = optional("share of the time without readings", default=0.0)
    dropout_time: Duration | None = optional("mean length of a drop-out")

    @model_validator(mode="before")
    @classmethod
    def _no_principle(cls, entry: Any) -> Any:
        if isinstance(entry, dict) and "principle" in entry:
            raise broken("has the key 'principle' of earlier versions, which changed nothing; remove it")
        return entry

    @model_validator(mode="after")
    def _times(self) -> Self:
        for name, time in (("drift", self.drift_time), ("dropouts", self.dropout_time)):
            if bool(getattr(self, name)) != (time is not None):
                raise broken(f"{name} and {name.removesuffix('s')}_time want each other; give both or neither")
        return self


class Accelerometer(Table):
    """Longitudinal acceleration of the car body."""

    noise: AccelerationError = Field(description="1σ, white, each reading")
    bias: AccelerationError = Field(description="1σ, drawn once a stop")
    feels_gradient: StrictBool = optional("whether it reads the gravity along the track, too", default=False)


class RailUnderWheels(Table):
    """Irregularities of the track under the wheels, as the frames of the bogies answer to them."""

    track: Literal["erri-low", "erri-high", "fra-4", "fra-5", "fra-6"] = Field(
        description="published spectrum of the height: ERRI B176, or classes of the FRA"
    )
    frequency: Annotated[float, Unit("Hz", above=0, at_most=100)] = Field(
        description="natural frequency of a frame on its primary suspension"
    )
    damping: Annotated[float, Unit("1", above=0, at_most=2)] = Field(description="damping ratio of that")


class DeflectionSensor(Table):
    """Travel of the primary suspension at each wheelset."""

    noise: TravelError = Field(description="1σ, white, each reading")
    irregularity: RailUnderWheels | None = optional()


class PressureTransducer(Table):
    """Cylinder pressure of each group."""

    full_scale: Annotated[float, Unit("Pa", at_least=1e3, at_most=1e8, because="brake cylinders hold some bar")]
    error: Deviation = Field(description="1σ of the offset over full scale, drawn once a stop")
    bits: Annotated[StrictInt, Field(ge=4, le=24)] = Field(description="of the converter, over full scale")
    lag: Lag = Field(description="first-order time constant")


class ServiceSensors(Table):
    """Sensors as a train in service may have them."""

    kind: Literal["service"]
    period: Period | None = optional(
        "at which all are sampled and their noise is drawn, a whole multiple of the communication step; "
        "where it is not given 1 ms, or what is nearest to it"
    )
    wheel: WheelEncoder
    speed: SpeedSensor
    acceleration: Accelerometer
    deflection: DeflectionSensor
    pressure: PressureTransducer


class Gnss(Table):
    """A receiver of carrier phases in the middle of the train: small errors beside one that wanders slowly.

    Each of north, east and height has both, the wandering one a Gauss-Markov process.
    """

    period: Period
    horizontal: PlaceError = Field(description="1σ of either, white, each reading")
    height: PlaceError = Field(description="1σ, white, each reading")
    horizontal_wander: PlaceError = Field(description="1σ of either")
    height_wander: PlaceError = Field(description="1σ")
    wander_time: Duration = Field(description="over which the autocorrelation of the wander falls to 1/e")


class WhiteSensors(Table):
    """Readings are the plant's outputs with errors, every sample; a quantity that no table names is read as it is.

    Quantities are what every train reads (speed, wheelset_speed, deflection, acceleration, cylinder_pressure) and
    whatever else the plant shows, such as pad_force: once it is named, the trace has it as reading_pad_force. So are
    acceleration_along, of an accelerometer over each group that feels the gradient, too, and latitude, longitude and
    height by GNSS, NaN between its readings.
    """

    kind: Literal["white"]
    period: Period | None = optional(
        "at which quantities are read and noise is drawn, a whole multiple of the communication step; that "
        "itself where it is not given"
    )
    noise: dict[str, Magnitude] = Field(default={}, description="1σ of each quantity, white from sample to sample")
    bias: dict[str, Magnitude] = Field(default={}, description="1σ of each quantity, drawn once a stop for each sensor")
    scale: dict[str, Deviation] = Field(default={}, description="1σ of the relative error, drawn once a stop")
    gnss: Gnss | None = Field(default=None, description="wants [track.plan]")

    @property
    def named(self) -> frozenset[str]:
        """Quantities with errors."""
        receiver = () if self.gnss is None else GNSS
        return frozenset((*self.noise, *self.bias, *self.scale, *receiver))


SERVICE_PERIOD = 1e-3
"""Sampling period of the instruments of a train in service [s]."""


def sampled_every(sensors: object, communication: float) -> int:
    """Return the communication steps [s] between two readings of the sensors of a scenario."""
    own = getattr(sensors, "period", None)
    if own is None and isinstance(sensors, ServiceSensors):
        own = SERVICE_PERIOD
    return max(round((own or 0.0) / communication), 1)


Sensors = Annotated[
    Annotated[IdealSensors | WhiteSensors | ServiceSensors, Field(discriminator="kind"), Tag(OURS)]
    | Annotated[Custom, Tag(CUSTOM)],
    Discriminator(whose("sensors", lambda: ("ideal", "white", "service"))),
]
