"""What a fleet learns from many stops: pads, wheel radii and load, and releases designed for information.

`trains` simulates a fleet and combines the estimates of all stops, `study` designs and compares releases of single
groups.
"""
