"""Friction learned from axle-box accelerations.

`preprocessing` has the motions, the paper's filters, and the features that depend on friction, `network` small networks
and their training, `trained` estimators for whole runs and single samples, with their files. Runs and the evaluation of
estimators are in `railgrip.estimation.axle_box`.
"""
