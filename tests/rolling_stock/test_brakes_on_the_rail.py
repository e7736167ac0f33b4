"""Brakes on the rail act in an emergency brake alone: every kind asks for one, a kind that is added as well."""

import re
from typing import get_args

import pytest

from railgrip.rolling_stock.brakes import AxleBrake, DynamicBrake, EddyCurrentRail, RailBrake, TrackBrake
from railgrip.rolling_stock.modelica import class_text
from railgrip.rolling_stock.schema import train_of

MAGNETS = {
    "magnets": 2, "attraction": "60 kN", "friction_slow": 0.2, "friction_fast": 0.08, "friction_speed": "8 m/s",
    "delay": "0.3 s", "time_constant": "0.1 s", "estimated": True,
}  # fmt: skip
EDDY_CURRENT = {
    "kind": "eddy_current_rail", "force": "20 kN", "speed_peak": "90 km/h", "speed_full": "60 km/h",
    "speed_end": "50 km/h", "time_constant": "0.5 s", "estimated": True,
}  # fmt: skip
EXAMPLES = {TrackBrake: ("track_brake", MAGNETS), EddyCurrentRail: ("dynamic_brake", EDDY_CURRENT)}
"""Class of a brake on the rail → key of [bogies] that names it, and a table of it."""

CONDITIONS = ("brake_demand >= 1", "magnets > 0.5")
"""Emergency brake: the demand of the driver, or the input of magnets, which the loop sets with full brake."""


def text_with(tables, kind, *, pneumatic):
    """Return the plant of the train whose first bogie has a brake of a kind."""
    key, example = EXAMPLES[kind]
    tables[f"{key}s"] = {"rail": example}
    tables["bogies"]["braked"] = tables["bogies"]["trailer"] | {key: "rail"}
    tables["cars"][0]["bogies"][0]["kind"] = "braked"
    return class_text(train_of(tables, "ours.toml"), pneumatic=pneumatic)


def require_emergency(text):
    """Fail for a component that brakes a body without asking for an emergency brake; return the components' names."""
    bodies = re.findall(r"^ *body\d+\.track_force = (.*?);", text, flags=re.MULTILINE | re.DOTALL)
    names = [name for right in bodies for name in re.findall(r"- (\w+)\.force\b", right)]
    for name in names:
        equations = re.findall(rf"^ *{name}\.(?:demand|command) = (.*?);", text, flags=re.MULTILINE | re.DOTALL)
        assert any(condition in right for right in equations for condition in CONDITIONS), (
            f"{name} brakes on the rail, but acts with any demand: in rolling_stock/plant.mo.jinja, its demand must be "
            "0 unless `brake_demand >= 1` (emergency brake), as for eddy_current1"
        )
    return names


def test_every_kind_of_brake_on_the_rail_has_an_example():
    needs_no_axle = {kind for kind in get_args(get_args(DynamicBrake)[0]) if not issubclass(kind, AxleBrake)}
    lacking = sorted(kind.__name__ for kind in {*get_args(RailBrake), *needs_no_axle} - EXAMPLES.keys())
    assert not lacking, f"add a table of {', '.join(lacking)} to EXAMPLES: it must act in an emergency brake alone"


@pytest.mark.parametrize("kind", EXAMPLES)
@pytest.mark.parametrize("pneumatic", [True, False], ids=["valves", "pressures"])
@pytest.mark.parametrize("train", ["tables", "piped"], ids=["wire", "pipe"])
def test_it_asks_for_an_emergency_brake(kind, pneumatic, train, request):
    assert require_emergency(text_with(request.getfixturevalue(train), kind, pneumatic=pneumatic))


def test_a_kind_that_acts_with_any_demand_is_named(tables):
    text = text_with(tables, EddyCurrentRail, pneumatic=True).replace(" and brake_demand >= 1", "")
    with pytest.raises(AssertionError, match="eddy_current1 brakes on the rail, but acts with any demand"):
        require_emergency(text)
