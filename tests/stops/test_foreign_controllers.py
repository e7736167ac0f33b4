"""Controllers as FMUs: built-in laws, exported and read back, and refusals of FMUs that do not match."""

from functools import partial

import casadi as ca
import pytest
from synthetic import LIBRARY
from table_1 import table_1_scenario

from railgrip.base.errors import FmuError, ScenarioError
from railgrip.base.system import SampledSystem, Variable
from railgrip.fmus.build import fmu
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.export.controller import controller_fmu
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


@pytest.mark.parametrize(
    ("stop", "trust"),
    [
        *(("trapezoid-ideal-adhesion_based", trust) for trust in ("true", "false")),
        *(("random-service-slip_two_state", trust) for trust in ("true", "false")),
        *((f"sine_sweep-ideal-{law}", "true") for law in ("slip_two_state", "adhesion_based")),
        *((f"sine_sweep-service-{law}", "true") for law in ("adhesion_literal", "adhesion_based", "slope_seeking")),
    ],
)
def test_a_law_exported_as_an_fmu_brakes_as_before(stop, trust, folder):
    """The same operations in the same order give identical digits, in this process or in a separate one.

    This holds whether the FMU outputs pressures or, with its valve logic inside, commands.
    """
    one, other = (run_stop(scenario) for scenario in with_fmu(stop, folder, f"controller.trust={trust}"))
    assert one.trace["distance"].values.tobytes() == other.trace["distance"].values.tobytes()
    assert one.trace["command"].values.tobytes() == other.trace["command"].values.tobytes()
    assert set(other.fmus) - set(one.fmus) == {f"{stop.split('-')[0]}-{stop.split('-')[2]}.fmu"}


@pytest.mark.parametrize("law", ["wheel_reference", "constant_slip", "extremum_seeking"])
def test_an_exported_law_that_table_1_lacks_also_brakes_as_before(law, folder):
    stop = "sine_sweep-service-adhesion_based"
    one, other = (run_stop(s) for s in with_fmu(stop, folder, "controller.trust=true", law=(f"controller.kind={law}",)))
    assert one.trace["command"].values.tobytes() == other.trace["command"].values.tobytes()


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
    with pytest.raises(ScenarioError, match=r"\[demand\] limits the pressures .* commands the valves; leave out"):
        run_stop(other)


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
    step = ca.Function("step", [left, ca.SX(0, 1), ca.SX(0, 1)], [left - 1.0 / (left > 0), ca.SX.ones(4) * 1e5])
    variable = partial(Variable, description="")
    return SampledSystem(
        name="Lasting",
        description="Ends",
        period=1e-3,
        states=(variable(name="left", unit="1", start=float(calls)),),
        inputs=(),
        parameters=(),
        outputs=tuple(variable(name=f"demand[{g}]", unit="Pa", start=0.0) for g in range(1, 5)),
        step=step,
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
