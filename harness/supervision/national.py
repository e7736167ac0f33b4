"""National values: a TOML file with the names of SUBSET-026, whose defaults are those of A.3.2."""

from pathlib import Path
from typing import Annotated

from pydantic import Field, StrictBool, StrictInt

from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import FASTEST, Length, Speed, Table, table_error

StepSpeed = Annotated[float, UnitRange("m/s", between=(0, FASTEST), usual=(0.0, 95.0))]
Deceleration = Annotated[
    float, UnitRange("m/s2", above=0, at_most=3, because="trains brake with 0.2 to 2.5 m/s2, magnets included")
]
_Factor = Annotated[float, UnitRange("1", above=0, at_most=1.5, because="variables of ETCS have factors up to 1.26")]
_Share = Annotated[float, UnitRange("1", between=(0, 1))]


class NationalValues(Table):
    """The national values that braking curves depend on."""

    Q_NVSBTSMPERM: StrictBool = Field(default=True, description="whether target speed monitoring may use service brake")
    Q_NVGUIPERM: StrictBool = Field(default=False, description="whether guidance curves are permitted")
    Q_NVSBFBPERM: StrictBool = Field(
        default=False, description="whether feedback of the service brake is permitted; no effect: no train here has it"
    )
    Q_NVINHSMICPERM: StrictBool = Field(
        default=False, description="whether the compensation of the inaccuracy of speed may be left out; it then is"
    )
    V_NVREL: Speed = Field(default=40 / 3.6, description="release speed")
    Q_NVLOCACC: Annotated[float, UnitRange("m", between=(0, 63))] = Field(
        default=12.0, description="accuracy of the location of a balise group"
    )
    M_NVAVADH: _Share = Field(
        default=0.0, description="weight of the adhesion of dry rail against that of wet rail, K_wet_rst"
    )
    M_NVEBCL: Annotated[StrictInt, Field(ge=0, le=9)] = Field(
        default=9, description="confidence level: 0 is 50 %, 1 is 90 %, … 9 is 1 − 1e-9"
    )
    M_NVKTINT: _Factor = Field(default=1.1, description="Kt_int, factor on the build-up time of the conversion model")
    M_NVKRINT: tuple[tuple[Length, _Factor], ...] = Field(
        default=((0.0, 0.9),), min_length=1, max_length=5, description="Kr_int: length of the train above which, factor"
    )
    M_NVKVINT_freight: tuple[tuple[StepSpeed, _Factor], ...] = Field(
        default=((0.0, 0.7),),
        min_length=1,
        max_length=5,
        description="Kv_int of freight trains: speed above which, factor",
    )
    M_NVKVINT_passenger: tuple[tuple[StepSpeed, _Factor, _Factor], ...] = Field(
        default=((0.0, 0.7, 0.7),),
        min_length=1,
        max_length=5,
        description="Kv_int of passenger trains: speed above which, factors for A_ebmax up to A_NVP12 and from A_NVP23",
    )
    A_NVP12: Deceleration | None = Field(default=None, description="lower limit of A_ebmax for Kv_int")
    A_NVP23: Deceleration | None = Field(default=None, description="upper limit of A_ebmax for Kv_int")
    A_NVMAXREDADH1: Deceleration = Field(
        default=1.0, description="maximum on reduced adhesion, passenger trains with brakes that need no adhesion"
    )
    A_NVMAXREDADH2: Deceleration = Field(default=0.7, description="maximum on reduced adhesion, other passenger trains")
    A_NVMAXREDADH3: Deceleration = Field(default=0.7, description="maximum on reduced adhesion, freight trains")

    def _check(self) -> None:
        for name in ("M_NVKRINT", "M_NVKVINT_freight", "M_NVKVINT_passenger"):
            require_rising(name, [row[0] for row in getattr(self, name)])
        differ = any(a != b for _, a, b in self.M_NVKVINT_passenger)
        if differ and (self.A_NVP12 is None or self.A_NVP23 is None or self.A_NVP12 >= self.A_NVP23):
            raise table_error(
                "M_NVKVINT_passenger has two factors for a speed, between which A_NVP12 and A_NVP23 decide: give both, "
                "A_NVP12 below A_NVP23"
            )


def require_rising(name: str, starts: list[float]) -> None:
    """Raise an error for steps that do not start at 0, or whose starts do not rise."""
    if starts[0] != 0 or starts != sorted(set(starts)):
        raise table_error(f"{name}: the first step starts at 0, and the starts rise; got {starts} in SI units")


def load_national(path: Path | None) -> NationalValues:
    """Return the national values of a file; the defaults of A.3.2 without one.

    Raises:
        ScenarioError: The file cannot be read or is wrong; one sentence for each problem, with file and key.
    """
    if path is None:
        return NationalValues()
    return validate_table(NationalValues, read_toml(path), directory=path.parent, origin=path.name)
