"""The content of a stop.json, checked before it is used: what reports take from it has the types that they expect."""

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat

from railgrip.base.errors import UnitError
from railgrip.base.units import to_si
from railgrip.scenario.table import Name, Seed, table_error

Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class Stored(BaseModel):
    """A table of a result file: no value is converted to another type, and keys that reports do not use are kept."""

    model_config = ConfigDict(strict=True, frozen=True, extra="allow", allow_inf_nan=False)


class _StoredKind(Stored):
    kind: str


class _StoredStart(Stored):
    speed: Annotated[FiniteFloat, Field(ge=0, le=1e6)]


class _StoredLimits(Stored):
    alpha_max: FiniteFloat


class _StoredCurve(Stored):
    name: str


class _StoredPatch(Stored):
    mu0: list[FiniteFloat] = []
    polach: _StoredCurve | None = None


class _StoredAdhesion(_StoredKind):
    polach: _StoredCurve
    polach_of_wheelset: list[_StoredCurve] = []
    patch: list[_StoredPatch] = []
    calibrated: dict[str, FiniteFloat] = {}


class _StoredConstant(_StoredAdhesion):
    mu0: list[FiniteFloat]


class _StoredEstimator(_StoredKind):
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
            raise table_error(f"{name} is not a ratio")
    return parameters


class _StoredController(_StoredKind):
    tuning: str = "paper"
    parameters: dict[str, Any] = {}


class _StoredSlipController(_StoredController):
    parameters: Annotated[dict[str, Any], AfterValidator(_ratios)] = {}


class _StoredVehicle(Stored):
    train: str | None = None
    model: str | None = None
    plant: str | None = None


class StoredScenario(Stored):
    """The keys of a resolved scenario that reports use."""

    name: Name
    description: str = ""
    seed: Seed
    vehicle: _StoredVehicle
    start: _StoredStart
    adhesion: _StoredAdhesion
    sensors: _StoredKind
    actuation: _StoredKind
    estimator: _StoredEstimator
    controller: _StoredController
    limits: _StoredLimits

    @classmethod
    def check(cls, table: dict[str, Any]) -> None:
        """Check a resolved scenario, and its tables whose keys depend on their kind.

        Raises:
            ValidationError: A key is missing or has another type.
        """
        scenario = cls.model_validate(table)
        if scenario.adhesion.kind == "constant":
            _StoredConstant.model_validate(table["adhesion"])
        if scenario.controller.kind.startswith("slip_"):
            _StoredSlipController.model_validate(table["controller"])


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
    fmu_warnings: dict[str, dict[str, int]] = {}
    remarks: list[str] = []
    trace_sha256: Digest | None
    sha256: Digest
