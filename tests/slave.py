"""A co-simulation FMU that is stepped through FMPy."""

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi2 import fmi2CallbackAllocateMemoryTYPE as AllocateType
from fmpy.fmi2 import fmi2CallbackFreeMemoryTYPE as FreeType


class Slave:
    """An instance of an FMU, initialised in `with`; values are set and returned by names of variables.

    Attributes:
        fmu: The instance of FMPy, by Co-Simulation, or by Model Exchange if `interface` is "me".
        messages: What it has logged.
    """

    def __init__(
        self,
        path: Path,
        start: Mapping[str, float] | None = None,
        *,
        folder: Path | None = None,
        interface: str = "cs",
        time: float = 0.0,
        messages: list[str] | None = None,
    ) -> None:
        description = read_model_description(str(path))
        self.start, self.time = dict(start or {}), time
        self.messages = [] if messages is None else messages
        self.variables = {v.name: v for v in description.modelVariables}
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.of = {c: [v.name for v in description.modelVariables if v.causality == c] for c in ("input", "output")}
        kind, of_kind = (
            (FMU2Slave, description.coSimulation) if interface == "cs" else (FMU2Model, description.modelExchange)
        )
        self.fmu = kind(
            guid=description.guid, unzipDirectory=str(folder or extract(str(path))), instanceName="one",
            modelIdentifier=of_kind.modelIdentifier,
        )  # fmt: skip
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = fmi2CallbackLoggerTYPE(lambda *call: self.messages.append(call[4].decode()))
        self._callbacks.allocateMemory, self._callbacks.freeMemory = AllocateType(), FreeType()

    def __enter__(self) -> "Slave":
        self.fmu.instantiate(callbacks=self._callbacks)
        self.initialise()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, of: TracebackType | None) -> None:
        self.fmu.freeInstance()

    def initialise(self) -> None:
        self.fmu.setupExperiment(startTime=self.time)
        for name, value in self.start.items():
            getattr(self.fmu, f"set{self.variables[name].type}")([self.reference[name]], [value])
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, **values: float) -> None:
        self.fmu.setReal([self.reference[name] for name in values], list(values.values()))

    def get(self, *names: str) -> list[float]:
        return self.fmu.getReal([self.reference[name] for name in names])

    def count(self, name: str) -> int:
        return self.fmu.getInteger([self.reference[name]])[0]

    def step(self, sample: int, period: float, **values: float) -> None:
        """Hold inputs over a step."""
        self.set(**values)
        self.fmu.doStep(sample * period, period)

    def steps(self, count: int, size: float, first: int = 0) -> None:
        for k in range(first, first + count):
            self.fmu.doStep(k * size, size)
