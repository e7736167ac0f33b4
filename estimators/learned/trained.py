"""Trained estimators: applied to a whole run or to single samples, and stored as a file."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import EstimatorError, InputError
from railgrip.base.files import read_text
from railgrip.base.system import SampledSystem
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.ensemble import Ensemble
from railgrip.estimators.learned.network import Network
from railgrip.estimators.learned.online import general, paper
from railgrip.estimators.learned.preprocessing import COMBINATIONS, AntiAlias, Chain, Scale, lateral_and_yaw, motions
from railgrip.estimators.learned.spectral import Spectral

FORMAT: Final = 1
"""Version of the file format, raised whenever an older reader would misread a newer file."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunEstimates:
    """Estimates over a run, each of shape (k,).

    Attributes:
        sample: Index of the last sample of each estimate.
        friction: Estimate.
        lower, upper: Ends of the 90 % interval; NaN for an estimator without interval.
    """

    sample: NDArray[np.intp]
    friction: Array
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperEstimator:
    """Abduraxman et al. (2024): filters, block means, scaling and a network 4-6-1, or the mean of several.

    Attributes:
        inputs: Key of `preprocessing.COMBINATIONS`.
    """

    chain: Chain
    scale: Scale
    networks: tuple[Network, ...]
    inputs: str

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
        estimates = self.ensemble(features[known])
        return RunEstimates(
            sample=self.slow.keep * (known + 1) - 1,
            friction=estimates.friction,
            lower=estimates.lower,
            upper=estimates.upper,
        )

    def online(self) -> SampledSystem:
        """See `PaperEstimator`."""
        return general(self.slow, self.spectral, self.ensemble)


Trained = PaperEstimator | GeneralEstimator


def save(trained: Trained, file: Path) -> Path:
    """Write a trained estimator, without rounding of numbers; return the file."""
    file.write_text(
        json.dumps({"format": FORMAT, "kind": _KIND[type(trained)], **asdict(trained)}, default=_plain),
        encoding="utf-8",
    )
    return file


def load(file: Path) -> Trained:
    """Return the estimator that `save` wrote.

    Raises:
        EstimatorError: The file is missing, or is not a trained estimator.
    """
    try:
        content = json.loads(read_text(file, 256 << 20))
    except InputError as problem:
        is_missing = isinstance(problem.__cause__, FileNotFoundError)
        raise EstimatorError(
            f"{problem}{'; `make learn` writes trained estimators' if is_missing else ''}."
        ) from problem
    except (json.JSONDecodeError, RecursionError) as problem:
        raise EstimatorError(f"{file}: is not JSON: {problem}.") from problem
    if not isinstance(content, dict) or content.get("kind") not in _READ or content.get("format") != FORMAT:
        raise EstimatorError(
            f"{file}: is not a trained estimator of format {FORMAT}; it needs kind {' or '.join(_READ)}."
        )
    try:
        return _READ[content["kind"]](content)
    except (KeyError, TypeError, ValueError) as problem:
        raise EstimatorError(f"{file}: is a damaged trained estimator: {problem!r}.") from problem


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"a trained estimator cannot contain {type(value).__name__}")


def _paper(content: Mapping[str, Any]) -> PaperEstimator:
    if content["inputs"] not in COMBINATIONS:
        raise ValueError(f"inputs '{content['inputs']}' are unknown")
    return PaperEstimator(
        chain=Chain(**content["chain"]),
        scale=Scale(**{name: np.array(values) for name, values in content["scale"].items()}),
        networks=tuple(map(_network, content["networks"])),
        inputs=content["inputs"],
    )


def _general(content: Mapping[str, Any]) -> GeneralEstimator:
    ensemble = dict(content["ensemble"])
    return GeneralEstimator(
        slow=AntiAlias(**content["slow"]),
        spectral=replace(Spectral(**content["spectral"]), centres=tuple(content["spectral"]["centres"])),
        ensemble=Ensemble(
            centre=np.array(ensemble["centre"]),
            spread=np.array(ensemble["spread"]),
            networks=tuple(map(_network, ensemble["networks"])),
            second=tuple(map(_network, ensemble["second"])),
            half_width=ensemble["half_width"],
        ),
    )


def _network(content: Mapping[str, Any]) -> Network:
    weights = {name: np.array(content[name]) for name in ("hidden_weights", "hidden_bias", "output_weights")}
    return Network(**weights, output_bias=content["output_bias"], bias=content["bias"])


_KIND: Final[Mapping[type, str]] = {PaperEstimator: "paper", GeneralEstimator: "general"}
_READ: Final[Mapping[str, Callable[[Mapping[str, Any]], Trained]]] = {"paper": _paper, "general": _general}
