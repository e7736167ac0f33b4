"""The track: the table [track] of a scenario, its alignment, its position on the Earth, and its irregularities.

`table` has the keys and the force along the track. `alignment` constructs a track as engineers do: straights,
transition curves and arcs; straight grades joined by parabolas. `geodesy` converts positions on the ellipsoid to a
local north-east-down frame. `irregularity` draws deviations from the alignment.
"""
