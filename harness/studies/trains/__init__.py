"""Comparison of the built-in trains with published stops, a calculation by hand, UIC 540, and a trial of sanders."""
