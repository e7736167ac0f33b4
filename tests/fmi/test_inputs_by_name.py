"""Each value sent to a plant arrives at the input of its name, whatever the order of the table of signals."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from faulty_fmu import faulty_fmu

from railgrip.fmi import CoSimulation, bind, describe
from railgrip.simulate.bound_plant import plant_signals
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import CURVE, PLANT_INPUTS, layout_of

FORMATION = Formation((2, 1, 1, 2))


@pytest.mark.parametrize("pneumatic", [False, True])
@pytest.mark.parametrize(
    "order", list(permutations((*PLANT_INPUTS, CURVE[0]))), ids=lambda order: " ".join(s.name for s in order)
)
def test_inputs_have_the_indices_of_the_loops_vector(order, pneumatic):
    layout = layout_of(FORMATION, input=order)
    inputs, _, _ = plant_signals(layout, pneumatic=pneumatic, track_force=False)
    first, places = 0, {}
    for signal in inputs:
        name = "command" if signal.name in ("pressure_command", "valve_command") else signal.name
        places[name] = slice(first, first := first + max(signal.size, 1))
    assert places == dict(layout.input)


def braked(file: Path, order) -> np.ndarray:
    """Return the outputs of a second of full braking on a good rail, with the inputs in an order."""
    layout = layout_of(FORMATION, input=order)
    inputs, outputs, start = plant_signals(layout, pneumatic=False, track_force=False)
    description = describe(file)
    binding = bind(description, inputs=inputs, outputs=outputs, parameters=(start,))
    values = np.zeros(layout.inputs)
    values[layout.input["command"]], values[layout.input["mu0"]] = 3.4e5, 0.3
    with CoSimulation(description, binding, period=1e-2, parameters=binding.translate({"start_speed": 20.0})) as plant:
        rows = [plant.start(values)]
        rows += [plant.step(values) for _ in range(100)]
    return np.array(rows)


def test_swapping_two_signals_does_not_change_the_braking(foundry: Path):
    """The same bytes: friction that arrived as pressure would not brake."""
    file = faulty_fmu(foundry)
    plain, swapped = braked(file, PLANT_INPUTS), braked(file, (PLANT_INPUTS[1], PLANT_INPUTS[0], PLANT_INPUTS[2]))
    assert plain[-1, 1] < plain[0, 1] - 0.5, "the speed falls"
    assert plain.tobytes() == swapped.tobytes()
