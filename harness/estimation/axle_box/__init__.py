"""Friction learned from axle-box accelerations: Abduraxman et al. (2024), judged on runs outside of the training.

`instrumented_car` simulates the car and its sensors, and turns a run into training data, `evaluate` has splits and
scores, `training` the runs of the study and what is trained on them, `recordings` a user's folder of recorded runs,
`ride` the car together with a trained estimator. Runs are open loop: the car has no brake; irregularities under four
wheelsets are its twenty inputs at 1280 Hz.
"""
