"""Every model of Validation reproduces its reference and every example runs, in rumoca's own simulator."""

import re
from pathlib import Path

import numpy as np
import pytest
import rumoca
from sampling import FUZZ

LIBRARY = Path(__file__).parents[2] / "modelica" / "RailBraking"

EXPLICIT = {
    "EnergyOfAStop", "EnergyOfAConsist", "ValveTimes", "AirCounted", "ReservoirBalance",
    "BrakePipeOfTenCoaches",
}  # fmt: skip
"""Models with a whole train, air or a clock: rumoca's BDF is slow, or fails with an error of its sampler."""


PIPES = {"PipeFront", "PipeWave", "BrakePipeOfTenCoaches"}
"""Models that take seconds in this simulator; tests/fmus/test_brake_equipment.py simulates them as FMUs, too."""


def models(package: str) -> list[str]:
    names = (LIBRARY / package / "package.order").read_text().split()
    return [name for name in names if FUZZ or name not in PIPES]


def simulate(model: rumoca.Model, until: float, *, explicit: bool = False) -> rumoca.Result:
    """Simulate; an assertion that fails raises."""
    solver, tolerance = ("rk-like", 1e-7) if explicit else ("bdf", 1e-8)
    config = rumoca.SimConfig(solver=solver, rtol=tolerance, atol=tolerance / 10)
    return model.simulate((0, until), dt=0.05, config=config)


@pytest.fixture(scope="module")
def session() -> rumoca.Session:
    """One session for all models: reading the library takes longer than most of them."""
    return rumoca.Session(roots=[str(LIBRARY.parent)])


def load(session: rumoca.Session, class_name: str) -> tuple[rumoca.Model, float]:
    """Return a class of the library and the stop time of its experiment, s."""
    text = (LIBRARY / (class_name.replace(".", "/") + ".mo")).read_text()
    experiment = re.search(r"experiment\(StopTime=([\d.]+), Tolerance=", text)
    assert experiment, f"{class_name} has no experiment"
    model = session.load(str(LIBRARY / "package.mo"), model=f"RailBraking.{class_name}")
    return model, float(experiment[1])


@pytest.mark.parametrize("name", models("Validation"))
def test_the_model_reproduces_the_closed_form(session: rumoca.Session, name: str) -> None:
    result = simulate(*load(session, f"Validation.{name}"), explicit=name in EXPLICIT)
    error = np.asarray(result["error"])
    assert error.size > 10
    assert np.isfinite(error).all()


def test_a_wrong_answer_fails(session: rumoca.Session) -> None:
    """A self-checking model must be able to fail."""
    source = "model Strict extends RailBraking.Validation.LoadTransfer(tolerance=-1); end Strict;"
    with pytest.raises(rumoca.SimulationError, match="off by"):
        simulate(session.loads(source, model="Strict", filename="Strict.mo"), 1.0)


@pytest.mark.parametrize("name", models("Examples"))
def test_the_example_runs(session: rumoca.Session, name: str) -> None:
    result = simulate(*load(session, f"Examples.{name}"), explicit="Stop" in name or name in EXPLICIT)
    if "train.speed" in result.names:
        assert np.asarray(result["train.speed"])[-1] == pytest.approx(0.0, abs=1e-9)
