"""Estimations as TOML files: the library, units, noises and messages about invalid files."""

import re

import numpy as np
import pytest

from railgrip.base.errors import EstimationError, ScenarioError
from railgrip.base.names import STATE_NAMES
from railgrip.estimation.run import by_name
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import (
    LIBRARY,
    load_specification,
    prediction_for,
    settings_for,
)

TEXT = (LIBRARY / "rig_own.toml").read_text()


def written(tmp_path, name="rig_own", **changes):
    text = (LIBRARY / f"{name}.toml").read_text(encoding="utf-8")
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "mine.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("path", sorted(LIBRARY.glob("*.toml")), ids=lambda path: path.stem)
def test_every_file_of_the_library_creates_a_filter(path):
    specification = load_specification(path)
    settings = settings_for(specification, 0.01)
    prediction = prediction_for(specification)
    # One noise for every state, under its name or that of its array, and no other noise.
    assert by_name("process", settings.process, prediction.states).shape == (len(prediction.states),)


def test_equation_20_is_exactly_as_printed():
    noise = load_specification(LIBRARY / "rig_paper.toml").noise
    assert noise.kind == "per_step"
    assert noise.process == {"wheelset_speed": 1e1, "speed": 1e-5, "pad_friction": 1e-3, "group_adhesion": 1e-1}
    assert noise.readings == {"wheelset_speed": 1e-9, "speed": 1e-7}


def test_noise_per_step_does_not_depend_on_the_period():
    paper = load_specification(LIBRARY / "rig_paper.toml")
    for period in (1e-3, 2e-2):
        assert settings_for(paper, period).process["wheelset_speed"] * period == pytest.approx(10.0, rel=1e-15)


def test_a_missing_source_is_refused():
    with pytest.raises(ScenarioError, match="snow: there is no such file, and no scenario of that name"):
        recording_of_estimation(load_specification(LIBRARY / "wagon.toml"), scenario="snow")


def test_noises_may_come_from_a_file(tmp_path):
    (tmp_path / "tuned.toml").write_text("[noise]" + TEXT.partition("[noise]")[2].partition("[start]")[0])
    before, _, after = TEXT.partition("[noise]")
    path = tmp_path / "mine.toml"
    path.write_text(before + '[noise]\nfile = "tuned.toml"\n[start]' + after.partition("[start]")[2])
    assert load_specification(path).noise == load_specification(LIBRARY / "rig_own.toml").noise
    path.write_text(path.read_text().replace('"tuned.toml"', '"tuned.toml"\nkind = "density"'))
    with pytest.raises(EstimationError, match=r"mine\.toml: \[noise\] file replaces the whole table"):
        load_specification(path)
    path.write_text(path.read_text().replace('"tuned.toml"\nkind = "density"', '"lost.toml"'))
    with pytest.raises(ScenarioError, match=r"lost\.toml"):
        load_specification(path)


def test_the_laws_of_the_paper_are_selected_by_parameters():
    """From one file, by `--set`: the wagon as printed in (5), (4) and (12), and pads that relax as in (9)."""
    overrides = ("model.parameters.adhesion_share=0.5", "model.parameters.mu_b_relaxes=1", "noise.process.speed=1e-3")
    specification = load_specification(LIBRARY / "wagon.toml", overrides)
    assert specification.noise.process["speed"] == 1e-3
    literal, consistent = prediction_for(specification), prediction_for(load_specification(LIBRARY / "wagon.toml"))
    x, u = np.array([60.0, 60.0, 28.0, 0.30, 0.35, 0.06]), np.array([2e4, 2e4, 0.0, 0.0, 0.0])
    drag = -1.2 / 2 * 0.9 * 10.0 * 28.0**2 / 40e3
    rates = [prediction.derivative(x, u)[2] - drag for prediction in (literal, consistent)]
    np.testing.assert_allclose(rates, [-0.5 * 0.06 * 9.81, -0.06 * 9.81], rtol=1e-3)  # g to three digits
    # (9): (0.35 − 0.30) over 30 s times 0.30; the other pad is inactive.
    np.testing.assert_allclose(literal.derivative(x, u)[3:5], [0.05 / (30.0 * 0.30), 0.0], rtol=0.011, atol=1e-9)
    assert not consistent.derivative(x, u)[3:5].any()


def test_all_errors_of_an_estimation_are_reported_before_compilation(tmp_path, monkeypatch):
    monkeypatch.setattr("railgrip.estimation.models.prediction_description", lambda *_: pytest.fail("an FMU was built"))
    monkeypatch.setattr("railgrip.estimation.sources.trace_of", lambda *_: pytest.fail("a stop was simulated"))
    changes = [
        "model.parameters.lod='98 kN'",
        "model.parameters.J='3 m'",
        "noise.readings.yaw=1e-3",
        "gate.states=['mu_c']",
        "gate.threshold='1.5 bar'",
        "inputs.pad_froce='1 kN'",
    ]
    path = written(
        tmp_path,
        process=("pad_friction = 5e-5, ", ""),
        mean=("pad_friction = 0.35, group_adhesion = 0.0 }", "pad_friction = 0.35 }"),
        scale=("pad_friction = 0.35, group_adhesion = 0.05 }", "group_adhesion = 0.05 }"),
    )
    with pytest.raises(ScenarioError) as refusal:
        recording_of_estimation(load_specification(path, changes))
    lines = str(refusal.value).splitlines()
    expected = [
        ("[model.parameters]", "'lod'"),
        ("[model.parameters] J", "'3 m'"),
        ("[noise] process", "pad_friction"),
        ("[noise] readings", "yaw"),
        ("[start] mean", "group_adhesion"),
        ("[gate] states", "mu_c"),
        ("[gate] threshold", "'1.5 bar'"),
        ("[inputs]", "'pad_froce'"),
        ("[observability] scale", "pad_friction"),
    ]
    for where, what in expected:
        assert sum(line.startswith(f"rig-own: {where}") and what in line for line in lines) == 1, (where, lines)
    assert len(lines) == len(expected)


def test_a_model_of_another_train_is_refused_before_its_stop_is_simulated(tmp_path, monkeypatch):
    scenario = tmp_path / "other.toml"
    scenario.write_text('extends = "plain"\n[vehicle]\ntrain = "loco_coaches"\n', encoding="utf-8")
    monkeypatch.setattr("railgrip.estimation.sources.trace_of", lambda *_: pytest.fail("a stop was simulated"))
    with pytest.raises(EstimationError, match=r"4 of cylinder_pressure.* has \d"):
        recording_of_estimation(load_specification(LIBRARY / "field.toml"), scenario=str(scenario))


def test_symbols_of_states_in_older_files_are_accepted_and_named(tmp_path):
    """The same estimation with `v`, `w`, `mu_b` and `alpha` for its states has the same settings, and says so."""
    text = (LIBRARY / "rig_own.toml").read_text(encoding="utf-8")
    for symbol, name in STATE_NAMES.items():
        text = re.sub(rf"(?<=[{{,] ){name}(?= = )", symbol, text).replace(
            f'states = ["{name}"]', f'states = ["{symbol}"]'
        )
    path = tmp_path / "older.toml"
    # Readings have the names of signals, as before.
    path.write_text(re.sub(r"(?m)^readings = .*$", readings_line(LIBRARY / "rig_own.toml"), text), encoding="utf-8")
    older, now = load_specification(path), load_specification(LIBRARY / "rig_own.toml")
    assert "mu_b" in path.read_text(encoding="utf-8")
    assert settings_for(older, 0.01) == settings_for(now, 0.01)
    assert now.older_names == []
    (sentence,) = [each for each in older.older_names if each.startswith("older.toml: [noise] process")]
    assert "pad_friction (mu_b)" in sentence


def test_a_symbol_overrides_the_name_below_it_and_not_beside_it():
    """An option with `v` changes the speed of the file; a table with both is ambiguous."""
    changed = load_specification(LIBRARY / "rig_own.toml", ("noise.process.v=1e-3",))
    assert changed.noise.process["speed"] == 1e-3
    assert "v" not in changed.noise.process
    with pytest.raises(EstimationError, match="process has v and speed, which are the same state"):
        by_name("process", {"v": 1.0, "speed": 2.0}, ("speed",))


def readings_line(path):
    return re.search(r"(?m)^readings = .*$", path.read_text(encoding="utf-8"))[0]
