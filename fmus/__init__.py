"""Modelica classes and CasADi functions in, checked FMI 2.0 FMUs out."""
