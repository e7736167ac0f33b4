"""The only package that touches an FMU: describes it, maps its names and units to ours, and steps it.

`describe` reads a file into a value, `bind` ties our signals to its variables, and then a plant is stepped
(`open_plant`; `CoSimulation` where it is Co-Simulation by FMI 2.0 in this process) or a prediction is evaluated
(`FmuPrediction`). A wrong question is an `FmuError`; an FMU that fails while it runs is a `PlantFailed`.
"""

from railgrip.fmi.cosimulation import CoSimulation
from railgrip.fmi.description import Description, Variable, describe
from railgrip.fmi.exchange import FmuPrediction
from railgrip.fmi.isolation import IsolatedCoSimulation, open_plant, shared_budget
from railgrip.fmi.mapping import Binding, Side, Signal, bind

__all__ = [
    "Binding",
    "CoSimulation",
    "Description",
    "FmuPrediction",
    "IsolatedCoSimulation",
    "Side",
    "Signal",
    "Variable",
    "bind",
    "describe",
    "open_plant",
    "shared_budget",
]
