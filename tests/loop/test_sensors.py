"""Service sensors compared with their data sheets."""

import numpy as np
import pytest
from kernel_calls import Encoder, along_track, read, service_sensors
from synthetic import LAYOUT

from railgrip.simulate.sensors.ideal import IdealSensors
from railgrip.simulate.sensors.white import WhiteSensors

PERIOD = 1e-3
STEP = 1e6 / 4096
OFFSET = np.array([1e3, -1e3, 2e3, 0.0])
PERFECT = {"acceleration": {"noise": 0.0}}


def biased_sensors():
    """Return service sensors with a bias of the accelerometer and offsets of the transducers."""
    return service_sensors({"acceleration_bias": 0.04, "offset_steps": OFFSET / STEP})


def truth(speed=20.0, wheel=52.0, acceleration=-0.8, pressure=2e5):
    values = np.zeros(LAYOUT.outputs)
    values[LAYOUT.output["speed"]] = speed
    values[LAYOUT.output["wheelset_speed"]] = wheel
    values[LAYOUT.output["acceleration"]] = acceleration
    values[LAYOUT.output["cylinder_pressure"]] = pressure
    return values


def encoder_readings(speed_of, seconds, **wheel):
    encoder = Encoder(wheel)
    samples = np.arange(round(seconds / PERIOD))
    true = np.array([speed_of(k * PERIOD) for k in samples])
    return samples * PERIOD, true, np.array([encoder.read(int(k), w) for k, w in zip(samples, true, strict=True)])


def test_white_sensors_err_by_gain_bias_and_noise_as_stated():
    """20 s of constant truth: means within four standard errors, deviations within 5 %."""
    size, speed = LAYOUT.readings, LAYOUT.reading["speed"].start
    deviation = np.zeros(size)
    deviation[speed] = 0.1
    sensors = WhiteSensors(
        IdealSensors(LAYOUT).places, np.full(size, 1.01), np.full(size, 0.5), deviation, np.random.default_rng(3)
    )
    readings = np.array([read(sensors, k, truth()) for k in range(20000)])
    assert readings[:, speed].mean() == pytest.approx(20 * 1.01 + 0.5, abs=4 * 0.1 / np.sqrt(20000))
    assert readings[:, speed].std() == pytest.approx(0.1, rel=0.05)
    assert np.all(readings[:, LAYOUT.reading["cylinder_pressure"]] == 2e5 * 1.01 + 0.5)


def test_a_perfect_encoder_is_as_accurate_as_its_clock():
    """One clock tick on each of two pulses at a distance of one pitch or more: ω·clock/gap.

    The speed drifts by less than 1e-3 of itself over a gap.
    """
    _, true, read = encoder_readings(lambda t: 50 - 2 * t, 5.0, pitch_error=0.0)
    there = ~np.isnan(read)
    there[:20] = False
    gap = 2 * np.pi / 100 / true[there]
    assert np.all(np.abs(read[there] - true[there]) < true[there] * (1e-6 / gap * 1.01) + 2 * (gap + PERIOD))


def test_tooth_errors_scatter_as_specified():
    """At one pulse per sample the relative error of a reading has the pitch error's deviation, here 0.3 %."""
    _, true, read = encoder_readings(lambda t: 2 * np.pi / 100 / 1.3e-3, 5.0, clock=1e-9)
    error = (read / true - 1)[~np.isnan(read)][10:]
    # Readings repeat each revolution, so there are 100 independent ones: 15 % is two deviations of their scatter.
    assert np.std(error) == pytest.approx(0.003, rel=0.2)
    assert abs(error.mean()) < 1e-4


def test_slow_wheels_read_rarely_and_stationary_ones_zero():
    """At 2 rad/s a pitch takes 31 ms; below the cut-off of 0.3 m/s, 0.8 rad/s, it reads zero."""
    _, _, read = encoder_readings(lambda t: 2.0, 2.0)
    gaps = np.diff(np.flatnonzero(~np.isnan(read)))
    assert 30 <= np.median(gaps) <= 33
    _, _, stopped = encoder_readings(lambda t: 20.0 if t < 1 else 0.0, 2.0)
    assert stopped[-1] == 0.0
    assert not (stopped[1200:] > 0).any()


def test_a_wheel_that_turns_again_is_read_again():
    time, true, read = encoder_readings(lambda t: 0.0 if 1 < t < 2 else 20.0, 3.0, pitch_error=0.0)
    late = (time > 2.1) & ~np.isnan(read)
    assert np.allclose(read[late], true[late], rtol=1e-3)


def test_noises_and_biases_are_those_of_the_data_sheet():
    """20 s of constant truth: means within four standard errors, deviations within 10 %."""
    sensors = biased_sensors()
    readings = np.array([read(sensors, k, truth()) for k in range(20000)])
    speed = readings[:, 0][~np.isnan(readings[:, 0])]
    assert len(speed) == pytest.approx(20000 / 50, abs=2)
    # Late by 50 ms and extrapolated with the (biased) acceleration over 50 ms.
    assert speed.mean() == pytest.approx(20 * 1.002 + (-0.8 + 0.04) * 0.05, abs=4 * 0.1 / np.sqrt(len(speed)))
    assert speed.std() == pytest.approx(0.1, rel=0.1)
    acceleration = readings[:, LAYOUT.reading["acceleration"].start]
    assert acceleration.mean() == pytest.approx(-0.76, abs=4 * 0.03 / np.sqrt(20000))
    assert acceleration.std() == pytest.approx(0.03, rel=0.05)
    deflection = readings[:, LAYOUT.reading["deflection"]]
    assert deflection.std(axis=0) == pytest.approx([2e-4] * 6, rel=0.05)
    pressure = readings[-1, LAYOUT.reading["cylinder_pressure"]]
    assert np.abs(pressure - (2e5 + OFFSET)).max() <= 0.5 * STEP


def test_a_pressure_step_arrives_with_the_transducers_lag():
    """63 % after the time constant, within one sample."""
    sensors = service_sensors(pressure={"bits": 20})
    read(sensors, 0, truth(pressure=0.0))
    seen = [read(sensors, k, truth(pressure=1e5))[LAYOUT.reading["cylinder_pressure"]][0] for k in range(1, 40)]
    reached = int(np.argmax(np.array(seen) >= 1e5 * (1 - np.exp(-1)))) + 1
    assert reached == pytest.approx(10, abs=1)


def test_a_lost_reading_is_nan_and_factors_continue_in_turn():
    """Readings every 50 ms are 1.01, NaN, 0.99 of the speed, and so on; the first one is due after the latency."""
    factors = np.array([1.01, np.nan, 0.99])
    sensors = service_sensors({"speed_factor": factors, "speed_factors": 3}, speed={"noise": 0.0}, **PERFECT)
    readings = [read(sensors, k, truth(acceleration=0.0))[LAYOUT.reading["speed"]][0] for k in range(301)]
    assert readings[::50] == pytest.approx([np.nan, np.nan, 19.8, 20.2, np.nan, 19.8, 20.2], nan_ok=True)


def test_an_accelerometer_measures_the_slope_under_it():
    """A gravity component rising from 0 at 10 m to 0.1 m/s² at 20 m, and constant before and beyond."""
    sensors = service_sensors({"gravity": along_track(10.0, 5.0, [0.0, 0.05, 0.1])}, **PERFECT)
    ramp = {0.0: 0.0, 10.0: 0.0, 12.5: 0.025, 16.0: 0.06, 20.0: 0.1, 99.0: 0.1}
    for k, (distance, felt) in enumerate(ramp.items()):
        at = truth()
        at[LAYOUT.output["distance"]] = distance
        acceleration = read(sensors, k, at)[LAYOUT.reading["acceleration"].start]
        assert acceleration == pytest.approx(-0.8 + felt, abs=1e-12)
