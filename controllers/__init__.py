"""Wheel-slide control laws: from observations and estimates to demanded brake cylinder pressures.

Every law is an object with `decide(observation) -> demands`: one demanded pressure [Pa] per braked group. In
`railgrip.controllers.valves` demands become valve commands, so that the same law drives an ideal pressure actuator and
a pneumatic one. Of the other packages, this one uses only `railgrip.base` and `railgrip.vehicle`.

A law is written as a graph of symbols with `railgrip.controllers.sampled.FormulaBuilder`, for one group at a time;
`railgrip.controllers.law` assembles the formula of all groups, and `railgrip.controllers.train_level` wraps it in
decisions for the whole train.
"""
