"""Compilers from Modelica classes or CasADi functions to checked FMUs."""
