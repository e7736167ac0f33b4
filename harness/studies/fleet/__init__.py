"""What a fleet learns from many stops: pads, wheel radii and load, and releases designed for information.

`joint` combines the estimates of all stops, `releases` designs releases of single groups, `trains` simulates a fleet,
`study` compares the releases.
"""
