"""The table [sensors]: what stands between the plant and those who see it."""

from typing import Annotated, Literal

from pydantic import Field, StrictInt

from harness.scenario.quantity import Unit
from harness.scenario.table import Delay, Deviation, Duration, Table


class IdealSensors(Table):
    """Readings are the plant's outputs."""

    kind: Literal["ideal"]


class WheelEncoder(Table):
    """Pulse-timing encoder of each independent wheelset."""

    pulses: Annotated[StrictInt, Field(ge=1, le=10000)] = Field(description="pulses per revolution")
    pitch_error: Deviation = Field(description="1σ error of a tooth's pitch over the pitch; repeats each revolution")
    clock: Duration = Field(description="tick of the clock that times the pulses")
    cut_off: Annotated[float, Unit("m/s", at_least=0)] = Field(description="speed below which it reads zero")


class SpeedSensor(Table):
    """Speed over ground: Doppler radar or GNSS."""

    principle: Literal["doppler", "gnss"]
    noise: Annotated[float, Unit("m/s", at_least=0)] = Field(description="1σ, white, each reading")
    scale_error: Deviation = Field(description="1σ of the relative error, drawn once a stop")
    period: Duration
    latency: Delay


class Accelerometer(Table):
    """Longitudinal acceleration of the car body."""

    noise: Annotated[float, Unit("m/s**2", at_least=0)] = Field(description="1σ, white, each reading")
    bias: Annotated[float, Unit("m/s**2", at_least=0)] = Field(description="1σ, drawn once a stop")


class DeflectionSensor(Table):
    """Travel of the primary suspension at each wheelset."""

    noise: Annotated[float, Unit("m", at_least=0)] = Field(description="1σ, white, each reading")


class PressureTransducer(Table):
    """Cylinder pressure of each group."""

    full_scale: Annotated[float, Unit("Pa", above=0)]
    error: Deviation = Field(description="1σ of the offset over full scale, drawn once a stop")
    bits: Annotated[StrictInt, Field(ge=4, le=24)] = Field(description="of the converter, over full scale")
    lag: Delay = Field(description="first-order time constant")


class ServiceSensors(Table):
    """Sensors as a train in service may have them."""

    kind: Literal["service"]
    wheel: WheelEncoder
    speed: SpeedSensor
    acceleration: Accelerometer
    deflection: DeflectionSensor
    pressure: PressureTransducer


Sensors = Annotated[IdealSensors | ServiceSensors, Field(discriminator="kind")]
