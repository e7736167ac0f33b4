"""Full brakes of trains in files."""

from pathlib import Path
from typing import Any

from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.schema import Scenario


def dry(
    vehicle: dict[str, Any], speed: str | float, directory: Path = Path(), *, mu0: float = 0.5, **changes: Any
) -> Scenario:
    """A full brake without an estimator on a rail that is dry, unless `mu0` is given."""
    table = load(Path("plain")).resolved() | {"vehicle": vehicle, "start": {"speed": speed}}
    table |= {"estimator": {"kind": "none"}, "controller": {"kind": "full_brake"}}
    table["adhesion"]["mu0"] = mu0
    return scenario_of(table | changes, directory=directory, origin="dry")
