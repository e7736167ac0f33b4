"""Run many stops in one pool of processes.

Campaigns, sweeps, repeats, and searches; each result is stored as one value.
"""
