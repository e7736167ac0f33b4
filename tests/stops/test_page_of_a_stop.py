"""The page of a stop has its laws, and says what it lacks; tests/stops/test_stop_in_a_browser.py runs such pages.

The program of the page is left out, because its compiler takes half a minute on a new machine.
"""

import json
import re

import pytest
from command_line import done


@pytest.fixture
def of_page(tmp_path, monkeypatch, capfd):
    """Return the data of a page of the stop `plain`, and what the command says."""
    monkeypatch.setattr("railgrip.simulate.export.browser.binary", lambda files, name, **options: b"\0asm")
    ended = done(capfd, "export", "plain", "--page", page := tmp_path / "pages/plain.html")
    assert ended.code == 0, ended.err
    (data,) = re.findall(r'<script [^>]*id="data"[^>]*>(.*?)</script>', page.read_text(encoding="utf-8"), re.DOTALL)
    return json.loads(data), ended.err


def test_laws_have_their_parameters_and_a_quantity_without_formula_has_no_slider(of_page):
    data, said = of_page
    laws = {law["kind"]: [each["name"] for each in law["thresholds"]] for law in data["laws"]}
    assert [*laws] == ["adhesion_based", "slip_two_state", "full_brake"]
    assert laws["slip_two_state"] == ["low", "high", "speed_min"]
    assert laws["full_brake"] == []
    assert [control["name"] for control in data["controls"]] == ["load", "pad friction"]
    assert re.findall(r"without a slider of the ([\w ]+):", said) == ["friction", "start speed", "gradient"]
