"""Trains in files: what they are made of, drawn to scale, checked, calculated by hand, and written as Modelica.

A package of its own above `railgrip.vehicle`: it reads scenario tables and draws with `railgrip.report`, and both of
them need formations.
"""
