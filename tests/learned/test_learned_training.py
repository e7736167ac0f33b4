"""Filters, networks and evaluations, independent of data."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime, least_squares

from railgrip.base.errors import EstimatorError
from railgrip.estimation.axle_box.evaluate import TrainingRecipe, exchange_labels
from railgrip.estimation.axle_box.instrumented_car import CHANNELS, OTHER_CHAINS, RATE, LabelledRun, Readings, reduce
from railgrip.estimators.learned import network as nn
from railgrip.estimators.learned.network import fit
from railgrip.estimators.learned.preprocessing import BLOCKS, COMBINATIONS, Chain, Scale, Spectral, motions


def test_the_high_pass_keeps_the_offset_of_the_first_sample():
    """Time constant 1/(2π 1e-4 Hz) = 1592 s: during a run it mainly subtracts the first sample."""
    chain = Chain(rate=512, block=8)
    raw = np.full((512 * 20, 1), 270.0)
    raw[0] = 268.5  # vibration at the first sample
    first = chain.filter(raw)[-1, 0]
    assert first == pytest.approx(1.5 * np.exp(-20 * 2 * np.pi * 1e-4), rel=1e-3)


def test_the_low_pass_is_half_power_at_1_hz():
    chain = Chain(rate=512, block=8)
    time = np.arange(0, 40, 1 / 512)
    for frequency, gain in ((0.1, 1.0), (1.0, np.sqrt(0.5)), (10.0, 0.01)):
        out = chain.filter(np.sin(2 * np.pi * frequency * time)[:, None])[512 * 20 :, 0]
        assert np.ptp(out) / 2 == pytest.approx(gain, rel=0.02)


def test_blocks_give_the_papers_rates():
    assert {mph: 5120 / block for mph, block in BLOCKS.items()} == pytest.approx(
        {60: 102.4, 40: 51.2, 26: 34.13, 16: 25.6}, rel=1e-3
    )
    raw = np.random.default_rng(0).standard_normal((1007, 4))
    assert Chain(rate=5120, block=50).process(raw).shape == (20, 4)


def test_the_eight_combinations_have_the_papers_sizes():
    one = np.ones((12, 3))
    sizes = [len(motions(one, name)) for name in COMBINATIONS]
    assert sizes == [12, 8, 8, 8, 8, 4, 4, 4]


def test_scaling_ends_at_plus_and_minus_one():
    data = np.random.default_rng(0).uniform(3, 9, (50, 4))
    values = Scale.over(data)(data)
    assert values.min(axis=0) == pytest.approx(-np.ones(4))
    assert values.max(axis=0) == pytest.approx(np.ones(4))


@pytest.mark.parametrize("bias", ["inside", "outside"])
def test_the_network_of_the_paper_has_37_parameters_and_a_correct_jacobian(bias):
    draw = np.random.default_rng(1)
    x = draw.uniform(-1, 1, (5, 4))
    p = draw.standard_normal(37)
    own = nn._jacobian(p, x, 6, bias)
    for k in range(5):
        numeric = approx_fprime(p, lambda q, k=k: nn._unpack(q, 4, 6, bias)(x)[k], 1e-7)
        assert own[k] == pytest.approx(numeric, abs=1e-6)  # forward differences of step 1e-7
    assert nn._unpack(p, 4, 6, bias).size == 37


def test_training_finds_the_same_minimum_as_minpack():
    draw = np.random.default_rng(2)
    target = draw.standard_normal(3)

    def residuals(p):
        return np.array([10 * (p[1] - p[0] ** 2), 1 - p[0], p[2] - target[2]])

    def jacobian(p):
        return np.array([[-20 * p[0], 10, 0], [-1, 0, 0], [0, 0, 1.0]])

    start = np.array([-1.2, 1.0, 0.0])
    result = nn.levenberg_marquardt(residuals, jacobian, start, 200)
    assert result == pytest.approx(least_squares(residuals, start, jac=jacobian, method="lm").x, abs=1e-6)


def run(name, friction, blocks, generator, slow=None):
    return LabelledRun(
        name=name, group=60, speed=26.8, friction=friction,
        blocks=np.abs(np.tile(blocks, (100, 5)) + 0.05 * generator.standard_normal((100, 20))),
        other_blocks={name: np.abs(generator.standard_normal((100, 20))) for name in OTHER_CHAINS},
        slow=np.zeros((3, 9)) if slow is None else slow,
    )  # fmt: skip


def test_exchanged_labels_are_those_of_other_runs():
    draw = np.random.default_rng(4)
    runs = [run(f"run {k}", mu, np.ones(4), draw) for k, mu in enumerate([0.1, 0.2, 0.3])]
    labels = [one.friction for one in exchange_labels(runs)]
    assert sorted(labels) == [0.1, 0.2, 0.3]
    assert all(label != one.friction for label, one in zip(labels, runs, strict=True))


def test_intervals_of_an_ensemble_cover_nine_in_ten_of_similar_runs():
    """Runs of a known law with noise between runs; 60 new ones: 90 % within three binomial deviations of 4 %."""
    draw = np.random.default_rng(5)

    def draw_runs(count):
        x = draw.uniform(-1, 1, (count, 3))
        y = 0.25 + 0.1 * np.tanh(x[:, 0]) + 0.02 * draw.standard_normal(count)
        rows = np.repeat(np.arange(count), 4)
        return x[rows] + 0.02 * draw.standard_normal((4 * count, 3)), y[rows], rows

    x, y, number = draw_runs(60)
    ensemble = fit(x, y, number, generator=draw, members=12)
    x, y, _ = draw_runs(60)
    answer = ensemble(x)
    share = np.mean((answer.lower <= y) & (y <= answer.upper))
    assert 0.78 <= share <= 1.0
    assert np.abs(answer.friction - y).mean() < 0.6 * np.abs(y - y.mean()).mean()


def test_too_few_networks_for_an_interval_are_refused():
    draw = np.random.default_rng(5)
    x, number = draw.standard_normal((4, 3)), np.arange(4)
    with pytest.raises(EstimatorError, match="outside of the training of 3 of the 2 networks"):
        fit(x, np.array([0.1, 0.2, 0.3, 0.4]), number, generator=draw, members=2, steps=2)


def test_a_second_stage_maps_slope_to_friction():
    """Friction is a nonlinear function of slope and slope of the features: two stages find both."""
    draw = np.random.default_rng(7)
    slope = draw.uniform(0.15, 0.75, 80)
    number = np.repeat(np.arange(80), 3)
    x = np.column_stack([np.log(slope)[number], draw.standard_normal(240)]) + 0.01 * draw.standard_normal((240, 2))
    friction = 0.15 + 0.2 / (1 + np.exp(-20 * (slope - 0.45)))
    ensemble = fit(x, friction[number], number, generator=draw, slope=slope[number], members=8, decay=1e-6)
    answer = ensemble(np.column_stack([np.log([0.2, 0.45, 0.7]), np.zeros(3)]))
    assert answer.friction == pytest.approx([0.151, 0.25, 0.349], abs=0.02)  # a tenth of the range


def test_only_levels_depend_on_the_roughness_of_the_track():
    draw = np.random.default_rng(6)
    lateral, yaw = draw.standard_normal((2, 2000, 4))
    spectral = Spectral(rate=128.0)
    speed = np.full(2000, 20.0)
    one, two = spectral.features(lateral, yaw, speed), spectral.features(3 * lateral, 3 * yaw, speed)
    level = np.array(["level" in name for name in spectral.names])
    after = slice(2 * spectral.settling_samples, None)
    assert two[after][:, ~level] == pytest.approx(one[after][:, ~level], abs=1e-9)
    assert two[after][:, level] - one[after][:, level] == pytest.approx(np.log(9), abs=1e-9)


def test_the_quadrature_of_signals_a_quarter_period_apart_is_one():
    """Lateral as the integral of yaw: quadrature 1, in phase 0, at the centre of a band."""
    time = np.arange(0, 60, 1 / 128)
    yaw = np.repeat(np.cos(2 * np.pi * 4 * time)[:, None], 4, axis=1)
    lateral = np.repeat(-np.sin(2 * np.pi * 4 * time)[:, None], 4, axis=1)
    spectral = Spectral(rate=128.0)
    features = dict(zip(spectral.names, spectral.features(lateral, yaw, np.full(time.size, 20.0))[-1], strict=True))
    # The bilinear transform moves 4 Hz by a third of a per cent at 128 Hz.
    assert abs(features["quadrature leading, 4 Hz"]) == pytest.approx(1.0, abs=0.02)
    assert features["in phase leading, 4 Hz"] == pytest.approx(0.0, abs=0.02)


def test_means_over_metres_follow_the_speed():
    """For a step of the signal where the car slows down, the mean decays with e^(-metres/50) at either speed."""
    spectral = Spectral(rate=128.0, metres=50.0, settling=0.5)
    level = np.concatenate([np.ones(6400), 2 * np.ones(6400)])
    speed = np.concatenate([np.full(6400, 20.0), np.full(6400, 5.0)])
    carrier = np.cos(2 * np.pi * 8 * np.arange(12800) / 128)
    yaw = np.repeat((level * carrier)[:, None], 4, axis=1)
    power = spectral.means(yaw, yaw, speed)[:, 3, 0, 0]
    low, high = power[6399], 4 * power[6399]  # 1000 m at level 1 are twenty times the memory
    distance = 5.0 * np.arange(1, 6401) / 128
    expected = high + (low - high) * np.exp(-distance / 50.0)
    # The band of 8 Hz settles within some tenths of a second, one or two metres of the fifty.
    assert power[6400 + 640 :] == pytest.approx(expected[640:], rel=0.03)


@pytest.mark.parametrize("inputs", list(COMBINATIONS))
def test_a_recipe_uses_the_motions_of_its_combination(inputs):
    one = run("run", 0.2, np.ones(4), np.random.default_rng(0))
    blocks = TrainingRecipe(inputs=inputs).blocks(one)
    expected = [one.blocks[:, CHANNELS[motion]] for motion in COMBINATIONS[inputs]]
    assert np.array_equal(blocks, np.hstack(expected))


@pytest.mark.parametrize("wheelsets", [1, 3])
def test_a_recipe_of_fewer_wheelsets_has_the_first_of_each_motion(wheelsets):
    one = run("run", 0.2, np.ones(4), np.random.default_rng(0))
    blocks = TrainingRecipe(inputs="longitudinal, yaw", wheelsets=wheelsets).blocks(one)
    assert np.array_equal(blocks, one.blocks[:, [*range(wheelsets), *range(8, 8 + wheelsets)]])


def test_the_other_chains_differ_in_drift_offset_and_blocks():
    """A constant plus a drift: the low-pass follows both, and delays the drift by √2/(2πf) of its corner frequency."""
    time = np.arange(20 * RATE) / RATE
    boxes = np.tile((270.0 + 0.5 * time)[:, np.newaxis], (1, 12))
    reduced = reduce("run", 0.2, Readings(boxes=boxes, speed=np.full(time.size, 26.8), backwards=False))
    last = 0.5 * (time[-1] - np.sqrt(2.0) / (2.0 * np.pi))
    # The mean of the last block is that in its middle, 5 ms earlier, and five times that for long blocks.
    assert reduced.other_blocks["without the high-pass"][-1, 0] == pytest.approx(last, abs=0.02)
    assert reduced.other_blocks["offset kept"][-1, 0] == pytest.approx(270.0 + last, abs=0.02)
    # A high-pass of 1e-4 Hz leaves a share of 1 - 20 s / (2 · 1592 s) of a drift of 20 s.
    assert reduced.blocks[-1, 0] == pytest.approx((1.0 - 20.0 * np.pi * 1e-4) * last, abs=0.02)
    short, long = reduced.other_blocks["blocks a fifth as long"], reduced.other_blocks["blocks five times as long"]
    np.testing.assert_allclose(short.reshape(-1, 5, 20).mean(axis=1), reduced.blocks, rtol=1e-12)
    count = len(long)
    np.testing.assert_allclose(reduced.blocks[: 5 * count].reshape(count, 5, 20).mean(axis=1), long, rtol=1e-12)


def test_decay_is_part_of_the_minimised_cost():
    """Training ends at the minimum of mean squared error plus decay times squared weights, at smaller weights."""
    draw = np.random.default_rng(9)
    x = draw.uniform(-1, 1, (60, 4))
    y = np.where(x[:, 0] > 0, 0.3, 0.15)
    sizes = {}
    for decay in (0.0, 1e-5):
        network = nn.train(x, y, hidden=6, bias="inside", generator=np.random.default_rng(1), decay=decay, steps=400)
        p = np.concatenate(
            [network.hidden_weights.ravel(), network.hidden_bias, network.output_weights, [network.output_bias]]
        )
        sizes[decay] = float(p @ p)

    def cost(q):
        return np.mean((nn._unpack(q, 4, 6, "inside")(x) - y) ** 2) + 1e-5 * (q @ q)

    assert sizes[1e-5] < sizes[0.0]
    # Forward differences of 1e-6 on a cost of curvature below one; at the start the slope is a thousand times that.
    assert np.abs(approx_fprime(p, cost, 1e-6)).max() < 1e-5
