"""The content of a stop.json, checked before it is used: what reports take from it has the types that they expect."""

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat

from railgrip.base.errors import UnitError
from railgrip.base.units import to_si
from railgrip.scenario.table import Name, Seed, broken

Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class Stored(BaseModel):
    """A table of a result file: no value is converted to another type, and keys that reports do not use are kept."""

    model_config = ConfigDict(strict=True, frozen=True, extra="allow", allow_inf_nan=False)


class _OfKind(Stored):
    kind: str


class _Start(Stored):
    speed: Annotated[FiniteFloat, Field(ge=0, le=1e6)]


class _Limits(Stored):
    alpha_max: FiniteFloat


class _Curve(Stored):
    name: str


class _Patch(Stored):
    mu0: list[FiniteFloat] = []
    polach: _Curve | None = None


class _Adhesion(_OfKind):
    polach: _Curve
    polach_of_wheelset: list[_Curve] = []
    patch: list[_Patch] = []
    calibrated: dict[str, FiniteFloat] = {}


class _Constant(_Adhesion):
    mu0: list[FiniteFloat]


class _Estimator(_OfKind):
    model: str = ""


def _ratios(parameters: dict[str, Any]) -> dict[str, Any]:
    """Check the slips of slip-based control, which its name in tables contains."""
    for name in ("low", "high"):
        value = parameters.get(name, 0.0)
        try:
            is_ratio = isinstance(to_si(value, "1") if isinstance(value, str) else value, int | float)
        except UnitError:
            is_ratio = False
        if not is_ratio:
            raise broken(f"{name} is not a ratio")
    return parameters


class _Controller(_OfKind):
    tuning: str = "paper"
    parameters: dict[str, Any] = {}


class _SlipController(_Controller):
    parameters: Annotated[dict[str, Any], AfterValidator(_ratios)] = {}


class _Vehicle(Stored):
    train: str | None = None
    model: str | None = None
    plant: str | None = None


class StoredScenario(Stored):
    """The keys of a resolved scenario that reports use."""

    name: Name
    description: str = ""
    seed: Seed
    vehicle: _Vehicle
    start: _Start
    adhesion: _Adhesion
    sensors: _OfKind
    actuation: _OfKind
    estimator: _Estimator
    controller: _Controller
    limits: _Limits

    @classmethod
    def check(cls, table: dict[str, Any]) -> None:
        """Check a resolved scenario, and its tables whose keys depend on their kind.

        Raises:
            ValidationError: A key is missing or has another type.
        """
        scenario = cls.model_validate(table)
        if scenario.adhesion.kind == "constant":
            _Constant.model_validate(table["adhesion"])
        if scenario.controller.kind.startswith("slip_"):
            _SlipController.model_validate(table["controller"])


class StoredStop(Stored):
    """The keys of stop.json."""

    outcome: str
    reason: str
    scenario: dict[str, Any]
    scenario_digest: Digest
    metrics: dict[str, Any]
    versions: dict[str, str]
    fmus: dict[str, str]
    classes: dict[str, dict[str, Any]] = {}
    trace_sha256: Digest | None
    sha256: Digest
