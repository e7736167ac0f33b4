"""How sure a brake is: K_dry of ETCS from the dispersion and failures of its components; docs/k_factors.md."""
