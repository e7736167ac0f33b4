"""Everything that decides a stop before it happens: scenario files, their values, and campaigns of them.

`load` turns a TOML file into a frozen `Scenario` in SI units or raises `ScenarioError` with one sentence a
problem; `adhesion` and `track` turn its tables into the functions of time and place that the loop asks every
sample.
"""
