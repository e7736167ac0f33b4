"""Control laws, one module for each kind in a scenario; tuned sets of parameters are in TOML files of the same name.

A module has one `railgrip.controllers.law.GroupLaw`, which declares everything about the law: its parameters with their
units, the estimates and brake data that it needs, and the ranges in which its parameters are searched. The searched set
is `<kind>.toml`, written by `railgrip maintain tune-control`; other sets are
`<kind>.<name>.toml`.
"""
