"""The lateral study: quantitative comparison of three filters, of which Mal et al. (2020) publish curves only.

`wheelset` is the plant on its track, `run` simulates it together with the filters, `judge` evaluates one run, `tables`
summarise many. The study is open loop: nothing brakes, and its step is 50 µs.
"""
