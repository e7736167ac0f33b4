"""The ideal bound: the adhesion that the best possible control could have used at every sample of a stop.

For each group it is min(peak adhesion, brake limit, α_max): what the rail gives at the best slip, what full
brake pressure could have drawn, or that which the driver demanded, what the operator may use.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.signals import CURVE
from railgrip.trace.contact import Contact, peak
from railgrip.trace.recorder import formation_in

Array = NDArray[np.float64]

_STRIDE = 0.01  # s between creep curves; rail and loads (pitch near 7 Hz) are straight lines over so short a time


@dataclass(frozen=True, slots=True, kw_only=True)
class Brake:
    """What full pressure makes at the rim of each group; names and values are the plant's parameters.

    Attributes:
        p_max: Highest cylinder pressure, shape (groups,) [Pa].
        n_units: Brake units of the group, shape (groups,).
        r_friction: Friction radius, shape (groups,) [m].
        r_wheel: Rolling radius, shape (groups,) [m].
        J: Moment of inertia, shape (groups,) [kg m2].
        A_piston: Piston area, shape (groups,) [m2].
        i_rigging: Rigging ratio, both pads, shape (groups,).
        eta_rigging: Rigging efficiency, shape (groups,).
        F_spring: Force of the return spring at the piston, shape (groups,) [N].
    """

    p_max: Array
    n_units: Array
    r_friction: Array
    r_wheel: Array
    J: Array
    A_piston: Array
    i_rigging: Array
    eta_rigging: Array
    F_spring: Array

    def limit(self, pad_friction: Array, load: Array, deceleration: Array, pressure: Array | None = None) -> Array:
        """Return the adhesion at which full pressure, or another, would just hold the slip, shape (n, groups).

        Args:
            pad_friction: Of each group, shape (n, groups).
            load: Of each group, shape (n, groups) [N].
            deceleration: Of the train, shape (n,) [m/s2]; some torque goes into slowing the wheelsets.
            pressure: Most that there is of each group, shape (n, groups) [Pa]; None for full.
        """
        most = self.p_max if pressure is None else np.minimum(pressure, self.p_max)
        pad_force = self.eta_rigging * self.i_rigging * np.maximum(most * self.A_piston - self.F_spring, 0)
        torque = self.n_units * pad_friction * pad_force * self.r_friction
        rotation = self.J * deceleration[:, None] / self.r_wheel
        return np.maximum(torque - rotation, 0) / (self.r_wheel * load)


def with_bound(trace: xarray.Dataset, contact: Contact, brake: Brake, alpha_max: float) -> xarray.Dataset:
    """Return the trace with the variables that a comparison with the ideal needs.

    `peak_slip`, `peak_adhesion` (time, group): of the creep curve. `brake_limit` (time, group).
    `ideal_adhesion` (time, group): the bound. `ideal_share` (time, wheelset): what each wheelset contributes
    to the bound of its group, in the proportion of their adhesion at the group's best slip.
    """
    time, speed = trace["time"].values, trace["speed"].values
    load, mu0 = trace["wheelset_load"].values, trace["mu0"].values
    formation = formation_in(trace)
    groups = formation.group_of_wheelset
    period = time[1] - time[0] if len(time) > 1 else _STRIDE
    # The last sample is always among them, so that nothing is extrapolated.
    instants = np.unique(np.append(np.arange(0, len(time), max(1, round(_STRIDE / period))), len(time) - 1))

    peak_slip, peak_each = np.empty((len(time), formation.groups)), np.empty(load.shape)
    curve = np.stack([trace[signal.name].values for signal in CURVE]) if CURVE[0].name in trace else None
    for group, members in enumerate(formation.members()):
        here = contact if curve is None else partial(contact, curve=curve[:, instants, members])
        slip, each = peak(here, speed[instants], load[instants, members], mu0[instants, members])
        peak_slip[:, group] = np.interp(time, time[instants], slip)
        for number, member in enumerate(range(members.start, members.stop)):
            peak_each[:, member] = np.interp(time, time[instants], each[:, number])

    group_load = formation.summed(load)
    peak_adhesion = formation.summed(peak_each * load) / group_load
    demanded = None
    if "driver_demand" in trace:
        # A row holds what was demanded until then: what is demanded now stands in the next one.
        demanded = trace["driver_demand"].values[np.minimum(np.arange(len(time)) + 1, len(time) - 1)]
    force = "full" if demanded is None else "the demanded"
    limit = brake.limit(trace["pad_friction"].values, group_load, -trace["acceleration"].values, demanded)
    ideal = np.minimum(np.minimum(peak_adhesion, limit), alpha_max)
    share = peak_each * (ideal / peak_adhesion)[:, groups]

    columns = {
        "peak_slip": ("group", peak_slip, "slip of the greatest adhesion"),
        "peak_adhesion": ("group", peak_adhesion, "greatest adhesion of the rail"),
        "brake_limit": ("group", limit, f"adhesion that {force} brake pressure draws"),
        "ideal_adhesion": ("group", ideal, "adhesion of the ideal bound"),
        "ideal_share": ("wheelset", share, "share in the ideal bound"),
    }
    return trace.assign(
        {
            name: (("time", extent), values, {"units": "1", "long_name": meaning})
            for name, (extent, values, meaning) in columns.items()
        }
    )
