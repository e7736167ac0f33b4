"""Supervision limits, release speeds and national values against their definitions in SUBSET-026."""

import numpy as np
import pytest
from onboard import FAR, case_of, percent_data, train_data

from railgrip.base.errors import InputError
from railgrip.supervision import fixed
from railgrip.supervision.limits import (
    emergency_curve,
    limits_of,
    release_speed,
    release_start,
    safe_deceleration,
    times_of,
    trip_location,
)
from railgrip.supervision.model import model_of
from railgrip.supervision.national import NationalValues

SPEED = 50.0


def limits(data, kind="SvL", speed=0, at=SPEED, **more):
    case = case_of(data, (kind, FAR, speed), **more)
    return limits_of(case, case.line.target[0], at)


def test_ceiling_margins_are_those_of_the_annex():
    """SUBSET-026 A.3.1 and 3.13.9.2.3 at the ends and in the middle of their ranges, in km/h."""
    for speed, warning, service, emergency in (
        (40, 4, 5.5, 7.5), (110, 4, 5.5, 7.5), (125, 4.5, 6.175, 8.625), (160, 5, 7.75, 11.25), (300, 5, 10, 15),
    ):  # fmt: skip
        at = fixed.ceiling_limits(speed / 3.6)
        margins = [3.6 * at[name] - speed for name in ("W", "SBI", "EBI")]
        assert margins == pytest.approx([warning, service, emergency])


def test_odometry_reads_too_little_as_in_subset_041():
    assert 3.6 * fixed.under_reading(np.array([0, 30, 265, 500]) / 3.6) == pytest.approx([2, 2, 7, 12])


def test_traction_that_lasts_moves_the_intervention():
    """T_traction = 12 − (2 + 5) = 5 s; A_est 1 m/s2 counts fully then, and 0.4 at most afterwards (T_be 8 s)."""
    data = train_data(traction_cut_off_time=12, emergency_time=8)
    case = case_of(data, ("SvL", FAR, 0), national={"Q_NVINHSMICPERM": True})
    at = limits_of(case, case.line.target[0], SPEED, 1.0)
    at_end = SPEED + 5 + 0.4 * 3
    driven = (SPEED + 2.5) * 5 + (SPEED + 5 + 0.4 * 3 / 2) * 3
    assert float(at["EBI"]) == pytest.approx(FAR - at_end**2 / 2 - driven)
    assert times_of(case_of(data.model_copy(update={"traction_cut_off": False}), ("SvL", FAR, 0)), 0).traction == 12


def test_without_service_brake_the_interventions_coincide():
    for at in (limits(train_data(service_brake=False)), limits(train_data(), national={"Q_NVSBTSMPERM": False})):
        assert float(at["SBI2"]) == float(at["EBI"])


def test_speeds_below_the_target_speed_do_not_shorten_the_way():
    """SUBSET-026 3.13.9.3.2.11: V_bec is not lower than V_target."""
    slow, target = limits(train_data(), "LoA", 60, 5.0), limits(train_data(), "LoA", 60, 60 / 3.6 - 1)
    assert float(slow["EBI"]) < float(target["EBD"])
    assert float(slow["EBD"]) == float(target["EBD"])


@pytest.mark.parametrize(("weight", "factor"), [(0.0, 0.7), (0.5, 0.85), (1.0, 1.0)])
def test_the_adhesion_weight_moves_from_wet_to_dry(weight, factor):
    model = model_of(train_data(k_dry=0.8, k_wet=0.7))
    safe = safe_deceleration(model, NationalValues(M_NVAVADH=weight))
    assert safe.values == pytest.approx([0.8 * factor * 1.0])


def test_guidance_may_only_move_the_permitted_speed_towards_the_train():
    rows = [{"above": 0, "deceleration": 0.5}]
    kn = [{"above": 0, "uphill": 2.0, "downhill": 3.0}]
    for slope, correction in ((0.01, 2.0), (-0.01, 3.0), (0.0, 0.0)):
        more = {"gradient": [{"begin": 0, "slope": slope}], "national": {"Q_NVGUIPERM": True}}
        at = limits(train_data(normal_service=rows, kn=kn), "EoA", **more)
        along = 9.81 * slope / (1.15 if slope > 0 else 1.02)
        deceleration = 0.5 + along - correction * slope
        assert float(at["GUI"]) == pytest.approx(FAR - SPEED**2 / 2 / deceleration)
        assert float(at["P"]) == min(float(at["GUI"]), float(at["SBI1"]) - 4 * SPEED)
    with pytest.raises(InputError, match="lacks normal_service"):
        limits(train_data(), "EoA", national={"Q_NVGUIPERM": True})


def test_guidance_to_a_speed_ends_where_the_permitted_speed_reaches_it():
    """SUBSET-026 3.13.8.5.2 b) and 3.13.9.3.5.9, .10."""
    data = train_data(normal_service=[{"above": 0, "deceleration": 0.5}])
    at = limits(data, "LoA", 60, 60 / 3.6, national={"Q_NVGUIPERM": True})
    without = limits(data, "LoA", 60, 60 / 3.6)
    assert float(at["GUI"]) == pytest.approx(float(without["P"]))


def authority(release, *restrictions, svl=500, **more):
    return case_of(
        percent_data(135, "passenger P", 250, 160),
        ("EoA", 5000, 0),
        ("SvL", 5000 + svl, 0),
        *restrictions,
        release=release,
        **({"balise": 4000} if release == "calculated" else {}),
        **more,
    )


def test_a_calculated_release_speed_is_intervened_at_the_trip_location():
    """SUBSET-026 3.13.9.4.8.2: V_release = V_EBD(d_trip + D_bec) − V_delta0."""
    case = authority("calculated")
    speed, svl = release_speed(case), case.line.one("SvL")
    assert trip_location(case) == 5000 + 2 * 12 + 10 + 0.1 * 1000
    assert speed is not None
    assert svl is not None
    v = speed + float(fixed.under_reading(speed))
    whole = max(times_of(case, 0.0).build_up, 10.0)  # traction lasts 10 s where it is not cut off
    assert emergency_curve(case, svl).speed(trip_location(case) + v * whole) == pytest.approx(v)
    # From the trip location the safe brake stops the train before the SvL.
    assert trip_location(case) + v * whole + v**2 / 2 / (0.7 * 0.9 * 1.0885) == pytest.approx(svl.at, abs=1e-3)


def test_release_speeds_come_from_where_the_line_says():
    assert release_speed(authority("none")) is None
    assert release_speed(authority("national")) == pytest.approx(40 / 3.6)
    assert release_speed(authority("given", release_speed=5.0)) == 5.0
    assert release_speed(authority("given", release_speed=39.0, speed=30.0)) == 30.0
    assert release_speed(authority("calculated", svl=100)) is None  # the trip location is behind the SvL
    # SUBSET-026 3.13.9.4.9
    assert release_speed(authority("national", ("MRSP", 4000, 30))) == pytest.approx(30 / 3.6)


def test_a_restriction_between_trip_location_and_supervised_location_lowers_the_release_speed():
    free = release_speed(authority("calculated", svl=800))
    speed = release_speed(authority("calculated", ("MRSP", 5300, 20), svl=800))
    assert free is not None
    assert speed is not None
    assert 20 / 3.6 <= speed < free


def test_release_monitoring_starts_at_the_first_service_intervention():
    case = authority("national")
    eoa, svl = case.line.target
    v = 40 / 3.6
    assert release_start(case, v) == min(float(limits_of(case, eoa, v)["SBI1"]), float(limits_of(case, svl, v)["SBI2"]))
