"""An FMU in a separate process gives the same numbers, and any failure of it is reported in a sentence."""

from pathlib import Path

import numpy as np
import pytest
from tiny_fmu import tied, tiny
from wrong import table

from railgrip.base.errors import PlantFailed
from railgrip.base.limits import FmuLimits
from railgrip.fmi import IsolatedCoSimulation, describe

PERIOD = 1e-3
AT_LEISURE = FmuLimits(patience=100.0)
SOON = 0.5  # s of real time; only an FMU that never returns takes this long


@pytest.mark.parametrize(("misbehaviour", "sentence"), table(__file__, "tables.toml")["failures"])
def test_any_failure_is_reported_in_a_sentence(foundry: Path, scratch: Path, misbehaviour: str, sentence: str):
    description = describe(tiny(foundry, misbehaviour))
    plant = IsolatedCoSimulation(description, tied(description), period=PERIOD, parameters={}, limits=AT_LEISURE)
    with plant:
        plant.start(np.zeros(1))
        process = plant._process
        for _ in range(3):  # the steps allowed to it
            plant.step(np.zeros(1))
        if misbehaviour == "NEVER_STOPS":
            plant._patience = SOON  # a successful step may take longer on a busy machine
        with pytest.raises(PlantFailed) as error:
            plant.step(np.zeros(1))
    assert str(error.value) == f"{misbehaviour.lower()}.fmu: {sentence}"
    assert process.poll() is not None, "the child has ended"
    assert list(scratch.iterdir()) == [], "its files are gone"
