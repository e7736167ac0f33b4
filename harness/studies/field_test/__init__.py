"""The field test of Schwarz, Lüdicke and Heckmann: recovery of the track, and friction estimation in case 6.

`runs` has the six runs, `filtering` the 13-state filter and its noises, `score` its errors against the truth; `tune`
finds the noises over cases 1 to 5. `railgrip.estimation.braking` computes distance and track force of a run.
"""
