"""FMUs of small Modelica models, returned by the fixtures of this folder."""

from dataclasses import dataclass, field
from pathlib import Path

import fmpy
import numpy as np
import rumoca
from fmpy.fmi2 import FMU2Model, FMU2Slave

FEATURES = Path(__file__).parent / "modelica" / "Features"


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


@dataclass(slots=True)
class Running:
    """An instance between initialisation and termination, addressed by names."""

    fmu: Fmu
    instance: FMU2Slave | FMU2Model
    messages: list[str] = field(default_factory=list)

    def get(self, *names: str) -> list[float]:
        return self.instance.getReal([self.fmu.reference(n) for n in names])

    def count(self, name: str) -> int:
        return self.instance.getInteger([self.fmu.reference(name)])[0]

    def set(self, **values: float) -> None:
        self.instance.setReal([self.fmu.reference(n) for n in values], list(values.values()))

    def steps(self, count: int, size: float, first: int = 0) -> None:
        for k in range(first, first + count):
            self.instance.doStep(k * size, size)


def reference_run(library: Path, class_name: str, stop: float, step: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the grid points without a nearby event, and rumoca's own simulation at these.

    Near an event one of two simulators is earlier by a rounding error, so 2 ms on either side are excluded.
    """
    model = rumoca.Session(roots=[str(library.parent)]).load(str(library / "package.mo"), model=class_name)
    result = model.simulate((0, stop), dt=step, config=rumoca.SimConfig(solver="bdf", rtol=1e-10, atol=1e-12))
    time = np.asarray(result.time)
    doubled = time[np.flatnonzero(np.diff(time) < 1e-9)]
    on_grid = np.abs(time - np.round(time / step) * step) < 1e-9
    clear = np.array([np.all(np.abs(t - doubled) > 2e-3) for t in time])
    keep = on_grid & clear
    return time[keep], {name: np.asarray(result[name])[keep] for name in result.names if name != "time"}
