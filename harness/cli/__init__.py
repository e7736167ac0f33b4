"""The command line: each command parses its arguments, calls a function and shows the result.

Commands load what they need when they need it: a refusal or `--help` must not wait for CasADi.
"""
