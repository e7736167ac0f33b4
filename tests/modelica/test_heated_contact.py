"""Contacts heated and cleaned by slip: flash temperature, friction, and the same cleaning as that of the rail."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import rumoca
from maxima_stops import PECLETS, RAILS, interpolated_rise, mean_rise

from railgrip.fmus.native import Model, lower
from railgrip.scenario.surface import Polach
from railgrip.simulate.contact import compiled_contact
from railgrip.simulate.creep_curves import LOAD, curves

LIBRARY = Path(__file__).parents[2] / "modelica" / "RailBraking"
K, RHO, C_P = 50.0, 7850.0, 450.0
DRY = {"k_A": 1.0, "k_S": 0.4, "A_falling": 0.4, "B_falling": 0.6}
UNHEATED, PER_KELVIN = {"temperature_loss": 0.0}, 8.3e-4
SLIPS = np.geomspace(1e-3, 1.0, 200)


def at(contact, slip, speed, mu0, load=LOAD):
    return contact(slip, np.full_like(slip, speed), np.full_like(slip, load), np.full_like(slip, mu0))


def heated(shape, **parameters):
    return compiled_contact(lower("RailBraking.FMUs.HeatedContactPoint"), parameters, shape)


def call(function: str, tmp_path, **arguments: float) -> float:
    """Return the value of a function of the library."""
    source = tmp_path / "Calls.mo"
    written = ", ".join(f"{name}={value!r}" for name, value in arguments.items())
    source.write_text(
        f'block Calls "Calls a function"\n  RailBraking.Interfaces.RealOutput y(final unit="1") = '
        f"RailBraking.Contact.{function}({written});\nend Calls;\n"
    )
    model: Model = lower("Calls", source)
    return float(ca.evalf(ca.SX(model.output(0, ca.SX(0, 1), ca.SX(0, 1), ca.SX(0, 1)))))


def test_the_formula_of_the_flash_temperature_is_the_quadrature_of_moving_sources(tmp_path):
    """Tian and Kennedy's formula is an interpolation: exact at both ends, 4 % low at intermediate Péclet numbers."""
    for peclet in PECLETS:
        assert interpolated_rise(peclet) == pytest.approx(mean_rise(peclet), rel=0.04)
    assert interpolated_rise(0.0) == pytest.approx(mean_rise(0.0), rel=1e-3)
    a, speed = 5.8e-3, 20.0
    found = call("flashResistance", tmp_path, a=a, b=a, V=speed, k=K, rho=RHO, c_p=C_P)
    peclet = speed * a * RHO * C_P / (2 * K)
    assert found == pytest.approx(interpolated_rise(peclet) * a / K / (np.pi * a**2), rel=1e-9)


def test_with_temperature_independent_friction_the_heated_contact_is_the_cold_one():
    cold = compiled_contact(lower("RailBraking.FMUs.ContactPoint"), {}, DRY)
    assert np.array_equal(at(heated(DRY, **UNHEATED), SLIPS, 20.0, 0.3), at(cold, SLIPS, 20.0, 0.3))


def test_heating_replaces_the_fall_of_polachs_dry_curve():
    """The default of temperature_loss: Polach (2005), dry, at 40 km/h, within 6 % in the root mean square."""
    slip_speed = np.linspace(0.1, 5.0, 50)
    speed, full = 40 / 3.6, {"k_A": 1.0, "k_S": 1.0, "A_falling": 1.0, "B_falling": 0.0}
    friction = at(heated(full, temperature_loss=PER_KELVIN), slip_speed / speed, speed, 0.55)
    # Full sliding: with k_A = k_S = 1 adhesion equals friction, apart from 1/epsilon^3.
    published = 0.55 * (0.6 * np.exp(-0.6 * slip_speed) + 0.4)
    assert np.sqrt(np.mean((friction / published - 1) ** 2)) < 0.06


def test_a_hot_tread_lowers_friction_by_its_share_of_the_contact():
    """The contact of two equal rolling bodies has the mean of their temperatures."""
    mu0, rise = 0.3, 200.0
    full = {"k_A": 1.0, "k_S": 1.0, "A_falling": 1.0, "B_falling": 0.0}
    slip = np.array([1e-2])
    cold = at(heated(full, temperature_loss=PER_KELVIN), slip, 1.0, mu0)
    hot = at(heated(full, temperature_loss=PER_KELVIN, T_tread=293.15 + rise), slip, 1.0, mu0)
    assert hot / cold == pytest.approx(1 - PER_KELVIN * rise / 2, rel=2e-3)  # slip of 1 %: nearly equal speeds


@pytest.fixture(scope="module")
def session() -> rumoca.Session:
    return rumoca.Session(roots=[str(LIBRARY.parent)])


@pytest.mark.parametrize("rail", RAILS)
def test_a_contact_cleans_itself_like_the_rail(session: rumoca.Session, rail: str):
    """The steady adhesion of CleaningContact on cold treads is that of a heated contact on a cleaned rail."""
    name, mu0 = RAILS[rail]
    polach, slips, speed = Polach.model_validate(name), np.array([0.02, 0.1, 0.3, 0.6]), 80 / 3.6
    clean = polach.recovery
    assert clean is not None
    shape = f"k_A={polach.k_A}, k_S={polach.k_S}, A={polach.A}, B={polach.B}"
    source = f"""model Sliding
  parameter Real slip[{slips.size}] = {{{", ".join(map(str, slips))}}};
  RailBraking.Contact.CleaningContact contact[{slips.size}](
    each r=0.38, each curve=RailBraking.Data.CreepCurve({shape}), each mu_clean={clean.mu0},
    each removal_rate={clean.rate}, each removal_share=0, each tread(m=1e9));
equation
  for i in 1:{slips.size} loop
    contact[i].v = {speed};
    contact[i].w = (1 - slip[i])*{speed}/0.38;
    contact[i].load = {LOAD};
    contact[i].mu0 = {mu0};
  end for;
end Sliding;
"""
    model = session.loads(source, model="Sliding", filename="Sliding.mo")
    result = model.simulate((0, 1), dt=0.1, config=rumoca.SimConfig(solver="bdf", rtol=1e-8, atol=1e-9))
    contact = [np.asarray(result[f"contact[{i}].alpha"])[-1] for i in range(1, slips.size + 1)]
    _, cleaned = curves(name, mu0, slips, way=10.0)
    # The gain by cleaning is rounded by 1e-6/(4 gain), and the contact is as slow as its regularised slip: 1e-5.
    assert contact == pytest.approx(cleaned[:, 0], rel=1e-3)
