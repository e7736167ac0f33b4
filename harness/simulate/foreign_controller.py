"""User-defined controllers as co-simulation FMUs, which get the same observation as a built-in law."""

from collections.abc import Callable, Collection, Generator
from contextlib import contextmanager

import numpy as np

from railgrip.base.errors import ControllerFailed, FmuError, PlantFailed
from railgrip.controllers.observation import Observation
from railgrip.fmi import Binding, Description, Signal, bind, open_plant
from railgrip.scenario.parts import ControllerFmu
from railgrip.scenario.schema import Scenario
from railgrip.simulate.loop.parts import LoopPlant
from railgrip.simulate.roles import require_role

_READ = ("speed", "acceleration", "slip", "wheelset_speed", "pressure", "driver_demand")
_BELIEVED = ("adhesion", "pad_friction")
_DECISIONS = ("demand", "command")
_UNITS = {
    "speed": "m/s", "acceleration": "m/s2", "wheelset_speed": "rad/s", "pressure": "Pa", "driver_demand": "Pa",
    "demand": "Pa",
}  # fmt: skip
_OF_TRAIN = frozenset({"speed", "acceleration"})


def _signals(names: tuple[str, ...], groups: int) -> tuple[Signal, ...]:
    return tuple(
        Signal(name=name, unit=_UNITS.get(name, "1"), size=0 if name in _OF_TRAIN else groups, needed=False)
        for name in names
    )


def controller_signals(groups: int) -> tuple[tuple[Signal, ...], tuple[Signal, ...]]:
    """Return the inputs that a controller FMU may have, and its alternative outputs, of which it has one."""
    return _signals((*_READ, *_BELIEVED), groups), _signals(_DECISIONS, groups)


class ForeignController:
    """An FMU as a control law.

    A step of the FMU lasts from one decision to the next. Its inputs are the observation at the start of the step, held
    constant. Its outputs at the end of the step are the decision, which is applied at once: a sampled law decides on
    its current inputs, and a law in continuous time leads by one period. As for built-in laws, readings that no sensor
    has delivered yet are NaN.
    """

    def __init__(self, fmu: LoopPlant, binding: Binding, gives: str) -> None:
        """Decide by an open FMU that has not been started; `gives` is the name of its output, demand or command."""
        self._fmu = fmu
        self._inputs = np.zeros(binding.inputs.size)
        self._decision = binding.outputs.layout[gives]
        self._has_started = False

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa], or the valve command if that is the FMU's output.

        Raises:
            ControllerFailed: The FMU failed.
        """
        _, speed, acceleration, wheels, slip, _, adhesion, pad_friction, pressure, driver_demand = observation
        estimated = [values for values in (adhesion, pad_friction) if values is not None]
        self._inputs[:] = np.concatenate(((speed, acceleration), slip, wheels, pressure, driver_demand, *estimated))
        try:
            if not self._has_started:
                self._fmu.start(self._inputs)
                self._has_started = True
            outputs = self._fmu.step(self._inputs)
        except PlantFailed as failed:
            raise ControllerFailed(f"The controller failed: {failed}") from failed
        return tuple(outputs[self._decision].tolist())


def binding_of(
    scenario: Scenario, table: ControllerFmu, description: Description, groups: int, estimates: Collection[str]
) -> tuple[Binding, str]:
    """Bind observation and decision to variables of the FMU; return the binding and the output, demand or command.

    Raises:
        FmuError: The map does not fit the FMU, or the FMU has neither output.
    """
    where = f"{scenario.name}: [controller.map]"
    if not table.map:
        require_role(description, "controller", f"{scenario.name}: [controller] file")
    inputs = (*_READ, *(name for name in _BELIEVED if name in estimates))
    outputs = tuple(name for name in _DECISIONS if name in table.map) or _DECISIONS
    binding = bind(
        description,
        inputs=_signals(inputs, groups),
        outputs=_signals(outputs, groups),
        table=table.map,
        where=where,
    )
    file, decisions = description.file.name, [name for name in outputs if name not in binding.outputs.absent]
    if len(decisions) != 1:
        names = " and ".join(decisions) or "neither demand nor command"
        raise FmuError(
            f"{where}: {file} gives {names}; expected is either demand [Pa] or command of the {groups} groups: state "
            'which variables they are, as in demand = "pressure[{i}]".'
        )
    if decisions == ["command"] and scenario.actuation.kind != "pneumatic":
        raise FmuError(
            f"{where}: {file} commands valves, but [actuation] kind is '{scenario.actuation.kind}', which takes "
            "pressures; make it 'pneumatic', with a plant that has valves."
        )
    return binding, decisions[0]


@contextmanager
def foreign_controller(
    scenario: Scenario,
    table: ControllerFmu,
    description: Description,
    parameters: dict[str, float],
    groups: int,
    estimates: Collection[str],
    notify: Callable[[str], None],
) -> Generator[tuple[ForeignController, bool]]:
    """Open the FMU of a scenario's controller; yield the law and whether it commands the valves directly.

    Inputs without a source, such as an adhesion that is not estimated, are reported.

    Raises:
        FmuError: The FMU does not fit.
        PlantFailed: The FMU does not load.
    """
    binding, gives = binding_of(scenario, table, description, groups, estimates)
    if binding.unused:
        names = ", ".join(dict.fromkeys(name.partition("[")[0] for name in binding.unused))
        notify(
            f"{description.file.name}: nothing drives its {names} ([estimator] kind is '{scenario.estimator.kind}'): "
            "what it starts with stays."
        )
    context = open_plant(
        description,
        binding,
        period=scenario.periods.controller,
        parameters=parameters,
        trusted=table.trust,
        notify=notify,
        limits=scenario.limits.fmu,
        table="[controller]",
    )
    with context as fmu:
        yield ForeignController(fmu, binding, gives), gives == "command"
