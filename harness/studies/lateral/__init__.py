"""The lateral study: three filters on a wheelset that wanders, judged where Mal et al. (2020) show only curves.

`filters` says what the filters are told, `run` steps them with the twin, `judge` measures one run, `study` runs many
and keeps what is done, `tables` and `figures` say what came out; `command` is `railgrip lateral`.
"""
