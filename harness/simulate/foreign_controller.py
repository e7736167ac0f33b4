"""User-defined controllers as co-simulation FMUs, which get the same observation as a built-in law."""

from collections.abc import Callable, Collection, Generator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from railgrip import fmi
from railgrip.base.errors import ControllerFailed, FmuError, PlantFailed
from railgrip.base.interrupted import end_if_stuck
from railgrip.controllers.observation import Observation
from railgrip.fmi import Binding, Description, bind, open_plant
from railgrip.scenario.parts import ControllerFmu
from railgrip.scenario.schema import Scenario
from railgrip.simulate.loop.parts import LoopPlant
from railgrip.simulate.roles import require_role
from railgrip.vehicle.signals import DEMANDED, OBSERVED, ONLY_ESTIMATED, Signal

_DECISIONS = (*DEMANDED, Signal("command", "group", "1", "command to the valves: -1 vent, 0 hold, 1 fill"))
"""Alternative outputs of a controller FMU."""


EXPORTED: Final = "railgrip (CasADi"
"""Start of the generation tool of a law that was exported here."""
_VALID: Final = "_valid"
"""End of the names of inputs that say whether the quantity has a value."""


def _starts(binding: Binding, description: Description) -> NDArray[np.float64]:
    """Return the start values of the FMU's inputs, in the units of the harness; 0 for those without one."""
    values = np.zeros(binding.inputs.size)
    for channel in binding.inputs.channels:
        start = np.nan_to_num([description.variables[name].start for name in channel.variables])
        values[channel.positions] = (start - channel.shift) / channel.gain
    return values


def _bindable(signals: Sequence[Signal], groups: int) -> tuple[fmi.Port, ...]:
    return tuple(
        fmi.Port(name=s.name, unit=s.unit, size=0 if s.extent == "train" else groups, needed=False) for s in signals
    )


def controller_signals(groups: int) -> tuple[tuple[fmi.Port, ...], tuple[fmi.Port, ...]]:
    """Return the inputs that a controller FMU may have, and its alternative outputs, of which it has one."""
    return _bindable(OBSERVED, groups), _bindable(_DECISIONS, groups)


class ForeignController:
    """An FMU as a control law.

    A step of the FMU lasts from one decision to the next. Its inputs are the observation at the start of the step, held
    constant. Its outputs at the end of the step are the decision, which is applied at once: a sampled law decides on
    its current inputs, and a law in continuous time leads by one period.

    The FMU never gets NaN, for which comparisons are false in most languages. A quantity without a value keeps its last
    one, or the start value of the FMU's input before the first. An input such as `slip_valid` is 1 while the slip has a
    value, else 0. Only a law that railgrip exported gets NaN, by which it defines a missing value.
    """

    def __init__(self, fmu: LoopPlant, binding: Binding, gives: str, description: Description) -> None:
        """Decide by an open FMU that has not been started; `gives` is the name of its output, demand or command."""
        self.fmu = fmu
        self._inputs, self._places = _starts(binding, description), binding.inputs.layout
        self._decision = binding.outputs.layout[gives]
        self._has_started = False
        self._knows_nan = description.generator.startswith(EXPORTED)

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa], or the valve command if that is the FMU's output.

        Raises:
            ControllerFailed: The FMU failed.
        """
        for name, place in self._places.items():
            if name.endswith(_VALID):
                continue
            values = np.atleast_1d(np.asarray(getattr(observation, name), dtype=np.float64))
            has_value = np.isfinite(values)
            np.copyto(self._inputs[place], values, where=has_value | self._knows_nan)
            self._inputs[self._places[name + _VALID]] = has_value
        try:
            if not self._has_started:
                self.fmu.start(self._inputs)
                self._has_started = True
            outputs = self.fmu.step(self._inputs)
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
    inputs = [signal for signal in OBSERVED if signal.name not in ONLY_ESTIMATED - {*estimates}]
    outputs = [signal for signal in _DECISIONS if signal.name in table.map] or _DECISIONS
    binding = bind(
        description,
        inputs=(
            *_bindable(inputs, groups),
            *(replace(port, name=port.name + _VALID, unit="1") for port in _bindable(inputs, groups)),
        ),
        outputs=_bindable(outputs, groups),
        table=table.map,
        where=where,
    )
    file, decisions = description.file.name, [s.name for s in outputs if s.name not in binding.outputs.absent]
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
            "the start value remains."
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
    with end_if_stuck(description.file.name) if table.trust else nullcontext(), context as fmu:
        yield ForeignController(fmu, binding, gives, description), gives == "command"
