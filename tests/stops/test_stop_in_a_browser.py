"""A page runs a stop in a browser as the loop does here; the tests need Chromium and ziglang."""

import importlib.util
import json
import re
import sys
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from legible import needs_browser, posted_by
from pages import needs_nothing_else
from sampling import sample

from railgrip.base.errors import ScenarioError
from railgrip.scenario.load import load
from railgrip.simulate.export.browser import write_page
from railgrip.simulate.export.c_parts import with_filter_in_c
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import CustomParts

DOCUMENTED = Path(__file__).parents[2] / "docs/stop.html"
SETTINGS = 20
ROUNDING = 1e-9
"""Relative error of a distance: the C library of WebAssembly (musl) rounds exp, pow and others differently."""

AMPLIFIED = 1e-3
"""The same where a law seeks or switches: wheels that slide beyond the peak amplify rounding until a law decides one
sample earlier or later. By 1e-3 and more, distances count as ill-conditioned."""

_DRIVE = """<script>addEventListener("load", async () => {{
  const found = [];
  for (const settings of {settings}) {{
    try {{
      const [{{ end, rows, time, seconds, peaks }}] = await runStops(settings);
      const last = (name) => rows[rows.length - data.width + data.columns[name][0]];
      found.push({{ end, time, seconds, distance: last("distance"), peaks: peaks.length }});
    }} catch (problem) {{ found.push({{ end: problem.message }}); }}
  }}
  parent.postMessage(JSON.stringify(found), "*");
}});</script>"""

pytestmark = [
    needs_browser,
    pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="needs the package ziglang"),
]


def of_scenario(more):
    return load("trapezoid", [*more], [])


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "stop.html"
    assert write_page(of_scenario, file) == []
    return file


_PRESS = """<script>addEventListener("load", async () => {
  const shown = () => document.querySelector("#results td:nth-child(2)")?.textContent;
  const changed = async (before) => {
    while (!shown() || shown() === before) await new Promise((go) => setTimeout(go, 20));
    return shown();
  };
  const first = await changed(), slider = document.querySelector("input[type=range]");
  const tabs = [...document.querySelectorAll("input, button, summary, select")].map((one) => one.tabIndex);
  slider.focus();
  slider.dispatchEvent(new KeyboardEvent("keydown", { key: "PageDown", bubbles: true, cancelable: true }));
  const second = await changed(first), friction = document.querySelector("output").textContent;
  document.querySelector("#controls > button").click();
  parent.postMessage(JSON.stringify({ first, second, friction, third: await changed(second), tabs }), "*");
});</script>"""

_SHOWN = """<script>addEventListener("load", async () => {
  for (let k = 0; k < 500 && !document.querySelector(".bad"); k++) await new Promise((go) => setTimeout(go, 20));
  parent.postMessage(JSON.stringify(document.querySelector(".bad")?.textContent), "*");
});</script>"""


def answer_of(page, script, folder):
    text = page.read_text(encoding="utf-8").replace("</body>", f"{script}</body>")
    return json.loads(posted_by(text, folder))


def stops_in_browser(page, folder, settings):
    return answer_of(page, _DRIVE.format(settings=json.dumps(settings)), folder)


def random_settings():
    """Yield settings of the page, and the same as overrides; the first are those of the scenario."""
    laws = [("adhesion_based", "margin", 0.0097), ("slip_two_state", "high", 0.15), ("full_brake", None, None)]
    yield {"controls": {}, "shown": ["adhesion_based"]}, []
    random = np.random.default_rng(3)
    for number in range(SETTINGS - 1):
        friction, speed, load_, pads, slope, threshold = random.uniform(
            [0.7, 13.0, 0.85, 0.85, -0.02, 0.9], [1.3, 27.0, 1.2, 1.2, 0.02, 1.3]
        ).tolist()
        kind, name, value = laws[number % len(laws)]
        names = ("friction", "start speed", "load", "pad friction", "gradient")
        controls = dict(zip(names, (friction, speed, load_, pads, slope), strict=True))
        overrides = [f"controller.kind={kind}", f"adhesion.level={friction!r}", f"start.speed={speed!r}"]
        overrides.append(f"track.gradient=[{{begin=0,slope={slope!r}}}]")
        masses = (13400.0, 14100.0, 14500.0, 14500.0, 14100.0, 13400.0)
        overrides += [f'vehicle.parameters."m_wheelset[{i}]"={load_ * m!r}' for i, m in enumerate(masses, 1)]
        for group in range(1, 5):
            overrides += [f'vehicle.parameters."mu_b_{when}[{group}]"={pads * 0.35!r}' for when in ("nominal", "start")]
        settings = {"controls": controls, "shown": [kind]}
        if name is not None:
            settings["laws"] = {kind: {name: threshold * value}}
            overrides.append(f"controller.parameters.{name}={threshold * value!r}")
        yield settings, overrides


def test_a_stop_in_a_browser_is_that_of_the_loop(page, tmp_path):
    cases = sample([*random_settings()], 7)
    found = stops_in_browser(page, tmp_path, [settings for settings, _ in cases])
    for number, ((settings, overrides), here) in enumerate(zip(cases, found, strict=True)):
        there = run_stop(with_filter_in_c(of_scenario(overrides)))
        is_exact = number == 0 or settings["shown"] == ["full_brake"]
        assert here["end"] == there.outcome.value, settings
        assert here["distance"] == pytest.approx(there.metrics.distance, rel=ROUNDING if is_exact else AMPLIFIED)
        assert here["time"] == pytest.approx(there.metrics.duration, rel=ROUNDING if is_exact else AMPLIFIED)
        assert here["peaks"] > 100


def test_the_law_of_the_tutorial_runs_on_a_page(tmp_path, monkeypatch):
    text = (DOCUMENTED.parent / "tutorials/own_controller.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```(?:python|toml)\n(.*?)```", text, re.DOTALL)
    module, named = (
        next(each for each in blocks if part in each) for part in ("class ThresholdFormula", "[controller]")
    )
    (tmp_path / "my_formula.py").write_text(module, encoding="utf-8")
    (tmp_path / "mine.toml").write_text(named, encoding="utf-8")
    monkeypatch.delitem(sys.modules, "my_formula", raising=False)
    objects, page = CustomParts(folders=(tmp_path,)), tmp_path / "mine.html"
    assert write_page(lambda more: load(tmp_path / "mine.toml", [*more], []), page, objects) == []
    kind = "my_formula:ThresholdFormula"
    settings = [{"controls": {}, "shown": [kind], "laws": {kind: {"threshold": level}}} for level in (0.05, 0.15)]
    for level, here in zip((0.05, 0.15), stops_in_browser(page, tmp_path, settings), strict=True):
        scenario = load(tmp_path / "mine.toml", [f"controller.parameters.threshold={level}"], [])
        distance = run_stop(with_filter_in_c(scenario), objects=objects).metrics.distance
        assert here["distance"] == pytest.approx(distance, rel=AMPLIFIED)


def test_a_stop_that_does_not_end_or_run_is_a_sentence(page, tmp_path):
    moving, wrong, after = stops_in_browser(page, tmp_path, [
        {"controls": controls, "shown": ["full_brake"]} for controls in ({"friction": 1e-3}, {"load": 0.0}, {})
    ])  # fmt: skip
    assert (moving["end"], wrong["end"], after["end"]) == ("horizon", "plant_failed", "standstill")
    full = tmp_path / "full.html"
    start, exhaust = "  const level = settings.controls", "  for (let n = 65536; n; n >>= 1) while (api.allocate(n));\n"
    full.write_text(page.read_text(encoding="utf-8").replace(start, exhaust + start), encoding="utf-8")
    assert "the plant failed: the browser has no memory left for it" in answer_of(full, _SHOWN, tmp_path)


def test_the_page_needs_nothing_else_and_forbids_it(page):
    text = page.read_text(encoding="utf-8")
    policy = re.search(r'Content-Security-Policy" content="(.*?)"', text).group(1)
    assert needs_nothing_else(page)
    assert page.stat().st_size < 1.5e6
    assert policy.startswith("default-src 'none'")
    assert "'unsafe-eval'" not in policy
    assert "eval(" not in text


def test_a_stop_that_is_not_in_c_is_refused(tmp_path):
    noisy = ["sensors.kind=white", "sensors.noise.speed=0.1"]
    with pytest.raises(ScenarioError, match=r"trapezoid: \[sensors\] have noise, .* use kind = 'ideal'"):
        write_page(lambda more: of_scenario([*noisy, *more]), tmp_path / "stop.html")


def test_a_key_moves_the_friction_and_a_button_moves_it_back(page, tmp_path):
    found = answer_of(page, _PRESS, tmp_path)
    distances = [float(found[name].removesuffix(" m")) for name in ("first", "second", "third")]
    assert found["friction"] == "90 %"
    assert distances[0] == distances[2] == pytest.approx(run_stop(of_scenario([])).metrics.distance, abs=0.005)
    assert distances[1] > 1.05 * distances[0]
    assert set(found["tabs"]) == {0}


def test_the_page_of_the_documentation_runs_the_present_code(tmp_path):
    """`railgrip export trapezoid --page docs/stop.html` has written it, and writes it anew after a change of code."""
    text = DOCUMENTED.read_text(encoding="utf-8")
    for script in ("browser.js", "browser_worker.js"):
        assert (files("railgrip.simulate.export") / script).read_text(encoding="utf-8").strip() in text, script
    kinds = {"adhesion_based", "slip_two_state", "full_brake"}
    settings = [{"controls": {}, "shown": [kind]} for kind in sorted(kinds)]
    for kind, here in zip(sorted(kinds), stops_in_browser(DOCUMENTED, tmp_path, settings), strict=True):
        there = run_stop(of_scenario([f"controller.kind={kind}"]))
        rounding = AMPLIFIED if kind == "slip_two_state" else ROUNDING
        assert here["distance"] == pytest.approx(there.metrics.distance, rel=rounding), kind
