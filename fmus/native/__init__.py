"""The built-in compiler: rumoca's checked DAE → CasADi → C → FMI 2.0, without OpenModelica.

From Modelica to explicit equations:
    dae calls the front end rumoca; rewriting changes forms that it does not read, and error_places reports its errors.
    language, names and connections check the tree of classes for code that it would misinterpret or should refuse;
    variables, expressions (with arrays) and conditions turn the DAE into CasADi expressions.
    structure reduces the index and solves for the unknowns; system has the result.
From explicit equations to
    CasADi functions: equations calls all of this, in a separate_process for a user's classes.
    an FMU: code (with c_source) and description write its files, package packs it;
    toolchain has the C compiler and access to its libraries, and `runtime` the FMI functions and the solver.
From a step in C or CasADi, without Modelica: discrete writes an FMU or a C library.
"""

from railgrip.fmus.native.equations import Model, lower

__all__ = ["Model", "lower"]
