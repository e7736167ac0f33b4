"""The quasi-static brake: deceleration in steps of speed and stopping distance, vectorised over draws.

s = v₀ t_e + Σ (v_j² − v_{j+1}²)/(2 a_j), a = (brake force + resistance)/(m + m_rot), the form of EN 14531-1. Names of
parameters are those of the plant `TwoPartTrainPneumatic`, whose pads and discs these are in their steady state.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from railgrip.base.errors import ScenarioError
from railgrip.estimators.belief import Array
from railgrip.rolling_stock.dispersion import Dispersion
from railgrip.supervision.dispersed import PARTS, Deviations, DispersedBrake
from railgrip.vehicle.brake import BRAKE, air_resistance, pad_force, rolling_resistance
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.parameters import VehicleParameters

_SCALARS = (
    *("speed_effect", "pad_speed_nominal", "temperature_effect", "temperature_nominal", "temperature_range"),
    *("force_effect", "pad_force_nominal", "m_disc", "m_disc_surface", "c_disc", "G_disc", "pad_share"),
    *("mu_bearing", "r_bearing", "e_rolling", "c_drag", "A_drag", "rho_air", "dead_fill", "T_fill", "leak"),
)


class QuasiStaticBrake(DispersedBrake):
    """The brake of a plant with the pads, discs and cylinders of `TwoPartTrainPneumatic`."""

    def __init__(
        self,
        parameters: Mapping[str, float],
        formation: Formation,
        dispersion: Sequence[Dispersion],
        speeds: Sequence[float],
    ) -> None:
        """Create the brake from the plant's parameters, dispersions, and limits of the steps of speed, falling to 0
        [m/s].

        Raises:
            ScenarioError: The plant lacks a parameter.
        """
        try:
            self._of = {name: parameters[name] for name in _SCALARS}
            self._friction, self._first_friction, self._temperature = (
                np.array([parameters[f"{name}[{g + 1}]"] for g in range(formation.groups)])
                for name in ("mu_b_nominal", "mu_b_start", "T_disc_start")
            )
            vehicle = VehicleParameters(formation, parameters)
            brakes, self._wheelset_mass = vehicle.formation.brakes, vehicle.masses
            self._brake = {name: np.array([getattr(brake, name) for brake in brakes]) for name in BRAKE}
        except KeyError as problem:
            raise ScenarioError(
                f"K factors are of a plant with the brake of TwoPartTrainPneumatic; this one lacks {problem}."
            ) from None
        super().__init__([int(count) for count in self._brake["units"]], dispersion, speeds)
        self._finish()

    def plant_parameters(self, available: Sequence[int], standard: Array | None) -> dict[str, float]:
        """Return the plant's parameters of one draw, shape (dimension,), or of the nominal train.

        The plant has one friction for all units of a group and one efficiency for all: what units differ by goes into
        the friction of their group.
        """
        deviations, braking = self._deviations(None if standard is None else standard[None, :]), np.array(available) > 0
        scale = self._torque(available, deviations)[0] / np.maximum(
            self._torque(available, deviations, alike=True)[0], 1e-9
        )
        scale = np.where(braking, scale, 1.0)
        each: dict[str, Array] = {
            "mu_b_nominal": self._friction * scale,
            "mu_b_start": self._first_friction * scale,
            # A disc that is not braked has no heat: its group keeps its units, and has zero pressure.
            "p_max": np.where(braking, self._brake["pressure_max"] + deviations["pressure"][0], 0.0),
            "n_units": np.where(braking, available, self.units),
            "r_wheel": self._brake["wheel_radius"] * deviations["wheel_radius"][0],
            "m_wheelset": self._wheelset_mass * deviations["mass"][0],
        }
        parameters = {
            f"{name}[{i + 1}]": float(value) for name, values in each.items() for i, value in enumerate(values)
        }
        return parameters | {"T_fill": self._of["T_fill"] * float(deviations["build_up"][0, 0])}

    def _pressure(self, deviations: Deviations) -> Array:
        """Return the steady cylinder pressure of each group, less the loss through the leak [Pa]."""
        return self._brake["pressure_max"] + deviations["pressure"] - self._of["leak"] * self._of["T_fill"]

    def _torque(self, available: Sequence[int], deviations: Deviations, *, alike: bool = False) -> Array:
        """Return the torque of each group at nominal speed and pad temperature [N m].

        With `alike` all units have nominal friction, efficiency and radius.
        """
        brake, of, group = self._brake, self._of, self._group
        force = pad_force(
            self._pressure(deviations),
            piston_area=brake["piston_area"],
            spring_force=brake["spring_force"],
            rigging=brake["rigging"],
        )[:, group]
        arm = brake["friction_radius"][group] * self._friction[group]
        if not alike:
            force, arm = (
                force * deviations["efficiency"],
                arm * deviations["friction_radius"] * deviations["pad_friction"],
            )
        torque = force * arm * (1 - of["force_effect"] * (force / of["pad_force_nominal"] - 1))
        of_group = (group == np.arange(len(self.units))[:, None]).astype(np.float64)
        return torque @ (of_group * self._brakes(available)).T

    def _stops(self, available: Sequence[int], deviations: Deviations) -> tuple[Array, Array, Array]:
        """Return the deceleration of each step, slowest first, shape (n, steps), distance and equivalent time."""
        brake, of, count = self._brake, self._of, np.maximum(np.asarray(available), 1)
        torque, radius = self._torque(available, deviations), brake["wheel_radius"] * deviations["wheel_radius"]
        mass = self._wheelset_mass.sum() * deviations["mass"][:, 0]
        inertial = mass + (brake["inertia"] / radius**2).sum(axis=1)
        rolling, drag = rolling_resistance(of, mass, brake["wheel_radius"].mean()), air_resistance(of)
        force = torque / radius
        share = force / np.maximum(force.sum(axis=1, keepdims=True), 1e-9)
        start, disc_share = self.speeds[0], 1.0 - of["pad_share"]
        steps: list[Array] = []
        distance = np.zeros(len(mass))
        for high, low in pairwise(self.speeds):
            width = (high**2 - low**2) / PARTS
            inverse = np.zeros(len(mass))
            for part in range(PARTS):
                square = high**2 - (part + 0.5) * width
                speed = square**0.5
                # The energy in the bulk of a disc is the braking energy less the energy that is still in its surface.
                energy = 0.5 * inertial[:, None] * (start**2 - square) * share / count
                surface = of["m_disc_surface"] * of["c_disc"] * force / count * speed / of["G_disc"]
                warmth = np.maximum(energy - surface, 0.0) * disc_share / (of["m_disc"] * of["c_disc"])
                heat = (self._temperature + warmth - of["temperature_nominal"]) / of["temperature_range"]
                pad_speed = speed * brake["friction_radius"] / radius / of["pad_speed_nominal"]
                steady = (1 + of["speed_effect"] * (1 - pad_speed)) * (1 + of["temperature_effect"] * _saturate(heat))
                deceleration = ((force * steady).sum(axis=1) + rolling + drag * square) / inertial
                inverse += 1 / deceleration
            steps.append(PARTS / inverse)
            distance += 0.5 * width * inverse
        piston = np.maximum(self._pressure(deviations) * brake["piston_area"], 1.0)
        # Pads touch when the pressure has passed the spring, and then their force follows with the same time constant.
        rise = np.where(
            piston > brake["spring_force"], -np.log1p(-np.minimum(brake["spring_force"] / piston, 0.99)), 0.0
        )
        time = of["dead_fill"] + of["T_fill"] * deviations["build_up"][:, 0] * (1 + (share * rise).sum(axis=1))
        return np.stack(steps[::-1], axis=1), distance + start * time, time


def _saturate(x: Array) -> Array:
    # As RailBraking.Friction.saturate.
    return (np.sqrt((x + 1) ** 2 + 0.01) - np.sqrt((x - 1) ** 2 + 0.01)) / 2
