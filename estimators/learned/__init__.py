"""Friction learned from axle-box accelerations.

`preprocessing` has the motions and the paper's filters, `spectral` the features that depend on friction, `network` and
`ensemble` small networks and their training, `online` the trained estimator as one CasADi function for each sample, and
`trained` estimators with their files. Runs and the evaluation of estimators are in `railgrip.studies.axle_box`.
"""
