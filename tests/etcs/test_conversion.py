"""The conversion model against the numbers of SUBSET-026, A.3.7 to A.3.9, worked out by hand."""

import numpy as np
import pytest
from onboard import FAR, case_of, percent_data

from railgrip.supervision import conversion
from railgrip.supervision.limits import times_of
from railgrip.supervision.model import integrated_factor, model_of, safe_deceleration
from railgrip.supervision.national import NationalValues


@pytest.mark.parametrize(
    ("percentage", "starts"),
    [
        (40, [0, 81.711, 100, 120, 150, 180]),
        (65, [0, 100.584, 120, 150, 180]),
        (135, [0, 137.525, 150, 180]),
        (200, [0, 162.720, 180]),
        (250, [0, 179.027, 180]),
    ],
)
def test_steps_below_the_first_limit_are_left_out(percentage, starts):
    """V_lim = 16.85 · 135^0.428 = 137.5 km/h, so that the polynomials 1 and 2 are ignored, and 3 starts there.

    test_independent_programs.py has the decelerations.
    """
    assert 3.6 * conversion.emergency_deceleration(percentage).starts == pytest.approx(starts, abs=1e-3)


def test_full_service_braking_uses_135_per_cent_at_most():
    """The Agency's tool left this out (openETCS/validation#141)."""
    for percentage in (136, 180, 250):
        service = conversion.service_deceleration(percentage)
        assert (service.values == conversion.emergency_deceleration(135).values).all()
    assert (conversion.service_deceleration(100).values == conversion.emergency_deceleration(100).values).all()


@pytest.mark.parametrize(
    ("position", "length", "emergency", "service"),
    [
        ("passenger P", 250, 2.3 + 0.17 * 16, 3 + 1.5 * 2.5 + 0.1 * 6.25),
        ("passenger P", 900, 2.3 + 0.17 * 81, 3 + 1.5 * 9 + 0.1 * 81),
        ("freight P", 700, 2.3 + 0.17 * 49, 3 + 2.77 * 7),
        ("freight P", 1200, -0.4 + 1.6 * 12 + 0.03 * 144, 10.5 + 0.32 * 12 + 0.18 * 144),
        ("freight G", 250, 12 + 0.05 * 6.25, 3 + 2.77 * 4),
        ("freight G", 1500, -0.4 + 1.6 * 15 + 0.03 * 225, 10.5 + 0.32 * 15 + 0.18 * 225),
    ],
)
def test_build_up_times_are_those_of_the_annex(position, length, emergency, service):
    factor = 1.16 if position == "freight G" else 1.2
    assert conversion.emergency_times(position, length) == pytest.approx((emergency, factor * emergency))
    assert conversion.service_times(position, length) == pytest.approx((service, factor * service))


def test_integrated_factors_apply_to_deceleration_and_build_up():
    data = percent_data(90, "freight P", 700, 120)
    national = NationalValues(
        M_NVKRINT=((0, 0.9), (600, 0.85)), M_NVKVINT_freight=((0, 0.8), (80 / 3.6, 0.7)), M_NVKTINT=1.2
    )
    model = model_of(data)
    safe = safe_deceleration(model, national)
    first = 0.0075 * 90 + 0.076
    assert safe.at(np.array([10.0, 30.0])) == pytest.approx([0.8 * 0.85 * first, 0.7 * 0.85 * first])
    case = case_of(data, ("SvL", FAR, 0), national={"M_NVKTINT": 1.2})
    assert times_of(case, 0.0).build_up == pytest.approx(1.2 * (2.3 + 0.17 * 49))
    assert times_of(case, 10.0).build_up == pytest.approx(1.2 * 1.2 * (2.3 + 0.17 * 49))


@pytest.mark.parametrize(("percentage", "factor"), [(80, 0.6), (135, 0.65), (200, 0.7)])
def test_passenger_trains_have_factors_between_two_sets(percentage, factor):
    """SUBSET-026 3.13.6.2.1.8.1: A_ebmax of 135 % is 1.0885 m/s2, in the middle between these limits."""
    national = NationalValues(M_NVKVINT_passenger=((0, 0.6, 0.7),), A_NVP12=0.9885, A_NVP23=1.1885)
    model = model_of(percent_data(percentage, "passenger P", 250, 160))
    assert integrated_factor(model, national).values == pytest.approx([factor])
