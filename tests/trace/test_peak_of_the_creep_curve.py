"""The peak finder compared with a dense grid, on Polach's curve written out here."""

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from railgrip.simulate.contact import compiled_contact
from railgrip.simulate.named_models import compile_class
from railgrip.trace.bound import peak

STIFFNESS = 10e6  # N, G·π·a·b·c11/… of the order of a wheel of 7 t; only the shape matters here


def polach(slip, speed, load, mu0, k_a, k_s, a, b):
    """Polach (2005), adhesion of a wheelset of two wheels."""
    wheel = load / 2
    friction = mu0 * ((1 - a) * np.exp(-b * slip * speed) + a)
    gradient = np.pi * STIFFNESS * slip / (4 * wheel * friction)
    return 2 * friction / np.pi * (k_a * gradient / (1 + (k_a * gradient) ** 2) + np.arctan(k_s * gradient))


SETS = st.sampled_from(
    [
        (1, 0.4, 0.4, 0.6),
        (0.3, 0.1, 0.4, 0.2),
        (1, 1, 0.1, 0.2),
        (0.05, 0.02, 0.4, 0.15),
        (0.04, 0.015, 0.5, 0.1),
    ]
)


@given(shape=SETS, speed=st.floats(0.5, 60), mu0=st.floats(0.02, 0.6), other=st.floats(0.5, 1.0))
@example(shape=(0.04, 0.015, 0.5, 0.1), speed=55.0, mu0=0.59375, other=0.75)  # rises again towards the lock
@settings(max_examples=60)
def test_the_peak_is_that_of_a_dense_grid(shape, speed, mu0, other):
    def contact(slip, v, load, friction):
        return polach(slip, v, load, friction, *shape)

    load, friction = np.array([[1.3e5, 1.4e5]]), np.array([[mu0 * other, mu0]])
    slip, each = peak(contact, np.array([speed]), load, friction)
    dense = np.geomspace(1e-4, 1, 20001)[:, None] * np.ones(2)
    forces = (contact(dense, speed, load, friction) * load).sum(axis=1)
    total = float((each * load).sum())
    # The dense grid can miss the peak by half a step of 2.3e-4 of the slip, far below 1e-6 of the force.
    assert total >= forces.max() * (1 - 1e-9)
    assert total <= forces.max() * (1 + 1e-6)
    assert 1e-4 <= slip[0] <= 1


def test_samples_do_not_affect_each_other():
    def contact(slip, v, load, friction):
        return polach(slip, v, load, friction, 0.3, 0.1, 0.4, 0.2)

    speeds, loads, frictions = np.array([20.0, 3.0]), np.array([[1.3e5], [1.4e5]]), np.array([[0.1], [0.05]])
    together = peak(contact, speeds, loads, frictions)
    alone = [peak(contact, speeds[k : k + 1], loads[k : k + 1], frictions[k : k + 1]) for k in (0, 1)]
    assert np.array_equal(together[0], np.concatenate([slip for slip, _ in alone]))
    assert np.array_equal(together[1], np.concatenate([each for _, each in alone]))


def test_a_monotonic_curve_peaks_at_the_locked_wheel():
    slip, each = peak(lambda s, v, q, m: m * s, np.array([10.0]), np.array([[1e5]]), np.array([[0.1]]))
    assert slip[0] == 1.0
    assert each[0, 0] == 0.1


def test_the_compiled_contact_equals_the_model_at_each_point():
    model, random = compile_class("RailBraking.FMUs.ContactPoint"), np.random.default_rng(3)
    shape = {"k_A": 0.3, "k_S": 0.1, "A_falling": 0.4, "B_falling": 0.6}
    contact = compiled_contact(model, {"r_wheel": 0.31}, shape)
    points = np.stack([random.uniform(*ends, 20) for ends in ((0, 1), (0, 60), (4e4, 2e5), (0.01, 0.5))])
    curves = np.array([*shape.values()])[:, None] * random.uniform(0.5, 1.5, 20)

    def of_the_model(point, curve):
        names = [variable.name for variable in model.parameters]
        values = {variable.name: variable.start for variable in model.parameters} | {"r_wheel": 0.31}
        values |= dict(zip(shape, curve, strict=True))
        return float(model.output(0, [], point, [values[name] for name in names]))

    assert [variable.name for variable in model.inputs] == ["slip", "speed", "load", "mu0"]
    same = [of_the_model(point, shape.values()) for point in points.T]
    np.testing.assert_allclose(contact(*points), same, rtol=1e-13)
    each = [of_the_model(point, curve) for point, curve in zip(points.T, curves.T, strict=True)]
    np.testing.assert_allclose(contact(*points, curve=curves), each, rtol=1e-13)
    assert not np.allclose(same, each, rtol=1e-3)
