"""Friction learned from axle-box accelerations: Abduraxman et al. (2024), judged on runs that were not seen.

`instrumented_car`, `irregularity` and `accelerometer` (the car on its track, and what it measures), `runs` (which
passes), `gather` (simulate, measure, filter; cached by content), `users` (a folder of somebody's own runs), `evaluate`
(splits and scores), `tables` and `figures`. Runs of the car are open loop: it has no brake, but irregularities under
four wheelsets as twenty inputs at 1280 Hz.
"""
