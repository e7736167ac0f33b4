"""The readings of a faulty sensor and the effect of a faulty brake, sample by sample."""

import numpy as np
import pytest
from kernel_calls import Encoder, show, transmit
from synthetic import LAYOUT
from test_sensors import encoder_readings

from railgrip.fmus.native.discrete import memory_image
from railgrip.simulate.faults.site import FREE, Faults

SPEED = LAYOUT.reading["speed"].start


def readings_of(course, *, valves=True, noise_rate=1, **fault):
    """Readings of the train speed with one fault between samples 3 and 6; -1 for none."""
    values = {"place": SPEED, "begin": 3, "end": 6} | fault
    faults = Faults(LAYOUT, valves=valves, noise_rate=noise_rate)
    faults.add_reading(**values)
    readings = []
    for k, speed in enumerate(course):
        reading = np.arange(LAYOUT.readings, dtype=float)
        reading[SPEED] = np.nan if speed == -1 else speed
        result = show(faults, k, reading)
        assert np.delete(result, SPEED).tolist() == np.delete(reading, SPEED).tolist()
        readings.append(result[SPEED])
    return [-1 if np.isnan(reading) else reading for reading in readings]


UP_AND_DOWN = np.array([1.0, -1.0])
COURSE = [20, 19, 18, 17, 16, 15, 14, 13]


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ({"kind": "dead"}, [20, 19, 18, -1, -1, -1, 14, 13]),
        ({"kind": "stuck"}, [20, 19, 18, 18, 18, 18, 14, 13]),
        ({"kind": "scaled", "value": 2.0}, [20, 19, 18, 34, 32, 30, 14, 13]),
        ({"kind": "biased", "value": -0.5}, [20, 19, 18, 16.5, 15.5, 14.5, 14, 13]),
        ({"kind": "noisy", "value": 2.0, "noise": UP_AND_DOWN}, [20, 19, 18, 19, 14, 17, 14, 13]),
        ({"kind": "noisy", "value": 2.0, "noise": UP_AND_DOWN, "noise_rate": 2}, [20, 19, 18, 19, 18, 13, 14, 13]),
    ],
    ids=lambda value: value["kind"] if isinstance(value, dict) else "",
)  # fmt: skip
def test_each_fault_has_its_effect_and_ends(fault, expected):
    assert readings_of(COURSE, **fault) == expected


@pytest.mark.parametrize("kind", ["dead", "stuck"])
def test_a_sensor_faulty_from_the_start_repeats_its_first_reading(kind):
    """Nothing was read before sample 1, so that reading is the one that the fault holds."""
    after = -1 if kind == "dead" else 19
    assert readings_of([-1, 19, 18, -1, 16], kind=kind, begin=0, end=99) == [-1, 19, after, -1, after]


def test_faults_of_one_sensor_act_in_their_order():
    results = []
    for kinds in (("scaled", "biased"), ("biased", "scaled")):
        faults = Faults(LAYOUT, valves=True, noise_rate=1)
        for kind in kinds:
            faults.add_reading(kind, SPEED, begin=0, end=9, value=2.0)
        results.append(show(faults, 0, np.full(LAYOUT.readings, 10.0))[SPEED])
    assert results == [22.0, 24.0]


def passed(commands, *, valves, inside=(0.0,) * 20, air=(0.0,) * 20, **fault):
    """Commands that arrive at group 2 with one fault between samples 2 and 5."""
    values = {"group": 1, "begin": 2, "end": 5} | fault
    faults = Faults(LAYOUT, valves=valves, noise_rate=1)
    faults.add_command(**values)
    arrived = []
    for k, command in enumerate(commands):
        truth = np.zeros(LAYOUT.outputs)
        truth[LAYOUT.output["cylinder_pressure"]] = inside[k]
        truth[LAYOUT.output["air_used"]] = air[k]
        result = transmit(faults, k, truth, (7.0, command, 8.0, 9.0))
        assert result[[0, 2, 3]].tolist() == [7.0, 8.0, 9.0]
        arrived.append(float(result[1]))
    return arrived


def test_a_valve_is_fixed_held_or_late():
    course = [1, 2, 3, 4, 5, 6]
    assert passed(course, valves=False, kind="fixed", value=-1.0) == [1, 2, -1, -1, -1, 6]
    assert passed(course, valves=False, kind="kept") == [1, 2, 2, 2, 2, 6]
    # Faulty from the start, it holds the first command.
    assert passed(course, valves=False, kind="kept", begin=0) == [1, 1, 1, 1, 1, 6]
    assert passed(course, valves=False, kind="late", delay=2) == [1, 2, 1, 2, 3, 6]
    assert passed(course, valves=False, kind="late", delay=0) == course


def test_a_reservoir_empties_by_the_air_that_it_supplies():
    """p = p0 - p_free ΔV/V: for 10 l at 2 bar, a litre of free air lowers it by 0.101 bar; earlier consumption counts.

    A check valve keeps the pressure in the cylinder, so that a command is never limited below it.
    """
    air = [0.5, 0.5, 0.5, 0.501, 0.510, 0.6]
    common = dict(kind="limited", value=0.01, pressure=2e5, air=air)
    limits = [3e5, 3e5, 2e5, 2e5 - 0.1 * FREE, 2e5 - FREE, 3e5]
    assert passed([3e5] * 6, valves=False, **common) == pytest.approx(limits)
    assert passed([3e5] * 6, valves=False, begin=0, **common) == pytest.approx([2e5, 2e5, *limits[2:]])
    assert passed([5e4] * 6, valves=False, **common) == [5e4] * 6
    inside = [1.5e5] * 6
    assert passed([3e5] * 6, valves=False, inside=inside, **common)[4] == 1.5e5
    assert passed([1.0] * 6, valves=True, inside=inside, **common) == [1, 1, 1, 1, 0, 1]
    assert passed([-1.0] * 6, valves=True, inside=inside, **common) == [-1.0] * 6


def test_a_compressor_refills_a_reservoir_until_it_is_full():
    """Half a litre of free air per sample raises 10 l by 0.051 bar; a full reservoir is not refilled."""
    air = [0.5, 0.5, 0.5, 0.501, 0.510, 0.6]
    common = dict(kind="limited", value=0.01, pressure=2e5, air=air, valves=False)
    limits = [3e5, 3e5, 2e5, 2e5 - 0.05 * FREE, 2e5 - 0.9 * FREE, 3e5]
    assert passed([3e5] * 6, refill=5e-4, **common) == pytest.approx(limits)
    assert passed([3e5] * 6, refill=1.0, **common)[2:5] == [2e5] * 3


@pytest.mark.parametrize("missing", [1, 2, 7])
def test_a_gap_in_a_pole_wheel_reads_slow_once_a_revolution(missing):
    """Over a gap of m teeth one pulse takes m + 1 pitches: the reading is ω/(m + 1), once per revolution; elsewhere ω.

    A pitch lasts 1.3 samples, so that each pulse gives a new reading.
    """
    speed = 2 * np.pi / 100 / 1.3e-3
    encoder = Encoder({"pitch_error": 0.0, "clock": 1e-9}, missing=missing, end=10**9)
    read = np.array([encoder.read(k, speed) for k in range(2600)])  # twenty revolutions
    read = read[~np.isnan(read)][5:]
    slow = np.isclose(read, speed / (missing + 1), rtol=1e-5)
    assert np.isclose(read[~slow], speed, rtol=1e-5).all()
    assert slow.sum() in (19, 20)


def test_a_pole_wheel_without_a_gap_reads_the_same():
    encoder = Encoder(missing=3, begin=10**6, end=10**9)
    _, true, plain = encoder_readings(lambda t: 50 - 2 * t, 2.0)
    assert np.array_equal([encoder.read(k, w) for k, w in enumerate(true)], plain, equal_nan=True)


def test_the_memory_of_faults_can_be_moved_with_its_rings():
    """In a browser the loop has its memory at other addresses, so every pointer in it must be a link of the image."""
    faults = Faults(LAYOUT, valves=True, noise_rate=1)
    faults.add_reading("noisy", SPEED, begin=0, end=9, value=1.0, noise=UP_AND_DOWN)
    for group in (0, 1):
        faults.add_command("late", group, begin=0, end=9, delay=group)
    image = memory_image(faults.struct)
    arrays_and_their_rings = 2 + 3
    assert len(image.links) == arrays_and_their_rings
    ends = sorted(int(target) for _, target in image.links)
    assert ends[-1] < 8 * image.words.size
    assert not image.words[image.links[:, 0]].any()
