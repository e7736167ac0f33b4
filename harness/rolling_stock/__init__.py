"""Trains in files: what they are made of, drawn to scale, checked, calculated by hand, and written as Modelica."""
