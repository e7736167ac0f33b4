"""Speed and distance monitoring of ETCS: braking curves and supervision limits of a train on a line.

Paragraphs (§) and annexes (A.3) are those of SUBSET-026-3, version 3.6.0, in SI units; version 4.0.0 has the same
numbers. Its shorter build-up times near a target (A.3.12) are not applied.
"""
