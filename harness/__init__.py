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
    from railgrip.api import Scenario, estimate, open, run, sweep
    from railgrip.controllers.observation import Observation
    from railgrip.custom import Controller, Estimate, Estimator, Plant, Sensors
    from railgrip.errors import RailgripError
    from railgrip.trace.outcome import Outcome
    from railgrip.trace.stop import Stop
    from railgrip.vehicle.formation import Formation

__all__ = [
    "Controller",
    "Estimate",
    "Estimator",
    "Formation",
    "Observation",
    "Outcome",
    "Plant",
    "RailgripError",
    "Scenario",
    "Sensors",
    "Stop",
    "__version__",
    "estimate",
    "open",
    "run",
    "sweep",
    "testing",
]

_PLACES = {
    "railgrip.api": ("Scenario", "estimate", "open", "run", "sweep"),
    "railgrip.controllers.observation": ("Observation",),
    "railgrip.custom": ("Controller", "Estimate", "Estimator", "Plant", "Sensors"),
    "railgrip.errors": ("RailgripError",),
    "railgrip.vehicle.formation": ("Formation",),
    "railgrip.trace.outcome": ("Outcome",),
    "railgrip.trace.stop": ("Stop",),
}


def __getattr__(name: str) -> Any:
    """Import a name when it is used: a command line that only prints its help must not wait for CasADi (PEP 562)."""
    if name == "__version__":
        return version("railgrip")
    if name == "testing":
        return import_module("railgrip.testing")
    for module, names in _PLACES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module 'railgrip' has no attribute '{name}'; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
