"""Random layers of a scenario: the value of each array element is that of the highest layer that names it.

The layers are those of users: a file, a file that extends it, a variant of a campaign, and `--set`.
"""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_fuzz_questions import many

from railgrip.api import Scenario
from railgrip.base.errors import ScenarioError
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.load import load
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.vehicle.parameters import with_each

GROUPS = 4  # of the two-part train
KEY = "controller.parameters"
radius = st.floats(0.3, 0.6).map(lambda value: round(value, 6))
whole = st.one_of(radius, st.lists(radius, min_size=GROUPS, max_size=GROUPS))
elements = st.dictionaries(st.integers(1, GROUPS), radius, max_size=GROUPS)
layers = st.one_of(
    st.just({}),
    whole.map(lambda value: {"r_wheel": value}),
    elements.map(lambda each: {f"r_wheel[{i}]": value for i, value in each.items()}),
    # In one table an element is more specific than the value for all.
    st.builds(lambda value, i: {"r_wheel": value, f"r_wheel[{i}]": 0.55}, radius, st.integers(1, GROUPS)),
)


def named(layer, element):
    """Return the value that a layer gives to an element, or None."""
    if (value := layer.get(f"r_wheel[{element}]")) is not None:
        return value
    value = layer.get("r_wheel")
    return value[element - 1] if isinstance(value, list) else value


def lines(layer):
    return "".join(f'"{key}" = {value!r}\n' for key, value in layer.items())


def overrides(layer):
    return [f'{KEY}."{key}"={value!r}' for key, value in layer.items()]


def written(folder: Path, below, above):
    (folder / "below.toml").write_text(f'extends = "plain"\n[{KEY}]\n{lines(below)}', encoding="utf-8")
    (folder / "above.toml").write_text(f'extends = "below.toml"\n[{KEY}]\n{lines(above)}', encoding="utf-8")
    return folder / "above.toml"


def radii(scenario):
    vehicle = VehicleData(scenario)
    values = {name: magnitude.si("m") for name, magnitude in scenario.controller.parameters.items()}
    each = with_each(values, vehicle.formation)
    assert all(vehicle.nominal.parameters[name] == value for name, value in each.items())
    return [each.get(f"r_wheel[{i}]") for i in range(1, GROUPS + 1)]


def highest(*stack):
    """Return the expected radii of layers, the lowest first."""
    return [
        next((value for layer in reversed(stack) if (value := named(layer, element)) is not None), None)
        for element in range(1, GROUPS + 1)
    ]


@many
@given(below=layers, above=layers, variant=layers, last=layers)
def test_the_highest_layer_that_names_an_element_wins(below, above, variant, last, tmp_path):
    file = written(tmp_path, below, above)
    assert radii(load(file, overrides(last))) == highest(below, above, last)
    changes = {f'{KEY}."{key}"': value for key, value in variant.items()}
    later = {f'{KEY}."{key}"': value for key, value in last.items()}
    in_python = Scenario.load(file, changes).changed(later)
    assert radii(in_python) == highest(below, above, variant, last)
    campaign = tmp_path / "campaign.toml"
    text = f'name = "layers"\nscenarios = ["above.toml"]\n[axes.radius.one.{KEY}]\n{lines(variant)}'
    campaign.write_text(text, encoding="utf-8")
    (stop,) = load_campaign(campaign, overrides(last)).stops
    assert radii(stop.scenario) == highest(below, above, variant, last)


@many
@given(
    below=layers,
    length=st.integers(0, 6).filter(lambda n: n != GROUPS),
    element=st.none() | st.integers(1, 6),
    is_override=st.booleans(),
)
def test_a_list_of_another_length_or_with_an_element_is_refused_in_any_layer(
    below, length, element, is_override, tmp_path
):
    layer = {"r_wheel": [0.4] * (GROUPS if element else length)} | ({f"r_wheel[{element}]": 0.5} if element else {})
    file = written(tmp_path, below, {} if is_override else layer)
    words = "is given too" if element else f"is a list of {length}, but" if length else "is an empty list"
    with pytest.raises(ScenarioError, match=words):
        _ = VehicleData(load(file, overrides(layer) if is_override else [])).nominal
