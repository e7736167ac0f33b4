"""The track under a train: where it lies, what it was laid as, and what a train's sensors tell about it.

`geodesy` turns GNSS positions into a local north-east-down frame, `laid` draws a track as engineers do (straights,
transition curves, arcs; straight grades joined by parabolas), `motion` fuses speed, acceleration and position into
distance, speed and acceleration along the track, `course` recovers curvature and slope over distance, and
`railgrip.scenario.track` turns those into a force.
"""
