"""Trains in files: schema, drawing to scale, checks, calculation by hand, and Modelica.

Separate from `railgrip.vehicle`, because it reads scenario tables and draws with `railgrip.report`, which both need
formations.
"""
