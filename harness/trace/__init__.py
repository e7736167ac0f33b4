"""A trace: the signals of a run on one even time grid, whether a stop gave it or a train's recorder.

It is an xarray data set with the dimension `time` [s] and, where a signal has one value each, `group` or `wheelset`,
both counted from 1, lead to trail. Every variable has its unit. The prefix names the source, as in
`railgrip.vehicle.signals`:

    reading_wheelset_speed   reading of the sensor, NaN without a new one; the only input of a filter
    wheelset_speed           true value, or input of the plant; in recordings only if it is known
    estimate_wheelset_speed  estimate of the estimator in the loop

`recorder` collects the rows of a stop in the loop, `netcdf` stores a trace, and `metrics` measures it;
`railgrip.report.stop` stores both. `railgrip.recording` makes a trace from a file of a train's recorder.
"""
