"""How sure a brake is: K_dry of ETCS from the dispersion and the failures of its components; see docs/k_factors.md."""
