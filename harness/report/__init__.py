"""Present and compare results: tables, figures and reports, and the comparison with baselines.

This package reads result folders and runs no simulation.
"""
