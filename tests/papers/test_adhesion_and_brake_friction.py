"""The page on Schwarz and Keck (2020): measurements on the figures, which the page must contain."""

from pathlib import Path

import numpy as np
import pytest
import xarray

from railgrip.recording.samples import recording_of
from railgrip.report.table import with_tables
from railgrip.scenario.load import load
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.papers import adhesion_and_brake_friction as page
from railgrip.studies.papers.pages import FOLDER, measures_of
from railgrip.studies.roller_rig import recording_of_rig

PROJECT = Path(__file__).parents[2]
PERIOD = 0.005


def test_the_page_contains_the_measurements():
    text = (PROJECT / FOLDER / page.PAGE).read_text(encoding="utf-8")
    tables = {"published": page.table(measures_of(page.PAGE, PROJECT))}
    assert with_tables(text, tables) == text
    assert "<!-- published: written by `railgrip study roller_rig --write` -->\n" in text
    stale = text.replace("| 120 km/h |", "| 121 km/h |")
    assert with_tables(stale, tables) == text != stale


def test_brake_applications_before_the_long_pause_are_the_short_ones():
    time = np.arange(12000) * PERIOD
    begins = np.array([18.0, 24.0, 30.0, 42.0, 44.0, 46.0, 48.0])
    force = np.zeros(time.size)
    for begin in begins:
        force[(time >= begin) & (time < begin + 1)] = 2e4
    found = page.brakings(recording_of({"pad_force": (force, "N")}, period=PERIOD))
    assert found["stop"] == pytest.approx(42.0, abs=2 * PERIOD)
    assert [begin for begin, _ in found["short"]] == pytest.approx([18.0, 24.0, 30.0], abs=2 * PERIOD)
    assert [end for _, end in found["short"]] == pytest.approx([19.0, 25.0, 31.0], abs=2 * PERIOD)
    # Four brake applications until the end, at 60 s.
    assert found["applications"] == pytest.approx(4 / 18, rel=1e-3)


def judged(truth, mean):
    """Return a recording with the truth of some states, and estimates of them, state → values."""
    time = np.arange(len(truth["group_adhesion"])) * PERIOD
    units = {"wheelset_speed": "rad/s", "speed": "m/s", "group_adhesion": "1"}
    states = {name: (values, units[name]) for name, values in truth.items()}
    recording = recording_of({"speed": (time, "m/s")}, period=PERIOD, truth=states)
    coords = {"time": recording["time"], "state": [*mean]}
    return recording, xarray.Dataset({"mean": (("time", "state"), np.stack([*mean.values()], axis=1))}, coords=coords)


def test_errors_above_the_limit_count_once_per_interval_in_the_deep_slide():
    time = np.arange(4000) * PERIOD
    error = np.zeros(time.size)
    for begin, end in ((1.0, 1.1), (4.0, 4.2), (6.0, 6.01), (12.0, 12.5)):
        error[(time >= begin) & (time < end)] = -1.1 * page.LIMIT
    error[(time >= 8.0) & (time < 8.5)] = 0.9 * page.LIMIT
    assert page.peaks_in_slide(*judged({"group_adhesion": 0.05 + 0 * time}, {"group_adhesion": 0.05 + error})) == 2


def test_the_start_is_corrected_when_the_error_stays_within_the_limit():
    time = np.arange(600) * PERIOD
    for begin, end, expected in (
        (0.0, 0.3, 0.3),
        (0.2, 0.4, 0.4),
        (0.0, 0.0, 0.0),
        (0.0, 1.5, np.inf),
        (2.5, 2.6, 0.0),
    ):
        error = np.where((time >= begin - 1e-9) & (time < end - 1e-9), 0.03, 0.0)
        found = page.settling(*judged({"group_adhesion": 0 * time}, {"group_adhesion": error}))
        assert found == pytest.approx(expected, abs=PERIOD / 10)


def test_late_errors_are_those_of_adhesion_from_the_published_instant_on():
    """An error of 0.01 from 110 s on with one sample of 0.04; w and v are wrong by constants."""
    time = np.arange(24000) * PERIOD
    late = time >= 110.0
    error = np.where(late, 0.01, 0.3)
    error[-1] = 0.04
    truth = {"wheelset_speed": time, "speed": time, "group_adhesion": 0.05 + 0 * time}
    errors = {"wheelset_speed": 1e-3, "speed": -2e-3, "group_adhesion": error}
    found = page.late_errors(*judged(truth, {name: truth[name] + errors[name] for name in truth}))
    assert found["wheelset_speed"] == pytest.approx(1e-3, rel=1e-6)
    assert found["speed"] == pytest.approx(2e-3, rel=1e-6)
    assert found["largest"] == pytest.approx(0.04)
    assert found["adhesion"] == pytest.approx(np.sqrt(1e-4 + (16e-4 - 1e-4) / late.sum()), rel=1e-6)


def test_the_response_of_a_lag_is_its_time_constant():
    """Pad force with a lag of 0.2 s behind two interventions."""
    time = np.arange(4000) * PERIOD
    busy, force = np.zeros(time.size), np.full(time.size, 4e4)
    for begin in (4.0, 12.0):
        since = time - begin
        part = (since >= -PERIOD / 2) & (since < 3.0)
        busy[part], force[part] = 1.0, 4e4 * np.exp(-since[part] / 0.2)
    recording = recording_of({"pad_force": (force, "N"), "protecting": (busy, "1")}, period=PERIOD)
    assert page.response(recording) == pytest.approx(0.2, abs=2 * PERIOD)


@pytest.fixture(scope="module")
def slide():
    scenario = load(Path("rig_sand"), ["limits.horizon='11 s'"])
    return page.points_of_slide(recording_of_rig(scenario), VehicleData(scenario).contact)


def test_the_release_is_beyond_the_peak_and_the_wheelset_returns_over_it(slide):
    (peak_slip, peak), (release_slip, release), (rolling_slip, rolling) = slide["points"].values()
    assert rolling_slip < peak_slip < release_slip
    assert max(release, rolling) < 0.7 * peak
    slip, adhesion = slide["way"]
    assert slip[0] == slip.max() == release_slip
    assert np.mean(np.diff(slip) < 0) > 0.99
    # Friction scatters by 5 % along the roller.
    assert adhesion.max() == pytest.approx(peak, rel=0.1)
    assert 0.3 * peak_slip < slip[np.argmax(adhesion)] < 3 * peak_slip


def test_the_adhesion_of_the_plant_is_on_the_curve_of_its_friction(slide):
    slips, curve = slide["curve"]
    slip, adhesion = slide["points"][2]
    # The curve has 60 points between 0.1 and 50 %; the friction of a row holds until the next one.
    assert np.interp(slip, slips, curve) == pytest.approx(adhesion, rel=0.01)


def test_figures_have_axes_with_units_and_marks_of_the_text(slide):
    (panel,) = page.qualitative_figure(slide).axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("slip [%]", "adhesion")
    assert [text.get_text() for text in panel.texts] == ["1", "2", "3"]
    forces = {text.get_text() for text in page.wagon_figure().axes[0].texts}
    assert {"$F_{x,f}$", "$F_{z,r}$", "$m g$", "$v_x$", "$h$", "$a$"} <= forces
