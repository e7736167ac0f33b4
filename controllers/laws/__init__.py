"""Control laws: one module for each, with the name of its kind in a scenario; tuned sets are in TOML files of that
name.

A module has one `railgrip.controllers.law.GroupLaw`, which says all that there is to say of the law: its parameters
with their units, the estimates that it needs, where its parameters are searched, and how it takes part in the type
test. The sets are `<kind>.toml`, written by `railgrip maintain tune-control`, and `<kind>.<name>.toml` for one of
another name.
"""
