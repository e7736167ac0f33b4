"""A trained estimator beside the car's FMU, through the protocols of the loop: in CasADi, as FMU, and all at once."""

from dataclasses import replace
from zipfile import ZipFile

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from railgrip.errors import EstimatorError, FmuError, ScenarioError
from railgrip.estimators.learned.antialias import AntiAlias
from railgrip.estimators.learned.ensemble import Ensemble
from railgrip.estimators.learned.network import Network
from railgrip.estimators.learned.preprocessing import Chain, Scale
from railgrip.estimators.learned.spectral import Spectral
from railgrip.estimators.learned.trained import GeneralEstimator, PaperEstimator, load, save
from railgrip.fmu import describe
from railgrip.fmus.native.package import pack
from railgrip.loop import ports
from railgrip.loop.beside import watch
from railgrip.studies.axle_box.accelerometer import AXLE_BOX, RATE, SampleBySample, disturbance, measure
from railgrip.studies.axle_box.export import as_fmu
from railgrip.studies.axle_box.instrumented_car import Pass, car_of
from railgrip.studies.axle_box.parties import READINGS, AxleBoxes, in_casadi, in_fmu
from railgrip.studies.axle_box.ride import LIBRARY, difference, read_ride, ride_beside, said_of

ROUNDING = 1e-11
"""Friction, absolute. Offsets of 270 m/s² in doubles are rounded at 6e-14; some ten thousand recursive steps and a
network of slope about 1 leave two orders above that, and another order of additions shows no more (3e-14 measured)."""

# Twelve metres of rail: what is compared does not depend on how far the car goes, and filters settle in 0.2 s here.
RIDE = Pass(
    name="short", speed=26.8, condition="wet", friction=0.2, track="erri-low", track_seed=1, seed=1, length=12.0,
    backwards=True,
)  # fmt: skip


def network(draw, inputs, hidden):
    return Network(
        hidden_weights=draw.standard_normal((hidden, inputs)) / inputs**0.5, hidden_bias=draw.standard_normal(hidden),
        output_weights=draw.standard_normal(hidden), output_bias=-1.0, bias="inside",
    )  # fmt: skip


@pytest.fixture(scope="module")
def estimators():
    """Both kinds, of the exported structure; what their weights are does not matter here."""
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
        networks=(network(draw, 4, 6),), inputs="longitudinal",
    )  # fmt: skip
    return {"general": general, "paper": paper}


@pytest.fixture(scope="module")
def files(estimators, tmp_path_factory):
    folder = tmp_path_factory.mktemp("exported")
    return {name: pack(as_fmu(one.online()), folder / f"{name}.fmu") for name, one in estimators.items()}


def beside(estimator, run=RIDE):
    with car_of(run, rate=RATE) as (car, inputs, skipped):
        sensors = AxleBoxes(run, len(inputs) - skipped)
        parties = ((car, ports.Plant), (sensors, ports.Sensors), (estimator, ports.Estimator))
        assert all(isinstance(party, protocol) for party, protocol in parties)
        return watch(
            plant=car, inputs=inputs, sensors=sensors, estimator=estimator,
            estimator_inputs=np.array([-1.0 if run.backwards else 1.0]), lead_in=skipped,
        )  # fmt: skip


def said_by(estimator, readings, direction=1.0):
    """Mean and variance after every reading."""
    estimator.inputs[:] = direction
    for reading in readings:
        estimator.readings[:] = reading
        estimator.advance()
        yield estimator.mean[0], estimator.covariance[0, 0]


@pytest.fixture(scope="module")
def rides(estimators):
    return {name: beside(in_casadi(one.online())) for name, one in estimators.items()}


@pytest.mark.parametrize("kind", ["general", "paper"])
def test_the_loop_says_sample_by_sample_what_is_said_of_the_record_at_once(kind, estimators, rides):
    ride = rides[kind]
    answer = said_of(estimators[kind], ride, RIDE)
    assert len(answer.sample) >= 30
    assert np.ptp(answer.friction) > 1e-5  # there is something to be equal in, six orders above the tolerance
    assert difference(ride, answer) < ROUNDING
    assert np.isnan(ride.mean[: answer.sample[0]]).all()
    between = ride.mean[answer.sample[0] : answer.sample[-1], 0].reshape(len(answer.sample) - 1, -1)
    assert np.array_equal(between, np.repeat(between[:, :1], between.shape[1], axis=1))  # held from one to the next


def test_the_interval_of_the_loop_is_that_of_the_record(estimators, rides):
    answer = said_of(estimators["general"], rides["general"], RIDE)
    half = 1.6449 * np.sqrt(rides["general"].variance[answer.sample, 0])
    longer = np.maximum(answer.upper - answer.friction, answer.friction - answer.lower)
    assert half == pytest.approx(longer, abs=ROUNDING)
    assert np.isnan(rides["paper"].variance[-1, 0])  # the paper's network gives none


@pytest.mark.parametrize("kind", ["general", "paper"])
def test_the_exported_fmu_is_the_same_party(kind, estimators, files, rides):
    """Through railgrip.fmu, 5120 samples a second; same operations in the same order, so nothing but rounding of the C
    compiler's own (fused or reordered operations) may differ."""
    assert validate_fmu(str(files[kind])) == []
    ride = rides[kind]
    with in_fmu(files[kind], RATE) as estimator:
        made = list(said_by(estimator, ride.reading, direction=-1.0))
    mean, variance = np.array(made).T
    np.testing.assert_allclose(mean, ride.mean[:, 0], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(variance, ride.variance[:, 0], rtol=1e-9)


def test_the_fmu_runs_at_the_loggers_rate_and_refuses_another(files):
    for file in files.values():
        assert describe(file).variables["lateral[4]"].causality == "input"
        with ZipFile(file) as parts:
            description = parts.read("modelDescription.xml").decode()
        assert "accelerations of the axle boxes, 5120 a second" in description
        assert f'stepSize="{1 / 5120!r}"' in description
    with (
        in_fmu(files["paper"], 3 * RATE // 2) as estimator,
        pytest.raises(Exception, match="whole number of periods"),
    ):
        list(said_by(estimator, np.zeros((1, len(READINGS)))))


def test_a_sample_that_is_missing_is_held(estimators):
    """NaN brings nothing new: the same as the last reading once more."""
    draw = np.random.default_rng(2)
    readings = 270 + draw.standard_normal((300, len(READINGS)))
    holes = readings.copy()
    holes[5:, 3] = np.nan
    readings[5:, 3] = readings[4, 3]
    answers = []
    for entry in (readings, holes):
        answers.append(list(said_by(in_casadi(estimators["paper"].online()), entry)))
    assert answers[0][-1][0] == answers[1][-1][0] > 0


def test_sensors_sample_by_sample_are_those_of_the_records():
    """To rounding of a recursive filter on numbers of 270."""
    draw = np.random.default_rng(3)
    true = draw.standard_normal((2000, 3))
    whole = measure(true, RATE, 20.0, AXLE_BOX, np.random.default_rng(1), np.random.default_rng(2))
    noise_of_run = disturbance(2000, 3, 20.0, AXLE_BOX, np.random.default_rng(1), np.random.default_rng(2))
    one = SampleBySample(AXLE_BOX, noise_of_run)
    np.testing.assert_allclose([one.read(k, row) for k, row in enumerate(true)], whole, rtol=0, atol=1e-10)


def test_backwards_is_half_a_turn():
    """The same truth in axes that point forwards, seen by a turned car: wheelset 1 is last, left is right."""
    truth = np.concatenate([np.arange(12.0), np.zeros(8), [26.8]])
    ahead, behind = (AxleBoxes(replace(RIDE, backwards=b), 10).read(0, truth) for b in (False, True))
    change_ahead = ahead - AxleBoxes(replace(RIDE, backwards=False), 10).read(0, 0 * truth)
    change_behind = behind - AxleBoxes(RIDE, 10).read(0, 0 * truth)
    # Gains differ by a per cent from sensor to sensor.
    assert change_behind[:4] == pytest.approx(-change_ahead[4:8][::-1], rel=0.1, abs=0.2)
    assert change_behind[8:12] == pytest.approx(-change_ahead[8:12][::-1], rel=0.1, abs=0.2)


@pytest.mark.parametrize("kind", ["general", "paper"])
def test_what_is_saved_comes_back(kind, estimators, tmp_path):
    back = load(save(estimators[kind], tmp_path / "one.json"))
    draw = np.random.default_rng(4)
    boxes, speed = 270 + draw.standard_normal((3000, 12)), np.full(3000, 20.0)
    one, two = (e.offline(boxes, speed, backwards=False) for e in (estimators[kind], back))
    assert len(one.friction) > 0
    assert np.array_equal(one.friction, two.friction)
    assert np.array_equal(one.upper, two.upper, equal_nan=True)


def test_a_ride_is_named_by_a_file(estimators, tmp_path):
    """A spec names car and estimator; the loop runs it and says how far it is from the record at once."""
    save(estimators["paper"], tmp_path / "mine.json")
    table = read_ride(written(tmp_path, file="mine.json", length=3.0))
    ride = ride_beside(table, tmp_path)
    assert ride.apart is not None
    assert ride.apart < ROUNDING
    assert ride.trace.sizes["time"] == pytest.approx(3.0 / 26.82 * RATE, rel=0.05)  # the held speed is near that
    assert float(ride.trace["friction"][-1]) > 0


@pytest.mark.parametrize("trusted", [False, True])
def test_an_fmu_rides_in_a_process_of_its_own_unless_it_is_trusted(trusted, files):
    sentences = []
    with in_fmu(files["paper"], RATE, trusted=trusted, tell=sentences.append) as estimator:
        estimator.readings[:] = 0.0
        estimator.advance()
    assert ["runs in a process of its own" in sentence for sentence in sentences] == [True] * (not trusted)
    assert all("trust = true under [estimator]" in sentence for sentence in sentences)


def written(folder, *, kind="learned", file="mine.json", condition="wet", length=30.0):
    path = folder / "ride.toml"
    path.write_text(
        f'name = "mine"\n[car]\nspeed = "60 mph"\ncondition = "{condition}"\nfriction = 0.2\ntrack = "erri-low"\n'
        f'track_seed = 1\nseed = 1\nlength = {length}\n[estimator]\nkind = "{kind}"\nfile = "{file}"\n'
    )
    return path


def test_the_library_ride_reads():
    assert read_ride(LIBRARY / "wet_60mph.toml").run().speed == pytest.approx(26.82, abs=0.01)


def test_what_cannot_ride_is_answered(tmp_path, files):
    with pytest.raises(ScenarioError, match=r"\[car\] condition is 'oil'; there is dry"):
        read_ride(written(tmp_path, condition="oil"))
    with pytest.raises(EstimatorError, match="there is no such file; `make learn` writes"):
        ride_beside(read_ride(written(tmp_path, file="gone.json")), tmp_path)
    (tmp_path / "other.json").write_text('{"kind": "paper", "format": 1}')
    with pytest.raises(EstimatorError, match="damaged trained estimator"):
        load(tmp_path / "other.json")
    (tmp_path / "none.json").write_text("[]")
    with pytest.raises(EstimatorError, match="is no trained estimator of format 1"):
        load(tmp_path / "none.json")
    with pytest.raises(FmuError, match="there is no such file"), in_fmu(tmp_path / "gone.fmu", RATE):
        pass
