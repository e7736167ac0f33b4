"""Friction learned from axle boxes: runs, training, honest judgement, report.

`runs` (which passes), `gather` (simulate, measure, filter; cached by content), `users` (a folder of somebody's own
runs), `evaluate` (splits and scores), `tables` and `figures`, `command` (`railgrip learn`).
"""
