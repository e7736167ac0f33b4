"""The built-in compiler: rumoca's checked DAE → CasADi → C → FMI 2.0, without OpenModelica.

dae (front end) → expressions, variables, conditions → index, structure → system (explicit equations) → model
(CasADi functions) or code, description, package (the FMU).
"""

from railgrip.fmus.native.equations import lower
from railgrip.fmus.native.model import Model

__all__ = ["Model", "lower"]
