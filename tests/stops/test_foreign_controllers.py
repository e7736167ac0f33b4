"""Controllers that come as FMUs: the laws of this project, exported and put back, and what does not fit."""

from functools import partial
from pathlib import Path

import casadi as ca
import pytest

from railgrip.assemble import run_stop
from railgrip.assemble.export import controller_fmu
from railgrip.errors import FmuError, ScenarioError
from railgrip.fmus.build import fmu
from railgrip.fmus.native import Variable
from railgrip.fmus.native.discrete import Discrete, sources
from railgrip.fmus.native.package import pack
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.load import load
from railgrip.trace.outcome import Outcome

SCENARIOS = Path(__file__).parents[2] / "harness" / "scenario"
SHORT = ("limits.horizon=3 s",)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("controllers")


def exported(scenario, folder):
    return pack(controller_fmu(scenario), folder / f"{scenario.name}-{scenario.controller.kind}.fmu")


def with_fmu(campaign_stop: str, folder, *overrides: str):
    """Return a stop of the table, and the same with its controller as an FMU."""
    own = load_campaign(SCENARIOS / "campaigns" / "table1.toml", SHORT)
    (one,) = (stop.scenario for stop in own.stops if stop.name == campaign_stop)
    path = exported(one, folder)
    foreign = load_campaign(
        SCENARIOS / "campaigns" / "table1.toml",
        [*SHORT, "controller.kind=fmu", f"controller.file={path}", *overrides],
    )
    (other,) = (stop.scenario for stop in foreign.stops if stop.name == campaign_stop)
    return one, other


@pytest.mark.parametrize("trust", ["true", "false"])
@pytest.mark.parametrize("stop", ["trapezoid-ideal-adhesion_based", "random-service-slip_two_state"])
def test_a_law_that_went_out_as_an_fmu_brakes_as_before(stop, trust, folder):
    """Same operations in the same order: not a digit differs, in this process or in one of its own, whether the FMU
    gives pressures or, with its valve logic inside, commands."""
    one, other = (run_stop(asked) for asked in with_fmu(stop, folder, f"controller.trust={trust}"))
    assert one.trace["distance"].values.tobytes() == other.trace["distance"].values.tobytes()
    assert one.trace["command"].values.tobytes() == other.trace["command"].values.tobytes()
    assert set(other.fmus) - set(one.fmus) == {f"{stop.split('-')[0]}-{stop.split('-')[2]}.fmu"}


def test_parameters_of_the_fmu_are_set(folder):
    _, other = with_fmu("trapezoid-ideal-slip_two_state", folder, "controller.trust=true")
    _, gentle = with_fmu(
        "trapezoid-ideal-slip_two_state", folder, "controller.trust=true", "controller.parameters.high=0.5"
    )
    assert run_stop(gentle).trace["slip"].max() > run_stop(other).trace["slip"].max() + 0.1


def test_an_fmu_that_brakes_nothing_is_refused():
    """The contact of the physics library takes slip and gives adhesion: no controller."""
    path = fmu("ContactPoint")
    scenario = load(SCENARIOS / "library" / "plain.toml", ["controller.kind=fmu", f"controller.file={path}"])
    with pytest.raises(FmuError, match=r"plain: .controller.map.: ContactPoint.fmu gives neither demand nor command"):
        run_stop(scenario)


def test_valve_commands_want_valves(folder):
    service = load_campaign(SCENARIOS / "campaigns" / "table1.toml", SHORT)
    (one,) = (stop.scenario for stop in service.stops if stop.name == "random-service-slip_two_state")
    path = exported(one, folder)
    scenario = load(SCENARIOS / "library" / "plain.toml", ["controller.kind=fmu", f"controller.file={path}"])
    with pytest.raises(FmuError, match=r"commands valves, but .actuation. kind is 'ideal'"):
        run_stop(scenario)


def test_valve_commands_take_no_demand_of_a_driver(folder):
    _, other = with_fmu(
        "random-service-slip_two_state", folder, "controller.trust=true", "demand.phases=[{pressure=0}]"
    )
    with pytest.raises(ScenarioError, match=r"\[demand\] limits the pressures .* commands the valves; leave out"):
        run_stop(other)


def test_an_unknown_name_in_the_map_is_refused(folder):
    path = exported(load(SCENARIOS / "library" / "plain.toml"), folder)
    scenario = load(
        SCENARIOS / "library" / "plain.toml",
        ["controller.kind=fmu", f"controller.file={path}", "controller.map.demnd=demand[{i}]"],
    )
    with pytest.raises(FmuError, match="has no signal 'demnd'"):
        run_stop(scenario)


@pytest.mark.parametrize(
    ("name", "sentence"), [("period", "has no parameter 'period'"), ("rise", "is at least 0, got")]
)
def test_what_an_exported_law_cannot_do_is_refused(name, sentence, folder):
    """The period is that of its step, and none of its parameters is negative."""
    path = exported(load(SCENARIOS / "library" / "plain.toml"), folder)
    wrong = [f"controller.file={path}", f"controller.parameters.{name}={'5 ms' if name == 'period' else -0.1}"]
    with pytest.raises(ValueError, match=sentence):
        run_stop(load(SCENARIOS / "library" / "plain.toml", ["controller.kind=fmu", *wrong, *SHORT]))


def lasting(calls: int) -> Discrete:
    """Return a controller that demands 1 bar and has a state that is no number after so many calls and one more."""
    left = ca.SX.sym("left")
    step = ca.Function("step", [left, ca.SX(0, 1), ca.SX(0, 1)], [left - 1.0 / (left > 0), ca.SX.ones(4) * 1e5])
    variable = partial(Variable, description="", minimum=None, maximum=None, nominal=1.0)
    return Discrete(
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
def test_a_controller_that_fails_ends_the_stop_with_its_words(trust, folder):
    """What came before is kept: seven calls that decide, from sample 0 on, and the row of the one that does not."""
    path = pack(sources(lasting(7)), folder / "lasting.fmu")
    asked = [f"controller.file={path}", f"controller.trust={trust}", "estimator.kind=none", "periods.trace=1 ms"]
    stop = run_stop(load(SCENARIOS / "library" / "plain.toml", ["controller.kind=fmu", *asked, *SHORT]))
    assert stop.outcome is Outcome.CONTROLLER_FAILED
    assert stop.reason.startswith("The controller failed: lasting.fmu: at 0.007 s")
    assert "a state is not a number" in stop.reason
    assert stop.trace["command"].values[:, 0].tolist() == [0.0] + [1e5] * 7


def test_the_owner_of_an_isolated_controller_is_told_where_to_trust_it(folder):
    told: list[str] = []
    path = pack(sources(lasting(1)), folder / "lasting.fmu")
    asked = [f"controller.file={path}", "estimator.kind=none"]
    run_stop(load(SCENARIOS / "library" / "plain.toml", ["controller.kind=fmu", *asked, *SHORT]), notify=told.append)
    assert ["set trust = true under [controller]" in sentence for sentence in told] == [True]


def test_inputs_that_nobody_estimates_are_told(folder):
    _, other = with_fmu("random-service-slip_two_state", folder)
    told: list[str] = []
    run_stop(other, notify=told.append)
    assert told[0].startswith("random-slip_two_state.fmu: nothing drives its adhesion, pad_friction ([estimator] kind")
    _, other = with_fmu("trapezoid-ideal-adhesion_based", folder, "controller.trust=true")
    told.clear()
    run_stop(other, notify=told.append)
    assert told == []
