"""Signals are mapped to variables of an FMU with other names, units and signs, or the error is reported."""

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from tiny_fmu import per_second, tiny, xml

from railgrip.base.errors import FmuError, PlantFailed
from railgrip.fmi import Binding, CoSimulation, Description, Port, bind, describe
from railgrip.fmi.instance import assignments

WHERE = "city.toml: [vehicle.map]"


def signal(name: str, unit: str = "1", size: int = 0, *, needed: bool = True) -> Port:
    return Port(name=name, unit=unit, size=size, needed=needed)


def tied(description: Description, table: dict[str, object] | None = None, **more: object) -> Binding:
    values: dict[str, object] = {
        "inputs": [signal("command", "Pa")],
        "outputs": [signal("speed", "m/s")],
        "table": {"command": "u", "speed": "x"} | (table or {}),
        "where": WHERE,
    }
    return bind(description, **(values | more))  # type: ignore[arg-type]


@pytest.fixture
def foreign(foundry: Path) -> Description:
    """Speed in km/h, pressure in bar, and y without a unit."""
    return describe(tiny(foundry, description=xml(state_unit="km/h", input_unit="bar")))


KMH_AND_BAR, DEGREES = {"state_unit": "km/h", "input_unit": "bar"}, {"state_unit": "degC", "input_unit": "degC"}
TEMPERATURES = {"inputs": [signal("command", "K")], "outputs": [signal("speed", "K")]}


@pytest.mark.parametrize(
    ("units", "table", "signals", "sent", "factor", "shift"),
    [
        (KMH_AND_BAR, {}, {}, 2e5, 1 / 3.6, 0.0),
        (KMH_AND_BAR, {"speed": "-x"}, {}, 2e5, -1 / 3.6, 0.0),
        # ours = scale · theirs: with scale −2, sending −4e5 Pa is 2 bar of theirs.
        (KMH_AND_BAR, {"command": {"variable": "-u", "scale": 2}}, {}, -4e5, 1 / 3.6, 0.0),
        (DEGREES, {}, TEMPERATURES, 275.15, 1.0, 273.15),
    ],
)
def test_values_arrive_in_the_units_and_signs_of_each_side(
    foundry: Path, units, table, signals, sent: float, factor: float, shift: float
):
    """1 km/h is 1/3.6 m/s, 2e5 Pa is 2 bar, 2 degC is 275.15 K: checked with a step of the closed-form FMU."""
    description = describe(tiny(foundry, description=xml(**units)))
    # dx/dt = -2 x + 3 u with x = 1 and u = 2 of theirs at first; after h, x = 3 - 2 exp(-2 h).
    with CoSimulation(description, tied(description, table, **signals), period=0.5, parameters={}) as plant:
        values = [plant.start(np.array([sent])), plant.step(np.array([sent]))]
    # Two conversions and one exponential: rounding only, for the offset 6e-14 K.
    np.testing.assert_allclose(np.ravel(values), shift + factor * np.array([1.0, 3 - 2 * np.exp(-1)]), rtol=1e-14)


def test_booleans_and_integers_are_passed_as_numbers(foundry: Path):
    description = describe(tiny(foundry))
    binding = bind(
        description,
        inputs=[signal("command"), signal("mode")],
        outputs=[signal("count"), signal("y"), signal("flag"), signal("x")],
        table={"command": "u"},
    )
    with CoSimulation(description, binding, period=1e-3, parameters={"allowed": 9}) as plant:
        plant.start(np.array([1.0, 2.0]))
        outputs = [plant.step(np.array([1.0, 2.0])) for _ in range(3)][-1]
    x = 1.5 - 0.5 * np.exp(-2 * 3e-3)
    np.testing.assert_allclose(outputs, [3, 2 * x + 1, 1, x], rtol=1e-14)


def test_elements_have_the_variables_and_scales_of_a_list(foundry: Path):
    text = xml().replace('name="x"', 'name="bogie[1].n"').replace('name="y"', 'name="bogie[2].n"')
    table = {"wheel": ["bogie[2].n", {"variable": "bogie[1].n", "scale": 3}]}
    bound = bind(describe(tiny(foundry, description=text)), inputs=[], outputs=[signal("wheel", size=2)], table=table)
    assert bound.outputs.elements == ("wheel[1]", "wheel[2]")
    assert bound.outputs.channels[0].variables == ("bogie[2].n", "bogie[1].n")
    np.testing.assert_array_equal(bound.outputs.channels[0].gain, [1, 3])


def test_undriven_inputs_are_reported(foreign: Description):
    assert tied(foreign).unused == ("mode",)


UNKNOWN, PER_MINUTE = xml(state_unit="knots_at_sea"), per_second("1/min", 1 / 60)
UNDEFINED = xml(state_unit="km/h").replace(
    '<BaseUnit m="1" s="-1" factor="0.2777777777777778"/>', '<DisplayUnit name="mph"/>'
)


@pytest.mark.parametrize(
    ("text", "entry", "unit", "found"),
    [
        (xml(), "y", "m/s", r"does not say the unit of 'y'; state it .* unit = \"m/s\""),
        (xml(), {"variable": "y", "unit": "km/h"}, "m/s", 1 / 3.6),
        (UNKNOWN, "x", "m/s", r"'knots_at_sea' without defining it, .* \{ variable = \"x\", unit = \"m/s\" \}"),
        (UNKNOWN, {"variable": "x", "unit": "km/h"}, "m/s", 1 / 3.6),
        (UNDEFINED, "x", "m/s", 1 / 3.6),
        *((xml(state_unit=unit), "x", "1", 1.0) for unit in ("-", "none", "null")),
        (xml(state_unit="-"), {"variable": "x", "unit": "Pa"}, "Pa", 1.0),
        # A unit library reads `1/min` as 1/min, a factor of 2π from revolutions; railgrip does not guess.
        (PER_MINUTE, "x", "rad/s", r'say in mapping what turns: \{ variable = "x", unit = "rev/min" \}, or rad/min'),
        (PER_MINUTE, {"variable": "x", "unit": "rev/min"}, "rad/s", np.pi / 30),
        (PER_MINUTE, {"variable": "x", "unit": "rev/s"}, "rad/s", "already gives '1/min'"),
        (per_second("rev/min", 1 / 60), "x", "rad/s", np.pi / 30),
    ],
)
def test_a_unit_is_that_of_the_fmu_or_of_the_map(foundry: Path, text: str, entry, unit: str, found: float | str):
    """`unit` in the map is the remedy that each refusal names, and it works."""
    description = describe(tiny(foundry, description=text))
    with pytest.raises(FmuError, match=found) if isinstance(found, str) else nullcontext():
        bound = bind(description, inputs=(), outputs=[signal("own", unit)], table={"own": entry})
        np.testing.assert_allclose(bound.outputs.channels[0].gain, [found], rtol=1e-15)


def test_a_name_that_begins_with_a_minus_is_not_a_negation(foundry: Path):
    only = describe(tiny(foundry, description=xml().replace('name="y"', 'name="-v"')))
    ratio = bind(only, inputs=[], outputs=[signal("ratio")], table={"ratio": "-v"}).outputs.channels[0]
    assert (ratio.variables, ratio.gain.tolist()) == (("-v",), [1.0])
    both = describe(tiny(foundry, description=xml().replace('name="y"', 'name="-x"')))
    with pytest.raises(FmuError, match=r"has '-x' as well as 'x', so '-x' is ambiguous; .* scale = -1"):
        bind(both, inputs=[], outputs=[signal("ratio")], table={"ratio": "-x"})
    table = {"ratio": {"variable": "x", "scale": -1}}
    assert bind(both, inputs=[], outputs=[signal("ratio")], table=table).outputs.channels[0].gain.tolist() == [-1.0]


def test_a_bound_is_met_within_the_rounding_of_a_conversion(foundry: Path):
    """Two units multiplied into a value move it by a bit or two; the FMU receives the bound itself."""
    description = describe(tiny(foundry))
    (sent,) = assignments(description, {"rate": 10 * (1 + 4e-16)})
    assert sent.values == (10.0,)
    (sent,) = assignments(description, {"rate": 0.1 * (1 - 4e-16)})
    assert sent.values == (0.1,)
    with pytest.raises(FmuError, match="at most 10"):
        assignments(description, {"rate": 10 * (1 + 1e-12)})


def test_an_offset_is_dropped_for_a_difference(foundry: Path):
    outputs = [signal("rise", "K")]
    table: dict[str, object] = {"rise": "x"}
    for relative, shift in ((False, 273.15), (True, 0.0)):
        description = describe(tiny(foundry, description=xml(state_unit="degC", relative=relative)))
        channel = bind(description, inputs=[], outputs=outputs, table=table).outputs.channels[0]
        assert channel.shift[0] == shift


def test_everything_missing_is_reported_at_once(foundry: Path):
    with pytest.raises(
        FmuError, match=r"no output 'cont' \(did you mean 'count'\?\), 'torque\[1\]', 'torque\[2\]'; it has"
    ):
        bind(describe(tiny(foundry)), inputs=[], outputs=[signal("cont"), signal("torque", "N.m", 2)])


def test_the_vectors_keep_their_layout_if_a_signal_is_missing(foundry: Path):
    """A missing signal is NaN among outputs and dropped among inputs; the others keep their indices."""
    description = describe(tiny(foundry))
    binding = bind(
        description,
        inputs=[signal("wind", "N", 2, needed=False), signal("u")],
        outputs=[signal("heat", "J", needed=False), signal("y"), signal("slip", size=2, needed=False), signal("flag")],
    )
    assert binding.outputs.absent == ("heat", "slip")
    assert binding.outputs.layout["flag"] == slice(4, 5)
    with CoSimulation(description, binding, period=1e-3, parameters={}) as plant:
        for outputs in (plant.start(np.array([5.0, 6.0, 0.5])), plant.step(np.array([5.0, 6.0, 0.5]))):
            np.testing.assert_array_equal(np.isnan(outputs), [True, False, True, True, False])
    x = 0.75 + 0.25 * np.exp(-2e-3)
    np.testing.assert_allclose(outputs[[1, 4]], [2 * x + 0.5, 1.0], rtol=1e-14)


def test_a_failure_names_the_signal_if_another_is_missing(foundry: Path):
    description = describe(tiny(foundry, "NAN_OUTPUT"))
    binding = bind(description, inputs=[], outputs=[signal("heat", "J", needed=False), signal("x"), signal("y")])
    with CoSimulation(description, binding, period=1e-3, parameters={"allowed": 0}) as plant:
        plant.start(np.zeros(0))
        with pytest.raises(PlantFailed, match="output 'y' is not a finite number"):
            plant.step(np.zeros(0))


def test_an_incomplete_array_is_refused(foundry: Path):
    description = describe(tiny(foundry, description=xml().replace('name="y"', 'name="slip[1]"')))
    with pytest.raises(FmuError, match=r"no output 'slip\[2\]'"):
        bind(description, inputs=[], outputs=[signal("slip", size=2, needed=False)])


ARRAY = [signal("speed", "m/s", 4)]
MAYBE = [signal("speed", "m/s", needed=False)]


@pytest.mark.parametrize(
    ("table", "signals", "sentence"),
    [
        ({"speed": {"variable": "x", "factor": 2}}, {}, "has no key 'factor'; it has variable, scale and unit"),
        ({"speed": {"variable": "x", "scale": 0}}, {}, "scale is a finite number other than 0, got 0"),
        ({"speed": {"variable": "x", "scale": "2"}}, {}, "scale is a finite number other than 0, got '2'"),
        ({"speed": {"variable": "x", "unit": 3}}, {}, "unit is a text as 'bar', got 3"),
        ({"speed": {"variable": "x", "unit": "m/s"}}, {}, "already gives 'km/h'; leave it out, or use scale"),
        ({"speed": {"scale": 2}}, {}, "expected is the name of an FMU variable, got None"),
        ({"speed": 7}, {}, "expected is the name of an FMU variable, got 7"),
        ({"speed": ""}, {}, "expected is the name of an FMU variable, got ''"),
        ({"speed": ["x", "y"]}, {}, "the list names 2 variables, the signal has one value, not a list"),
        ({"speed": "label"}, {}, "'label' of .* is a parameter, but must be an output"),
        ({"speed": {"variable": "y", "unit": "parsec"}}, {}, "'parsec' is not a unit known here"),
        ({"sped": "x"}, {}, rf"{WHERE[:9]}.* has no signal 'sped'; did you mean 'speed'\?"),
        ({"speed": "rats"}, {"outputs": MAYBE}, r"speed: .* has no variable 'rats'; did you mean 'rate'\?"),
        ({"speed": "x"}, {"outputs": ARRAY}, r"4 elements; name them by a pattern, 'x\[\{i\}\]', or by a list of 4"),
        (
            {"speed": ["x"]},
            {"outputs": ARRAY},
            r"the list names 1 variables, the signal has 4 elements; .*wheelsets_per_group",
        ),
        ({}, {"inputs": [signal("command", "N.m")]}, r"'u' is in 'bar', the harness sends 'command' in 'N\.m'"),
        ({"p_max": "u"}, {"parameters": [signal("p_max", "bar")]}, r"'u' of .* is an input, but must be a parameter"),
        ({}, {"parameters": [signal("start_speed", "m/s")]}, "no parameter 'start_speed'; it has rate, gain"),
    ],
)
def test_a_table_that_does_not_match_is_refused(
    foreign: Description, table: dict[str, object], signals: dict[str, object], sentence: str
):
    with pytest.raises(FmuError, match=sentence):
        tied(foreign, table, **signals)


def test_two_signals_cannot_drive_one_input(foundry: Path):
    with pytest.raises(FmuError, match=r"two signals drive the same input of .*: u"):
        bind(describe(tiny(foundry)), inputs=[signal("a"), signal("b")], outputs=[], table={"a": "u", "b": "u"})


def test_parameters_are_converted_to_the_units_of_the_fmu(foundry: Path):
    text = xml().replace('start="2" min="0.1" max="10"', 'unit="km/h" start="2"')
    description = describe(tiny(foundry, description=text))
    start = [signal("start_speed", "m/s")]
    binding = bind(description, inputs=[], outputs=[], parameters=start, table={"start_speed": "rate"})
    assert binding.translate({"start_speed": 10.0}) == {"rate": pytest.approx(36.0, rel=1e-15)}
