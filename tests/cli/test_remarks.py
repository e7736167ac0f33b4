"""A remark on a scenario is printed by run and campaign, stored in stop.json, and on the pages of stop and campaign."""

import json
from html import unescape
from pathlib import Path

import pytest
from command_line import done

import railgrip as rg
from railgrip.report.stop import read_stop
from railgrip.scenario.file import inline_toml
from railgrip.simulate.remarks import remarks_before

CHANGES = {
    "estimator": {"kind": "none"},
    "controller": {"kind": "full_brake"},
    "adhesion.mu0": 0.3,
    "start.speed": "30 km/h",
    "sensors": {"kind": "ideal"},
    "adhesion.level": 0.15,
    "limits.alpha_max": 0.005,
    "faults": [{"part": "radar", "kind": "dead", "begin": 110.0}],
}
EXPECTED = [
    "plain: [adhesion] level is 0.15; usual are 0.2 to 5; it scales a friction of at most 1.",
    "plain: [limits] alpha_max is 0.005; usual are 0.01 to 0.6; dry rail carries up to 0.5 (Polach, 2005).",
]


@pytest.fixture(scope="module")
def stop():
    return rg.run(rg.Scenario.load("plain", CHANGES))


def test_the_python_interface_has_them(stop):
    assert list(stop.remarks[:2]) == EXPECTED
    assert stop.remarks[2].startswith("plain: [faults[1]] had no effect: it begins at 110 s, and the stop ended at ")
    assert all(sentence in repr(stop) for sentence in stop.remarks)


def test_run_and_campaign_print_them(stop, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    changes = [word for key, value in CHANGES.items() for word in ("--set", f"{key}={inline_toml(value)}")]
    single = done(capsys, "run", "plain", *changes, "--out", tmp_path / "run", "--json")
    assert json.loads(single.out)["remarks"] == list(stop.remarks)
    assert all(sentence in single.err for sentence in stop.remarks)
    assert read_stop(tmp_path / "run").remarks == stop.remarks
    (tmp_path / "few.toml").write_text(
        'name = "few"\nscenarios = ["plain"]\npanels = "none"\n[axes.seed.a]\nseed = 1\n[axes.seed.b]\nseed = 2\n',
        encoding="utf-8",
    )
    several = done(capsys, "campaign", tmp_path / "few.toml", *changes, "--out", tmp_path / "few", "--workers", 1)
    page = unescape((tmp_path / "few" / "index.html").read_text(encoding="utf-8"))
    for sentence in stop.remarks:
        assert several.err.count(f"{sentence} (In 2 of 2 stops.)") == 1
        assert sentence in page
        assert sentence in (tmp_path / "few" / "few.md").read_text(encoding="utf-8").replace("\\", "")


@pytest.mark.parametrize(
    ("plant", "controller", "announced"),
    [
        ({"p_max": [4.2e5, 3.6e5, 3.6e5, 4.2e5]}, {}, True),
        ({"p_max[2]": 3.6e5}, {}, True),
        ({"p_max[2]": 3.6e5}, {"p_max[2]": 3.6e5}, False),
        ({"p_max": [2e5, 1e5, 1e5, 2e5]}, {}, False),
    ],
)
def test_a_pressure_that_the_controller_never_demands_is_announced(plant, controller, announced):
    """A higher limit of the plant alone changes no pressure, a lower one does."""
    scenario = rg.Scenario.load(
        "trapezoid",
        {
            "vehicle.parameters": plant, "estimator.kind": "none", "adhesion.level": 3.0, "limits.horizon": "1 s",
            "controller": {"kind": "full_brake", "parameters": controller},
        },
    )  # fmt: skip
    stop = rg.run(scenario)
    assert any("p_max" in sentence for sentence in stop.remarks) == announced
    usual = stop.trace["cylinder_pressure"].values.max(axis=0) == pytest.approx([3.4e5, 2e5, 2e5, 3.4e5], rel=1e-2)
    assert usual == announced


@pytest.mark.parametrize(("distance", "is_missed"), [("100 m", True), ("600 m", False)])
def test_a_target_that_the_brakes_do_not_reach_has_remarks_and_an_error(distance, is_missed):
    aim = {"distance": distance, "deceleration": "0.8 m/s2", "full_deceleration": "1.0 m/s2"}
    changes = {
        "estimator": {"kind": "none"},
        "controller": {"kind": "full_brake"},
        "sensors": {"kind": "ideal"},
        "adhesion.mu0": 0.3,
        "start.speed": "80 km/h",
        "demand": {"phases": [{"stop_at": aim}]},
    }
    stop = rg.run(rg.Scenario.load("plain", changes))
    error = float(stop.trace["distance"][-1]) - float(distance.split()[0])
    assert stop.metrics.target_error == pytest.approx(error)
    assert (error > 100.0, abs(error) < 5.0) == (is_missed, not is_missed)
    about = [remark for remark in stop.remarks if "target" in remark]
    missed = [
        "plain: the target at 100 m cannot be reached: from 80 km/h the train takes 246.9 m with the full_deceleration "
        "of [demand.phases[1]] stop_at.",
        f"plain: the train stopped {error:.4g} m behind its target at 100 m.",
    ]
    assert about == (missed if is_missed else [])


@pytest.mark.parametrize(("target", "is_said"), [("30 m", True), ("120 m", False)])
def test_a_target_of_the_law_within_the_emergency_brake_distance_is_said_before_the_stop(target, is_said):
    law = {"kind": "deceleration_control", "parameters": {"target": target}}
    stop = rg.Scenario.load("plain", {"controller": law, "start.speed": "55 km/h"})
    remarks = remarks_before(stop.replaced({"vehicle": {"train": "tram"}}))
    assert any("the target at 30 m cannot be reached" in remark for remark in remarks) == is_said
