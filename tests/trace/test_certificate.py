"""The certificate of bounded slip against a reduced model of a wheelset, integrated with another method."""

from dataclasses import replace

import numpy as np
import pytest
import xarray
from bounded_slip import HORIZON, STRIDE, slip_bound, with_certificate
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from railgrip.vehicle.brake import Brake

BRAKE = Brake(
    load=1e5,
    inertia=100.0,
    wheel_radius=0.42,
    units=2,
    friction_radius=0.25,
    piston_area=0.03,
    rigging=2.5,
    spring_force=1500.0,
    pressure_max=3.8e5,
)
PADS = 0.35
CHOKED = 15e5
VALVES = {"T_fill": 0.4, "T_vent": 0.2, "dead_fill": 0.05, "dead_vent": 0.04, "rate_choked": CHOKED}
SLOWING = 0.5  # m/s²


def contact_of(lowest, decay):
    """Polach's curve with falling friction, its stiffness that of a dry rail."""

    def contact(slip, speed, load, mu0):
        friction = mu0 * ((1 - lowest) * np.exp(-decay * slip * speed) + lowest)
        stiffness = 40.0 * slip / friction
        return friction * 2 / np.pi * (stiffness / (1 + stiffness**2) + np.arctan(stiffness))

    return contact


def slide(contact, speed, friction, release_at):
    """Return the trace of a wheelset that is braked until its slip exceeds a value, and released from then on.

    The valves act on commands of every millisecond after their dead times, and slip and pressure are integrated with
    bounded steps by an explicit Runge-Kutta method.
    """
    period, samples = 1e-3, len(friction)
    times = np.arange(samples) * period
    command, slip, pressure = np.ones(samples), np.zeros(samples), np.zeros(samples)
    dead = {True: round(VALVES["dead_fill"] / period), False: round(VALVES["dead_vent"] / period)}

    def torque(pressure):
        return BRAKE.units * PADS * BRAKE.friction_radius * BRAKE.pad_force(pressure)

    for k in range(samples - 1):
        command[k] = -1.0 if (k and command[k - 1] < 0) or slip[k] > release_at else 1.0
        filling = k >= dead[True] and command[k - dead[True]] > 0
        venting = k >= dead[False] and command[k - dead[False]] < 0

        def rates(time, state, k=k, filling=filling, venting=venting):
            slip, pressure = state
            v = speed - SLOWING * time
            force = BRAKE.load * contact(max(slip, 1e-9), v, BRAKE.load, friction[k])
            wheel = (torque(pressure) - BRAKE.wheel_radius * force) * BRAKE.wheel_radius / (BRAKE.inertia * v)
            flow = pressure / VALVES["T_vent"]
            vented = flow / (1 + (flow / CHOKED) ** 8) ** 0.125 if venting else 0.0
            filled = (BRAKE.pressure_max - pressure) / VALVES["T_fill"] if filling else 0.0
            return wheel - (1 - slip) * SLOWING / v, filled - vented

        done = solve_ivp(rates, (times[k], times[k + 1]), (slip[k], pressure[k]), rtol=1e-4, atol=(1e-7, 1.0))
        slip[k + 1], pressure[k + 1] = np.clip(done.y[0, -1], 0.0, 1.0), done.y[1, -1]
    command[-1] = command[-2]
    columns = {"slip": slip, "command": command, "cylinder_pressure": pressure, "pad_friction": np.full(samples, PADS)}
    of_wheelset = {"mu0": friction, "wheelset_load": np.full(samples, BRAKE.load)}
    return xarray.Dataset(
        {name: (("time", "group"), values[:, None]) for name, values in columns.items()}
        | {name: (("time", "wheelset"), values[:, None]) for name, values in of_wheelset.items()}
        | {"speed": ("time", speed - SLOWING * times), "group_of_wheelset": ("wheelset", [1])},
        coords={"time": times},
    )


def certificate_of(trace, contact):
    return with_certificate(trace, contact, (BRAKE,), VALVES, window=0.1)


def friction_of(mean, deviation, correlation, seed, duration=1.6):
    """Friction in steps of one millisecond, an exponentially correlated process within 40 % of its mean."""
    noise = np.random.default_rng(seed).standard_normal(round(duration / 1e-3))
    values, share = np.zeros_like(noise), 1e-3 / correlation
    for k in range(1, len(noise)):
        values[k] = (1 - share) * values[k - 1] + np.sqrt(2 * share) * noise[k]
    return mean * (1 + np.clip(deviation * values, -0.4, 0.4))


@settings(max_examples=8, deadline=None)
@given(
    mean=st.floats(0.03, 0.15),
    deviation=st.floats(0.0, 0.3),
    correlation=st.floats(0.02, 1.0),
    lowest=st.floats(0.3, 0.9),
    decay=st.floats(0.1, 0.8),
    speed=st.floats(6.0, 40.0),
    release_at=st.floats(0.02, 0.45),
    seed=st.integers(0, 999),
)
def test_slip_never_exceeds_the_bound_of_a_released_wheelset(
    mean, deviation, correlation, lowest, decay, speed, release_at, seed
):
    contact = contact_of(lowest, decay)
    found = certificate_of(slide(contact, speed, friction_of(mean, deviation, correlation, seed), release_at), contact)
    inside = np.isfinite(found["slip_bound"].values)
    over = (found["slip_reached"] - found["slip_bound"]).values[inside]
    # The certificate has one sample of friction for ten of the model.
    assert np.nanmax(over, initial=-1.0) < 2e-3


def falling_rail(share, at=0.55):
    return np.where(np.arange(1600) * 1e-3 < at, 0.1, 0.1 * share)


@settings(max_examples=6, deadline=None)
@given(
    share=st.floats(0.1, 0.4),
    length=st.floats(0.15, 0.25),
    lowest=st.floats(0.6, 0.95),
    decay=st.floats(0.05, 0.2),
    speed=st.floats(8.0, 16.0),
)
def test_slip_exceeds_a_bound_from_mean_friction_in_a_dip_but_not_the_certificate(share, length, lowest, decay, speed):
    """A short dip after the release hardly changes the mean friction of the horizon."""
    contact, times = contact_of(lowest, decay), np.arange(1600) * 1e-3
    in_dip = (times >= 0.55) & (times < 0.55 + length)
    trace = slide(contact, speed, np.where(in_dip, 0.1 * share, 0.1), 0.02)
    found = certificate_of(trace, contact)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "bounded_slip.slip_bound",
            lambda rail, release: slip_bound(replace(rail, shortfall=0.0 * rail.shortfall), release),
        )
        of_mean = certificate_of(trace, contact)
    reached = found["slip_reached"].values
    assert np.nanmax(reached - of_mean["slip_bound"].values) > 2e-3
    assert np.nanmax(reached - found["slip_bound"].values) < 2e-3


def test_there_is_no_bound_where_the_release_is_too_late():
    contact = contact_of(0.3, 0.8)
    trace = slide(contact, 10.0, falling_rail(0.2), 0.8)
    assert trace["slip"].values.max() > 0.98
    found = certificate_of(trace, contact).isel(group=0)
    late = ((found["slip"] > 0.8) & (found["slip"] < 0.95) & found["slip_reached"].notnull()).values
    assert late.any()
    assert np.isnan(found["slip_bound"].values[late]).all()


def test_samples_without_slide_have_a_bound_near_their_slip():
    contact = contact_of(0.6, 0.2)
    quiet = slide(contact, 20.0, np.full(1600, 0.14), 0.001)
    found = certificate_of(quiet, contact).isel(group=0, time=slice(-20, None))
    assert found["slip_bound"].values == pytest.approx(found["slip"].values, abs=1e-3)


def test_the_change_of_adhesion_is_split_into_those_of_slip_and_of_the_rail():
    contact = contact_of(0.6, 0.2)
    trace = slide(contact, 15.0, falling_rail(0.5), 0.02)
    found = certificate_of(trace, contact).isel(group=0)
    step = round(0.1 / STRIDE)
    slip, speed = found["slip"].values, trace["speed"].values[:: round(STRIDE / 1e-3)]
    friction = trace["mu0"].values[:: round(STRIDE / 1e-3), 0]
    total = contact(slip, speed, 1e5, friction)[step:] - contact(slip, speed, 1e5, friction)[:-step]
    parts = (found["adhesion_by_slip"] + found["adhesion_by_rail"]).values[:-step]
    # Neither part contains the product of both changes.
    product = np.abs(np.diff(friction, append=friction[-1])).sum()
    assert np.abs(total - parts).max() < product
    assert found.sizes["time"] * STRIDE > 2 * HORIZON
