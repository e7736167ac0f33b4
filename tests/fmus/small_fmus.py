"""FMUs of small Modelica models, returned by the fixtures of this folder."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np
import pytest
import rumoca
from slave import Slave

FEATURES = Path(__file__).parent / "modelica" / "Features"
INTERFACES = ["CoSimulation", "ModelExchange"]
SCOPE = {
    "mod": np.mod, "rem": np.fmod, "floor": np.floor, "ceil": np.ceil, "integer": np.floor, "sign": np.sign,
    "abs": np.abs, "min": np.minimum, "max": np.maximum, "sin": np.sin, "div": lambda a, b: np.trunc(a / b),
}  # fmt: skip
"""Functions of Modelica in numpy."""


@dataclass(frozen=True, slots=True)
class Fmu:
    """A built FMU: the archive, its unpacked folder and its description."""

    path: Path
    folder: Path
    description: fmpy.model_description.ModelDescription

    def reference(self, name: str) -> int:
        return next(v.valueReference for v in self.description.modelVariables if v.name == name)

    def names(self, causality: str, *types: str) -> list[str]:
        return [
            v.name for v in self.description.modelVariables
            if v.causality == causality and (not types or v.type in types)
        ]  # fmt: skip


def write_files(folder: Path, files: Mapping[str, str | bytes]) -> Path:
    """Write files into a folder by their paths in it, and return the folder."""
    for name, content in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content.encode() if isinstance(content, str) else content)
    return folder


def check_directional_derivatives(
    instance: Slave, unknown: list[str], known: list[str], *, least: float = 1.0, rounding: float = 0.0
) -> None:
    """Compare the FMU's own derivatives of variables, by each of others, with central differences.

    Truncation and rounding of the differences allow 1e-5 of a value, and `rounding` of its size over the step,
    which is 1e-6 of the variable or of `least`.
    """
    references = [instance.reference[n] for n in unknown]
    for name in known:
        (x,) = instance.get(name)
        h = 1e-6 * max(abs(x), least)
        sides = []
        for shifted in (x + h, x - h):
            instance.set(**{name: shifted})
            sides.append(np.array(instance.get(*unknown)))
        instance.set(**{name: x})
        given = np.array(instance.fmu.getDirectionalDerivative(references, [instance.reference[name]], [1.0]))
        error = 1e-5 + np.max(rounding * np.maximum(np.abs(sides[0]), 1) / h)
        assert given == pytest.approx((sides[0] - sides[1]) / (2 * h), rel=1e-5, abs=error), name


def reference_run(library: Path, class_name: str, stop: float, step: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the grid points without a nearby event, and rumoca's own simulation at these."""
    model = rumoca.Session(roots=[str(library.parent)]).load(str(library / "package.mo"), model=class_name)
    result = model.simulate((0, stop), dt=step, config=rumoca.SimConfig(solver="bdf", rtol=1e-10, atol=1e-12))
    keep = away_from_events(np.asarray(result.time), step, 2e-3)
    found = {name: np.asarray(result[name])[keep] for name in result.names if name != "time"}
    return np.asarray(result.time)[keep], found


def away_from_events(time: np.ndarray, step: float, margin: float) -> np.ndarray:
    """Return which times of a simulation are on the grid and away from events, which are there twice.

    Near an event one of two simulators is earlier by a rounding error.
    """
    doubled = time[np.flatnonzero(np.diff(time) < 1e-9)]
    clear = np.array([np.all(np.abs(t - doubled) > margin) for t in time])
    return (np.abs(time - np.round(time / step) * step) < 1e-9) & clear


def simulated(
    file: Path, inputs: Mapping[str, float], outputs: Sequence[str], until: float, step: float, **settings: object
) -> np.ndarray:
    """Return outputs on a grid as columns by name, from FMPy, under constant inputs."""
    signals = np.array(
        [(t, *inputs.values()) for t in (0.0, until)], dtype=[("time", float), *((n, float) for n in inputs)]
    )
    return fmpy.simulate_fmu(
        str(file), stop_time=until, output_interval=step, input=signals, output=list(outputs), **settings
    )


def trajectory(
    fmu: Fmu, interface: str, *names: str, stop: float = 1.0, step: float = 0.1, **start: float
) -> list[list[float]]:
    """Return the values of variables at each communication point."""
    found = fmpy.simulate_fmu(
        str(fmu.folder), stop_time=stop, output=names, output_interval=step, fmi_type=interface, start_values=start,
        record_events=False,
    )  # fmt: skip
    return [found[name].astype(float).tolist() for name in names]


def compare(names: Sequence[str], found: np.ndarray, time: np.ndarray, expected: Mapping[str, np.ndarray]) -> None:
    """Compare columns with expected values at some times, within 1e-5 of the largest value."""
    for n in names:
        seen = np.interp(time, found["time"], found[n].astype(float))
        scale = np.max(np.abs(expected[n]))
        assert np.max(np.abs(seen - expected[n])) <= 1e-5 * scale + 1e-9, n
