"""Read FMUs, map their names and units to the harness, and step them; no other package accesses an FMU.

`describe` reads a file into a value, and `bind` ties signals of the harness to its variables. Then a plant is stepped
(`open_plant`; `CoSimulation` for Co-Simulation by FMI 2.0 in this process) or a prediction is evaluated
(`FmuPrediction`, or `SteppedFmuPrediction` by Co-Simulation). A wrong request raises `FmuError`; an FMU that fails
while it runs raises `PlantFailed`.
"""

from railgrip.fmi.description import Description, FmuVariable, describe
from railgrip.fmi.exchange import FmuPrediction
from railgrip.fmi.instance import foreign_code
from railgrip.fmi.isolation import IsolatedCoSimulation, open_plant, shared_budget
from railgrip.fmi.mapping import Binding, Port, SignalVector, bind
from railgrip.fmi.plant import CoSimulation
from railgrip.fmi.stepped import SteppedFmuPrediction

__all__ = [
    "Binding",
    "CoSimulation",
    "Description",
    "FmuPrediction",
    "FmuVariable",
    "IsolatedCoSimulation",
    "Port",
    "SignalVector",
    "SteppedFmuPrediction",
    "bind",
    "describe",
    "foreign_code",
    "open_plant",
    "shared_budget",
]
