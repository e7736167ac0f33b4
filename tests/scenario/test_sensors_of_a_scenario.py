"""White sensors of a scenario read the requested quantities, with the effects of the track."""

import numpy as np
import pandas as pd
import pytest
from kernel_calls import read
from synthetic import LAYOUT, LIBRARY, TWO_PART_TRAIN

from railgrip.base.errors import ScenarioError, SensorsFailed
from railgrip.scenario.file import merge
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.track_geometry import RIDE, local, spectrum
from railgrip.vehicle.signals import EXTRA, PLANT, READINGS, layout_of

OUTPUTS = [signal.name for signal in PLANT]
PLAN = {
    "latitude": 50.6, "longitude": 12.7, "height": "340 m", "middle": "0 m", "heading": "0 deg",
    "course": [["500 m", 0]], "slope": "10 permille", "start": "400 m", "direction": "backward",
}  # fmt: skip
GNSS = {
    "period": "0.1 s", "horizontal": "0.02 m", "height": "0.04 m", "horizontal_wander": "0.2 m",
    "height_wander": "0.3 m", "wander_time": "10 s",
}  # fmt: skip


def scenario_with(track=None, **sensors):
    written = load(LIBRARY / "trapezoid.toml").resolved() | {"sensors": {"kind": "white"} | sensors}
    return scenario_of(written | {"track": track or {}}, directory=LIBRARY, origin="own.toml")


def reader(scenario):
    layout = layout_of(TWO_PART_TRAIN, reading=(*READINGS, *scenario.sensors.extra_readings(OUTPUTS)))
    return layout, scenario.sensors.open(scenario, layout, 0.4)


def test_quantities_of_the_noise_table_are_read_in_addition_to_those_of_every_train():
    scenario = scenario_with(noise={"pad_force": "100 N", "speed": "0.1 m/s"})
    layout, sensors = reader(scenario)
    assert [s.name for s in layout.signals["reading"]] == [*(s.name for s in READINGS), "reading_pad_force"]
    truth = np.arange(float(layout.outputs))
    seen = np.array([sensors.read(k, truth) for k in range(5000)])
    error = seen[:, layout.reading["pad_force"]] - truth[layout.output["pad_force"]]
    assert error.std(axis=0) == pytest.approx([100.0] * 4, rel=0.05)
    np.testing.assert_array_equal(seen[:, layout.reading["deflection"]][9], truth[layout.output["deflection"]])


def test_accelerometers_measure_the_gradient_and_gnss_finds_the_train_on_its_track():
    """Backwards down a track that climbs to the north by 10 ‰."""
    track = {"plan": PLAN}
    scenario = scenario_with(track, bias={"acceleration_along": "0.03 m/s^2"}, gnss=GNSS)
    layout, sensors = reader(scenario)
    truth = np.zeros(layout.outputs)
    truth[layout.output["acceleration"]] = -0.5
    place = layout.output["distance"]
    readings = []
    for k in range(20001):
        truth[place] = 300.0 * k / 20000
        readings.append(sensors.read(k, truth))
    readings = np.array(readings)
    along = readings[:, layout.reading["acceleration_along"]]
    assert np.ptp(along, axis=0) == pytest.approx([0.0] * 4, abs=1e-12)
    assert np.ptp(along[0]) > 0.0
    assert along[0] == pytest.approx([-0.5 - 9.81 * np.sin(np.arctan(0.01))] * 4, abs=4 * 0.03)
    fixes = readings[:, layout.reading["latitude"].start : layout.reading["height"].stop]
    assert np.flatnonzero(np.isfinite(fixes[:, 0])).tolist() == list(range(0, 20001, 100))
    north, east, _ = local(*fixes[::100].T, scenario.track.plan.alignment().origin).T
    error = np.column_stack([north - (400 - 300 * np.arange(201) / 200), east])
    # White noise of 0.02 m in differences of neighbours, plus that of the random walk, 0.2 sqrt(2 * 0.1/10).
    assert np.diff(error, axis=0).std() == pytest.approx(np.hypot(0.02 * np.sqrt(2), 0.2 * np.sqrt(0.02)), rel=0.15)
    assert np.abs(error).max() < 5 * 0.2
    truth[place] = 401.0
    with pytest.raises(SensorsFailed, match=r"left its track at -1 m of \[track.plan\], which is 500 m long"):
        sensors.read(20100, truth)


def test_an_extra_output_is_in_the_layout_of_a_plant_that_has_it():
    layout = layout_of(TWO_PART_TRAIN, output=(*PLANT, *EXTRA))
    assert layout.output["drive_torque"].stop == layout.outputs
    assert "OUTPUT_CONTACT_FORCE" in layout.header()


def service(step, **sensors):
    written = load(LIBRARY / "degraded.toml").resolved()
    changes = {"periods": dict.fromkeys(written["periods"], step), "vehicle": {"plant": "TwoPartTrain"}}
    changes |= {"actuation": {"kind": "ideal"}, "sensors": sensors, "faults": []}
    return scenario_of(merge(written, changes), directory=LIBRARY, origin="mine.toml")


def rows_of(scenario, truths):
    """Return the readings of true outputs at successive samples [rows of LAYOUT]."""
    sensors = scenario.sensors.open(scenario, LAYOUT, 0.4)
    return np.array([read(sensors, k, truth) for k, truth in enumerate(truths)])


def test_readings_do_not_depend_on_the_communication_step():
    """Sampled each millisecond, readings of the same truth are equal with a loop at 1, 0.5 or 0.25 ms."""
    assert service("0.3 ms").sensors.sampled_every(3e-4) == 3
    assert service("2 ms").sensors.sampled_every(2e-3) == 1  # a coarser loop reads at each of its steps
    readings = []
    for step in ("1 ms", "0.5 ms", "0.25 ms"):
        scenario = service(step)
        every = scenario.sensors.sampled_every(scenario.periods.communication)
        assert every * scenario.periods.communication == 1e-3
        readings.append(rows_of(scenario, np.linspace(30.0, 1.0, 1500)[:, None] * np.ones(LAYOUT.outputs)))
    assert readings[0].tobytes() == readings[1].tobytes() == readings[2].tobytes()


@pytest.mark.parametrize("times", [2, 4, 5])
def test_a_coarser_loop_reads_like_a_fine_one(times):
    """The truth is linear between the readings, so interpolation is exact apart from rounding.

    Noise is that of the reading instants: it is drawn each millisecond, also beyond a block of draws.
    """
    places = np.r_[LAYOUT.reading["wheelset_speed"], LAYOUT.reading["cylinder_pressure"]]
    noisy = np.r_[LAYOUT.reading["acceleration"], LAYOUT.reading["deflection"]]
    last, noises = [], []
    for scenario, step in ((service("1 ms"), 1), (service(f"{times} ms"), times)):
        time = step * np.arange(6000 // step)[:, None]
        truths = np.zeros((len(time), LAYOUT.outputs))
        truths[:, LAYOUT.output["wheelset_speed"]] = 40.0 - 0.005 * time
        truths[:, LAYOUT.output["cylinder_pressure"]] = 1e5 * (1.0 + 0.5e-3 * time)
        readings = rows_of(scenario, truths)
        last.append(pd.DataFrame(readings[:, places]).ffill().to_numpy())
        noises.append(readings[:, noisy])
    assert np.array_equal(noises[0][::times], noises[1])
    assert noises[1].std(axis=0).min() > 0.0
    assert last[1][1:] == pytest.approx(last[0][::times][1:], rel=1e-6, nan_ok=True)
    assert np.isfinite(last[1][20:]).all()


def test_a_pole_wheel_loses_teeth_at_the_same_time_with_any_communication_step():
    """From 1 s, when readings start to be uneven."""
    fault = {"part": "speed_sensor", "kind": "missing_teeth", "group": 1, "value": 2, "begin": "1 s"}
    for step in ("0.25 ms", "1 ms", "5 ms"):
        table = service(step).resolved() | {"faults": [fault]}
        scenario = scenario_of(table, directory=LIBRARY, origin="mine.toml")
        period = max(1e-3, scenario.periods.communication)
        truth = np.where(np.arange(LAYOUT.outputs) == LAYOUT.output["wheelset_speed"].start, 40.0, 0.0)
        speed = rows_of(scenario, [truth] * round(2.0 / period))[:, LAYOUT.reading["wheelset_speed"].start]
        odd = np.flatnonzero(np.abs(speed / 40.0 - 1.0) > 0.05) * period
        # A step of 5 ms includes newer pulses than most gaps, which occur once a revolution.
        assert 1.0 <= odd.min() < 1.0 + 3 * 2 * np.pi / 40.0


@pytest.mark.parametrize("step", ["2 ms", "4 ms", "5 ms"])
def test_a_coarser_loop_reads_the_radar_at_its_rate_and_latency(step):
    """50 ms, also where these are 12.5 steps; the true speed equals its time."""
    scenario = service(step, speed={"noise": 0.0, "scale_error": 0.0}, acceleration={"noise": 0.0, "bias": 0.0})
    period = scenario.periods.communication
    times = period * np.arange(500)
    truths = times[:, None] * (np.arange(LAYOUT.outputs) == LAYOUT.output["speed"].start)
    speed = rows_of(scenario, truths)[:, LAYOUT.reading["speed"].start]
    due = np.flatnonzero(np.isfinite(speed))
    assert speed[due] == pytest.approx(times[due] - 0.05, abs=1e-12)
    multiples = 0.05 * np.arange(1, 1 + due.size)
    assert times[due] == pytest.approx(period * np.ceil(multiples / period - 1e-9))


def driven(scenario, speed=20.0, seconds=40.0):
    """Return the readings of a train at constant speed [rows of LAYOUT]."""
    period = scenario.periods.communication
    truths = np.zeros((round(seconds / period), LAYOUT.outputs))
    truths[:, LAYOUT.output["distance"].start] = speed * period * np.arange(len(truths))
    truths[:, LAYOUT.output["speed"]] = speed
    return rows_of(scenario, truths)


def test_dropouts_and_drift_of_a_radar_are_those_of_the_table():
    """400 s are 8000 readings, a quarter of them lost in some 200 intervals of 0.5 s.

    A drift of 1 % decorrelates 200 times.
    """
    radar = {"noise": 0, "scale_error": 0, "drift": "1 %", "drift_time": "2 s"}
    radar |= {"dropouts": "25 %", "dropout_time": "0.5 s"}
    longer = merge(service("5 ms", speed=radar).resolved(), {"limits": {"horizon": "410 s"}})
    rows = driven(scenario_of(longer, directory=LIBRARY, origin="mine"), seconds=400.0)
    readings = rows[20::10, LAYOUT.reading["speed"].start]
    lost = np.isnan(readings)
    assert lost.mean() == pytest.approx(0.25, abs=0.06)
    lengths = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], lost, [0]]).astype(int))))[::2]
    assert lengths.mean() * 0.05 == pytest.approx(0.5, rel=0.3)
    error = readings / 20.0 - 1.0
    assert np.nanstd(error) == pytest.approx(0.01, rel=0.3)
    close = error[1:] - error[:-1]
    # For a Gauss-Markov process: 2 σ² (1 - exp(-Δ/T)).
    assert np.nanstd(close) == pytest.approx(0.01 * np.sqrt(2 * (1 - np.exp(-0.05 / 2.0))), rel=0.1)


def test_an_accelerometer_measures_the_gradients_of_the_track_and_an_unknown_one():
    sheet = {"acceleration": {"noise": 0, "bias": 0, "feels_gradient": True}}
    scenario = service("1 ms", **sheet)
    gradient = [{"begin": "100 m", "slope": 0.02}, {"begin": "300 m", "slope": 0}]
    track = {"gradient": gradient}
    changes = {"track": track, "truth": {"gradient": 0.01}}
    scenario = scenario_of(merge(scenario.resolved(), changes), directory=LIBRARY, origin="mine")
    read = driven(scenario, seconds=20.0)[:, LAYOUT.reading["acceleration"].start]
    g = 9.81
    assert read[[4000, 6000, 14000, 16000]] == pytest.approx([g * 0.01, g * 0.03, g * 0.03, g * 0.01], rel=1e-3)


def test_deflections_are_the_response_of_a_frame_to_the_rail():
    """At 20 m/s the variance is that of the spectrum times |H|² of the suspension.

    Each wheelset reads the same rail later, once the initial motion at the scenario's 80 km/h has decayed.
    """
    frequency, damping = 6.0, 0.2
    rail = {"track": "erri-low", "frequency": f"{frequency} Hz", "damping": damping}
    rows = driven(service("1 ms", deflection={"noise": 0, "irregularity": rail}), seconds=90.0)
    deflection = rows[:, LAYOUT.reading["deflection"]]
    f = RIDE.frequencies
    s, omega = 2j * np.pi * f * 20.0, 2 * np.pi * frequency
    passed = np.abs(s**2 / (s**2 + 2 * damping * omega * s + omega**2)) ** 2
    expected = np.sqrt(np.sum(spectrum("erri-low", "vertical", f) * passed) * RIDE.spacing)
    assert deflection[:, 0].std() == pytest.approx(expected, rel=0.1)
    later = round(1.9 / 20.0 / 1e-3)
    assert np.abs(deflection[later:, 1] - deflection[:-later, 0])[3000:].max() < 0.01 * expected
    assert np.abs(deflection[:100]).max() > 0.1 * expected  # the frames were in motion before


def test_a_quantity_that_the_plant_does_not_show_is_refused():
    scenario = scenario_with(noise={"pad_force": "100 N"})
    with pytest.raises(ScenarioError, match="names 'pad_force', which this plant does not show; its sensors read spee"):
        scenario.sensors.open(scenario, layout_of(TWO_PART_TRAIN), 0.4)
