"""The contact parameters of a plant are read back and compared with those that were set, before a stop uses them."""

import shutil
from pathlib import Path

import pytest

from railgrip.base.errors import FmuError
from railgrip.fmus.build import build_class
from railgrip.fmus.native.library import LIBRARY
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate import bound_plant
from railgrip.simulate.run import run_stop

SHORT = ("limits.horizon=0.1 s", "estimator.kind=none", "controller.kind=full_brake")

ALL = "each r=r, each r_rail=r_rail, each curvature_rail=curvature_rail, each E=E, each nu=nu,\n    curve=curve,"
DEFAULT_CURVE = "curve=fill(Data.CreepCurve(k_A=0.3, k_S=0.1, A=0.4, B=0.2), n),"
LOST = {
    "everything": f"each r=0.38, {DEFAULT_CURVE}",
    "the radius": ALL.replace("each r=r", "each r=0.38"),
    "the curve": ALL.replace("curve=curve,", DEFAULT_CURVE),
    "nothing": ALL,
}
_EACH = ", ".join(f"'r_wheel[{g}]' = '0.42 m'" for g in (1, 2))
RADIUS = [f"vehicle.parameters={{ {_EACH} }}"]
CURVE = ["adhesion.polach={ k_A = 0.6, k_S = 0.2, A = 0.3, B = '0.1 s/m' }"]


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """Return a function that gives the FMU of the wagon as compiled by a compiler that loses modifiers."""

    def built(lost: str) -> Path:
        library = tmp_path_factory.mktemp("lost") / "Wrong"
        shutil.copytree(LIBRARY, library)
        for file in library.rglob("*.mo"):
            file.write_text(file.read_text().replace("RailBraking", "Wrong"))
        wheelsets = library / "Components" / "Wheelsets.mo"
        text = wheelsets.read_text()
        assert ALL in text
        wheelsets.write_text(text.replace(ALL, LOST[lost]))
        return build_class("Wrong.Plants.Wagon", library, compiler="native").path

    return built


@pytest.fixture
def lose(wrong, monkeypatch):
    """Return a function that replaces the recipe of the wagon by an FMU with lost modifiers."""
    monkeypatch.setattr(bound_plant, "_read_back", set())
    return lambda lost: monkeypatch.setattr(
        "railgrip.simulate.named_models.recipe_file", lambda name, lost=lost: wrong(lost)
    )


@pytest.mark.parametrize(
    ("lost", "sentence"),
    [
        # Like OpenModelica's FMUs of these trains: distances up to 19 % off, without an error.
        ("everything", r"the contacts of group 1 have a wheel radius of 0\.38 m"),
        ("the radius", r"0\.38 m by .*r_wheel is 0\.42 m"),
        ("the curve", r"adhesion\[1\] is .* the scenario \(k_A = 0\.6, k_S = 0\.2, A_falling = 0\.3, B_f"),
    ],
)
def test_an_fmu_that_lost_radius_or_creep_curve_is_refused_with_both_values(lose, lost, sentence):
    lose(lost)
    changes = [*SHORT, *RADIUS, *([] if lost == "the radius" else CURVE)]
    with pytest.raises(FmuError, match=rf"Wagon\.fmu: .*{sentence}"):
        run_stop(load(Path("wagon"), changes))


def test_an_fmu_that_lost_nothing_runs_and_is_read_back_once(lose, monkeypatch):
    lose("nothing")
    calls: list[str] = []
    probe_outputs = bound_plant.probe_outputs
    monkeypatch.setattr(bound_plant, "probe_outputs", lambda *a, **k: calls.append("probed") or probe_outputs(*a, **k))
    scenario = load(Path("wagon"), [*SHORT, *RADIUS, *CURVE])
    assert [run_stop(scenario).outcome for _ in range(2)] == [Outcome.HORIZON] * 2
    assert calls == ["probed"]


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        # The contact of a wheel on a roller differs from that on a rail.
        *((name, ()) for name in ("rig_sand", "rig_slide", "wagon", "wagon_unequal", "wagon_stop")),
        ("trapezoid", (*SHORT, "truth.wheel_radius=0.97")),
        ("trapezoid", (*SHORT, "truth.creep.A_falling=0.8")),
        ("trapezoid", (*SHORT, "vehicle.parameters={ r_rail = '0.25 m', v_small = '0.3 m/s' }")),
    ],
)
def test_plants_that_received_truth_and_parameters_are_accepted(name, changes, monkeypatch):
    monkeypatch.setattr(bound_plant, "_read_back", done := set())
    run_stop(load(Path(name), ["limits.horizon=0.1 s", "estimator.kind=none", *changes]))
    assert len(done) == 1
