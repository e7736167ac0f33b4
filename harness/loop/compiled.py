"""A plant and compiled filters stepped together in C, over tables of inputs and noise.

For runs of many short steps without a controller: 10 s at 50 µs are 200 000 steps, and a loop in Python would spend
most of its time between them. The plant is any co-simulation FMU; a filter is a `CompiledFilter` whose inputs come from
the table or from integrals of its own states.
"""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.errors import LoopError
from railgrip.estimators.compiled import CompiledFilter
from railgrip.fmu import CoSimulation
from railgrip.fmus.native.toolchain import shared_library

Array = NDArray[np.float64]

KERNEL = files("railgrip.loop") / "kernel" / "run.c"


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Where an input of a filter comes from, at every step.

    Attributes:
        kind: column: of the table of inputs; integral: the input itself, moved on by the period times a state of the
            filter (forward Euler), beginning at what the filter's `inputs` contains.
        name: Of the column, or of the filter's state.
    """

    kind: Literal["column", "integral"]
    name: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Observer:
    """A filter in the loop; its `mean`, `covariance` and `inputs` are where it starts and where it ends.

    Attributes:
        name: For the record.
        filter: Its outputs are the readings, in this order.
        sources: Of every input of the filter.
    """

    name: str
    filter: CompiledFilter
    sources: Mapping[str, Source]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beliefs:
    """What a filter believed at the recorded samples; NaN after it diverged.

    Attributes:
        mean: Shape (k, n).
        covariance: Shape (k, n, n).
        squared_innovation: NIS, shape (k,).
        failure: Outcome of the filter's C step, 0 when fine, as in `railgrip.estimators.compiled.DIVERGED`.
        failure_sample: Sample at which it diverged, or −1.
    """

    mean: Array
    covariance: Array
    squared_innovation: Array
    failure: int
    failure_sample: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Record:
    """Every `every`-th sample of a run.

    Attributes:
        sample: Counts from the plant's start, shape (k,).
        outputs: Of the plant, without noise, shape (k, ny).
        beliefs: By name of the observer.
    """

    sample: NDArray[np.int64]
    outputs: Array
    beliefs: Mapping[str, Beliefs]


class _Filter(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("advance", "block", "mean", "covariance", "held", "seen", "squared")),
        *((name, ctypes.c_void_p) for name in ("kind", "from_", "means", "covariances", "squares")),
        *((name, ctypes.c_longlong) for name in ("states", "width", "inputs", "failed", "failed_at")),
    )


class _Run(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("cross", "plan", "to", "outputs")),
        *((name, ctypes.c_longlong) for name in ("n_inputs", "n_columns", "n_outputs", "n_readings", "n_filters")),
        ("period", ctypes.c_double),
        *((name, ctypes.c_longlong) for name in ("count", "every")),
        *((name, ctypes.c_void_p) for name in ("inputs", "noise", "shown", "record", "filter")),
        *((name, ctypes.c_longlong) for name in ("first", "done")),
    )


_KINDS = {"column": 0, "integral": 1}


def run(
    plant: CoSimulation,
    inputs: Array,
    *,
    further: Sequence[str] = (),
    readings: Sequence[str],
    noise: Array,
    observers: Sequence[Observer] = (),
    every: int = 1,
) -> Record:
    """Step a started plant and its observers through a table of inputs; call again to go on.

    Args:
        plant: Where it stands is where the run begins.
        inputs: Row k is held during step k, shape (K, nu + number of `further`).
        further: Names of columns after those of the plant's inputs, for observers.
        readings: Outputs of the plant that the observers see.
        noise: Added to the readings at the end of step k, shape (K, m).
        observers: Filters whose outputs are the readings, with the plant's period.
        every: Samples from one row of the record to the next.

    Raises:
        LoopError: Shapes, names or periods do not fit.
        PlantFailed: Raised by the plant's `note_steps`.
    """
    interface = plant.c_interface()
    table, noises = (np.ascontiguousarray(values, dtype=np.float64) for values in (inputs, noise))
    steps, columns = len(table), (*interface.input_names, *further)
    if table.shape != (steps, len(columns)) or noises.shape != (steps, len(readings)):
        raise LoopError(
            f"run: wants inputs of shape (K, {len(columns)}) for {', '.join(columns)} and noise of "
            f"(K, {len(readings)}) for {', '.join(readings)}; got {table.shape} and {noises.shape}."
        )
    if every < 1:
        raise LoopError(f"run: every counts samples, 1 or more, got {every}.")
    if not np.all(np.isfinite(table)):
        raise LoopError("run: the table of inputs holds a value that is not a finite number.")
    places = np.array([_index("reading", name, interface.output_names) for name in readings], dtype=np.intc)
    rows = steps // every
    outputs = np.empty((rows, interface.outputs.size))
    beside = [_Beside(observer, interface.period, columns, tuple(readings), rows) for observer in observers]
    filters = (_Filter * max(len(beside), 1))(*(one.struct for one in beside))
    plan = _Run(
        cross=interface.cross, plan=interface.plan, to=_at(interface.inputs), outputs=_at(interface.outputs),
        n_inputs=interface.inputs.size, n_columns=len(columns), n_outputs=interface.outputs.size,
        n_readings=len(readings), n_filters=len(beside), period=interface.period, count=steps, every=every,
        inputs=_at(table), noise=_at(noises), shown=_at(places),
        record=_at(outputs), filter=ctypes.addressof(filters), first=interface.sample,
    )  # fmt: skip
    code = _library().run(ctypes.byref(plan))
    plant.note_steps(plan.done, code)
    return Record(
        sample=interface.sample + every * np.arange(1, rows + 1),
        outputs=outputs,
        beliefs={one.name: one.beliefs(filters[i], interface.sample) for i, one in enumerate(beside)},
    )


class _Beside:
    """The memory of one observer during a run."""

    def __init__(
        self,
        observer: Observer,
        period: float,
        columns: tuple[str, ...],
        readings: tuple[str, ...],
        rows: int,
    ) -> None:
        of, design = observer.filter, observer.filter.design
        who = f"run: observer '{observer.name}'"
        if tuple(design.outputs) != readings:
            raise LoopError(f"{who} sees {', '.join(design.outputs)}, the readings are {', '.join(readings)}.")
        if design.period != period:
            raise LoopError(f"{who} has a period of {design.period} s, the plant {period} s; give both one.")
        if set(observer.sources) != set(design.inputs):
            raise LoopError(
                f"{who} wants a source for each of {', '.join(design.inputs)}; got {', '.join(observer.sources)}."
            )
        names = {"column": columns, "integral": tuple(design.states)}
        sources = [observer.sources[name] for name in design.inputs]
        n = len(design.states)
        self.name = observer.name
        self._kind = np.array([_KINDS[source.kind] for source in sources], dtype=np.intc)
        self._from = np.array(
            [_index(source.kind, source.name, names[source.kind]) for source in sources], dtype=np.intc
        )
        self._means, self._covariances, self._squares = np.empty((rows, n)), np.empty((rows, n, n)), np.empty(rows)
        advance, block, nis = of.entry
        self.struct = _Filter(
            advance=advance, block=block, mean=_at(of.mean), covariance=_at(of.covariance),
            held=_at(of.inputs), seen=_at(of.readings), squared=nis, kind=_at(self._kind), from_=_at(self._from),
            means=_at(self._means), covariances=_at(self._covariances), squares=_at(self._squares),
            states=n, width=of.covariance.strides[0] // of.covariance.itemsize, inputs=len(sources),
        )  # fmt: skip

    def beliefs(self, after: Any, first: int) -> Beliefs:
        return Beliefs(
            mean=self._means,
            covariance=self._covariances,
            squared_innovation=self._squares,
            failure=after.failed,
            failure_sample=first + after.failed_at + 1 if after.failed else -1,
        )


@cache
def _library() -> ctypes.CDLL:
    library = ctypes.CDLL(str(shared_library({"run.c": KERNEL.read_text(encoding="utf-8")}, "run", flags=("-O3",))))
    library.run.argtypes, library.run.restype = [ctypes.c_void_p], ctypes.c_int
    return library


def _at(array: NDArray[Any]) -> int:
    return array.ctypes.data


def _index(kind: str, name: str, names: Sequence[str]) -> int:
    if name not in names:
        raise LoopError(f"run: there is no {kind} '{name}'; there are {', '.join(names) or 'none'}.")
    return list(names).index(name)
