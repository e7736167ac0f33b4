"""A user's own data: files of recorded signals, made a recording that the estimators take.

    from railgrip.estimation.recorded.read import recorded

    taken = recorded(Path("run.csv"), table, model)       # table: [data] of an estimation
    taken.recording                                       # xarray, even grid, names and units of the model
    for flag in taken.flags: print(flag)                  # what was left out or bridged, and when

`table` is the column map, `files` reads formats, `cleaning` finds what is wrong with a signal, `grid` puts it on an
even grid. What cannot be mended is refused in a sentence; what can is mended and said, never silently.
"""
