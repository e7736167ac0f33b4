"""Controllers as FMUs: built-in laws, exported and read back, and refusals of FMUs that do not match."""

import re
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from sampled_systems import sampled
from sampling import sample
from synthetic import LIBRARY
from table_1 import table_1_scenario

from railgrip.base.errors import FmuError, ScenarioError
from railgrip.base.system import SampledSystem
from railgrip.controllers.observation import Observation
from railgrip.fmi import Port, bind, describe
from railgrip.fmi.instance import Instance
from railgrip.fmus.build import fmu
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.controller import ForeignController
from railgrip.simulate.export.controller_and_plant import controller_fmu
from railgrip.simulate.run import run_stop

PLAIN = LIBRARY / "plain.toml"
SHORT = ("limits.horizon=3 s",)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("controllers")


def exported(scenario, folder):
    return pack(controller_fmu(scenario), folder / f"{scenario.name}-{scenario.controller.kind}.fmu")


def with_fmu(name: str, folder, *overrides: str, law: tuple[str, ...] = ()):
    """Return a stop of Table 1, optionally with another law, and the same with its controller as an FMU."""
    plain = table_1_scenario(name, *SHORT, *law)
    own = f"controller.file={exported(plain, folder)}"
    return plain, table_1_scenario(name, *SHORT, "controller.kind=fmu", own, *overrides)


def plain_with(path, *overrides: str):
    """Return the plain scenario with a controller FMU."""
    return load(PLAIN, ["controller.kind=fmu", f"controller.file={path}", *SHORT, *overrides])


def test_plant_and_controller_are_given_the_horizon(folder, monkeypatch):
    ends, enter = {}, Instance.enter_initialization

    def note(fmu, begin=0.0, tolerance=None, end=None):
        ends[fmu.description.file.stem] = end
        enter(fmu, begin, tolerance, end)

    monkeypatch.setattr(Instance, "enter_initialization", note)
    _, scenario = with_fmu("random-ideal-slip_two_state", folder, "controller.trust=true", "limits.horizon=0.2 s")
    run_stop(scenario)
    assert set(ends.values()) == {0.2}
    assert len(ends) == 2


@pytest.mark.parametrize(
    ("stop", "trust", "law"),
    [
        ("trapezoid-ideal-adhesion_based", "true", None),
        ("random-service-slip_two_state", "false", None),
        *sample(
            [
                *((f"sine_sweep-service-{law}", "true", None) for law in ("adhesion_literal", "adhesion_based")),
                *((f"sine_sweep-ideal-{law}", "true", None) for law in ("slip_two_state", "adhesion_based")),
                ("trapezoid-ideal-adhesion_based", "false", None),
                ("random-service-slip_two_state", "true", None),
                ("sine_sweep-service-slope_seeking", "true", None),
            ],
            2,
        ),
        # Laws that Table 1 lacks.
        *(
            ("sine_sweep-service-adhesion_based", "true", law)
            for law in sample(["wheel_reference", "constant_slip", "extremum_seeking", "deceleration_control"], 2)
        ),
    ],
)
def test_a_law_exported_as_an_fmu_brakes_as_before(stop, trust, law, folder):
    """The same operations in the same order give identical digits, in this process or in a separate one.

    This holds whether the FMU outputs pressures or, with its valve logic inside, commands.
    """
    scenario, _, kind = stop.split("-")
    other_law = (f"controller.kind={law}",) if law else ()
    one, other = (run_stop(each) for each in with_fmu(stop, folder, f"controller.trust={trust}", law=other_law))
    assert one.trace["distance"].values.tobytes() == other.trace["distance"].values.tobytes()
    assert one.trace["command"].values.tobytes() == other.trace["command"].values.tobytes()
    assert set(other.fmus) - set(one.fmus) == {f"{scenario}-{law or kind}.fmu"}


def test_parameters_of_the_fmu_are_set(folder):
    _, other = with_fmu("trapezoid-ideal-slip_two_state", folder, "controller.trust=true")
    _, gentle = with_fmu(
        "trapezoid-ideal-slip_two_state", folder, "controller.trust=true", "controller.parameters.high=0.5"
    )
    assert run_stop(gentle).trace["slip"].max() > run_stop(other).trace["slip"].max() + 0.1


VALVE_LAW = "random-service-slip_two_state"


def test_an_fmu_without_brake_outputs_is_refused():
    """The contact of the physics library has slip as input and adhesion as output: it is not a controller."""
    with pytest.raises(FmuError, match=r"plain: .controller.map.: ContactPoint.fmu gives neither demand nor command"):
        run_stop(plain_with(fmu("ContactPoint")))


def test_valve_commands_require_valves(folder):
    path = exported(table_1_scenario(VALVE_LAW, *SHORT), folder)
    with pytest.raises(FmuError, match=r"commands valves, but .actuation. kind is 'ideal'"):
        run_stop(plain_with(path))


def test_valve_commands_accept_no_demand_of_a_driver(folder):
    _, other = with_fmu(VALVE_LAW, folder, "controller.trust=true", "demand.phases=[{pressure=0}]")
    with pytest.raises(
        ScenarioError, match=r"\[demand\] limits the pressures .* commands the valves instead; leave out"
    ):
        run_stop(other)
    limited = other.revised({"controller": {"release_max": "7 s"}})
    sentences = (
        r"random: \[demand\] limits .*\n"
        r"random: \[controller\] release_max cannot change pressures: .* commands the valves"
    )
    with pytest.raises(ScenarioError, match=sentences):
        run_stop(limited)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("map.demnd=demand[{i}]", "has no signal 'demnd'"),
        ("parameters.period=5 ms", "has no parameter 'period'"),
        ("parameters.rise=-0.1", "is at least 0, got"),
    ],
)
def test_a_table_that_does_not_match_an_exported_law_is_refused(override, sentence, folder):
    """The period is that of its step, and none of its parameters is negative."""
    path = exported(load(PLAIN), folder)
    with pytest.raises((FmuError, ValueError), match=sentence):
        run_stop(plain_with(path, f"controller.{override}"))


def lasting(calls: int) -> SampledSystem:
    """Return a controller that demands 1 bar and whose state becomes NaN one call after a number of calls."""
    left = ca.SX.sym("left")
    return sampled(
        ca.Function("step", [left, ca.SX(0, 1), ca.SX(0, 1)], [left - 1.0 / (left > 0), ca.SX.ones(4) * 1e5]),
        period=1e-3,
        states=[("left", "1", float(calls))],
        outputs=[(f"demand[{g}]", "Pa", 0.0) for g in range(1, 5)],
    )


@pytest.mark.parametrize("trust", ["true", "false"])
def test_a_controller_that_fails_ends_the_stop_with_its_message(trust, folder):
    """Earlier results are kept: seven calls that decide, from sample 0, and the row of the one that does not."""
    path = pack(sources(lasting(7)), folder / "lasting.fmu")
    stop = run_stop(plain_with(path, f"controller.trust={trust}", "estimator.kind=none", "periods.trace=1 ms"))
    assert stop.outcome is Outcome.CONTROLLER_FAILED
    assert stop.reason.startswith("The controller failed: lasting.fmu: at 0.007 s")
    assert "a state is not a number" in stop.reason
    assert stop.trace["command"].values[:, 0].tolist() == [0.0] + [1e5] * 7


def notifications(scenario) -> list[str]:
    sentences: list[str] = []
    run_stop(scenario, notify=sentences.append)
    return sentences


def test_the_user_of_an_isolated_controller_is_notified_how_to_trust_it(folder):
    path = pack(sources(lasting(1)), folder / "lasting.fmu")
    (sentence,) = notifications(plain_with(path, "estimator.kind=none"))
    assert "set trust = true under [controller]" in sentence


def test_inputs_without_an_estimate_are_reported(folder):
    _, other = with_fmu(VALVE_LAW, folder)
    assert "random-slip_two_state.fmu: nothing drives its adhesion, pad_friction" in notifications(other)[0]
    _, other = with_fmu("trapezoid-ideal-adhesion_based", folder, "controller.trust=true")
    assert notifications(other) == []


class Recorder:
    """A plant that records its inputs."""

    def __init__(self):
        self.rows = []

    def start(self, inputs):
        return inputs

    def step(self, inputs):
        self.rows.append(inputs.copy())
        return np.zeros(2)


def law_of_inputs(folder, tool: str = "a hand"):
    """Return description and binding of a law with these inputs: speed in km/h, slip, its validity, an array."""
    state, inputs = ca.SX.sym("x", 0), ca.SX.sym("u", 7)
    system = sampled(
        ca.Function("step", [state, inputs], [state, inputs[:2]]),
        period=0.01,
        inputs=[
            ("speed", "km/h", 36.0), ("slip[1]", "1", 0.02), ("slip[2]", "1", 0.03), ("slip_valid[1]", "1", 1.0),
            ("slip_valid[2]", "1", 1.0), ("pressure[1]", "Pa", 7.0), ("pressure[2]", "Pa", 8.0),
        ],
        outputs=[("demand[1]", "Pa", 0.0), ("demand[2]", "Pa", 0.0)],
    )  # fmt: skip
    source = sources(system)
    source = replace(source, xml=re.sub(r'generationTool="[^"]*"', f'generationTool="{tool}"', source.xml))
    description = describe(pack(source, folder / f"law_{len(tool)}.fmu"))
    ports = [
        Port(name=name, unit=unit, size=size, needed=False)
        for name, unit, size in (
            ("speed", "m/s", 0), ("slip", "1", 2), ("pressure", "Pa", 2),
            ("speed_valid", "1", 0), ("slip_valid", "1", 2), ("pressure_valid", "1", 2),
        )
    ]  # fmt: skip
    outputs = [Port(name="demand", unit="Pa", size=2, needed=True)]
    return description, bind(description, inputs=ports, outputs=outputs)


def observed(speed: float, slip: list[float], pressure: list[float]) -> Observation:
    empty = np.full(2, np.nan)
    return Observation(
        0.0, speed, 0.0, empty, np.array(slip), False, None, None, np.array(pressure), np.full(2, 1e5)
    )  # fmt: skip


def test_a_controller_of_others_never_gets_nan(folder):
    """Before the first reading it gets its own start values, later the last reading; validity has separate inputs."""
    description, binding = law_of_inputs(folder)
    fmu, nan = Recorder(), np.nan
    law = ForeignController(fmu, binding, "demand", description)
    law.decide(observed(nan, [nan, nan], [nan, nan]))
    law.decide(observed(20.0, [0.1, nan], [3e5, 2e5]))
    law.decide(observed(nan, [nan, 0.2], [nan, nan]))
    places = binding.inputs.layout
    assert not np.isnan(fmu.rows).any()
    rows = {name: np.array(fmu.rows)[:, places[name]].tolist() for name in ("speed", "slip", "slip_valid", "pressure")}
    assert rows["speed"] == [[pytest.approx(10.0)], [20.0], [20.0]]  # 36 km/h
    assert rows["slip"] == [[0.02, 0.03], [0.1, 0.03], [0.1, 0.2]]
    assert rows["slip_valid"] == [[0, 0], [1, 0], [0, 1]]
    assert rows["pressure"] == [[7.0, 8.0], [3e5, 2e5], [3e5, 2e5]]


def test_an_exported_law_gets_nan_which_it_defines(folder):
    description, binding = law_of_inputs(folder, "railgrip (CasADi 3)")
    fmu = Recorder()
    ForeignController(fmu, binding, "demand", description).decide(observed(np.nan, [np.nan, 0.1], [1.0, 1.0]))
    assert np.isnan(fmu.rows[0][binding.inputs.layout["slip"]]).tolist() == [True, False]
