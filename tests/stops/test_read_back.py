"""What the contacts of a plant have is compared with what they were given, before a stop runs on them."""

import shutil
from pathlib import Path

import pytest

from railgrip.assemble import plant, run_stop
from railgrip.errors import FmuError
from railgrip.fmus.build import build_class
from railgrip.fmus.native.library import LIBRARY
from railgrip.scenario.load import load
from railgrip.trace.outcome import Outcome

SHORT = ("limits.horizon=0.1 s", "estimator.kind=none", "controller.kind=full_brake")

ALL = "each r=r, each r_rail=r_rail, each curvature_rail=curvature_rail, each E=E, each nu=nu,\n    curve=curve,"
DEFAULT_CURVE = "curve=fill(Data.CreepCurve(k_A=0.3, k_S=0.1, A=0.4, B=0.2), n),"
LOST = {
    "everything": f"each r=0.38, {DEFAULT_CURVE}",
    "the radius": ALL.replace("each r=r", "each r=0.38"),
    "the curve": ALL.replace("curve=curve,", DEFAULT_CURVE),
    "nothing": ALL,
}
_EACH = ", ".join(f"'r_wheel[{g}]' = '0.42 m'" for g in range(1, 5))
RADIUS = [f"vehicle.parameters={{ {_EACH} }}"]
CURVE = ["adhesion.polach={ k_A = 0.6, k_S = 0.2, A = 0.3, B = '0.1 s/m' }"]


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """Return a function that gives the FMU of the two-part train as a compiler makes it that loses modifiers."""

    def built(lost: str) -> Path:
        library = tmp_path_factory.mktemp("lost") / "Wrong"
        shutil.copytree(LIBRARY, library)
        for file in library.rglob("*.mo"):
            file.write_text(file.read_text().replace("RailBraking", "Wrong"))
        wheelsets = library / "Components" / "Wheelsets.mo"
        text = wheelsets.read_text()
        assert ALL in text
        wheelsets.write_text(text.replace(ALL, LOST[lost]))
        return build_class("Wrong.Plants.TwoPartTrain", library, compiler="native").path

    return built


@pytest.fixture
def of(wrong, monkeypatch):
    """Return a function that lets the recipe of the two-part train be an FMU that lost something."""
    monkeypatch.setattr(plant, "_read_back", set())
    return lambda lost: monkeypatch.setattr("railgrip.assemble.files.recipe_file", lambda name, lost=lost: wrong(lost))


def test_every_axle_with_the_radius_and_the_curve_of_the_defaults_is_refused(of):
    """As OpenModelica made our trains: distances up to 19 % off, without an error."""
    of("everything")
    with pytest.raises(FmuError, match=r"TwoPartTrain\.fmu: the contacts of group 1 have a wheel radius of 0\.38 m"):
        run_stop(load(Path("trapezoid"), [*SHORT, *RADIUS, *CURVE]))


def test_a_radius_alone_is_refused_in_a_sentence_with_both_numbers(of):
    of("the radius")
    with pytest.raises(FmuError, match=r"0\.38 m by slip\[1\], speed and wheelset_speed\[1\].*r_wheel is 0\.42 m"):
        run_stop(load(Path("trapezoid"), [*SHORT, *RADIUS]))


def test_a_curve_alone_is_refused_in_a_sentence_with_the_scenarios(of):
    of("the curve")
    sentence = r"TwoPartTrain\.fmu: adhesion\[1\] is .* the scenario \(k_A = 0\.6, k_S = 0\.2, A_falling = 0\.3, B_f"
    with pytest.raises(FmuError, match=sentence):
        run_stop(load(Path("trapezoid"), [*SHORT, *CURVE]))


def test_an_fmu_that_lost_nothing_runs_and_is_read_back_once(of, monkeypatch):
    of("nothing")
    calls: list[str] = []
    probed = plant.probed
    monkeypatch.setattr(plant, "probed", lambda *a, **k: calls.append("probed") or probed(*a, **k))
    scenario = load(Path("trapezoid"), [*SHORT, *RADIUS, *CURVE])
    assert [run_stop(scenario).outcome for _ in range(2)] == [Outcome.HORIZON] * 2
    assert calls == ["probed"]


SCENARIOS = ("rig_sand", "rig_slide", "wagon", "wagon_unequal", "wagon_stop")


@pytest.mark.parametrize("name", SCENARIOS)
def test_right_plants_of_every_kind_pass(name, monkeypatch):
    """A wheel on a roller has another contact than on a rail; `[truth]` and parameters reach the plant."""
    monkeypatch.setattr(plant, "_read_back", done := set())
    run_stop(load(Path(name), ["limits.horizon=0.1 s", "estimator.kind=none"]))
    assert len(done) == 1


@pytest.mark.parametrize(
    "change",
    [
        ["truth.wheel_radius=0.97"],
        ["truth.creep.A_falling=0.8"],
        ["vehicle.parameters={ r_rail = '0.25 m', v_small = '0.3 m/s' }"],
    ],
)
def test_what_the_truth_changes_is_believed(change, monkeypatch):
    monkeypatch.setattr(plant, "_read_back", done := set())
    run_stop(load(Path("trapezoid"), [*SHORT, *change]))
    assert len(done) == 1
