"""What the results mean: tables, figures and reports, and whether anything moved against the baselines.

Reads result folders; runs nothing.
"""
