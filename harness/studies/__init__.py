"""Programmes of one paper each, field test, lateral wheelset, axle-box estimator, brake monitor; and K factors.

They are built from the rooms around them. Nothing but the command line knows them, and an edit here runs no stop again.
"""
