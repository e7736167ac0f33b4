"""A Co-Simulation FMU as the step of a filter: the FMU integrates over the period, and the filter does not.

This is the interface of Brembeck et al., Nonlinear State Estimation with an Extended FMI 2.0 Co-Simulation Interface
(2014). Their extension sets the states between two steps by fmi2SetReal, which FMI 2.0 does not allow (§4.2.4). Within
FMI 2.0 every step begins in a saved state of the whole FMU in its initialisation mode, where start values of states may
be set. An FMU that refuses this may have the extension, as those of OpenModelica do. Which one works is tried once.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from math import isfinite
from pathlib import Path
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from railgrip.base.arrays import Matrix, Vector
from railgrip.base.errors import FmuError, PlantFailed
from railgrip.estimators.model_in_c import Pattern, transition_pattern
from railgrip.fmi.description import Description, Interface
from railgrip.fmi.exchange import KERNEL, FmuPrediction, references_of
from railgrip.fmi.instance import Instance, Values
from railgrip.fmus.native.toolchain import Struct, kernel_library

TOLERANCE: Final = 1e-8
"""Relative error that the FMU's solver is asked to keep."""

_RELATIVE_STEP: Final = 1e-3
"""Difference of states over their size for the Jacobian of a step.

A solver with an error of `TOLERANCE` that differs between two steps adds 1e-5 to an entry. Truncation is the square of
this number, times the third derivative of a step, which is of the order of the period.
"""

_MARGIN: Final = 10 * TOLERANCE
"""Difference of two steps over the size of the states that the errors of their solvers explain."""

_STEPS: Final = 100
"""Steps without a restart in the check of an FMU."""


class SteppedFmuPrediction(FmuPrediction):
    """Implements the Prediction protocol by a Co-Simulation FMU 2.0 in this process; used inside `with`.

    `derivative` is the mean rate over the period, so that forward Euler with it is the step of the FMU; the filter's
    order is 1 therefore. Its Jacobian follows from the directional derivatives at the start of the period by the
    polynomial of degree 4 that a filter has for Model Exchange; without them it is the central difference of steps.

    Attributes:
        period: Period of a step [s].
    """

    _calls: ClassVar[Mapping[str, str]] = {**FmuPrediction._calls, "SETTING_STATES": "fmi2SetReal"}

    def __init__(
        self,
        description: Description,
        *,
        period: float,
        parameters: Values,
        states: Sequence[str],
        inputs: Sequence[str],
        outputs: Sequence[str],
        readings: Sequence[str] = (),
    ) -> None:
        """Check the arguments; nothing is loaded before `with`.

        Args:
            description: Description of the FMU; variables in SI.
            period: Period of a step [s].
            parameters, states, inputs, outputs, readings: See `FmuPrediction`.

        Raises:
            FmuError: As for `FmuPrediction`; or the FMU does not offer Co-Simulation, lists no states, or cannot save
                its state.
        """
        interface = description.co_simulation
        if interface is None:
            raise FmuError(
                f"{description.file}: this FMU offers only Model Exchange; export it as Co-Simulation, or evaluate the "
                "prediction by Model Exchange."
            )
        if not description.states:
            raise FmuError(
                f"{description.file}: it does not say which variables are its states, which a filter sets; list their "
                "derivatives in ModelStructure, or export it as Model Exchange."
            )
        if not interface.saves_state:
            raise FmuError(
                f"{description.file}: a prediction by Co-Simulation begins every step in a saved state, and this FMU "
                "has no canGetAndSetFMUstate; export it with this, or as Model Exchange."
            )
        if not (isfinite(period) and period > 0):
            raise FmuError(f"{description.file}: the period is a positive time, got {period} s.")
        super().__init__(
            description, parameters=parameters, states=states, inputs=inputs, outputs=outputs, readings=readings
        )
        self.period = period
        variables = description.variables
        self._state_references = self._references[0].tolist()
        self._slope_references = references_of(variables[name] for name in self._derivatives).tolist()
        # Inputs in the check of the FMU.
        self._held = [value if isfinite(value := variables[name].start) else 0.0 for name in self.inputs]
        # Within a step a state acts along any path of dependencies.
        self._derivative_pattern = transition_pattern(self._slope_pattern, len(self.states))

    @property
    def _interface(self) -> Interface | None:
        return self._description.co_simulation

    @property
    def _differentiated(self) -> tuple[NDArray[np.uint32], Pattern]:
        if self.has_directional_derivatives:
            return super()._differentiated
        return self._references[0], self._derivative_pattern

    @property
    def start(self) -> Vector:
        """Initial state of the FMU, shape (n,)."""
        self._open()
        return self._start.copy()

    def _begin(self, folder: Path, stack: ExitStack) -> Instance:
        problems: dict[str, str] = {}
        for mode in ("initialisation mode", "step mode"):
            with ExitStack() as attempt:
                self._trial = instance = Instance(self._description, "co-simulation", folder, name="prediction")
                attempt.callback(instance.close)
                self._initialises = mode == "initialisation mode"
                try:
                    self._save()
                    problem = self._problem()
                except PlantFailed as error:
                    problem = str(error)
                if not problem:
                    stack.push(attempt.pop_all())
                    return instance
                problems[mode] = problem
        raise FmuError(
            f"{self.file}: no step can begin at an estimate. "
            + " ".join(f"With states set in {mode}: {problem.rstrip('.')}." for mode, problem in problems.items())
            + " Export it as Model Exchange."
        )

    def _fields(self, instance: Instance) -> dict[str, object]:
        n, library = len(self.states), kernel_library(*KERNEL)
        self._slopes = np.zeros(sum(map(len, self._slope_pattern)) + 1)
        exact = self.has_directional_derivatives
        stepping = library.struct(
            "Stepping", do_step=instance.address("fmi2DoStep"), restore=instance.address("fmi2SetFMUstate"),
            exit_initialisation=instance.address("fmi2ExitInitializationMode") if self._initialises else None,
            saved=self._saved.value, state_references=self._references[0], slope=_rows(self._slope_pattern),
            rate=_rows(self._derivative_pattern), slopes=self._slopes,
            power=np.zeros((n, n)) if exact else None, next_power=np.zeros((n, n)) if exact else None,
            period=self.period,
        )  # fmt: skip
        return {"stepping": stepping, "relative_step": _RELATIVE_STEP}

    def _rates(self, x: Vector, u: Vector) -> tuple[Callable[[Vector], Vector], Matrix]:
        if not self.has_directional_derivatives:
            return super()._rates(x, u)
        self._held = u.tolist()
        self.derivative_jacobian(x, u)  # fills `_slopes`
        return partial(self._get, self._slope_references), self._matrix(self._slopes, self._slope_pattern)

    # Steps from any states, and a check that they are those of a function of states and inputs.

    def _save(self) -> None:
        # Before the state is saved, the states are read, so that it contains what the FMU computes from parameters.
        self._trial.assign(self._assignments, 0.0)
        self._trial.enter_initialization(tolerance=TOLERANCE)
        if not self._initialises:
            self._trial.exit_initialization()
        with self._trial.calling(0.0, "reading its states") as fmu:
            self._start = np.array(fmu.getReal(self._state_references))
        self._saved = self._trial.save_state(0.0)

    def _problem(self) -> str:
        """Return why steps from given states are not possible, or are not those of a filter's prediction; else ''."""
        if not np.all(np.isfinite(self._start)):
            return "a start value of its states is not finite"
        size = np.maximum(np.abs(self._start), self._nominal)
        point = self._start + _RELATIVE_STEP * size
        if (bad := np.flatnonzero(np.abs(self._get(self._state_references, point) - point) > 1e-9 * size)).size:
            name, value = self._symbols[bad[0]], point[bad[0]]
            return f"'{name}' is {self._get(self._state_references, point)[bad[0]]:g} after it was set to {value:g}"
        if changed := self._lost_parameter(point):
            return changed
        first = self._step(point)
        self._step(self._start)
        if np.any(np.abs(self._step(point) - first) > 1e-9 * size):
            return "two steps from the same states differ, so that it keeps values that are not saved"
        expected = self._runge_kutta(point)
        largest = np.max(np.abs(expected - point) / size)
        # A solver of order 1 with this period may be off by several percent; one that ignores the period is off by 1.
        if np.any(np.abs(first - expected) > (0.1 * largest + _MARGIN) * size):
            return (
                f"its step of {self.period:g} s does not follow its derivatives: its own steps are longer, or it "
                "depends on time"
            )
        before, after = self._steps_without_restart(point)
        change = np.max(np.abs(after - before) / size)
        if np.any(np.abs(self._step(before) - after) > (1e-3 * change + _MARGIN) * size):
            return "its steps depend on time, or on values besides its states"
        return ""

    def _lost_parameter(self, x: Vector) -> str:
        self._restart(x)
        with self._trial.calling(0.0, "reading its parameters") as fmu:
            for entry in self._assignments:
                found = getattr(fmu, f"get{entry.carrier}")(entry.references)
                for value, after in zip(entry.values, found, strict=True):
                    if value != (after.decode() if isinstance(after, bytes) else after):
                        return f"a parameter is {after} after it was set to {value} and its state restored"
        return ""

    def _restart(self, x: Vector) -> None:
        with self._trial.calling(0.0, "setting its states") as fmu:
            fmu.setFMUstate(self._saved)
            fmu.setReal(self._state_references, x.tolist())
            if self.inputs:
                fmu.setReal(self._references[1].tolist(), self._held)
        if self._initialises:
            self._trial.exit_initialization()

    def _get(self, references: list[int], x: Vector) -> Vector:
        self._restart(x)
        with self._trial.calling(0.0, "reading its values") as fmu:
            return np.array(fmu.getReal(references))

    def _advance(self, number: int) -> Vector:
        time = number * self.period
        with self._trial.calling(time, "stepping the prediction") as fmu:
            fmu.doStep(time, self.period, noSetFMUStatePriorToCurrentPoint=False)
            return np.array(fmu.getReal(self._state_references))

    def _step(self, x: Vector) -> Vector:
        self._restart(x)
        return self._advance(0)

    def _runge_kutta(self, x: Vector) -> Vector:
        slope, total, period = self._get(self._slope_references, x), np.zeros_like(x), self.period
        for part, weight in ((0.5, 1.0), (0.5, 2.0), (1.0, 2.0)):
            total += weight * slope
            slope = self._get(self._slope_references, x + part * period * slope)
        return x + period / 6.0 * (total + slope)

    def _steps_without_restart(self, x: Vector) -> tuple[Vector, Vector]:
        """Return the states before and after the last of `_STEPS` steps from x."""
        self._restart(x)
        before = x
        for number in range(_STEPS - 1):
            before = self._advance(number)
        return before, self._advance(_STEPS - 1)


def _rows(pattern: Pattern) -> Struct:
    first = np.cumsum([0, *map(len, pattern)], dtype=np.longlong)
    column = np.array([column for row in pattern for column in row] or [0], dtype=np.longlong)
    return kernel_library(*KERNEL).struct("Rows", first=first, column=column)
