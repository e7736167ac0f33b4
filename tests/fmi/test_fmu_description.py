"""The description of an FMU is read correctly, and a file that cannot be a plant is refused with a sentence."""

import hashlib
from math import isnan
from pathlib import Path

import pytest
from tiny_fmu import per_second, tiny, xml

from railgrip.base.errors import FmuError
from railgrip.fmi import describe


def test_a_description_equals_the_xml(foundry: Path):
    description = describe(tiny(foundry, description=xml(state_unit="km/h")))
    assert description.model == "Tiny"
    assert description.states == ("x",)
    assert description.derivatives == ("der(x)",)
    assert description.names("input") == ("u", "mode")
    assert description.names("parameter") == ("rate", "gain", "label", "allowed")
    rate = description.variables["rate"]
    assert (rate.reference, rate.kind, rate.minimum, rate.maximum, rate.start) == (3, "Real", 0.1, 10.0, 2.0)
    unit = description.variables["x"].defined_unit
    assert unit.factor == pytest.approx(1 / 3.6, rel=1e-15)
    assert unit.dimension == "m.s-1"
    assert description.co_simulation is not None
    assert description.model_exchange is not None
    assert description.model_exchange.directional_derivatives


@pytest.mark.parametrize(
    ("name", "factor", "dimension"),
    [
        ("rad/s", 1.0, "s-1.rad"),
        ("Hz", 1.0, "s-1"),
        ("1/s", 1.0, "s-1"),
        ("a word of their own", 1.0, "s-1"),
        ("rad/s", 6.283185307179586, "s-1"),  # contradicts its name in more than the radian
    ],
)
def test_a_radian_omitted_from_a_definition_is_read_from_the_name(
    foundry: Path, name: str, factor: float, dimension: str
):
    """SI's radian is one, FMI's a base unit, and tools differ: OpenModelica's "rad/s" is s⁻¹."""
    unit = describe(tiny(foundry, description=per_second(name, factor))).variables["x"].defined_unit
    assert (unit.dimension, unit.factor) == (dimension, factor)


def test_the_digest_is_that_of_the_file(foundry: Path):
    file = tiny(foundry)
    assert describe(file).digest == hashlib.sha256(file.read_bytes()).hexdigest()


@pytest.mark.parametrize(("way", "stays"), [("ModelExchange", "co_simulation"), ("CoSimulation", "model_exchange")])
def test_an_interface_without_its_library_is_left_out(foundry: Path, way: str, stays: str):
    text = xml().replace(f'<{way} modelIdentifier="tiny"', f'<{way} modelIdentifier="absent"')
    description = describe(tiny(foundry, description=text))
    assert [w for w in ("co_simulation", "model_exchange") if getattr(description, w) is not None] == [stays]
    assert "its library binaries/" in description.blemishes


@pytest.mark.parametrize("start", ["INF", "-INF", "NaN"])
def test_a_start_value_that_is_not_finite_is_accepted_for_an_unused_variable(foundry: Path, start: str):
    text = xml().replace('Real start="3"', f'Real start="{start}"')
    description = describe(tiny(foundry, description=text))
    assert isnan(description.variables["gain"].start)
    with pytest.raises(FmuError, match="Integer; correct it"):
        describe(tiny(foundry, description=xml().replace('Integer start="3"', f'Integer start="{start}"')))
