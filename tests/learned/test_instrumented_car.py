"""The instrumented car, its track and its sensors, compared with published and closed-form values."""

from dataclasses import replace

import numpy as np
import pytest

from railgrip.estimation.axle_box.instrumented_car import AXLE_BOX, MPH, RATE, Pass, measure, ride
from railgrip.estimation.axle_box.training import campaign
from railgrip.scenario.track_geometry import KINDS, RIDE, TRACKS, Band, realise, rms, spectrum

CHECKED = Band(lowest=0.024, highest=0.333, lines=4000)


@pytest.mark.parametrize(
    ("track", "kind", "millimetres"),
    [
        ("fra-5", "alignment", 3.06), ("fra-5", "vertical", 5.08),
        ("fra-6", "alignment", 2.04), ("fra-6", "vertical", 2.04),
    ],
)  # fmt: skip
def test_spectra_have_the_published_rms(track, kind, millimetres):
    """Root mean squares published for wavelengths from 3 to 42 m, given to 0.01 mm."""
    assert 1e3 * rms(track, kind, CHECKED) == pytest.approx(millimetres, abs=0.005)


def test_a_realisation_has_the_power_of_its_spectrum():
    """Over one whole period of the sum its mean square is that of the lines, whatever the phases."""
    band = Band(lowest=0.02, highest=0.22, lines=40)
    track = realise("erri-low", 1 / band.spacing, np.random.default_rng(1), band)
    # Lines are half a spacing off the multiples of the period, so the sum repeats with its sign reversed.
    place = np.linspace(0, 1 / band.spacing, 4000, endpoint=False)
    for kind in KINDS:
        power = np.sqrt(np.mean(track.at(kind, place) ** 2))
        assert power == pytest.approx(rms("erri-low", kind, band), rel=2e-3)  # interpolation, see `realise`


def test_the_spectrum_over_frequency_keeps_the_power_over_wavenumber():
    f = np.geomspace(0.01, 1, 4000)
    over_f = np.trapezoid(spectrum("erri-low", "vertical", f), f)
    over_omega = np.trapezoid(TRACKS["erri-low"].density("vertical", 2 * np.pi * f), 2 * np.pi * f)
    assert over_f == pytest.approx(over_omega, rel=1e-12)


def test_the_same_seed_gives_the_same_track():
    one, two, other = (
        realise("fra-6", 50.0, np.random.default_rng(s), RIDE).at("gauge", np.arange(50.0)) for s in (1, 1, 2)
    )
    assert np.array_equal(one, two)
    assert not np.allclose(one, other)


QUIET = replace(AXLE_BOX, noise=0.0, rolling=0.0, drift=0.0, walk=0.0, gain_error=0.0)


def test_an_accelerometer_adds_only_its_offset_at_low_frequency():
    """Far below the resonance of the plate a sine is unchanged."""
    time = np.arange(0, 4, 1 / 1280)
    true = np.column_stack([np.sin(2 * np.pi * 3 * time), np.zeros_like(time)])
    readings = measure(true, 1280, 20.0, QUIET, np.random.default_rng(1), np.random.default_rng(2))
    offset = readings[:, 1]
    assert 266 <= offset[0] <= 272
    assert np.ptp(offset) < 1e-9
    swing = readings[:, 0] - readings[:, 0].mean()
    fine = np.arange(len(readings)) / RATE
    expected = np.sin(2 * np.pi * 3 * fine)
    # Resonance at 640 Hz: 3 Hz is raised by (3/640)² and delayed by 2 ζ f/f0².
    # Compared after 50 ms, ten time constants of the plate.
    assert np.abs(swing - (expected - expected.mean()))[RATE // 20 :].max() < 1e-3


def test_a_plate_at_its_resonance_amplifies_by_its_quality_factor():
    time = np.arange(0, 1, 1 / RATE)
    true = np.sin(2 * np.pi * AXLE_BOX.plate_frequency * time)[:, None]
    readings = measure(true, RATE, 20.0, QUIET, np.random.default_rng(1), np.random.default_rng(2))
    steady = readings[RATE // 2 :, 0]
    # Eight samples a period miss the peak by less than 1 %.
    assert np.ptp(steady) / 2 == pytest.approx(1 / (2 * AXLE_BOX.plate_damping), rel=0.01)


def test_the_campaign_has_the_labels_of_table_2():
    runs = campaign()
    assert len(runs) == 24
    assert len({run.name for run in runs}) == 24
    assert sorted(run.friction for run in runs if run.speed == 40 * MPH) == [0.10, 0.17, 0.22, 0.24, 0.31, 0.37]


def short(**changes):
    run = Pass(
        name="short", speed=60 * MPH, condition="wet", friction=0.2, track="erri-low", track_seed=1, seed=1, length=30.0
    )
    return replace(run, **changes)


@pytest.fixture(scope="module")
def plain():
    return ride(short())


def test_the_car_keeps_its_speed_and_its_track(plain):
    assert np.ptp(plain.speed) < 0.05
    assert np.abs(plain.offset).max() < 0.012  # clearance of 6 mm and a few millimetres of flange contact
    assert 0.15 < plain.friction.mean() < 0.25


def test_coarser_communication_changes_nothing_below_the_plate(plain):
    """Four times as many communication points change accelerations by less than the accuracy of sensors."""
    fine = ride(short(), rate=5120)
    n = len(plain.speed)
    for signal in ("longitudinal", "lateral"):
        one, two = getattr(plain, signal), getattr(fine, signal)[::4][:n]
        # Held inputs are 0.3 ms later at the coarser rate, so standard deviations are compared.
        assert two.std(axis=0) == pytest.approx(one.std(axis=0), rel=0.03)
    # Slip acceleration too, although ω̇ is a difference of samples. Wheelsets roll: without slip ẍ is ω̇r.
    sizes = [np.sqrt(np.mean(one.slip_acceleration**2)) for one in (plain, fine)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.1)
    assert sizes[0] < 0.15


def test_an_unknown_condition_is_named():
    with pytest.raises(ValueError, match="condition 'oil' is unknown; there are dry"):
        short(condition="oil")
