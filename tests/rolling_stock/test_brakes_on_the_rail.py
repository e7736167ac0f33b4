"""Brakes on the rail act in an emergency brake alone: every kind asks for one, a kind that is added as well."""

import re

import pytest

from railgrip.base.registry import shelf
from railgrip.rolling_stock.dynamic_brakes.eddy_current_rail import EddyCurrentRail
from railgrip.rolling_stock.modelica import class_text
from railgrip.rolling_stock.schema import load_train, train_of

EXAMPLES = {type(brake): brake for path in shelf("trains").values() for *_, brake in load_train(path).rail_brakes}
"""Class of a brake on the rail → one of the package; test_dynamic_brakes.py requires one of each kind."""

CONDITIONS = ("brake_demand >= 1", "magnets > 0.5")
"""Emergency brake: the demand of the driver, or the input of magnets, which the loop sets with full brake."""


def text_with(tables, kind, *, pneumatic):
    """Return the plant of the train whose first bogie has a brake of a kind."""
    key = "dynamic_brake" if EXAMPLES[kind].is_dynamic else "track_brake"
    tables[f"{key}s"] = {"rail": EXAMPLES[kind].model_dump(mode="json")}
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
            f"{name} brakes on the rail, but acts with any demand: `demand` of its class must be 0 unless the given "
            "condition holds"
        )
    return names


@pytest.mark.parametrize("kind", EXAMPLES)
@pytest.mark.parametrize("pneumatic", [True, False], ids=["valves", "pressures"])
@pytest.mark.parametrize("train", ["tables", "piped"], ids=["wire", "pipe"])
def test_it_asks_for_an_emergency_brake(kind, pneumatic, train, request):
    assert require_emergency(text_with(request.getfixturevalue(train), kind, pneumatic=pneumatic))


def test_a_kind_that_acts_with_any_demand_is_named(tables):
    text = text_with(tables, EddyCurrentRail, pneumatic=True).replace(" and brake_demand >= 1", "")
    with pytest.raises(AssertionError, match="eddy_current1 brakes on the rail, but acts with any demand"):
        require_emergency(text)
