"""How a track is recovered: [course.low_pass] and [course.trust] of an estimation."""

from typing import Annotated

from pydantic import Field

from railgrip.scenario.quantity import Unit
from railgrip.scenario.table import Length, Table

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class LowPass(Table):
    """How far to smooth."""

    plan: Length = Field(description="cut-off wavelength of north and east")
    height: Length = Field(description="of the height")
    base: Length = Field(description="Δs of the differences")


class Trust(Table):
    """Standard deviations of the sensors of motion."""

    speed: Annotated[float, Unit("m/s", above=0)] = Field(description="of the speed sensor")
    scale: Annotated[float, Unit("1", above=0)] = Field(description="of its scale")
    acceleration: Annotated[float, Unit("m/s**2", above=0)] = Field(description="of the mean of the accelerometers")
    bias: Annotated[float, Unit("m/s**2", above=0)] = Field(description="of their bias and gradient at the start")
    drift: Positive = Field(description="of these, per √s [m/s2/√s]")
    jerk: Positive = Field(description="change of acceleration, per √s [m/s2/√s]")
    position: Annotated[float, Unit("m", above=0)] = Field(description="of GNSS along the track")


LOW_PASS = LowPass(plan=100.0, height=150.0, base=10.0)
"""For a train at 5 to 30 m/s under a carrier-phase receiver at 10 Hz: transition curves and roundings are 50 to 100 m
long; shorter waves are the receiver's. An estimate, not fitted to any case."""

TRUST = Trust(speed=0.03, scale=2e-3, acceleration=0.05, bias=0.15, drift=0.02, jerk=0.7, position=0.3)
"""Class of the sensors (optical 0.1 %, four accelerometers, receiver wandering by 0.2 m); `drift` is the gradient that
changes by 5 ‰ in 5 s, `jerk` a brake that is applied within a second."""
