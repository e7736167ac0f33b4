"""Kinds of filters, their data, checked once, named sets of noises, and gates that freeze states while unobservable.

`noises.toml` has the sets of noises for the prediction models of the train, with their reasons.
"""

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import Any, ClassVar, Literal, Protocol, Self, get_args, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.errors import EstimatorError
from railgrip.base.names import ElementName
from railgrip.estimators.belief import GaussianEstimate, Matrix, Order, Vector, seal
from railgrip.estimators.prediction import FilterVariables


@dataclass(frozen=True, slots=True, kw_only=True)
class Gate:
    """Freezes a state while the input that makes it observable is small.

    With the pads released, for example, no torque depends on pad friction. Its variance would grow without bound, and
    the first reading after the next application could change the mean arbitrarily.

    While frozen, a state is a *consider state* of a Schmidt–Kalman filter: its derivative, process noise and gain are
    zero, so that neither its mean nor its variance changes. Its cross covariances with the other states are still
    updated by the transition and the gains of these states, whose variances continue to include the uncertainty caused
    by it. When the gate opens, estimation continues from a consistent joint covariance.

    Attributes:
        states: Names of the states to freeze.
        inputs: Names of the inputs that decide, one for each of `states`.
        threshold: A state is frozen while its input is below this value, in the unit of the input.

    Raises:
        EstimatorError: `states` and `inputs` differ in number, or a state is named twice.

    Source: Schmidt, Application of State-Space Methods to Navigation Problems (1966).
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    threshold: float

    def __post_init__(self) -> None:
        if len(self.states) != len(self.inputs):
            raise EstimatorError(
                f"Gate: {len(self.states)} states require as many inputs, got {len(self.inputs)}; "
                "name for each state the input that opens it."
            )
        if len(set(self.states)) != len(self.states):
            raise EstimatorError(f"Gate: each state must be named once, got {', '.join(self.states)}.")


@runtime_checkable
class SteppedVariables(Protocol):
    """Names of a model that integrates itself: its derivative is the mean rate over its period [s]."""

    @property
    def period(self) -> float:
        """Period over which it integrates [s]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterDesign:
    """Names, noises and gate of a filter, from which both implementations are built.

    Attributes:
        states: Names of the n states.
        inputs: Names of the held inputs.
        outputs: Names of the m readings.
        process_noise: Process noise that one period adds, shape (n, n).
        reading_noise: Covariance of the readings, shape (m, m).
        period: Seconds between two steps.
        gated_states: Index of every state that a gate may freeze.
        gating_inputs: Index of the input that decides, one for each of `gated_states`.
        gate_threshold: States are frozen below this value, in the unit of the gating inputs.
        order: Order of the discretisation.
        outlier_limit: Largest innovation of a reading that is used, in its standard deviations, shape (m,); infinity
            uses every reading.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    process_noise: Matrix
    reading_noise: Matrix
    period: float
    gated_states: tuple[int, ...]
    gating_inputs: tuple[int, ...]
    gate_threshold: float
    outlier_limit: Vector
    order: Order

    @classmethod
    def of(
        cls,
        prediction: FilterVariables,
        process_noise: ArrayLike,
        reading_noise: ArrayLike,
        period: float,
        gate: Gate | None,
        outlier_limit: ArrayLike | None,
        order: Order,
    ) -> Self:
        """Return the design after checking its parts against each other.

        Args:
            prediction: Names of states, inputs and readings.
            process_noise: Density of the process noise in (unit of the state)²/s: shape (n,) for independent
                noises, or (n, n). Positive semidefinite.
            reading_noise: Covariance of the readings: shape (m,) of variances, or (m, m). Positive definite.
            period: Seconds, positive.
            gate: States to freeze and the inputs that decide, or None.
            outlier_limit: Largest innovation of a reading that is used, in its standard deviations: one value for all,
                shape (m,), or None to use every reading.
            order: 1 for forward Euler, 4 for RK4; see `belief`. A prediction that integrates itself has
                order 1: forward Euler with its mean rate is its own step.

        Raises:
            EstimatorError: An argument is invalid; the message names it.
        """
        states, inputs, outputs = prediction.states, prediction.inputs, prediction.outputs
        for kind, names in (("state", states), ("input", inputs), ("output", outputs)):
            if len(set(names)) != len(names):
                raise EstimatorError(f"Filter: the prediction names a {kind} twice in {', '.join(names)}.")
        if not states or not outputs:
            raise EstimatorError("Filter: a prediction needs at least one state and one output.")
        if not (math.isfinite(period) and period > 0.0):
            raise EstimatorError(f"Filter: period must be a positive number of seconds, got {period}.")
        if isinstance(prediction, SteppedVariables):
            if not math.isclose(prediction.period, period, rel_tol=1e-12):
                raise EstimatorError(
                    f"Filter: the prediction integrates over {prediction.period:g} s, and the filter's period is "
                    f"{period:g} s; give both the same."
                )
            order = 1
        if order not in get_args(Order):
            raise EstimatorError(f"Filter: order must be 1 (forward Euler) or 4 (RK4), got {order}.")
        limits = np.full(len(outputs), math.inf)
        try:
            limits[:] = math.inf if outlier_limit is None else outlier_limit
        except ValueError as error:
            raise EstimatorError(f"Filter: outlier_limit must have shape ({len(outputs)},): {error}.") from error
        if not np.all(limits > 0.0):
            raise EstimatorError(
                "Filter: outlier_limit must be a positive number of standard deviations, "
                f"got {outlier_limit}; None uses every reading."
            )
        reading = _reading_covariance(reading_noise, outputs)
        return cls(
            states=states,
            inputs=inputs,
            outputs=outputs,
            process_noise=_process_noise(process_noise, states, period),
            reading_noise=reading,
            period=period,
            gated_states=() if gate is None else tuple(index("Gate", "state", n, states) for n in gate.states),
            gating_inputs=() if gate is None else tuple(index("Gate", "input", n, inputs) for n in gate.inputs),
            gate_threshold=-math.inf if gate is None else gate.threshold,
            outlier_limit=limits,
            order=order,
        )

    def with_noises(self, process_noise: ArrayLike, reading_noise: ArrayLike | None) -> Self:
        """Return the same filter with other noises, see `of`; None keeps the reading noise.

        Raises:
            EstimatorError: A noise does not match the states or readings.
        """
        reading = self.reading_noise if reading_noise is None else _reading_covariance(reading_noise, self.outputs)
        return replace(
            self, process_noise=_process_noise(process_noise, self.states, self.period), reading_noise=reading
        )

    def start(self, mean: ArrayLike, covariance: ArrayLike) -> GaussianEstimate:
        """Return the estimate before the first step.

        Args:
            mean: Shape (n,).
            covariance: Shape (n,) of variances, or (n, n); positive definite.

        Raises:
            EstimatorError: Wrong shape, a value that is not finite, or a matrix that is not a covariance.
        """
        first = np.array(mean, dtype=np.float64)
        if first.shape != (len(self.states),):
            raise EstimatorError(
                f"start: mean requires {len(self.states)} states ({', '.join(self.states)}), got shape {first.shape}."
            )
        infinite = [name for name, value in zip(self.states, first, strict=True) if not math.isfinite(value)]
        if infinite:
            raise EstimatorError(f"start: the mean of {', '.join(infinite)} is not a finite number.")
        matrix = noise_matrix("covariance", covariance, self.states)
        if not positive_definite(matrix):
            raise EstimatorError("start: covariance is not positive definite; give every state a variance above zero.")
        return seal(first, matrix)

    def check(self, inputs: Vector, readings: Vector) -> None:
        """Raise `EstimatorError` for inputs or readings of the wrong length."""
        if inputs.shape != (len(self.inputs),):
            raise EstimatorError(
                f"step: inputs requires {len(self.inputs)} inputs ({', '.join(self.inputs)}), got shape {inputs.shape}."
            )
        if readings.shape != (len(self.outputs),):
            raise EstimatorError(
                f"step: readings requires {len(self.outputs)} readings ({', '.join(self.outputs)}), "
                f"got shape {readings.shape}; write NaN for a missing reading."
            )


def _reading_covariance(reading_noise: ArrayLike, outputs: tuple[str, ...]) -> Matrix:
    reading = noise_matrix("reading_noise", reading_noise, outputs)
    if not positive_definite(reading):
        raise EstimatorError(
            "Filter: reading_noise is not positive definite; give every reading a variance above zero, "
            "a small one for a perfect sensor."
        )
    return reading


def _process_noise(density: ArrayLike, states: tuple[str, ...], period: float) -> Matrix:
    matrix = noise_matrix("process_noise", density, states)
    # Semidefinite, because a state may have no noise; the margin is what rounding does to a zero eigenvalue.
    if np.min(np.linalg.eigvalsh(matrix)) < -1e-12 * np.max(np.abs(matrix), initial=0.0):
        raise EstimatorError("Filter: process_noise has a negative eigenvalue, so it is not a covariance.")
    return matrix * period


def noise_matrix(what: str, values: ArrayLike, names: tuple[str, ...]) -> Matrix:
    """Return `values` as an exactly symmetric matrix; a vector contains the variances of independent entries.

    Raises:
        EstimatorError: Wrong shape, not finite, or not symmetric; the message names `what`.
    """
    matrix = np.array(values, dtype=np.float64)
    n = len(names)
    if matrix.shape not in ((n,), (n, n)):
        raise EstimatorError(
            f"Filter: {what} must have shape ({n},) or ({n}, {n}) for {', '.join(names)}; got {matrix.shape}."
        )
    if not np.all(np.isfinite(matrix)):
        raise EstimatorError(f"Filter: {what} contains a value that is not a finite number.")
    if matrix.ndim == 1:
        return np.diag(matrix)
    # Far above the rounding error of a product such as F P Fᵀ, far below any asymmetry that a person would write.
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=1e-12 * np.max(np.abs(matrix), initial=0.0)):
        raise EstimatorError(f"Filter: {what} is not symmetric.")
    return 0.5 * (matrix + matrix.T)


def positive_definite(matrix: Matrix) -> bool:
    """Return whether a symmetric matrix has a Cholesky factor."""
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return True


def index(who: str, kind: str, name: str, names: tuple[str, ...]) -> int:
    """Return the index of `name` in `names`.

    Raises:
        EstimatorError: `names` does not contain it; the message lists them.
    """
    try:
        return names.index(name)
    except ValueError:
        raise EstimatorError(f"{who}: there is no {kind} '{name}'; there are {', '.join(names) or 'none'}.") from None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FilterContext:
    """Data from which a filter is created; see `railgrip.estimators.design.FilterDesign.of`.

    Attributes:
        prediction: The model, in the form that `FilterKind.form` declares.
        process_noise, reading_noise: Noises of the prediction's states and outputs.
        period: Period of a step [s].
        gate: States that are frozen while an input is small, or None.
        outlier_limit: Largest innovation of each reading that is used, in standard deviations; None uses every reading.
        mean, covariance: Estimate before the first step.
    """

    prediction: Any
    process_noise: Vector
    reading_noise: Vector
    period: float
    gate: Gate | None
    outlier_limit: list[float] | None
    mean: Vector
    covariance: Matrix

    @property
    def arguments(self) -> tuple[Any, Vector, Vector, float, Gate | None, list[float] | None]:
        """Model, noises, period, gate and outlier limit: the arguments of a filter."""
        return (
            self.prediction, self.process_noise, self.reading_noise, self.period, self.gate, self.outlier_limit,
        )  # fmt: skip


class FilterKind:
    """A kind of filter, in a module of `railgrip.estimators.filters` that is named like the kind in a scenario.

    Attributes:
        form: Form of the model in it: equations in CasADi, an FMU, or coupled parts of a train.
    """

    form: ClassVar[Literal["equations", "fmu", "parts"]] = "fmu"

    @classmethod
    def of_context(cls, context: FilterContext) -> Any:
        """Return the filter with its first estimate, a `railgrip.simulate.loop.interfaces.Filter`."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseSet:
    """Noises that a filter assumes: standard deviations by variable, without index.

    Attributes:
        name: Name in reports.
        process: Process noise of the states, in their unit per √s.
        readings: Noise of the readings, in their unit.
        start: Standard deviation of the states at the start, in their unit.
    """

    name: str
    process: Mapping[str, float]
    readings: Mapping[str, float]
    start: Mapping[str, float]

    def process_noise(self, states: Sequence[str]) -> Vector:
        """Return the densities of independent process noises in (unit of the state)²/s, shape (n,)."""
        return self._squares("process noise", self.process, states)

    def reading_noise(self, outputs: Sequence[str]) -> Vector:
        """Return the variances of independent readings, shape (m,)."""
        return self._squares("reading noise", self.readings, outputs)

    def start_covariance(self, states: Sequence[str]) -> Vector:
        """Return the variances of the states at the start, shape (n,)."""
        return self._squares("start", self.start, states)

    def _squares(self, what: str, deviations: Mapping[str, float], names: Sequence[str]) -> Vector:
        missing = sorted({ElementName.of(name).array for name in names} - deviations.keys())
        if missing:
            raise EstimatorError(
                f"Noise set '{self.name}': no {what} for {', '.join(missing)}; it has {', '.join(deviations)}."
            )
        return np.array([deviations[ElementName.of(name).array] for name in names]) ** 2


def _noise_sets() -> dict[str, NoiseSet]:
    tables = tomllib.loads((files("railgrip.estimators") / "noises.toml").read_text(encoding="utf-8"))

    def together(of: str, names: Sequence[str]) -> dict[str, float]:
        return {variable: value for name in names for variable, value in tables[of][name].items()}

    return {
        key: NoiseSet(name=entry["name"], **{of: together(of, entry[of]) for of in ("process", "readings", "start")})
        for key, entry in tables["sets"].items()
    }


NOISE_SETS = _noise_sets()
"""Sets of noises by their names in scenario files."""


def pad_gate(threshold: float, groups: int) -> Gate:
    """Return the gate that freezes the pad friction of each group while its pads are released.

    Args:
        threshold: Cylinder pressure below which pads count as released [Pa]. Where both pads press with 1 to 2 kN, of
            56 kN at full brake, their torque is within the errors of the other torques.
        groups: Number of brake groups.
    """
    return Gate(
        states=tuple(f"pad_friction[{i}]" for i in range(1, groups + 1)),
        inputs=tuple(f"cylinder_pressure[{i}]" for i in range(1, groups + 1)),
        threshold=threshold,
    )
