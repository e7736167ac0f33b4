"""A co-simulation FMU that is stepped through FMPy."""

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


class Slave:
    """An instance of an FMU, initialised in `with`; values are set and returned by names of variables."""

    def __init__(self, path: Path, start: Mapping[str, float] | None = None) -> None:
        description = read_model_description(str(path))
        self.start = dict(start or {})
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.of = {c: [v.name for v in description.modelVariables if v.causality == c] for c in ("input", "output")}
        self.fmu = FMU2Slave(
            guid=description.guid, unzipDirectory=extract(str(path)), instanceName="one",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip

    def __enter__(self) -> "Slave":
        self.fmu.instantiate()
        self.initialise()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, of: TracebackType | None) -> None:
        self.fmu.freeInstance()

    def initialise(self) -> None:
        self.set(**self.start)
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, **values: float) -> None:
        self.fmu.setReal([self.reference[name] for name in values], list(values.values()))

    def get(self, *names: str) -> list[float]:
        return self.fmu.getReal([self.reference[name] for name in names])

    def step(self, sample: int, period: float, **values: float) -> None:
        """Hold inputs over a step."""
        self.set(**values)
        self.fmu.doStep(sample * period, period)
