"""The track under a train from its own sensors, as a filter of friction needs it.

`motion` fuses speed, acceleration and position into distance, speed and acceleration along the track, `course` recovers
curvature and slope over distance, and `braking` cuts out of a run what the filter takes, with the force of the track.
"""
