"""A brake whose K is known in closed form: linear in Gaussian numbers and in the share of units that brake."""

from itertools import product

import numpy as np
from scipy.optimize import brentq
from scipy.stats import binom, norm

from railgrip.studies.k_factors.k_dry import KFactorSpecification


class LinearBrake:
    """Share of the braking units, times 1 minus 5 % of the first of eight numbers; the same formula for all eight."""

    units = (3, 2, 2, 3)
    dimension = 8
    outputs = ("first", "all")
    without = None
    SIGMA = 0.05

    def ratios(self, available, standard):
        whole = standard.sum(axis=1) / np.sqrt(self.dimension)
        return sum(available) / sum(self.units) * (1 + self.SIGMA * np.stack([standard[:, 0], whole], axis=1))

    def probability(self, k, isolated):
        """P(ratio < k) if no valve fails: units are isolated independently of each other."""
        n = sum(self.units)
        available = np.arange(1, n + 1)
        below = norm.cdf((k * n / available - 1) / self.SIGMA)
        return float(binom.pmf(available, n, 1 - isolated) @ below) + isolated**n * (k > 0)

    def quantile(self, probability, isolated):
        return brentq(lambda k: np.log(self.probability(k, isolated) / probability), 1e-3, 1.5, xtol=1e-12)


def specification(*, seed=1, runs=10, samples=100, isolated=1e-3, stuck=0.0, error_factor=1.0, beta=0.0, **more):
    """A study of a brake; `error_factor` and `beta` are those of the isolated units."""

    def failure(probability, error_factor, beta):
        cause = {"beta": beta, "source": "a test"}
        return {"probability": probability, "error_factor": error_factor, "source": "a test", "common_cause": cause}

    mass = {"quantity": "mass", "per": "train", "kind": "normal", "deviation": "2 %", "source": "a test"}
    table = {"name": "test", "seed": seed, "scenario": "plain", "speed_steps": [], "dispersion": [mass]}
    table["estimate"] = {"runs": runs, "samples": samples}
    units, valves = failure(isolated, error_factor, beta), failure(stuck, 1.0, 0.0)
    table["failures"] = {"isolated_unit": units, "stuck_valve": valves}
    return KFactorSpecification.model_validate(table | more)


def brute_states(units, isolated, stuck):
    """Every combination of single units and valves: available units of each group → probability."""
    states = {}
    for losses in product(*(product((0, 1), repeat=n + 1) for n in units)):
        p = np.prod([(stuck if f[0] else 1 - stuck) * np.prod([isolated if u else 1 - isolated for u in f[1:]])
                     for f in losses])  # fmt: skip
        available = tuple(0 if f[0] else len(f) - 1 - sum(f[1:]) for f in losses)
        states[available] = states.get(available, 0.0) + p
    return states
