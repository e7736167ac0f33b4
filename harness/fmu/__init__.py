"""The only package that touches an FMU: describes it, maps its names and units to ours, and steps it.

`describe` reads a file into a value, `bind` ties our signals to its variables, and then a plant is stepped
(`CoSimulation`, or `IsolatedCoSimulation` for a file nobody here vouches for) or a prediction is evaluated
(`FmuPrediction`). A wrong question is an `FmuError`; an FMU that fails while it runs is a `PlantFailed`.
"""

from railgrip.fmu.cosimulation import CoSimulation
from railgrip.fmu.description import Description, Variable, describe
from railgrip.fmu.exchange import FmuPrediction
from railgrip.fmu.isolation import IsolatedCoSimulation, open_plant
from railgrip.fmu.mapping import Binding, Side, Signal, bind

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
]
