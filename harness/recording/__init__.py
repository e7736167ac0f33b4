"""A recording: measured signals from a user's file, as a trace that a filter can run over.

    from railgrip.recording.read import read_recording
    from railgrip.recording.samples import recording_of, samples, truth_of

    trace = read_recording(Path("run.csv"), table, …).recording   # csv, parquet, mat, mf4 by a map of columns
    trace = recording_of({"speed": (v, "m/s"), "wheelset_speed[1]": (w, "rad/s")}, period=0.01)
    samples(trace, ["speed", "wheelset_speed[1]"], ["m/s", "rad/s"])       # by the names of a model, shape (k, 2)

`table` is the map of columns, `files` reads formats, `cleaning` finds errors in a signal, `grid` puts it on an
even grid: errors are corrected and reported if possible, else refused.
"""
