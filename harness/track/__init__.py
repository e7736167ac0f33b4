"""A track as it is laid, and where it lies.

`geodesy` turns positions on the ellipsoid into a local north-east-down frame; `laid` draws a track as engineers do:
straights, transition curves, arcs; straight grades joined by parabolas. `irregularity` draws what is left beside that.
"""
