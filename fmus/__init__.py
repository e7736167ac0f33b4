"""A Modelica class (or a CasADi function) goes in, a checked FMU comes out."""
