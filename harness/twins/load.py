"""What scenarios of twins share: how they are found, by name or path, their quantities, and points in order."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypeVar

from railgrip.errors import EstimationError
from railgrip.scenario.file import is_file
from railgrip.scenario.load import read_toml, validated
from railgrip.scenario.quantity import Unit
from railgrip.scenario.table import Table, broken
from railgrip.units import cut

LIBRARY = Path(__file__).parent / "library"

Time = Annotated[float, Unit("s", at_least=0)]
Pressure = Annotated[float, Unit("Pa", at_least=0)]

_Scenario = TypeVar("_Scenario", bound=Table)


def load_twin(model: type[_Scenario], kind: str, name: str, directory: Path = Path()) -> _Scenario:
    """Return a scenario of the library by its name, or one from a file by its path.

    Args:
        model: Of the scenario.
        kind: Of the twin, which names of files in the library begin with.
        name: Such as `slide`, or `mine.toml`.
        directory: That paths are relative to.

    Raises:
        EstimationError: No such scenario.
        ScenarioError: The file is not one.
    """
    path = directory / name if name.endswith(".toml") else LIBRARY / f"{kind}_{name}.toml"
    if not is_file(path):
        there = ", ".join(sorted(p.stem.removeprefix(f"{kind}_") for p in LIBRARY.glob(f"{kind}_*.toml")))
        raise EstimationError(
            f"there is no {kind} scenario '{cut(name)}'; there is {there}, or the path of a file (*.toml)."
        )
    return validated(model, read_toml(path), directory=path.parent, origin=path.name)


def in_order(what: str, points: Sequence[Sequence[float]]) -> None:
    """Refuse points that do not begin with a time each, in its order.

    Raises:
        PydanticCustomError: For the sentence of a validator.
    """
    times = [point[0] for point in points]
    if not times or times != sorted(set(times)):
        raise broken(f"{what} wants points that begin with a time, in its order, got the times {times}")
