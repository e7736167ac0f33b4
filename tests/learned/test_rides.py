"""A trained estimator during a ride of the car: sample by sample in CasADi, as FMU, and over all readings at once."""

from zipfile import ZipFile

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from test_learned_online import network

from railgrip.base.errors import EstimatorError, FmuError, ScenarioError
from railgrip.estimation.axle_box.instrumented_car import (
    RATE,
    Pass,
    Ride,
    held_speed,
    in_axes_of_car,
    measure_run,
    ride,
)
from railgrip.estimation.axle_box.ride import (
    INPUTS,
    LIBRARY,
    belief_of,
    bind_estimator,
    outputs_of,
    outputs_of_fmu,
    read_ride,
    ride_with_estimator,
)
from railgrip.estimators.learned.network import Ensemble
from railgrip.estimators.learned.preprocessing import AntiAlias, Chain, Scale, Spectral
from railgrip.estimators.learned.trained import GeneralEstimator, PaperEstimator, load, save
from railgrip.fmi import describe
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack

ROUNDING = 1e-11
"""Friction, absolute.

Offsets of 270 m/s² are rounded at 6e-14 in double precision; some ten thousand recursive steps and a network of slope
about 1 add two orders; additions in another order differed by 3e-14.
"""

# The comparisons do not depend on the length; the filters here settle in 0.2 s.
RIDE = Pass(
    name="short", speed=26.8, condition="wet", friction=0.2, track="erri-low", track_seed=1, seed=1, length=12.0,
    backwards=True,
)  # fmt: skip


@pytest.fixture(scope="module")
def estimators():
    """Both kinds with the exported structure and random weights."""
    draw = np.random.default_rng(8)
    general = GeneralEstimator(
        slow=AntiAlias(rate=RATE, keep=40),
        spectral=Spectral(rate=128.0, metres=5.0, settling=0.1),
        ensemble=Ensemble(
            centre=np.zeros(51), spread=np.full(51, 3.0), networks=tuple(network(draw, 51, 4) for _ in range(4)),
            second=tuple(network(draw, 1, 3) for _ in range(3)), half_width=1.7,
        ),
    )  # fmt: skip
    paper = PaperEstimator(
        chain=Chain(rate=RATE, block=50), scale=Scale(lowest=np.zeros(4), highest=np.ones(4)),
        networks=(network(draw, 4),), inputs="longitudinal",
    )  # fmt: skip
    return {"general": general, "paper": paper}


@pytest.fixture(scope="module")
def files(estimators, tmp_path_factory):
    folder = tmp_path_factory.mktemp("exported")
    return {name: pack(sources(one.online()), folder / f"{name}.fmu") for name, one in estimators.items()}


@pytest.fixture(scope="module")
def samples():
    readings = measure_run(RIDE, ride(RIDE, rate=RATE), RATE, held_speed(RIDE))
    direction = np.full(len(readings.speed), -1.0)
    return dict(zip(INPUTS, (*readings.boxes.T, readings.speed, direction), strict=True))


@pytest.mark.parametrize("kind", ["general", "paper"])
def test_the_exported_fmu_equals_the_estimator(kind, files, estimators, samples):
    """The same operations in the same order, so only the C compiler's fused or reordered operations differ."""
    beliefs = belief_of(outputs_of(estimators[kind], samples))
    assert validate_fmu(str(files[kind])) == []
    friction, deviation = belief_of(outputs_of_fmu(*bind_estimator(files[kind]), RATE, samples))
    np.testing.assert_allclose(friction, beliefs[0], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(deviation, beliefs[1], rtol=1e-9)


def test_the_fmu_runs_at_the_loggers_rate_and_refuses_another(files):
    for file in files.values():
        assert describe(file).variables["lateral[4]"].causality == "input"
        with ZipFile(file) as parts:
            description = parts.read("modelDescription.xml").decode()
        assert "accelerations of the axle boxes, 5120 a second" in description
        assert f'stepSize="{1 / 5120!r}"' in description
    with pytest.raises(Exception, match="whole number of periods"):
        outputs_of_fmu(*bind_estimator(files["paper"]), 3 * RATE // 2, still())


def still(count=1):
    return {name: np.zeros(count) for name in INPUTS}


def test_the_last_known_estimate_is_held_with_its_interval():
    """An FMU may have no estimate for some time. The shorter half of an interval is limited by 0."""
    outputs = {"known": np.array([0, 1, 0, 1.0]), "friction": np.array([9, 0.2, 9, 0.3])}
    friction, deviation = belief_of(outputs)
    np.testing.assert_array_equal(friction, [np.nan, 0.2, 0.2, 0.3])
    np.testing.assert_array_equal(deviation, [np.inf, np.nan, np.nan, np.nan])
    interval = {"lower": np.array([9, 0.0, 9, 0.1]), "upper": np.array([9, 0.5, 9, 0.4])}
    np.testing.assert_allclose(1.6449 * belief_of(outputs | interval)[1], [np.inf, 0.3, 0.3, 0.2])


def test_running_backwards_is_a_rotation_by_half_a_turn():
    """The same motion in axes of a rotated car: wheelset 1 is last, left is right, forwards is backwards."""
    boxes = np.arange(1.0, 9.0).reshape(1, 4, 2)
    motion = Ride(
        longitudinal=boxes, lateral=boxes[..., 0], speed=np.full(1, 26.8), friction=boxes[..., 0],
        offset=boxes[..., 0], creep=boxes[..., 0], slip_acceleration=boxes[..., 0],
    )  # fmt: skip
    behind = in_axes_of_car(motion)
    assert behind.longitudinal.tolist() == [[[-8.0, -7.0], [-6.0, -5.0], [-4.0, -3.0], [-2.0, -1.0]]]
    for signal in (behind.lateral, behind.slip_acceleration, behind.offset):
        assert signal.tolist() == [[-7.0, -5.0, -3.0, -1.0]]
    assert behind.friction.tolist() == behind.creep.tolist() == [[7.0, 5.0, 3.0, 1.0]]
    assert behind.speed.tolist() == [26.8]


@pytest.mark.parametrize("kind", ["general", "paper"])
def test_a_saved_estimator_is_read_back(kind, estimators, tmp_path):
    back = load(save(estimators[kind], tmp_path / "one.json"))
    draw = np.random.default_rng(4)
    boxes, speed = 270 + draw.standard_normal((3000, 12)), np.full(3000, 20.0)
    one, two = (e.offline(boxes, speed, backwards=False) for e in (estimators[kind], back))
    assert len(one.friction) >= 49
    assert np.array_equal(one.friction, two.friction)
    assert np.array_equal(one.upper, two.upper, equal_nan=True)


@pytest.mark.parametrize("kind", ["general", "paper"])
def test_an_estimator_is_the_same_online_and_offline_during_a_ride(kind, estimators, tmp_path):
    save(estimators[kind], tmp_path / "mine.json")
    trace, apart = ride_with_estimator(read_ride(written(tmp_path, length=12.0)), tmp_path)
    assert apart < ROUNDING
    assert trace.sizes["time"] == pytest.approx(12.0 / 26.82 * RATE, rel=0.05)  # the car keeps approximately that speed
    friction = trace["friction"].values
    known = friction[np.isfinite(friction)]
    assert np.unique(known).size >= 30
    assert np.ptp(known) > 1e-5  # six orders above the tolerance
    assert np.isnan(friction[0])


@pytest.mark.parametrize("trusted", [False, True])
def test_an_fmu_runs_in_a_separate_process_unless_it_is_trusted(trusted, files):
    sentences = []
    outputs_of_fmu(*bind_estimator(files["paper"]), RATE, still(), trusted=trusted, notify=sentences.append)
    assert ["runs in a separate process" in sentence for sentence in sentences] == [True] * (not trusted)
    assert all("trust = true under [estimator]" in sentence for sentence in sentences)


def written(folder, *, kind="learned", file="mine.json", condition="wet", length=30.0):
    path = folder / "ride.toml"
    path.write_text(
        f'name = "mine"\n[car]\nspeed = "60 mph"\ncondition = "{condition}"\nfriction = 0.2\ntrack = "erri-low"\n'
        f'track_seed = 1\nseed = 1\nlength = {length}\n[estimator]\nkind = "{kind}"\nfile = "{file}"\n'
    )
    return path


def test_the_ride_of_the_library_is_valid():
    assert read_ride(LIBRARY / "wet_60mph.toml").run().speed == pytest.approx(26.82, abs=0.01)


def test_invalid_rides_and_estimators_are_refused(tmp_path, files):
    with pytest.raises(ScenarioError, match=r"\[car\] condition is 'oil'; there is dry"):
        read_ride(written(tmp_path, condition="oil"))
    with pytest.raises(EstimatorError, match="there is no such file; correct the path; `make learn` writes"):
        ride_with_estimator(read_ride(written(tmp_path, file="gone.json")), tmp_path)
    (tmp_path / "other.json").write_text('{"kind": "paper", "format": 1}')
    with pytest.raises(EstimatorError, match="damaged trained estimator"):
        load(tmp_path / "other.json")
    (tmp_path / "none.json").write_text("[]")
    with pytest.raises(EstimatorError, match="is not a trained estimator of format 1"):
        load(tmp_path / "none.json")
    with pytest.raises(FmuError, match="there is no such file"):
        ride_with_estimator(read_ride(written(tmp_path, kind="fmu", file="gone.fmu")), tmp_path)
