"""Kinds of filters in a scenario: one module for each, with the name of the kind."""
