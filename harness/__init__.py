"""The open bench for railway braking at low adhesion.

import railgrip as rg

stop = rg.run(rg.Scenario.load("trapezoid"))
stop.metrics.distance
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str
    from railgrip import testing
    from railgrip.api import (
        Controller,
        ControllerFailed,
        Estimate,
        EstimationError,
        Estimator,
        EstimatorFailed,
        FilterDiverged,
        FmuError,
        Formation,
        InputError,
        Observation,
        Outcome,
        Plant,
        PlantFailed,
        RailgripError,
        Scenario,
        ScenarioError,
        Sensors,
        SensorsFailed,
        Stop,
        compare,
        estimate,
        inspect,
        open,
        run,
        sweep,
    )

__all__ = [
    "Controller",
    "ControllerFailed",
    "Estimate",
    "EstimationError",
    "Estimator",
    "EstimatorFailed",
    "FilterDiverged",
    "FmuError",
    "Formation",
    "InputError",
    "Observation",
    "Outcome",
    "Plant",
    "PlantFailed",
    "RailgripError",
    "Scenario",
    "ScenarioError",
    "Sensors",
    "SensorsFailed",
    "Stop",
    "__version__",
    "compare",
    "estimate",
    "inspect",
    "open",
    "run",
    "sweep",
    "testing",
]


def __getattr__(name: str) -> Any:
    """Import a name when it is used: a command line that only prints its help must not wait for pydantic (PEP 562)."""
    if name == "__version__":
        return version("railgrip")
    if name == "testing":
        return import_module("railgrip.testing")
    if name in __all__:
        return getattr(import_module("railgrip.api"), name)
    raise AttributeError(f"module 'railgrip' has no attribute '{name}'; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
