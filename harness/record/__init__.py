"""What remains of a stop: the trace of its signals, the figures taken from it, its outcome, and their files.

`recorder` collects rows, `trace` names them and writes NetCDF, `metrics` measures, `stop` holds and stores
the whole.
"""
