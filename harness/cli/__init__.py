"""The command line: each command parses its arguments, calls a function and shows the result."""
