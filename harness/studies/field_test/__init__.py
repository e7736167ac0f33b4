"""The field test of Schwarz, Lüdicke and Heckmann: a track recovered, friction estimated in case 6.

`braking` turns the recording of a run into what the filter needs (distance, track force, the part from coasting to the
stop), `filtering` runs the 13-state filter, `objective` and `tune` find its noises over cases 1 to 5, `noise` keeps
them, `score` compares with the truth, `report` and `figures` show case 6.
"""
