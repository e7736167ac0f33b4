"""A repeatable table written once in single brackets is refused with a hint at double brackets."""

import pytest

from railgrip.base.errors import ScenarioError
from railgrip.scenario.campaign import load_campaign

CAMPAIGN = 'name = "mine"\nscenarios = ["plain"]\n[axes.control]\nnone = { "controller.kind" = "full_brake" }\n'


@pytest.mark.parametrize("table", ["exclude", "reference", "expected"])
def test_a_campaign_gives_the_hint(table, tmp_path):
    (tmp_path / "mine.toml").write_text(f'{CAMPAIGN}[{table}]\ncontrol = "none"\n', encoding="utf-8")
    with pytest.raises(ScenarioError, match=rf"mine.toml: \[{table}\] is a table, .*; write \[\[{table}\]\]"):
        load_campaign(tmp_path / "mine.toml")


@pytest.mark.parametrize("last", [2**63, 2**70, 10**400, -1, 1.5, True], ids=range(6))
def test_seeds_of_draws_are_those_of_a_scenario(last, tmp_path):
    text = f"{CAMPAIGN}[draws]\nfirst = 0\nlast = {str(last).lower()}\n"
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"mine.toml: \[draws\] last is "):
        load_campaign(tmp_path / "mine.toml")
