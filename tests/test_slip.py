"""Slip follows its definition, and near standstill it is not the quotient of two noises."""

import numpy as np

from railgrip.vehicle.brake import SMALL_SPEED, slip_of


def test_a_rolling_wheel_has_no_slip_and_a_locked_one_slips_fully():
    np.testing.assert_array_equal(slip_of(20.0, [20.0, 18.0, 0.0]), [0.0, 1.0 - 18.0 / 20.0, 1.0])


def test_near_standstill_slip_is_zero_and_without_a_speed_unknown():
    speed = np.array([[SMALL_SPEED], [0.9 * SMALL_SPEED], [-1.0], [np.nan]])
    slip = slip_of(speed, np.zeros((4, 2)))
    np.testing.assert_array_equal(slip[:, 0], [1.0, 0.0, 0.0, np.nan])
