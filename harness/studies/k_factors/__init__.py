"""Confidence of a brake: K_dry of ETCS from the dispersion and failures of its components; docs/k_factors.md."""
