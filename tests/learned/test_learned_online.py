"""The trained chain in CasADi, sample by sample, equals the offline chain."""

import numpy as np
import pytest

from railgrip.estimators.learned import trained as online
from railgrip.estimators.learned.network import Ensemble, Network
from railgrip.estimators.learned.preprocessing import AntiAlias, Chain, Scale, Spectral, motions
from railgrip.estimators.learned.trained import GeneralEstimator, PaperEstimator

ROUNDING = 1e-9
"""Relative: thousands of recursive filter steps with additions in another order, then a network of slope about 1."""


def network(draw, inputs, hidden=6, bias="inside"):
    return Network(
        hidden_weights=draw.standard_normal((hidden, inputs)) / inputs**0.5, hidden_bias=draw.standard_normal(hidden),
        output_weights=draw.standard_normal(hidden), output_bias=-1.0, bias=bias,
    )  # fmt: skip


def samples(draw, seconds, rate):
    """Offset, drift and coloured noise on twelve channels."""
    count = int(seconds * rate)
    slow = np.cumsum(draw.standard_normal((count, 12)), axis=0) / rate**0.5
    return 269 + slow + draw.standard_normal((count, 12))


@pytest.mark.parametrize("combination", ["longitudinal", "lateral, yaw"])
@pytest.mark.parametrize("bias", ["inside", "outside"])
def test_the_papers_estimator_is_the_same_online(combination, bias):
    draw = np.random.default_rng(3)
    raw, chain = samples(draw, 2, 5120), Chain(rate=5120, block=50)
    blocks = chain.process(np.stack(motions(raw.T, combination), axis=-1))
    networks = (network(draw, blocks.shape[1], bias=bias),)
    estimator = PaperEstimator(chain=chain, scale=Scale.over(blocks), networks=networks, inputs=combination)
    answer = online.run(estimator.online(), raw)
    offline = estimator.offline(raw, np.full(len(raw), np.nan), backwards=False)
    np.testing.assert_allclose(answer[49::50, 0], offline.friction, rtol=ROUNDING)
    assert np.all(answer[:49, 1] == 0)
    assert np.all(answer[49:, 1] == 1)
    assert np.all(answer[49:99, 0] == answer[49, 0])  # held between blocks


@pytest.mark.parametrize(("direction", "stages"), [(1.0, 1), (-1.0, 2)])
def test_the_general_estimator_is_the_same_online(direction, stages):
    draw = np.random.default_rng(4)
    slow = AntiAlias(rate=1280, keep=10)
    spectral = Spectral(rate=slow.slow_rate, settling=0.5, metres=30.0)
    size = len(spectral.names)
    ensemble = Ensemble(
        centre=np.zeros(size), spread=np.full(size, 3.0), half_width=1.7,
        second=tuple(network(draw, 1, hidden=3) for _ in range(2 * (stages - 1))),
        networks=tuple(network(draw, size) for _ in range(3)),
    )  # fmt: skip
    estimator = GeneralEstimator(slow=slow, spectral=spectral, ensemble=ensemble)
    raw = samples(draw, 4, slow.rate)
    speed = np.full(len(raw), 22.0)
    offline = estimator.offline(raw, speed, backwards=direction < 0)
    answer = online.run(estimator.online(), np.column_stack([raw, speed, np.full(len(raw), direction)]))
    for column, whole in enumerate((offline.friction, offline.lower, offline.upper)):
        np.testing.assert_allclose(answer[offline.sample, column], whole, rtol=ROUNDING, atol=1e-12)
    first = slow.keep * (2 * spectral.settling_samples + 1) - 1
    assert offline.sample[0] == first
    assert answer[first - 1, 3] == 0
    assert answer[first, 3] == 1


def test_a_start_that_is_not_causal_is_refused():
    chain = Chain(rate=5120, block=50, start="first second")
    scale = Scale(lowest=np.zeros(4), highest=np.ones(4))
    with pytest.raises(ValueError, match="first sample only"):
        online.paper(chain, scale, [network(np.random.default_rng(0), 4)])
