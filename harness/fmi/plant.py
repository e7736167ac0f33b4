"""A plant that is an FMU: its life cycle from `with` over start and steps to the first failure."""

from abc import ABC, abstractmethod
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from math import isclose, isfinite
from pathlib import Path
from types import TracebackType
from typing import ClassVar, Final, Self

import numpy as np

from railgrip.base.arrays import Vector
from railgrip.base.errors import FmuError, PlantFailed
from railgrip.fmi.description import Description
from railgrip.fmi.instance import Instance, Way, unpack
from railgrip.fmi.mapping import Binding
from railgrip.fmi.parameters import Values, assignments

SILENT_WARNING: Final = "the status of a call was a warning, without a message"


class SteppedPlant(ABC):
    """Base of plants that are stepped by an FMU in any process: step count, time and first failure.

    Attributes:
        sample: Number of steps since the start; −1 before `start`.
    """

    def __init__(
        self, description: Description, binding: Binding, period: float, parameters: Values, begin: float
    ) -> None:
        """Check period [s] and parameters; see `LoadedPlant`.

        The period is constant, as an FMU without canHandleVariableCommunicationStepSize requires.
        """
        if not (isfinite(period) and period > 0):
            raise FmuError(f"{description.file.name}: the communication period is a positive time, got {period} s.")
        step = description.co_simulation.fixed_step if description.co_simulation is not None else None
        if step is not None and not (round(period / step) >= 1 and isclose(period, round(period / step) * step)):
            near = max(round(period / step), 1) * step
            raise FmuError(
                f"{description.file.name}: its internal step is fixed at {step:g} s, and the communication period of "
                f"{period:g} s is not a whole multiple of it; give a multiple in [periods], such as {near:g} s."
            )
        only = description.co_simulation.only_step if description.co_simulation is not None else None
        if only is not None and not isclose(period, only, rel_tol=1e-9):
            raise FmuError(
                f"{description.file.name}: it declares one communication step, stepSize = {only:g} s with "
                f"canHandleVariableCommunicationStepSize = false, and is stepped every {period:g} s; set its period in "
                f'[periods] to "{only:g} s" (communication for a plant, controller for a controller), or export it for '
                "a variable step."
            )
        self._description = description
        self._binding = binding
        self._period, self._begins = period, begin
        self._parameters = dict(parameters)
        self._assignments = assignments(description, parameters)
        self._stack = ExitStack()
        self._failure: PlantFailed | None = None
        self.sample = -1

    @property
    @abstractmethod
    def warnings(self) -> dict[str, int]:
        """Messages of warnings so far, each kind with its number; also after the end of `with`."""

    @property
    def file(self) -> str:
        """Name of the FMU's file."""
        return self._description.file.name

    @property
    def time(self) -> float:
        """Time of the FMU [s]."""
        return self._begins + max(self.sample, 0) * self._period


class LoadedPlant(SteppedPlant):
    """An FMU in this process.

        with CoSimulation(description, binding, period=1e-3, parameters={"mass": 84e3}) as plant:
            outputs = plant.start(inputs)
            while moving:
                outputs = plant.step(inputs)

    Vectors have the layout of `binding.inputs` and `binding.outputs`. After a failed call the instance cannot be used.
    """

    _way: ClassVar[Way] = "co-simulation"

    def __init__(
        self,
        description: Description,
        binding: Binding,
        *,
        period: float,
        parameters: Values,
        begin: float = 0.0,
        folder: Path | None = None,
    ) -> None:
        """Check the arguments; nothing is loaded before `with`.

        Args:
            period: Communication step [s].
            parameters: Values by FMU variable, in the FMU's units.
            begin: Time of the FMU at the start [s].
            folder: Folder of the unpacked FMU; None unpacks it for the duration of the `with`.

        Raises:
            FmuError: A parameter is wrong or the period is not positive.
        """
        super().__init__(description, binding, period, parameters, begin)
        self._folder = folder
        self._instance: Instance | None = None
        self._listened: Instance | None = None
        self._ready = False  # started, not failed, not closed
        self._blank = np.full(binding.outputs.size, np.nan)

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            folder = self._folder or stack.enter_context(unpack(self._description))
            instance = Instance(self._description, self._way, folder, name="plant")
            stack.callback(instance.close)
            instance.assign(self._assignments, self._begins)
            self._instance = self._listened = instance
            self._prepare(instance)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._instance = None
        self._ready = False
        self._stack.close()

    @property
    def warnings(self) -> dict[str, int]:
        """Messages of warnings so far, each kind with its number; also after the end of `with`.

        A call that returned a warning without any message counts as a message that says so.
        """
        if self._listened is None:
            return {}
        messages = self._listened.warnings()
        return messages or ({SILENT_WARNING: self._warned} if self._warned else {})

    @property
    def _warned(self) -> int:
        """Number of calls that returned a warning."""
        return 0

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time.

        Raises:
            PlantFailed: The FMU cannot be initialised.
        """
        instance = self._open()
        if self.sample >= 0:
            raise RuntimeError("a plant is started once; open another one to start again")
        if np.shape(inputs) != (self._binding.inputs.size,):
            raise ValueError(f"the inputs are a vector of {self._binding.inputs.size}, got shape {np.shape(inputs)}")
        with self._remembering():
            instance.enter_initialization(self._begins)
            self._send(inputs)
            self._begin(instance)
            self.sample = 0
            outputs = self._receive()
        self._ready = True
        return outputs.copy()

    @abstractmethod
    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK, or an output is not finite.
        """

    @abstractmethod
    def _prepare(self, instance: Instance) -> None:
        """Prepare buffers that every step uses."""

    @abstractmethod
    def _send(self, inputs: Vector) -> None:
        """Set the inputs."""

    def _begin(self, instance: Instance) -> None:
        instance.exit_initialization()

    @abstractmethod
    def _receive(self) -> Vector:
        """Return the outputs, NaN for outputs that the FMU lacks."""

    def _open(self) -> Instance:
        if self._failure is not None:
            raise self._failure
        if self._instance is None:
            raise RuntimeError(f"a {type(self).__name__} is used inside 'with'")
        return self._instance

    def _not_ready(self) -> Exception:
        return self._failure or RuntimeError(f"a {type(self).__name__} is started before it is stepped, inside 'with'")

    def _not_finite(self, instance: Instance, place: int, value: float) -> PlantFailed:
        name = self._binding.outputs.elements[place]
        return PlantFailed(instance.failure("not_finite", "", self.time, variable=name, doing=f"{value}"))

    @contextmanager
    def _remembering(self) -> Generator[None]:
        # A plant that has failed is unusable; it repeats its failure from then on.
        try:
            yield
        except PlantFailed as error:
            self._failure, self._ready = error, False
            raise
