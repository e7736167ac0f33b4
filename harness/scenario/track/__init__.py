"""The track: the table [track] of a scenario, its alignment, its place on the Earth, and its irregularities.

`table` has the keys and the force along the track. `alignment` draws a track as engineers do: straights, transition
curves and arcs; straight grades joined by parabolas. `geodesy` turns positions on the ellipsoid into a local
north-east-down frame. `irregularity` draws deviations from the alignment.
"""
