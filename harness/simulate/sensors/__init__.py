"""Sensors of a scenario: a module for each kind, with its table and what reads with it."""
