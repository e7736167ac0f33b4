"""Two FMUs of one class are compared: variables by name, whatever order and parameters each compiler gives them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from small_fmus import simulated
from test_train_fmus import HELD, held

from railgrip.fmi import CoSimulation, Description, Port, bind

STOP, STEP = 3.0, 0.015
AT_REST = 1e-12
"""Values that count as zero: at standstill OpenModelica's speed is 4e-21 m/s, that of the built-in compiler 0."""


@dataclass(frozen=True, slots=True)
class Pair:
    """One class from both compilers."""

    ours: Description
    theirs: Description


def nudged(fmus: Pair) -> dict[str, float]:
    """Return every real parameter that both offer, one per cent below its default, where its bounds allow.

    The effect of parameters that a compiler has evaluated is in the trajectories.
    """
    parameters = [fmus.ours.variables[n] for n in fmus.ours.names("parameter") if n in fmus.theirs.names("parameter")]
    values = {v.name: 0.99 * float(v.start or 0) for v in parameters if v.kind == "Real"}
    lower = {v.name: -np.inf if v.minimum is None else v.minimum for v in parameters}
    upper = {v.name: np.inf if v.maximum is None else v.maximum for v in parameters}
    return {n: x for n, x in values.items() if lower[n] <= x <= upper[n]}


def integrated(
    description: Description, inputs: Mapping[str, float], start: Mapping[str, float], until: float = STOP
) -> np.ndarray:
    """Return all outputs on the grid as columns by name, from CVODE in FMPy."""
    return simulated(
        description.file, inputs, description.names("output"), until, STEP,
        validate=False, fmi_type="ModelExchange", record_events=False, relative_tolerance=1e-9,
        start_values=dict(start),
    )  # fmt: skip


def stepped(
    description: Description, values: Mapping[str, float], parameters: Mapping[str, float], until: float = STOP
) -> dict[str, np.ndarray]:
    """Return each output by its name after each millisecond; the built-in solver uses a tolerance of 1e-8."""

    def signals(causality: str) -> list[Port]:
        return [
            Port(name=n, unit=description.variables[n].unit or "1", size=0, needed=True)
            for n in description.names(causality)
        ]

    binding = bind(description, inputs=signals("input"), outputs=signals("output"))
    inputs = np.array([held(n, values) for n in binding.inputs.elements])
    own = {"_tolerance": 1e-8} if "_tolerance" in description.variables else {}
    with CoSimulation(description, binding, period=1e-3, parameters={**own, **parameters}) as plant:
        plant.start(inputs)
        rows = np.array([plant.step(inputs) for _ in range(round(until / 1e-3))])
    return dict(zip(binding.outputs.elements, rows.T, strict=True))


def disagreement(ours: np.ndarray, theirs: np.ndarray, booleans: tuple[str, ...]) -> dict[str, float]:
    """Return for each column the largest difference over its largest value.

    Rows next to one where a Boolean changes are excluded: one run reaches the event earlier by a rounding error.
    """
    assert len(ours) == len(theirs)
    turned = np.zeros(len(ours), dtype=bool)
    for n in booleans:
        for run in (ours, theirs):
            turned[1:] |= run[n][1:] != run[n][:-1]
    clear = ~turned
    clear[:-1] &= ~turned[1:]
    worst: dict[str, float] = {}
    for n in ours.dtype.names or ():
        a, b = ours[n][clear].astype(float), theirs[n][clear].astype(float)
        size, difference = np.max(np.abs(a)), np.max(np.abs(a - b))
        worst[n] = 0.0 if difference <= 1e-9 else difference / max(size, 1e-300)
    return worst


def turns(run: np.ndarray) -> int:
    """Return the index of the first row that equals the last one."""
    return int(np.argmax(np.abs(run - run[-1]) <= AT_REST))


__all__ = ["AT_REST", "HELD", "Pair", "disagreement", "held", "integrated", "nudged", "stepped", "turns"]
