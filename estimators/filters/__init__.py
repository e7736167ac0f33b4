"""Kinds of filters that a scenario may name: one module for each, found by its name."""
