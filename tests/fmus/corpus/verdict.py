"""Simulation of cases by the FMU of the built-in compiler, and comparison with their expected values."""

import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import fmpy
import numpy as np
from corpus.case import Case, Function, library

from railgrip.base.errors import InputError
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.package import pack, sources
from railgrip.fmus.native.system import explicit

STOP, STEP = 1.0, 0.0137
"""End and output interval of each simulation [s]; the times of events are not multiples of the interval."""

NEAR = 1e-6
"""Where a value jumps, that of either side is right within this time [s], the error of a state over its slope."""

Values = dict[str, np.ndarray]

PLACE = re.compile(r"Corpus\.mo:\d+")


INTERFACES = ("CoSimulation", "ModelExchange")


def simulate(text: str, names: Sequence[str], interfaces: Sequence[str] = INTERFACES) -> dict[str, Values] | str:
    """Return the trajectories of `Corpus.All` by interface, or why the simulation failed.

    Errors are texts, because those of FMPy and rumoca cannot be sent from one process to another.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "Corpus.mo")
        file.write_text(text)
        try:
            source = sources(explicit(read("Corpus.All", file)), interfaces=("me", "cs"))
        except InputError as refusal:
            return f"refused: {refusal}"
        except BaseException as error:  # rumoca's PanicException does not derive from Exception
            return f"internal error: {type(error).__name__}: {error}"
        try:
            fmu = pack(source, file.with_suffix(".fmu"), flags=("-O0",))
            return {interface: run(fmu, names, interface) for interface in interfaces}
        except Exception as error:
            return f"failed: {error}"


def run(fmu: Path, names: Sequence[str], interface: str) -> Values:
    """Return the trajectories of variables."""
    settings = {"relative_tolerance": 1e-9} if interface == "ModelExchange" else {"start_values": {"_tolerance": 1e-8}}
    found = fmpy.simulate_fmu(
        str(fmu), validate=False, fmi_type=interface, stop_time=STOP, output_interval=STEP, step_size=STEP,
        output=list(names), record_events=False, **settings,
    )  # fmt: skip
    return {name: found[name].astype(float) for name in ("time", *names)}


def deviation(time: np.ndarray, seen: np.ndarray, expected: Function, tolerance: float) -> str | None:
    """Return the first value that is wrong, None if all are right."""
    around = np.array([[expected(max(t + shift, 0.0)) for shift in (-NEAR, 0.0, NEAR)] for t in time.tolist()])
    margin = tolerance * max(1.0, np.max(np.abs(around)))
    wrong = ~((seen >= around.min(axis=1) - margin) & (seen <= around.max(axis=1) + margin))
    if not wrong.any():
        return None
    k = int(np.argmax(wrong))
    return f"at {time[k]:.4f} s it is {seen[k]:.9g}, expected {around[k, 1]:.9g} ({int(wrong.sum())} of {len(time)})"


Simulate = Callable[[str, Sequence[str]], Mapping[str, Values] | str]


def judge(cases: Sequence[Case], simulate: Simulate) -> dict[str, str]:
    """Return the verdict on each case that is not right, by its name.

    The cases are simulated in one FMU. If that fails, each is simulated alone.
    """
    places = [(f"c{k}.{variable}", case, expected) for k, case in enumerate(cases)
              for variable, expected in case.expected.items()]  # fmt: skip
    try:
        result = simulate(library(cases), [name for name, _, _ in places])
    except Exception as error:
        result = f"ended: {error!r}"  # no answer in time, or a crash
    if isinstance(result, str):
        if len(cases) == 1:
            is_named = not result.startswith("refused") or PLACE.search(result)
            return {cases[0].name: result if is_named else f"refused without a place: {result}"}
        middle = len(cases) // 2
        return judge(cases[:middle], simulate) | judge(cases[middle:], simulate)
    found: dict[str, str] = {}
    for interface, values in result.items():
        for name, case, expected in places:
            problem = deviation(values["time"], values[name], expected, case.tolerance)
            if problem:
                found[case.name] = f"wrong: {interface}: {name.partition('.')[2]}: {problem}\n{case.text}"
    return found
