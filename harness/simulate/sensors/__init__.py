"""Sensors of a scenario: one module for each kind, with its table and its implementation."""
