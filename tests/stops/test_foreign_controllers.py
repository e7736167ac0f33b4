"""Controllers that come as FMUs: the laws of this project, exported and put back, and what does not fit."""

from pathlib import Path

import pytest

from fmus.build import fmu
from fmus.native.package import pack
from harness.assemble import run_stop
from harness.export import controller_fmu
from harness.fmu import FmuError
from harness.record.outcome import Outcome
from harness.scenario.campaign import load_campaign
from harness.scenario.load import load

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


def test_an_unknown_name_in_the_map_is_refused(folder):
    path = exported(load(SCENARIOS / "library" / "plain.toml"), folder)
    scenario = load(
        SCENARIOS / "library" / "plain.toml",
        ["controller.kind=fmu", f"controller.file={path}", "controller.map.demnd=demand[{i}]"],
    )
    with pytest.raises(FmuError, match="has no signal 'demnd'"):
        run_stop(scenario)


@pytest.mark.parametrize("trust", ["true", "false"])
def test_a_controller_that_fails_ends_the_stop_with_its_words(trust, folder):
    """A filter time that undoes the period makes a state that is no number, and the FMU says so."""
    path = exported(load(SCENARIOS / "library" / "plain.toml"), folder)
    broken = [f"controller.trust={trust}", "controller.parameters.filter_time=-1 ms"]
    asked = load(
        SCENARIOS / "library" / "plain.toml", ["controller.kind=fmu", f"controller.file={path}", *SHORT, *broken]
    )
    stop = run_stop(asked)
    assert stop.outcome is Outcome.CONTROLLER_FAILED
    assert stop.reason.startswith("The controller failed: plain-adhesion_based.fmu: at 0")
    assert "a state is not a number" in stop.reason
