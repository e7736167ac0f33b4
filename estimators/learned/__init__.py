"""Friction learned from axle-box accelerations.

`channels` (which motions), `preprocessing` (the paper's filters), `spectral` (features that carry friction),
`network` and `training` (a small network by Levenberg-Marquardt), `online` (the trained chain sample by sample, as one
CasADi function). Knows neither where runs come from nor how they are judged: that is `railgrip.studies.axle_box`.
"""
