"""Trained estimators sample by sample: one CasADi function (state, input) → (state, output) each.

The same filters, scaling and networks as offline, in the same order of operations; what comes out differs from the
offline result by rounding alone. The function goes into an FMU as it is (`railgrip.fmus.native.discrete`).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

import casadi as ca
import numpy as np

from railgrip.estimators.belief import Array
from railgrip.estimators.learned.ensemble import LEAST_SPREAD, SLOPE_CENTRE, SLOPE_HALF, Ensemble
from railgrip.estimators.learned.network import Network
from railgrip.estimators.learned.preprocessing import COMBINATIONS, AntiAlias, Chain, Scale
from railgrip.estimators.learned.spectral import PRODUCTS, SLOWEST, TINY, Spectral, products, ratios
from railgrip.fmus.native import Variable

SX = ca.SX

BOXES: Final = (
    *(f"left[{k}]" for k in range(1, 5)), *(f"right[{k}]" for k in range(1, 5)),
    *(f"lateral[{k}]" for k in range(1, 5)),
)  # fmt: skip
"""Accelerations of the axle boxes: longitudinal left and right, lateral."""


def variable(*, name: str, unit: str, start: float, description: str) -> Variable:
    """Return a variable of an online estimator."""
    return Variable(name=name, unit=unit, start=start, description=description, minimum=None, maximum=None, nominal=1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Online:
    """An estimator sample by sample.

    Attributes:
        rate: Samples a second.
        step: (state, input) → (state, output).
    """

    name: str
    rate: int
    states: tuple[Variable, ...]
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    step: ca.Function

    def run(self, samples: Array) -> Array:
        """Return the outputs for samples fed one after the other, shape (n, inputs) → (n, outputs)."""
        state = np.array([s.start for s in self.states])
        over = self.step.mapaccum("run", len(samples))
        return np.asarray(over(state, samples.T)[1].full().T, dtype=np.float64)


@dataclass(slots=True)
class _Memory:
    """Collects states while a step function is written down."""

    names: list[str] = field(default_factory=list)
    symbols: list[SX] = field(default_factory=list)
    following: list[SX | None] = field(default_factory=list)

    def new(self, name: str) -> tuple[int, SX]:
        symbol = SX.sym(name)
        self.names.append(name)
        self.symbols.append(symbol)
        self.following.append(None)
        return len(self.names) - 1, symbol

    def edges(self) -> tuple[Variable, ...]:
        return tuple(variable(name=n, unit="", start=0.0, description="") for n in self.names)

    def column(self) -> SX:
        missing = [n for n, f in zip(self.names, self.following, strict=True) if f is None]
        assert not missing, f"states without a successor: {missing}"
        return ca.vertcat(*[f for f in self.following if f is not None])


def paper(chain: Chain, scale: Scale, networks: Sequence[Network], combination: str = "longitudinal") -> Online:
    """Return the paper's estimator: a new friction after every block, held in between.

    Args:
        chain: Must start at the first sample; the mean of the first second is not causal.
        networks: Their mean is the estimate; one is as good as in the paper.
    """
    if chain.start != "first sample":
        raise ValueError("online, the high-pass can start at the first sample only.")
    memory = _Memory()
    boxes = SX.sym("boxes", len(BOXES))
    channels = _motions(boxes, combination)
    first = _first(memory)
    gain = (1 + chain.remembers) / 2
    count, counted = memory.new("count")
    full = counted + 1 >= chain.block
    means: list[SX] = []
    for k, channel in enumerate(channels):
        relative = channel - _zero(memory, f"zero[{k + 1}]", channel, first)
        at, z = memory.new(f"high_pass[{k + 1}]")
        high = gain * relative + z
        memory.following[at] = -gain * relative + chain.remembers * high
        size = ca.fabs(_sections(memory, f"low_pass{k + 1}", chain.sections, high))
        at, total = memory.new(f"sum[{k + 1}]")
        memory.following[at] = ca.if_else(full, 0, total + size)
        means.append((total + size) / chain.block)
    memory.following[count] = ca.if_else(full, 0, counted + 1)
    entries = scale(np.array(means, dtype=object))
    latest = sum(_network(network, list(entries)) for network in networks) / len(networks)
    at, previous = memory.new("held")
    friction = memory.following[at] = ca.if_else(full, latest, previous)
    at, blocks = memory.new("blocks")
    known = memory.following[at] = ca.if_else(full, 1, blocks)
    state = ca.vertcat(*memory.symbols)
    return Online(
        name="Friction from axle boxes after Abduraxman",
        rate=chain.rate,
        states=memory.edges(),
        inputs=_boxes(),
        outputs=(
            variable(name="friction", unit="1", start=0.0, description="Friction coefficient"),
            variable(name="known", unit="1", start=0.0, description="1 once there is an estimate"),
        ),
        step=ca.Function("step", [state, boxes], [memory.column(), ca.vertcat(friction, known)]),
    )


def general(slow: AntiAlias, spectral: Spectral, ensemble: Ensemble) -> Online:
    """Return the estimator for all speeds: friction with its 90 % interval at the slow rate, held in between.

    Inputs beside the axle boxes: `speed` [m/s] and `direction`, +1 when wheelset 1 leads, −1 when wheelset 4 does.
    """
    memory = _Memory()
    entry = SX.sym("entry", len(BOXES) + 2)
    boxes, speed, ahead = entry[: len(BOXES)], entry[len(BOXES)], entry[len(BOXES) + 1] >= 0
    first = _first(memory)
    raw = [boxes[8 + k] for k in range(4)] + [boxes[4 + k] - boxes[k] for k in range(4)]
    slow_signals = [
        _sections(memory, f"anti_alias{k + 1}", slow.sections, x - _zero(memory, f"zero[{k + 1}]", x, first))
        for k, x in enumerate(raw)
    ]
    at, counted = memory.new("count")
    tick = counted + 1 >= slow.keep
    memory.following[at] = ca.if_else(tick, 0, counted + 1)
    lateral = [ca.if_else(ahead, slow_signals[k], -slow_signals[3 - k]) for k in range(4)]
    yaw = [ca.if_else(ahead, slow_signals[4 + k], slow_signals[7 - k]) for k in range(4)]

    at, ticks = memory.new("ticks")
    memory.following[at] = ca.if_else(tick, ticks + 1, ticks)
    weight = ca.if_else(ticks >= spectral.settling_samples, spectral.weight(speed, ca), 0)
    at, total = memory.new("total")
    weight_sum = total + weight * (1 - total)
    memory.following[at] = ca.if_else(tick, weight_sum, total)
    features: list[SX] = []
    for j, centre in enumerate(spectral.centres):
        matrices = spectral.band(centre)
        swing = [_band(memory, f"lateral{j + 1}_{k + 1}", matrices, lateral[k], tick) for k in range(4)]
        turn = [_band(memory, f"yaw{j + 1}_{k + 1}", matrices, yaw[k], tick) for k in range(4)]
        sums: list[SX] = [SX(0)] * PRODUCTS
        for bogie in range(2):
            lead, trail = 2 * bogie, 2 * bogie + 1
            for i, product in enumerate(products(swing[lead], swing[trail], turn[lead], turn[trail])):
                at, mean = memory.new(f"mean[{j + 1},{bogie + 1},{i + 1}]")
                new = mean + weight * (product - mean)
                memory.following[at] = ca.if_else(tick, new, mean)
                sums[i] = sums[i] + new / ca.fmax(weight_sum, TINY)
        features += ratios(sums, ca)
    features.append(ca.log(ca.fmax(ca.fabs(speed), SLOWEST)))

    x = [
        ca.fmin(ca.fmax((f - c) / s, -4), 4) / 2
        for f, c, s in zip(features, ensemble.centre, ensemble.spread, strict=True)
    ]
    first_stage = [_network(network, x) for network in ensemble.networks]
    each = [_friction(ensemble, one) for one in first_stage]
    mean, centre = _friction(ensemble, _mean(first_stage)), _mean(each)
    half = ensemble.half_width * ca.sqrt(sum((e - centre) ** 2 for e in each) / len(each) + LEAST_SPREAD**2)
    outputs: list[SX] = []
    ready = ca.logic_and(tick, ticks >= 2 * spectral.settling_samples)
    for name, value in (
        ("friction", mean), ("lower", ca.fmax(mean - half, 0)), ("upper", ca.fmin(mean + half, 1)), ("known", SX(1)),
    ):  # fmt: skip
        at, previous = memory.new(f"held_{name}")
        memory.following[at] = ca.if_else(ready, value, previous)
        outputs.append(ca.if_else(ready, value, previous))
    return Online(
        name="Friction from axle boxes at any speed",
        rate=slow.rate,
        states=memory.edges(),
        inputs=(
            *_boxes(),
            variable(name="speed", unit="m/s", start=20.0, description="Speed of the vehicle"),
            variable(name="direction", unit="1", start=1.0, description="+1 wheelset 1 leads, -1 wheelset 4 leads"),
        ),
        outputs=(
            variable(name="friction", unit="1", start=0.0, description="Friction coefficient"),
            variable(name="lower", unit="1", start=0.0, description="Lower end of the 90 % interval"),
            variable(name="upper", unit="1", start=0.0, description="Upper end of the 90 % interval"),
            variable(name="known", unit="1", start=0.0, description="1 once there is an estimate"),
        ),
        step=ca.Function("step", [ca.vertcat(*memory.symbols), entry], [memory.column(), ca.vertcat(*outputs)]),
    )


def _boxes() -> tuple[Variable, ...]:
    return tuple(variable(name=n, unit="m/s2", start=0.0, description="Acceleration of an axle box") for n in BOXES)


def _motions(boxes: SX, combination: str) -> list[SX]:
    left, right, lateral = ([boxes[4 * j + k] for k in range(4)] for j in range(3))
    parts = {
        "longitudinal": [(a + b) / 2 for a, b in zip(left, right, strict=True)],
        "lateral": lateral,
        "yaw": [b - a for a, b in zip(left, right, strict=True)],
        "left": left,
        "right": right,
    }
    return [channel for motion in COMBINATIONS[combination] for channel in parts[motion]]


def _first(memory: _Memory) -> SX:
    """Return whether this is the first sample."""
    at, later = memory.new("begun")
    memory.following[at] = SX(1)
    return later < 0.5


def _zero(memory: _Memory, name: str, value: SX, first: SX) -> SX:
    """Return the first value there ever was."""
    at, previous = memory.new(name)
    zero = ca.if_else(first, value, previous)
    memory.following[at] = zero
    return zero


def _sections(memory: _Memory, name: str, sections: Array, value: SX) -> SX:
    """Return the output of second-order sections, transposed direct form II as in SciPy."""
    for k, (b0, b1, b2, _, a1, a2) in enumerate(sections):
        (at0, z0), (at1, z1) = (memory.new(f"{name}_section{k + 1}_{i}") for i in (1, 2))
        out = b0 * value + z0
        memory.following[at0] = b1 * value - a1 * out + z1
        memory.following[at1] = b2 * value - a2 * out
        value = out
    return value


def _band(
    memory: _Memory, name: str, matrices: tuple[Array, Array, Array, Array], value: SX, tick: SX
) -> tuple[SX, SX]:
    """Return both outputs of a band filter that moves on when `tick` is true."""
    a, b, c, d = matrices
    (at0, x0), (at1, x1) = (memory.new(f"band_{name}_{i}") for i in (1, 2))
    for at, old, row in ((at0, x0, 0), (at1, x1, 1)):
        new = a[row, 0] * x0 + a[row, 1] * x1 + b[row, 0] * value
        memory.following[at] = ca.if_else(tick, new, old)
    low, high = (c[row, 0] * x0 + c[row, 1] * x1 + d[row, 0] * value for row in range(2))
    return low, high


def _friction(ensemble: Ensemble, first: SX) -> SX:
    """Return the friction of what the first stage says."""
    if not ensemble.second:
        return first
    inner = (first - SLOPE_CENTRE) / SLOPE_HALF
    return _mean([_network(network, [inner]) for network in ensemble.second])


def _mean(values: Sequence[SX]) -> SX:
    return ca.sum1(ca.vertcat(*values)) / len(values)


def _network(network: Network, x: Iterable[SX]) -> SX:
    inputs = ca.vertcat(*x)
    hidden = ca.tanh(ca.mtimes(network.hidden_weights, inputs) + network.hidden_bias)
    inner = ca.dot(SX(network.output_weights), hidden)
    if network.bias == "inside":
        return 1 / (1 + ca.exp(-(inner + network.output_bias)))
    return 1 / (1 + ca.exp(-inner)) + network.output_bias
