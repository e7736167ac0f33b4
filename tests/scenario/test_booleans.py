"""True and false are not numbers: no key of any table accepts a boolean instead of a number."""

import importlib
import pkgutil
import re
from typing import Annotated, Any

import numpy as np
import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError
from synthetic import LIBRARY
from wrong import table as stored

import railgrip.estimation
import railgrip.recording
import railgrip.rolling_stock
import railgrip.scenario
import railgrip.simulate
import railgrip.studies
import railgrip.trace
from railgrip.api import Scenario
from railgrip.base.errors import ScenarioError
from railgrip.scenario.load import load
from railgrip.scenario.quantity import Magnitude, Parameter
from railgrip.scenario.table import Table
from railgrip.simulate.vehicle_data import VehicleData

PACKAGES = (
    railgrip.estimation,
    railgrip.recording,
    railgrip.rolling_stock,
    railgrip.scenario,
    railgrip.simulate,
    railgrip.studies,
    railgrip.trace,
)
ENTRIES = (True, [True], [True, True], [[True, True]], {"a": True}, {"k_A": True})


def tables(base: type[BaseModel] = Table):
    for table in base.__subclasses__():
        yield table
        yield from tables(table)


def fields():
    modules = [m.name for package in PACKAGES for m in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")]
    for name in modules:
        importlib.import_module(name)
    every = {table for table in tables() if table.__module__ in modules}
    for table in sorted(every, key=lambda table: (table.__module__, table.__qualname__)):
        for name, field in table.model_fields.items():
            yield f"{table.__qualname__}.{name}", Annotated[field.annotation, *field.metadata, None]


def numbers(value: Any):
    """Yield all numbers of a value except booleans."""
    if isinstance(value, Magnitude) and not isinstance(value, Parameter):
        yield value.entry
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield value
    elif isinstance(value, dict):
        yield from (number for inner in value.values() for number in numbers(inner))
    elif isinstance(value, list | tuple):
        yield from (number for inner in value for number in numbers(inner))


def test_no_key_of_any_table_accepts_true_as_a_number():
    accepted, asked = [], 0
    for name, annotation in fields():
        adapter = TypeAdapter(annotation)
        for entry in ENTRIES:
            asked += 1
            try:
                value = adapter.validate_python(entry)
            except ValidationError:
                continue
            accepted += [(name, entry) for _ in numbers(value)]
    assert asked > 1000  # all tables were found
    assert {name for name, _ in accepted} == {"CarTable.direction"}  # 1 or -1, as true equals 1


@pytest.mark.parametrize(("key", "sentence"), stored(__file__, "tables.toml")["booleans"])
@pytest.mark.parametrize("how", ["--set", "python", "numpy"])
def test_true_is_refused_with_its_key(key, sentence, how):
    def vehicle():
        if how == "--set":
            scenario = load(LIBRARY / "plain.toml", [f"{key}=true"])
        else:
            scenario = Scenario.load("plain", {key: True if how == "python" else np.True_})
        return VehicleData(scenario).true, VehicleData(scenario).nominal

    with pytest.raises(ScenarioError, match=re.escape(sentence)):
        vehicle()
