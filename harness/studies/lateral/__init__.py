"""The lateral study: three filters for a wandering wheelset, judged where Mal et al. (2020) show only curves.

`wheelset` is the plant on its track, `run` steps it with the filters beside it, `judge` measures one run, `tables`
summarise many. The study is open loop: nothing brakes, and its step is 50 µs.
"""
