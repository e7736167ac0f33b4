"""Conditioning perturbs every real parameter of the plant by a small relative amount within its bounds."""

import numpy as np

from railgrip.scenario.vehicle_table import Nudge
from railgrip.simulate.bound_plant import perturb_parameters
from railgrip.simulate.named_models import description_of, parameters_of, recipe_file


def test_a_perturbation_is_small_and_reproducible_from_its_seed():
    plant = description_of(recipe_file("TwoPartTrain"))
    given = {"k_A": 1.0, "k_primary": 2e6}  # k_A is at its maximum: dry rail
    moved, again, other = (perturb_parameters(given, plant, Nudge(relative=1e-7, seed=seed)) for seed in (1, 1, 2))
    assert moved == again
    assert moved != other
    held = parameters_of(plant) | given
    names = [name for name in moved if held[name] != 0]
    shares = np.array([moved[name] / held[name] - 1 for name in names])
    assert len(names) > 90
    assert np.all(np.abs(shares) <= 1.0001e-7)
    assert np.count_nonzero(shares) >= len(names) - 5  # those at a bound stay there
    assert all(moves["k_A"] <= 1 for moves in (moved, other))
    assert np.std(shares) > 0.4e-7  # uniform: 0.58e-7
