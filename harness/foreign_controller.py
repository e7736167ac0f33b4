"""A controller of the user's own: a co-simulation FMU that is shown what a law sees."""

from collections.abc import Callable, Generator
from contextlib import contextmanager

import numpy as np

from controllers.sight import Sight
from harness.fmu import Binding, Description, FmuError, Plant, PlantFailed, Signal, bind, open_plant
from harness.loop.ports import ControllerFailed
from harness.record.signals import GROUPS
from harness.scenario.parties import ControllerFmu
from harness.scenario.schema import Scenario

_READ = (
    Signal(name="speed", unit="m/s", size=0, needed=False),
    Signal(name="acceleration", unit="m/s2", size=0, needed=False),
    Signal(name="slip", unit="1", size=GROUPS, needed=False),
    Signal(name="pressure", unit="Pa", size=GROUPS, needed=False),
)
_BELIEVED = (
    Signal(name="adhesion", unit="1", size=GROUPS, needed=False),
    Signal(name="pad_friction", unit="1", size=GROUPS, needed=False),
)
_GIVEN = (
    Signal(name="demand", unit="Pa", size=GROUPS, needed=False),
    Signal(name="command", unit="1", size=GROUPS, needed=False),
)


class ForeignController:
    """An FMU as a control law.

    A step of the FMU lasts from one decision to the next. Its inputs are what is seen at the first, held; its outputs
    at the end of the step are the decision, at once: a sampled law decides on what it is shown, and a law in
    continuous time is ahead by the period it is given. As for our own laws, what no sensor has read yet is NaN.
    """

    def __init__(self, fmu: Plant, binding: Binding, gives: str, *, believing: bool) -> None:
        """Decide by an open FMU that has not been started; `gives` names its output, demand or command."""
        self._fmu = fmu
        self._inputs = np.zeros(binding.inputs.size)
        self._believing = believing
        self._given = binding.outputs.layout[gives]
        self._started = False

    def decide(self, sight: Sight) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa], or the valve command if that is what the FMU gives.

        Raises:
            ControllerFailed: The FMU failed.
        """
        _, speed, acceleration, slip, adhesion, pad_friction, pressure = sight
        believed = (*(adhesion or ()), *(pad_friction or ())) if self._believing else ()
        self._inputs[:] = (speed, acceleration, *slip, *pressure, *believed)
        try:
            if not self._started:
                self._fmu.start(self._inputs)
                self._started = True
            decided = self._fmu.step(self._inputs)
        except PlantFailed as failed:
            raise ControllerFailed(f"The controller failed: {failed}") from failed
        return tuple(decided[self._given].tolist())


def binding_of(scenario: Scenario, table: ControllerFmu, description: Description) -> tuple[Binding, str]:
    """Tie what a law sees and gives to the variables of the FMU; return that and what it gives, demand or command.

    Raises:
        FmuError: It does not fit the FMU, or the FMU gives nothing that brakes.
    """
    where = f"{scenario.name}: [controller.map]"
    seen = (*_READ, *(_BELIEVED if scenario.estimator.kind != "none" else ()))
    mapped = tuple(signal for signal in _GIVEN if signal.name in table.map)
    binding = bind(description, inputs=seen, outputs=mapped or _GIVEN, table=table.map, where=where)
    file, given = description.file.name, [s.name for s in mapped or _GIVEN if s.name not in binding.outputs.absent]
    if len(given) != 1:
        found = " and ".join(given) or "neither demand nor command"
        raise FmuError(
            f"{where}: {file} gives {found}; wanted is one of demand [Pa] and command of the {GROUPS} groups: say "
            'which variables they are, as in demand = "pressure[{i}]".'
        )
    if given == ["command"] and scenario.actuation.kind != "pneumatic":
        raise FmuError(
            f"{where}: {file} commands valves, but [actuation] kind is '{scenario.actuation.kind}', which takes "
            "pressures; make it 'pneumatic', with a plant that has valves."
        )
    return binding, given[0]


@contextmanager
def foreign_controller(
    scenario: Scenario,
    table: ControllerFmu,
    description: Description,
    parameters: dict[str, float],
    tell: Callable[[str], None],
) -> Generator[tuple[ForeignController, bool]]:
    """Open the FMU of a scenario's controller; yield the law and whether it commands the valves itself.

    Inputs of it that nothing drives, such as an adhesion that nobody estimates, are told.

    Raises:
        FmuError: It does not fit.
        PlantFailed: It does not load.
    """
    binding, gives = binding_of(scenario, table, description)
    if binding.unused:
        names = ", ".join(dict.fromkeys(name.partition("[")[0] for name in binding.unused))
        tell(
            f"{description.file.name}: nothing drives its {names} ([estimator] kind is '{scenario.estimator.kind}'): "
            "what it starts with stays."
        )
    opened = open_plant(
        description,
        binding,
        period=scenario.periods.controller,
        parameters=parameters,
        trusted=table.trust,
        tell=tell,
        limits=scenario.limits.fmu.limits(),
        table="[controller]",
    )
    with opened as fmu:
        believing = scenario.estimator.kind != "none"
        yield ForeignController(fmu, binding, gives, believing=believing), gives == "command"
