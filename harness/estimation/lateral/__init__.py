"""The wheelset of Mal et al. (2020) with lateral and yaw motion, its filters, and their judgement.

`wheelset` is the plant on its track, `run` simulates it together with the filters, `judge` evaluates one run, and
`information` is what the readings determine. A run is open loop: nothing brakes, and its step is 50 µs.
"""
