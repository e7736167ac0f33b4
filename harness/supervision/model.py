"""The braking model of a train: a TOML file of its own, or what follows from a train file."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field, StrictBool

from railgrip.rolling_stock.schema import BrakePosition
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import Name, Speed, Table, table_error
from railgrip.supervision import conversion
from railgrip.supervision.curve import Steps, combine
from railgrip.supervision.national import Deceleration, NationalValues, StepSpeed, require_rising

Factor = Annotated[float, UnitRange("1", above=0, at_most=1.1)]
_Time = Annotated[
    float, UnitRange("s", between=(0, 60), because="the slowest build-up of A.3.9 takes 56 s for 1500 m in G")
]
_Length = Annotated[float, UnitRange("m", between=(1, 4095), because="ETCS has lengths up to 4095 m")]
_Kn = Annotated[float, UnitRange("m/s2", between=(0, 10))]
_Percentage = Annotated[
    float,
    UnitRange("1", between=(0.3, 2.5), because='the conversion model holds from 30 % to 250 %; write "135 %" or 1.35'),
]


class EmergencyStep(Table):
    """A step of A_brake_emergency(V) with its correction factors."""

    above: StepSpeed = Field(description="speed above which the step holds")
    deceleration: Deceleration = Field(description="nominal deceleration on dry rail")
    k_dry: Factor = Field(description="K_dry_rst at the confidence level M_NVEBCL of the national values")
    k_wet: Factor = Field(description="K_wet_rst")


class ServiceStep(Table):
    """A step of A_brake_service(V) or A_brake_normal_service(V)."""

    above: StepSpeed = Field(description="speed above which the step holds")
    deceleration: Deceleration = Field(description="deceleration of the service brake in this step")


class KnStep(Table):
    """A step of Kn+(V) and Kn-(V), corrections of the guidance curve on gradients (§3.13.2.2.9.2)."""

    above: StepSpeed = Field(description="speed above which the step holds")
    uphill: _Kn = Field(description="Kn+, correction on uphill gradients")
    downhill: _Kn = Field(description="Kn-, correction on downhill gradients")


_LEVEL = (KnStep(above=0.0, uphill=0.0, downhill=0.0),)
_CURVES = ("emergency", "service", "emergency_time", "service_time")


class TrainData(Table):
    """The file of a train's braking model: deceleration curves, or a brake percentage."""

    name: Name = Field(description="name of the train in figures and messages")
    source: str = Field(min_length=3, description="publication of the numbers, or that they are estimates")
    length: _Length = Field(description="length of the train")
    maximum_speed: Speed = Field(description="maximum speed of the train")
    brake_position: BrakePosition = Field(description="brake position of the train")
    brake_percentage: _Percentage | None = Field(
        default=None, description="brake percentage, for the conversion model in place of curves and times"
    )
    emergency: tuple[EmergencyStep, ...] = Field(default=(), max_length=7, description="A_brake_emergency(V)")
    service: tuple[ServiceStep, ...] = Field(default=(), max_length=7, description="A_brake_service(V)")
    normal_service: tuple[ServiceStep, ...] = Field(
        default=(), max_length=7, description="A_brake_normal_service(V), required where guidance curves are permitted"
    )
    kn: tuple[KnStep, ...] = Field(default=(), max_length=5, description="Kn+(V) and Kn-(V); 0 unless given")
    emergency_time: _Time | None = Field(default=None, description="T_brake_emergency")
    service_time: _Time | None = Field(default=None, description="T_brake_service")
    traction_cut_off_time: _Time = Field(description="T_traction_cut_off")
    traction_cut_off: StrictBool = Field(default=True, description="whether ETCS can cut off traction")
    service_brake: StrictBool = Field(default=True, description="whether ETCS can command the service brake")
    brakes_without_adhesion: StrictBool = Field(
        default=False, description="whether brakes that need no adhesion count on reduced adhesion (A_NVMAXREDADH1)"
    )
    rotating_mass: Annotated[float, UnitRange("1", between=(0, 0.3))] | None = Field(
        default=None, description="M_rotating_nom as a share of the mass; 2 % downhill and 15 % uphill unless given"
    )

    def _check(self) -> None:
        given = [key for key in _CURVES if getattr(self, key) not in (None, ())]
        if self.brake_percentage is None and len(given) < len(_CURVES):
            lacking = ", ".join(key for key in _CURVES if key not in given)
            raise table_error(f"lacks {lacking}; or give brake_percentage for the conversion model")
        if self.brake_percentage is not None:
            longest = conversion.LONGEST[self.brake_position]
            if given:
                raise table_error(f"has brake_percentage and {', '.join(given)}; keep one of the two models")
            if self.maximum_speed > conversion.FASTEST * (1 + 1e-9) or self.length > longest:
                raise table_error(
                    f"brake_percentage: the conversion model holds up to 200 km/h and {longest:g} m in position "
                    f"'{self.brake_position}' (SUBSET-026 3.13.3.2), this train has {3.6 * self.maximum_speed:g} km/h "
                    f"and {self.length:g} m; give the curves instead"
                )
        for name in ("emergency", "service", "normal_service", "kn"):
            if rows := getattr(self, name):
                require_rising(name, [row.above for row in rows])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BrakingModel:
    """What speed and distance monitoring knows of a train's brake (§3.13.2.2); a train file fills it, or `TrainData`.

    Attributes:
        name: Of the train.
        length: [m].
        maximum_speed: [m/s].
        position: Brake position.
        emergency: A_brake_emergency(V) [m/s2].
        k_dry: K_dry_rst(V) at the confidence level M_NVEBCL; None with the conversion model.
        k_wet: K_wet_rst(V); None with the conversion model.
        service: A_brake_service(V) [m/s2].
        normal_service: A_brake_normal_service(V) [m/s2], if the train has it.
        kn: Kn+(V) and Kn-(V) [m/s2]; 0 unless given.
        emergency_times: T_brake_emergency for target speeds of zero and above [s].
        service_times: T_brake_service likewise [s].
        cut_off_time: T_traction_cut_off [s].
        cuts_off: Whether ETCS cuts off traction at the warning.
        has_service_brake: Whether ETCS commands the service brake.
        without_adhesion: Whether brakes that need no adhesion count on reduced adhesion.
        rotating: M_rotating_nom [%], if it is known.
    """

    name: str
    length: float
    maximum_speed: float
    position: BrakePosition
    emergency: Steps
    k_dry: Steps | None
    k_wet: Steps | None
    service: Steps
    normal_service: Steps | None = None
    kn: tuple[Steps, Steps] = (Steps.constant(0.0), Steps.constant(0.0))
    emergency_times: tuple[float, float]
    service_times: tuple[float, float]
    cut_off_time: float
    cuts_off: bool = True
    has_service_brake: bool = True
    without_adhesion: bool
    rotating: float | None

    @property
    def is_converted(self) -> bool:
        """Whether the conversion model gives the brake, so that integrated correction factors apply (§3.13.2.2.9.1)."""
        return self.k_dry is None


def model_of(data: TrainData) -> BrakingModel:
    """Return the braking model of a file; with a brake percentage, by the conversion model (§3.13.2.2, §3.13.3)."""
    rows = data.emergency
    percentage = None if data.brake_percentage is None else 100 * data.brake_percentage
    position, length = data.brake_position, data.length
    if percentage is None:
        assert data.emergency_time is not None  # the table requires both without a percentage
        assert data.service_time is not None
        emergency, service = _steps(rows, "deceleration"), _steps(data.service, "deceleration")
        times = (data.emergency_time, data.emergency_time), (data.service_time, data.service_time)
    else:
        emergency = conversion.emergency_deceleration(percentage)
        service = conversion.service_deceleration(percentage)
        times = conversion.emergency_times(position, length), conversion.service_times(position, length)
    return BrakingModel(
        name=data.name,
        length=length,
        maximum_speed=data.maximum_speed,
        position=position,
        emergency=emergency,
        k_dry=_steps(rows, "k_dry") if rows else None,
        k_wet=_steps(rows, "k_wet") if rows else None,
        service=service,
        normal_service=_steps(data.normal_service, "deceleration") if data.normal_service else None,
        kn=(_steps(data.kn or _LEVEL, "uphill"), _steps(data.kn or _LEVEL, "downhill")),
        emergency_times=times[0],
        service_times=times[1],
        cut_off_time=data.traction_cut_off_time,
        cuts_off=data.traction_cut_off,
        has_service_brake=data.service_brake,
        without_adhesion=data.brakes_without_adhesion,
        rotating=None if data.rotating_mass is None else 100 * data.rotating_mass,
    )


def _steps(rows: Any, key: str) -> Steps:
    return Steps.of([(row.above, getattr(row, key)) for row in rows])


def safe_deceleration(model: BrakingModel, national: NationalValues) -> Steps:
    """Return A_brake_safe(V): A_brake_emergency(V) with the correction factors (§3.13.6.2.1.4).

    K_dry_rst (K_wet_rst + M_NVAVADH (1 − K_wet_rst)) A_brake_emergency, or Kv_int Kr_int A_brake_emergency.
    """
    if model.k_dry is not None and model.k_wet is not None:
        weight = national.M_NVAVADH
        return combine(
            lambda a, dry, wet: dry * (wet + weight * (1 - wet)) * a, model.emergency, model.k_dry, model.k_wet
        )
    of_length = float(Steps.of(national.M_NVKRINT).at(model.length))
    return combine(lambda a, kv: kv * of_length * a, model.emergency, integrated_factor(model, national))


def integrated_factor(model: BrakingModel, national: NationalValues) -> Steps:
    """Return Kv_int(V) (§3.13.6.2.1.8): of passenger trains, between two sets by the highest deceleration A_ebmax."""
    if model.position != "passenger P":
        return Steps.of(national.M_NVKVINT_freight)
    starts = model.emergency.starts
    most = float(model.emergency.values[starts <= model.maximum_speed].max())
    low, high = national.A_NVP12, national.A_NVP23
    share = 0.0 if low is None or high is None else float(np.interp(most, (low, high), (0.0, 1.0)))
    return Steps.of([(above, a + share * (b - a)) for above, a, b in national.M_NVKVINT_passenger])


def highest_on_low_adhesion(model: BrakingModel, national: NationalValues) -> float:
    """Return A_MAXREDADH of a train [m/s2] (§3.13.6.2.1.6)."""
    if model.position != "passenger P":
        return national.A_NVMAXREDADH3
    return national.A_NVMAXREDADH1 if model.without_adhesion else national.A_NVMAXREDADH2
