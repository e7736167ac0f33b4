"""Run many stops in one pool of processes.

The stops are those of campaigns, sweeps, repeats, and searches; each result is stored as one value.
"""
