"""Friction learned from axle-box accelerations.

`preprocessing` has the motions and the paper's filters, `spectral` the features that depend on friction, `network` and
`ensemble` small networks and their training, `online` the trained chain sample by sample as one CasADi function, and
`trained` the estimators as values. Runs and their judgement are in `railgrip.studies.axle_box`.
"""
