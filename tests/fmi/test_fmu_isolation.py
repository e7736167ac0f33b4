"""An FMU in a separate process gives the same numbers, and any failure of it is reported in a sentence."""

from pathlib import Path

import numpy as np
import pytest
from tiny_fmu import tied, tiny
from wrong import table

from railgrip.base.errors import FmuError, PlantFailed
from railgrip.base.limits import FmuLimits
from railgrip.fmi import (
    IsolatedCoSimulation,
    describe,
)

PERIOD = 1e-3
AT_LEISURE = FmuLimits(patience=100.0)
SOON = 0.5  # s of real time; only an FMU that never returns takes this long


def isolated(file: Path, limits: FmuLimits = AT_LEISURE, **parameters: object) -> IsolatedCoSimulation:
    description = describe(file)
    return IsolatedCoSimulation(description, tied(description), period=PERIOD, parameters=parameters, limits=limits)


@pytest.mark.parametrize(("misbehaviour", "sentence"), table(__file__, "tables.toml")["failures"])
def test_any_failure_is_reported_in_a_sentence(foundry: Path, scratch: Path, misbehaviour: str, sentence: str):
    plant = isolated(tiny(foundry, misbehaviour))
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
    assert process is not None
    assert process.poll() is not None, "the child has ended"
    assert list(scratch.iterdir()) == [], "its files are gone"


def test_it_stays_failed(foundry: Path):
    with isolated(tiny(foundry, "CRASH"), allowed=0) as plant:
        plant.start(np.zeros(1))
        for _ in range(2):
            with pytest.raises(PlantFailed, match="ended by SIGSEGV"):
                plant.step(np.zeros(1))


def test_a_refusal_to_start_is_reported(foundry: Path, scratch: Path):
    with pytest.raises(PlantFailed, match="no licence for plant"):
        isolated(tiny(foundry, "REFUSES")).__enter__()
    assert list(scratch.iterdir()) == []


def test_a_wrong_parameter_is_refused_before_a_process_starts(foundry: Path):
    with pytest.raises(FmuError, match=r"'rate' of .* is at most 10"):
        isolated(tiny(foundry), rate=11.0)
