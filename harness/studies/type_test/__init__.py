"""The type test: controllers against one another on many stops that none was tuned on, judged clause by clause."""
