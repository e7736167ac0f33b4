"""A Kalman filter whose cost is linear in the number of parts of a train (bogies or groups), and its prediction.

The prediction is composed of parts that share only the speed and acceleration of the train.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from itertools import pairwise
from typing import Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.compiled import StepInC
from railgrip.estimators.design import FilterContext, FilterDesign, FilterKind, Gate, index
from railgrip.estimators.model_in_c import LANES, places, table
from railgrip.fmus.native import Model
from railgrip.fmus.native.c_source import in_c


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """Wheelsets that are coupled to others only by the speed and acceleration of the train: a bogie or a group.

    Attributes:
        model: Equations of the part. Its last input is `acceleration`, in which the equations are linear; its only
            output is the braking force.
        parameters: Parameters of the model, in its order.
        states: Names of the states in the whole train, in the model's order.
        inputs: Names of the inputs in the whole train, without the acceleration.
        readings: Pairs of a reading and the state that it measures, by their names in the whole train.
    """

    model: Model
    parameters: Vector
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    readings: tuple[tuple[str, str], ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Consist:
    """Parts and the body that they brake.

    States are the speed, then those of each part. Readings are the speed, then those of each part, then the
    acceleration.

    Attributes:
        body: Model with one state v, inputs force and track_force, and the output acceleration.
        body_parameters: Parameters of the body, in its order.
        parts: Parts, leading one first.
    """

    body: Model
    body_parameters: Vector
    parts: Sequence[Part]

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return ("speed", *(name for part in self.parts for name in part.states))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs: pressures, then the force of the track."""
        return (*(name for part in self.parts for name in part.inputs), "track_force")

    @property
    def readings(self) -> tuple[tuple[str, str | None], ...]:
        """Name of each reading and of the state that it measures, None for the acceleration."""
        return (("speed", "speed"), *(pair for part in self.parts for pair in part.readings), ("acceleration", None))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the readings."""
        return tuple(name for name, _ in self.readings)

    @property
    def parameters(self) -> Vector:
        """Parameters of the body, then those of each part, shape (np,)."""
        return np.concatenate([self.body_parameters, *(part.parameters for part in self.parts)])


def part_equations(model: Model, kind: int) -> dict[str, ca.Function]:
    """Return the equations of a part for the decentralised filter, as functions of (x, u, p) whose names end in `kind`.

    `slope` returns ẋ at zero acceleration and the braking force; `linear` returns the same, and the derivatives of ẋ by
    the acceleration, of the force by x and of ẋ by x; `force` returns the braking force and its derivative by x.

    Raises:
        EstimatorError: The equations are not linear in the acceleration, or the force depends on it.
    """
    t = 0.0
    x, u, p = (ca.SX.sym(s, len(v)) for s, v in (("x", model.states), ("u", model.inputs), ("p", model.parameters)))
    slope, force = model.derivative(t, x, u, p), model.output(t, x, u, p)
    push = ca.jacobian(slope, u[-1])
    if ca.depends_on(push, ca.vertcat(x, u)) or ca.depends_on(force, u[-1]):
        raise EstimatorError(f"{model}: a part of a train is linear in its acceleration, and its force free of it.")
    pull = ca.jacobian(force, x)
    each = {
        "slope": [slope, force],
        "linear": [slope, force, push, pull, ca.jacobian(slope, x).T],
        "force": [force, pull],
    }
    # Dense, as the C code expects; transposed, because CasADi stores matrices by columns.
    return {
        name: ca.Function(f"{name}_{kind}", [x, u, p], [ca.densify(value) for value in values])
        for name, values in each.items()
    }


RANK = 9
"""Number of common unknowns: on the two-part train, deviations are within 0.1 % of those of the central filter."""

_SOURCES = ("dispatch.c", "lanes.h", "plain.c", "wide.c")


class DecentralisedFilter(StepInC, FilterKind):
    """An extended Kalman filter whose covariance is D + U C Uᵀ, D block diagonal by parts, U with `RANK` columns.

    Parts are coupled only by the acceleration of the train, which is a sum over all of them: through it each part
    affects the speed and the frames of the others, and its reading depends on all parts. The error is x = ξ + U η, with
    ξ independent between parts and a few common unknowns η. A reading of a part changes the part's block of D, its rows
    of U, and the small matrix C; the acceleration adds columns to U. A step adds three columns, and then the three of
    least effect are removed: in units of D the directions are orthogonal, each with one eigenvalue λ > −1. Removed
    directions with positive λ are added to D, and those with negative λ (information about a sum) are dropped, so that
    the covariance is never smaller than that of the full filter. With as many columns as there are directions both are
    equal. The cost is linear in the number of parts and cubic in `RANK`.

    A frozen state is a consider state as in `ExtendedKalmanFilter`, except for the covariance between frozen states of
    different parts: its mean and its covariance within its part are kept. Its derivative must be zero anyway.

    Args:
        consist: The train.
        process_noise, …: See `FilterDesign.of`; noises are independent, shapes (n,) and (m,).

    Attributes:
        mean: Estimate after the last step, shape (n,). This and the following arrays are views of the filter's memory.
        covariance: Variances on the diagonal of a matrix, shape (n, n); `joint` returns the full covariance.
        inputs: Inputs of the next step, shape (nu,).
        readings: Readings of the next step, shape (m,).
        selection: 1 for every reading that the last step used, shape (m,).

    Raises:
        EstimatorError: The arguments do not match each other.
        railgrip.base.errors.CompilerMissing: There is no C compiler on this machine.

    Sources: Friedland, Treatment of Bias in Recursive Filtering, IEEE Trans. Automatic Control 14 (1969), for the
    shared unknowns; Pnevmatikakis, Rahnama Rad, Huggins, Paninski, Fast Kalman Filtering and Forward–Backward Smoothing
    via a Low-Rank Perturbative Approach, J. Computational and Graphical Statistics 23 (2014), for the truncation.
    """

    form = "parts"

    def __init__(
        self,
        consist: Consist,
        process_noise: ArrayLike,
        reading_noise: ArrayLike,
        period: float,
        gate: Gate | None = None,
    ) -> None:
        """Check the arguments, generate and compile the step, and initialise its memory."""
        self.consist = consist
        self.design = design = FilterDesign.of(consist, process_noise, reading_noise, period, gate, None, 4)
        for what, matrix in (("process_noise", design.process_noise), ("reading_noise", design.reading_noise)):
            if np.count_nonzero(matrix - np.diag(np.diag(matrix))):
                raise EstimatorError(f"DecentralisedFilter: {what} must be independent for each state or reading.")
        tables = _tables(consist, design)
        first, width, n, m = tables["PART_STATE"], _width(consist), len(design.states), len(design.outputs)
        sizes = {
            "MEAN": n, "COVARIANCE": n * n, "INPUT": len(design.inputs), "READING": m, "USED": m, "SQUARED": 1,
            "PARAMETERS": consist.parameters.size, "PART_COVARIANCE": (len(first) - 1) * width * width,
            "SHARED": n * RANK, "COMMON": RANK, "PUSH": n, "NOISE": n, "READING_NOISE": m, "PERIOD": 1, "THRESHOLD": 1,
        }  # fmt: skip
        at = places(sizes)
        self._block = block = np.zeros(sum(sizes.values()))
        self.mean, self.covariance = block[at["MEAN"]], block[at["COVARIANCE"]].reshape(n, n)
        self.inputs, self.readings, self.selection = (block[at[name]] for name in ("INPUT", "READING", "USED"))
        self._nis, self._common = block[at["SQUARED"]], block[at["COMMON"]]
        self._block_diagonal = block[at["PART_COVARIANCE"]].reshape(-1, width, width)
        self._directions = block[at["SHARED"]].reshape(n, RANK)
        self._members = [slice(a, b) for a, b in pairwise(first)]
        block[at["PARAMETERS"]] = consist.parameters
        block[at["NOISE"]] = np.diag(design.process_noise)
        block[at["READING_NOISE"]] = np.diag(design.reading_noise)
        block[at["PERIOD"]], block[at["THRESHOLD"]] = design.period, design.gate_threshold
        numbers = {name: place.start for name, place in at.items()} | {
            "N": n, "M": m, "RANK": RANK, "WIDTH": width, "LENGTH": -(-(RANK + 3) // LANES) * LANES,
            "PARTS": len(self._members), "GATES": len(design.gated_states),
            "BLOCK": block.size, "TRACK_FORCE": design.inputs.index("track_force"),
        }  # fmt: skip
        sources = _sources(
            tuple(dict.fromkeys(part.model for part in consist.parts)),
            consist.body,
            tuple(numbers.items()),
            tuple((name, tuple(values)) for name, values in tables.items()),
        )
        self.load(dict(sources))

    @classmethod
    def of_context(cls, context: FilterContext) -> Self:
        """Return the filter of a scenario with its first estimate; it rejects no outliers."""
        filter_ = cls(context.prediction, context.process_noise, context.reading_noise, context.period, context.gate)
        filter_.start(context.mean, context.covariance)
        return filter_

    def start(self, mean: ArrayLike, covariance: ArrayLike) -> None:
        """Set the estimate before the first step: mean (n,), and variances (n,) or covariance (n, n) of the states.

        Raises:
            EstimatorError: Wrong shapes, no covariance, or states that are not independent.
        """
        first = self.design.start(mean, covariance)
        if np.count_nonzero(first.covariance) > len(first.mean):
            raise EstimatorError("start: the states of a decentralised filter are independent before the first step.")
        self.mean[:], self.covariance[:] = first.mean, first.covariance
        self._block_diagonal[:], self._directions[:], self._common[:] = 0.0, 0.0, 0.0
        for part, members in enumerate(self._members):
            size = members.stop - members.start
            self._block_diagonal[part, :size, :size] = first.covariance[members, members]

    def joint(self) -> Matrix:
        """Return the covariance of all states, shape (n, n)."""
        covariance = (self._directions * self._common) @ self._directions.T
        for part, members in enumerate(self._members):
            size = members.stop - members.start
            covariance[members, members] += self._block_diagonal[part, :size, :size]
        return covariance


def _width(consist: Consist) -> int:
    return -(-max(len(part.states) for part in consist.parts) // LANES) * LANES


def _tables(consist: Consist, design: FilterDesign) -> dict[str, list[int]]:
    models = list(dict.fromkeys(part.model for part in consist.parts))
    starts = np.cumsum([0, 1, *(len(part.states) for part in consist.parts)]).tolist()
    state_of = [-1 if state is None else design.states.index(state) for _, state in consist.readings]
    inputs = [index("Part", "input", name, design.inputs) for part in consist.parts for name in part.inputs]
    return {
        "PART_STATE": starts,
        "KIND": [0, *(models.index(part.model) for part in consist.parts)],
        "PART_PARAMETER": np.cumsum(
            [0, consist.body_parameters.size, *(part.parameters.size for part in consist.parts)]
        ).tolist(),
        "PART_INPUT": np.cumsum([0, 0, *(len(part.inputs) for part in consist.parts)]).tolist(),
        "INPUT_PLACE": inputs,
        "READING_STATE": state_of,
        "READING_PART": [-1 if s < 0 else int(np.searchsorted(starts, s, side="right")) - 1 for s in state_of],
        "GATE_STATE": list(design.gated_states),
        "GATE_PART": [int(np.searchsorted(starts, s, side="right")) - 1 for s in design.gated_states],
        "GATE_INPUT": list(design.gating_inputs),
    }


@lru_cache(maxsize=16)
def _sources(
    models: tuple[Model, ...],
    body: Model,
    numbers: tuple[tuple[str, int], ...],
    tables: tuple[tuple[str, tuple[int, ...]], ...],
) -> tuple[tuple[str, str], ...]:
    kinds = [part_equations(model, kind) for kind, model in enumerate(models)]
    v, u, p = ca.SX.sym("v"), ca.SX.sym("u", 2), ca.SX.sym("p", len(body.parameters))
    acceleration = body.output(0.0, v, u, p)
    slopes = [ca.densify(ca.jacobian(acceleration, symbol)) for symbol in (v, u[0])]
    moving = ca.Function("body", [v, u, p], [acceleration, *slopes])
    functions = [moving, *(function for kind in kinds for function in kind.values())]
    workspace, text = in_c(functions)
    pointers = [
        f"static int (*const {name.upper()}[])(const double **, double **, casadi_int *, double *, int) = "
        f"{{{', '.join(f'{name}_{kind}' for kind in range(len(kinds)))}}};"
        for name in kinds[0]
    ]
    shape = (
        "#define CASADI_SYMBOL_EXPORT static",
        *(f"#define {name} {number}" for name, number in (*numbers, *workspace.items())),
        *(table(name, values) for name, values in tables),
        text,
        *pointers,
    )
    kernel = files("railgrip.estimators") / "kernel"
    texts = {name: (kernel / name).read_text(encoding="utf-8") for name in _SOURCES}
    step = (kernel / "parts.h").read_text(encoding="utf-8")
    return tuple((texts | {"step.h": step, "shape.h": "\n".join(shape)}).items())
