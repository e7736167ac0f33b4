"""The built-in compiler: rumoca's checked DAE → CasADi → C → FMI 2.0, without OpenModelica.

From Modelica to explicit equations:
    dae calls the front end rumoca; rewriting changes forms that it does not read, and error_places reports its errors.
    language, names and connections check the tree of classes for code that it would misinterpret or should refuse;
    outer gives outer variables their values.
    variables, expressions (with arrays) and conditions turn the DAE into CasADi expressions.
    index reduces the index, structure solves for the unknowns; system has the result.
From explicit equations to
    CasADi functions: lowering, model; equations calls all of this, in a separate_process for a user's classes.
    an FMU: code (with functions, elimination, c_source) and description write its files, package and fmi3 pack it;
    toolchain has the C compiler, and `runtime` the FMI functions and the solver.
From a step in C or CasADi, without Modelica: discrete writes an FMU, and embedded (with memory, c_library) a C library.
"""

from railgrip.fmus.native.equations import lower
from railgrip.fmus.native.model import Model

__all__ = ["Model", "lower"]
