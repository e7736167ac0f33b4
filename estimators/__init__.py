"""Estimates of the state of the train: adhesion and pad friction estimated from readings of its sensors.

`prediction` says what a filter asks of a model, `ekf` is the extended Kalman filter in numpy (the reference), and
`compiled` the same filter generated as C. `design` checks the parts of a filter, and holds a state still while nothing
can be learned about it, `tuning` names the noises, `consistency` tests whether the covariance of a filter fits its
errors, and `observability` says which states readings determine.
"""
