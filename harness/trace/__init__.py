"""A trace: the signals of a run on one even time grid, whether a stop gave it or a train's recorder.

It is an xarray data set with the dimension `time` [s] and, where a signal has one value each, `group` or `wheelset`,
both counted from 1, lead to trail. Every variable has its unit. The prefix says who says it, as in
`railgrip.vehicle.signals`:

    reading_wheelset_speed   reading of the sensor, NaN without a new one; the only input of a filter
    wheelset_speed           true value, or input of the plant; in recordings only if it is known
    estimate_wheelset_speed  estimate of the estimator in the loop

    from railgrip.trace.netcdf import read_trace
    from railgrip.trace.read import read_recording
    from railgrip.trace.samples import recording_of, samples, truth_of

    trace = read_trace(Path("build/trapezoid/trace.nc"))          # a stop's own
    trace = read_recording(Path("run.csv"), table, …).recording   # csv, parquet, mat, mf4 by a map of columns
    trace = recording_of({"speed": (v, "m/s"), "wheelset_speed[1]": (w, "rad/s")}, period=0.01)
    samples(trace, ["speed", "wheelset_speed[1]"], ["m/s", "rad/s"])       # by the names of a model, shape (k, 2)

`table` is the map of columns, `files` reads formats, `cleaning` finds errors in a signal, `grid` puts it on an
even grid: errors are corrected and reported if possible, else refused.

Of a stop, `recorder` collects rows in the loop, and `metrics` measures the trace; `railgrip.report.stop` stores both.
"""
