"""Estimates of the state of the train: adhesion and pad friction estimated from readings of its sensors.

`prediction` is the interface of the model in a filter, `ekf` the extended Kalman filter in numpy (the reference), and
`compiled` the same filter generated as C. `design` checks the parts of a filter, freezes states while they are
unobservable, and has the named sets of noises. `consistency` tests whether the covariance of a filter fits its errors,
`observability` computes which states the readings determine, and `rail` what estimates say about the rail.
"""
