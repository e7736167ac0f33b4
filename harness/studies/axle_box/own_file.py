"""Learning from a user's runs, as a TOML file.

name = "car-7"

[runs]
folder = "runs"                     # recordings, from the folder of this file
labels = "labels.csv"               # file, friction, direction

[network]                           # optional: the paper's kind, one for each speed class
inputs = "left, right"              # any of the paper's eight combinations
bias = "inside"                     # where b2 of equation (4) stands, or "outside"
starts = 5

[data]                              # optional: columns are called as the signals are, in SI units
time = { column = "t", unit = "ms" }
period = "195.3125 us"
longest_gap = "50 ms"
frozen = "0.5 s"
spike = 20.0

[data.columns]
speed = { column = "v", unit = "km/h" }
"left[1]" = { column = "ax_1l", unit = "g_0" }
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictInt

from railgrip.estimators.learned.channels import COMBINATIONS
from railgrip.scenario.load import read_toml, validated
from railgrip.scenario.table import Name, Table, one_of
from railgrip.studies.axle_box.evaluate import Recipe
from railgrip.trace.table import DataTable


class RunsTable(Table):
    """[runs]: where recordings and labels are, from the folder of the file."""

    folder: str
    labels: str


class NetworkTable(Table):
    """[network]: the networks of the paper's kind."""

    inputs: Annotated[str, one_of(COMBINATIONS, "; ")] = "longitudinal"
    bias: Literal["inside", "outside"] = "inside"
    starts: Annotated[StrictInt, Field(ge=1, le=100)] = 5

    def recipe(self) -> Recipe:
        """Return how they are trained."""
        return Recipe(inputs=self.inputs, bias=self.bias, starts=self.starts)


class OwnFile(Table):
    """Everything that decides what is learned from a user's runs."""

    name: Name
    runs: RunsTable
    network: NetworkTable = NetworkTable()
    data: DataTable | None = None


def read_own(file: Path) -> OwnFile:
    """Return what a TOML file asks for.

    Raises:
        ScenarioError: The file is missing or says something else; each problem in one sentence.
    """
    return validated(OwnFile, read_toml(file), directory=file.parent, origin=file.name)
