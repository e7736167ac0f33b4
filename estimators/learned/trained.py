"""Trained estimators: applied to a whole run or to single samples, and stored as a file.

For single samples an estimator is a CasADi function (state, input) → (state, output). It applies the filters, scaling
and networks of the whole run in the same order of operations, so that results differ by rounding only. The function is
compiled into an FMU unchanged (`railgrip.fmus.native.discrete`).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Final, Literal

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, TypeAdapter, ValidationError

from railgrip.base.errors import EstimatorError, InputError
from railgrip.base.files import read_text
from railgrip.base.records import words_of
from railgrip.base.system import SampledSystem, Variable
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.network import (
    MIN_DEVIATION,
    Ensemble,
    FrictionEstimates,
    Network,
)
from railgrip.estimators.learned.preprocessing import (
    BOXES,
    COMBINATIONS,
    PRODUCTS,
    SLOWEST,
    TINY,
    AntiAlias,
    Chain,
    Scale,
    Spectral,
    lateral_and_yaw,
    motions,
    products,
    ratios,
)

SX = ca.SX


def run(system: SampledSystem, samples: Array) -> Array:
    """Return the outputs of a system without parameters for successive samples, shape (n, inputs) → (n, outputs)."""
    state = np.array([s.start for s in system.states])
    over = system.step.mapaccum("run", len(samples))
    return np.asarray(over(state, samples.T)[1].full().T, dtype=np.float64)


@dataclass(slots=True)
class _Memory:
    """States of a step function: symbols before the step and values after it, by name."""

    before: dict[str, SX] = field(default_factory=dict[str, SX])
    after: dict[str, SX] = field(default_factory=dict[str, SX])

    def state(self, name: str) -> SX:
        """Add a state and return its symbol; the caller sets `after`."""
        self.before[name] = SX.sym(name)
        return self.before[name]

    def hold(self, name: str, value: SX, new: SX) -> SX:
        """Return `value` while `new` is true, else the last value returned, which a state keeps."""
        previous = self.state(name)
        self.after[name] = ca.if_else(new, value, previous)
        return self.after[name]

    def online(
        self, name: str, rate: int, inputs: tuple[Variable, ...], sample: SX, outputs: Mapping[Variable, SX]
    ) -> SampledSystem:
        """Return the estimator with these states.

        Args:
            inputs: Variables of `sample`.
            outputs: Variable → its value.
        """
        states = [ca.vertcat(*(values[name_] for name_ in self.before)) for values in (self.before, self.after)]
        return SampledSystem(
            name=name,
            # The description states the rate, because with a longer step the inputs would be held over several samples.
            description=f"Friction between wheel and rail from accelerations of the axle boxes, {rate} a second",
            period=1 / rate,
            # Names of states must differ from those of inputs and outputs.
            states=tuple(Variable(name=f"memory.{name_}", unit="", description="") for name_ in self.before),
            inputs=inputs,
            outputs=tuple(outputs),
            step=ca.Function("step", [states[0], sample], [states[1], ca.vertcat(*outputs.values())]),
        )


def paper(chain: Chain, scale: Scale, networks: Sequence[Network], combination: str = "longitudinal") -> SampledSystem:
    """Return the paper's estimator: a new friction after every block, held in between.

    Args:
        chain: Filters; they must start at the first sample, because the mean of the first second is not causal.
        scale: Scaling of the block means.
        networks: Networks whose mean is the estimate; the paper uses one.
        combination: Key of `preprocessing.COMBINATIONS`.
    """
    if chain.start != "first sample":
        raise ValueError("online, the high-pass can start at the first sample only.")
    memory = _Memory()
    boxes = SX.sym("boxes", len(BOXES))
    first = _first(memory)
    gain = (1 + chain.remembers) / 2
    counted = memory.state("count")
    full = counted + 1 >= chain.block
    means: list[SX] = []
    for k, channel in enumerate(motions(boxes, combination), start=1):
        relative = channel - memory.hold(f"zero[{k}]", channel, first)
        # High-pass of first order in transposed direct form II, as in `Chain.filter`.
        z = memory.state(f"high_pass[{k}]")
        high = gain * relative + z
        memory.after[f"high_pass[{k}]"] = -gain * relative + chain.remembers * high
        size = ca.fabs(_sections(memory, f"low_pass{k}", chain.sections, high))
        total = memory.state(f"sum[{k}]")
        memory.after[f"sum[{k}]"] = ca.if_else(full, 0, total + size)
        means.append((total + size) / chain.block)
    memory.after["count"] = ca.if_else(full, 0, counted + 1)
    entries = scale(_row(means))
    outputs = [network(entries)[0] for network in networks]
    latest = SX(sum(outputs[1:], outputs[0]) / len(networks))
    friction, known = memory.hold("held", latest, full), memory.hold("blocks", SX(1), full)
    return memory.online(
        "Friction from axle boxes after Abduraxman", chain.rate, _boxes(), boxes, {_FRICTION: friction, _KNOWN: known}
    )


def general(slow: AntiAlias, spectral: Spectral, ensemble: Ensemble) -> SampledSystem:
    """Return the estimator for all speeds: friction with its 90 % interval at the slow rate, held in between.

    Inputs are the accelerations, `speed` [m/s], and `direction`, +1 if wheelset 1 leads and −1 if wheelset 4 leads.
    """
    memory = _Memory()
    sample = SX.sym("entry", len(BOXES) + 2)
    boxes, speed, ahead = sample[: len(BOXES)], sample[len(BOXES)], sample[len(BOXES) + 1] >= 0
    tick, lateral, yaw = _slow_signals(memory, slow, boxes, ahead)
    ticks = memory.state("ticks")
    memory.after["ticks"] = ca.if_else(tick, ticks + 1, ticks)
    weight = ca.if_else(ticks >= spectral.settling_samples, spectral.weight(speed, ca), 0)
    features = _features(memory, spectral, lateral, yaw, weight, tick)
    features.append(ca.log(ca.fmax(ca.fabs(speed), SLOWEST)))
    # The means start after the settling time of the filters; the first estimate follows after as long again.
    ready = ca.logic_and(tick, ticks >= 2 * spectral.settling_samples)
    values = {**_interval(ensemble, features), _KNOWN: SX(1)}
    return memory.online(
        "Friction from axle boxes at any speed",
        slow.rate,
        (
            *_boxes(),
            Variable(name="speed", unit="m/s", start=20.0, description="Speed of the vehicle"),
            Variable(name="direction", unit="1", start=1.0, description="+1 wheelset 1 leads, -1 wheelset 4 leads"),
        ),
        sample,
        {output: memory.hold(f"held_{output.name}", value, ready) for output, value in values.items()},
    )


_FRICTION, _LOWER, _UPPER, _KNOWN = (
    Variable(name=name, unit="1", start=0.0, description=description)
    for name, description in (
        ("friction", "Friction coefficient"),
        ("lower", "Lower end of the 90 % interval"),
        ("upper", "Upper end of the 90 % interval"),
        ("known", "1 once there is an estimate"),
    )
)


def _boxes() -> tuple[Variable, ...]:
    return tuple(Variable(name=n, unit="m/s2", start=0.0, description="Acceleration of an axle box") for n in BOXES)


def _first(memory: _Memory) -> SX:
    later = memory.state("begun")
    memory.after["begun"] = SX(1)
    return later < 0.5


def _slow_signals(memory: _Memory, slow: AntiAlias, boxes: SX, ahead: SX) -> tuple[SX, list[SX], list[SX]]:
    first = _first(memory)
    raw = [boxes[8 + k] for k in range(4)] + [boxes[4 + k] - boxes[k] for k in range(4)]
    signals: list[SX] = []
    for k, channel in enumerate(raw, start=1):
        zero = memory.hold(f"zero[{k}]", channel, first)
        signals.append(_sections(memory, f"anti_alias{k}", slow.sections, channel - zero))
    counted = memory.state("count")
    tick = counted + 1 >= slow.keep
    memory.after["count"] = ca.if_else(tick, 0, counted + 1)
    # Backwards, the car is turned by half a turn: see `preprocessing.lateral_and_yaw`.
    lateral = [ca.if_else(ahead, signals[k], -signals[3 - k]) for k in range(4)]
    yaw = [ca.if_else(ahead, signals[4 + k], signals[7 - k]) for k in range(4)]
    return tick, lateral, yaw


def _features(memory: _Memory, spectral: Spectral, lateral: list[SX], yaw: list[SX], weight: SX, tick: SX) -> list[SX]:
    total = memory.state("total")
    weight_sum = total + weight * (1 - total)
    memory.after["total"] = ca.if_else(tick, weight_sum, total)
    features: list[SX] = []
    for j, centre in enumerate(spectral.centres, start=1):
        matrices = spectral.band(centre)
        swing = [_band(memory, f"lateral{j}_{k + 1}", matrices, lateral[k], tick) for k in range(4)]
        turn = [_band(memory, f"yaw{j}_{k + 1}", matrices, yaw[k], tick) for k in range(4)]
        sums: list[SX] = [SX(0)] * PRODUCTS
        for bogie in range(2):
            lead, trail = 2 * bogie, 2 * bogie + 1
            for i, product in enumerate(products(swing[lead], swing[trail], turn[lead], turn[trail])):
                name = f"mean[{j},{bogie + 1},{i + 1}]"
                mean = memory.state(name)
                new = mean + weight * (product - mean)
                memory.after[name] = ca.if_else(tick, new, mean)
                sums[i] = sums[i] + new / ca.fmax(weight_sum, TINY)
        features += ratios(sums, ca)
    return features


def _interval(ensemble: Ensemble, features: list[SX]) -> dict[Variable, SX]:
    x = [
        ca.fmin(ca.fmax((f - c) / s, -4), 4) / 2
        for f, c, s in zip(features, ensemble.centre, ensemble.spread, strict=True)
    ]
    first = np.array([network(_row(x))[0] for network in ensemble.networks], dtype=object)
    each = ensemble.friction_of(first)
    mean, centre = ensemble.friction_of(first.mean(keepdims=True))[0], each.mean()
    half = ensemble.half_width * ca.sqrt(sum((e - centre) ** 2 for e in each) / len(each) + MIN_DEVIATION**2)
    return {_FRICTION: mean, _LOWER: ca.fmax(mean - half, 0), _UPPER: ca.fmin(mean + half, 1)}


def _sections(memory: _Memory, name: str, sections: Array, value: SX) -> SX:
    # Transposed direct form II, as scipy.signal.sosfilt computes it.
    for k, (b0, b1, b2, _, a1, a2) in enumerate(sections, start=1):
        names = [f"{name}_section{k}_{i}" for i in (1, 2)]
        z0, z1 = map(memory.state, names)
        out = b0 * value + z0
        memory.after |= {names[0]: b1 * value - a1 * out + z1, names[1]: b2 * value - a2 * out}
        value = out
    return value


def _band(
    memory: _Memory, name: str, matrices: tuple[Array, Array, Array, Array], value: SX, tick: SX
) -> tuple[SX, SX]:
    a, b, c, d = matrices
    names = [f"band_{name}_{i}" for i in (1, 2)]
    old = [memory.state(state_name) for state_name in names]
    for row, state_name in enumerate(names):
        new = a[row, 0] * old[0] + a[row, 1] * old[1] + b[row, 0] * value
        memory.after[state_name] = ca.if_else(tick, new, old[row])
    low, high = (c[row, 0] * old[0] + c[row, 1] * old[1] + d[row, 0] * value for row in range(2))
    return low, high


def _row(values: Sequence[SX]) -> Any:
    """Return symbols as an array for the arithmetic of NumPy, shape (1, n)."""
    return np.array([values], dtype=object)


FORMAT: Final = 1
"""Version of the file format, raised whenever an older reader would misread a newer file."""
_EXACT: Final = ConfigDict(extra="forbid")
"""A file has no other parts than its estimator, at any level."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunEstimates(FrictionEstimates):
    """Estimates over a run, each of shape (k,); the interval is NaN for an estimator without one.

    Attributes:
        sample: Index of the last sample of each estimate.
    """

    sample: NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperEstimator:
    """Abduraxman et al. (2024): filters, block means, scaling and a network 4-6-1, or the mean of several.

    Attributes:
        inputs: Key of `preprocessing.COMBINATIONS`.
    """

    KIND: ClassVar[str] = "paper"
    __pydantic_config__ = _EXACT

    chain: Chain
    scale: Scale
    networks: tuple[Network, ...]
    inputs: Literal[tuple(COMBINATIONS)]  # pyright: ignore[reportInvalidTypeForm]

    @property
    def rate(self) -> int:
        """Sampling rate of the accelerations [Hz]."""
        return self.chain.rate

    def offline(self, boxes: Array, speed: Array, *, backwards: bool) -> RunEstimates:
        """Return the estimates of a whole run; neither speed nor direction is used.

        Args:
            boxes: Accelerations in the order of `preprocessing.BOXES`, at `rate`, in axes of the car [m/s²], shape
                (n, 12).
            speed: Speed of the vehicle [m/s], shape (n,).
            backwards: Whether wheelset 4 leads.
        """
        blocks = self.chain.process(np.stack(motions(boxes.T, self.inputs), axis=-1))
        friction = np.mean([network(self.scale(blocks)) for network in self.networks], axis=0)
        none = np.full(len(blocks), np.nan)
        return RunEstimates(
            sample=self.chain.block * np.arange(1, len(blocks) + 1) - 1, friction=friction, lower=none, upper=none
        )

    def online(self) -> SampledSystem:
        """Return the same estimator for single samples."""
        return paper(self.chain, self.scale, self.networks, self.inputs)


@dataclass(frozen=True, slots=True, kw_only=True)
class GeneralEstimator:
    """One estimator for all speeds: spectral features of lateral and yaw acceleration, an ensemble, an interval."""

    KIND: ClassVar[str] = "general"
    __pydantic_config__ = _EXACT

    slow: AntiAlias
    spectral: Spectral
    ensemble: Ensemble

    @property
    def rate(self) -> int:
        """See `PaperEstimator`."""
        return self.slow.rate

    def offline(self, boxes: Array, speed: Array, *, backwards: bool) -> RunEstimates:
        """See `PaperEstimator`; an estimate at every slow sample once the features have settled."""
        lateral, yaw = lateral_and_yaw(self.slow, boxes, backwards=backwards)
        features = self.spectral.features(lateral, yaw, self.slow.every(speed))
        known = np.arange(2 * self.spectral.settling_samples, len(features))
        return RunEstimates(sample=self.slow.keep * (known + 1) - 1, **asdict(self.ensemble(features[known])))

    def online(self) -> SampledSystem:
        """See `PaperEstimator`."""
        return general(self.slow, self.spectral, self.ensemble)


Trained = PaperEstimator | GeneralEstimator


def save(trained: Trained, file: Path) -> Path:
    """Write a trained estimator, without rounding of numbers; return the file."""
    file.write_text(
        json.dumps({"format": FORMAT, "kind": trained.KIND, **asdict(trained)}, default=np.ndarray.tolist),
        encoding="utf-8",
    )
    return file


def load(file: Path) -> Trained:
    """Return the estimator that `save` wrote.

    Raises:
        EstimatorError: The file is missing, or is not a trained estimator.
    """
    try:
        content = json.loads(read_text(file, 256 << 20, if_missing="; `make learn` writes trained estimators"))
    except InputError as problem:
        raise EstimatorError(f"{problem}.") from problem
    except (json.JSONDecodeError, RecursionError) as problem:
        raise EstimatorError(f"{file}: is not JSON: {problem}.") from problem
    kinds = {kind.KIND: kind for kind in (PaperEstimator, GeneralEstimator)}
    if not isinstance(content, dict) or content.get("kind") not in kinds or content.get("format") != FORMAT:
        raise EstimatorError(
            f"{file}: is not a trained estimator of format {FORMAT}; it needs kind {' or '.join(kinds)}."
        )
    parts = {name: part for name, part in content.items() if name not in ("format", "kind")}
    try:
        return TypeAdapter(kinds[content["kind"]]).validate_python(parts)
    except ValidationError as problem:
        raise EstimatorError(f"{file}: is a damaged trained estimator: {words_of(problem)}.") from problem
