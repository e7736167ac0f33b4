"""All inputs of a stop: scenario files, their values, and campaigns of them.

`load` converts a TOML file to a frozen `Scenario` in SI units, or raises `ScenarioError` with one sentence per problem;
`adhesion` and `track` convert its tables to the functions of time and place that the loop evaluates every sample.
"""
