"""The field test of Schwarz, Lüdicke and Heckmann: recovery of the track, and friction estimation in case 6.

`filtering` has the six runs, the 13-state filter and its noises, `score` its errors against the truth and the search
for the noises over cases 1 to 5. `railgrip.estimation.motion` computes distance and track force of a run. The page with
the figures of the paper is docs/studies/field_test.py.
"""
