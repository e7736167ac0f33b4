"""Each value sent to a plant arrives at the input of its name, whatever the order of the table of signals."""

from itertools import permutations

import pytest

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
