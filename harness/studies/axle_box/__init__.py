"""Friction learned from axle boxes: runs, training, honest judgement, report.

`instrumented_car`, `irregularity` and `accelerometer` (the car on its track, and what it measures), `runs` (which
passes), `gather` (simulate, measure, filter; cached by content), `users` (a folder of somebody's own runs), `evaluate`
(splits and scores), `tables` and `figures`. Runs of the car are open loop: it has no brake, but irregularities under
four wheelsets as twenty inputs at 1280 Hz.
"""
