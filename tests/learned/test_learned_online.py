"""The trained chain in CasADi, sample by sample, equals the offline chain."""

import numpy as np
import pytest

from railgrip.estimators.learned import trained as online
from railgrip.estimators.learned.network import Ensemble, Network
from railgrip.estimators.learned.preprocessing import AntiAlias, Chain, Scale, Spectral, motions

ROUNDING = 1e-9
"""Relative: thousands of recursive filter steps with additions in another order, then a network of slope about 1."""


def network(generator, inputs, hidden=6, bias="inside"):
    draw = generator.standard_normal
    return Network(
        hidden_weights=draw((hidden, inputs)), hidden_bias=draw(hidden), output_weights=draw(hidden),
        output_bias=0.1, bias=bias,
    )  # fmt: skip


def samples(generator, seconds, rate):
    """Offset, drift and coloured noise on twelve channels."""
    count = int(seconds * rate)
    slow = np.cumsum(generator.standard_normal((count, 12)), axis=0) / rate**0.5
    return 269 + slow + generator.standard_normal((count, 12))


@pytest.mark.parametrize("combination", ["longitudinal", "lateral, yaw"])
@pytest.mark.parametrize("bias", ["inside", "outside"])
def test_the_papers_estimator_is_the_same_online(combination, bias):
    draw = np.random.default_rng(3)
    raw = samples(draw, 2, 5120)
    chain = Chain(rate=5120, block=50)
    blocks = chain.process(np.stack(motions(raw.T, combination), axis=-1))
    scale, net = Scale.over(blocks), network(draw, blocks.shape[1], bias=bias)
    offline = net(scale(blocks))
    answer = online.run(online.paper(chain, scale, [net], combination), raw)
    np.testing.assert_allclose(answer[49::50, 0], offline, rtol=ROUNDING)
    assert np.all(answer[:49, 1] == 0)
    assert np.all(answer[49:, 1] == 1)
    assert np.all(answer[49:99, 0] == answer[49, 0])  # held between blocks


def general_pair(direction, stages):
    draw = np.random.default_rng(4)
    slow = AntiAlias(rate=1280, keep=10)
    spectral = Spectral(rate=slow.slow_rate, settling=0.5, metres=30.0)
    raw, speed = samples(draw, 4, slow.rate), 22.0
    made = slow(np.hstack([raw[:, 8:], raw[:, 4:8] - raw[:, :4]]))
    lateral, yaw = made[:, :4], made[:, 4:]
    if direction < 0:
        lateral, yaw = -lateral[:, ::-1], yaw[:, ::-1]
    features = spectral.features(lateral, yaw, np.full(len(slow.every(raw)), speed))
    reference = features[2 * spectral.settling_samples :]
    ensemble = Ensemble(
        centre=reference.mean(axis=0), spread=reference.std(axis=0) + 1e-3, half_width=1.7,
        second=tuple(network(draw, 1, hidden=3) for _ in range(2 * (stages - 1))),
        networks=tuple(network(draw, features.shape[1]) for _ in range(3)),
    )  # fmt: skip
    entry = np.hstack([raw, np.full((len(raw), 1), speed), np.full((len(raw), 1), direction)])
    return online.general(slow, spectral, ensemble), ensemble(reference), entry, slow, spectral


@pytest.mark.parametrize(("direction", "stages"), [(1.0, 1), (-1.0, 2)])
def test_the_general_estimator_is_the_same_online(direction, stages):
    built, offline, entry, slow, spectral = general_pair(direction, stages)
    answer = online.run(built, entry)
    first = slow.keep * (2 * spectral.settling_samples + 1) - 1
    np.testing.assert_allclose(answer[first :: slow.keep, 0], offline.friction, rtol=ROUNDING)
    np.testing.assert_allclose(answer[first :: slow.keep, 1], offline.lower, rtol=ROUNDING, atol=1e-12)
    np.testing.assert_allclose(answer[first :: slow.keep, 2], offline.upper, rtol=ROUNDING)
    assert answer[first - 1, 3] == 0
    assert answer[first, 3] == 1


def test_a_start_that_is_not_causal_is_refused():
    chain = Chain(rate=5120, block=50, start="first second")
    scale = Scale(lowest=np.zeros(4), highest=np.ones(4))
    with pytest.raises(ValueError, match="first sample only"):
        online.paper(chain, scale, [network(np.random.default_rng(0), 4)])
