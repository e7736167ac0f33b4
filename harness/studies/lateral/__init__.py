"""The lateral study: three filters on a wheelset that wanders, judged where Mal et al. (2020) show only curves.

`wheelset` is the plant on its track, `filters` what the filters know, `run` steps them with the plant, `judge` measures
one run, `study` runs many and keeps what is done, `tables` and `figures` say what came out. The study is open loop,
with a compiled run of its own: nothing brakes, and its step is 50 µs.
"""
