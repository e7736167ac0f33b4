"""One stop, step by step: plant, sensors, estimator, controller and actuation, each at its own period.

The loop knows protocols, not parties: whoever offers `start`, `step`, `read`, `decide` or `act` may take part.
"""
