"""A run of the lateral wheelset as a recording, for any estimator that reads recordings."""

import numpy as np
import xarray

from railgrip.loop.compiled import run
from railgrip.studies.lateral.run import Case
from railgrip.studies.lateral.wheelset import PERIOD, PLANTS, READINGS, course, output_columns, wheelset
from railgrip.trace.samples import recording_of


def recorded(case: Case) -> xarray.Dataset:
    """Return readings and known inputs of a run on the grid of 50 µs, and the true states of `LateralPrediction`.

    Row k has what was read at the end of step k and the inputs that were held during it.
    """
    realisation = course(case.test, case.seed, case.irregularity)
    with wheelset(case.speed, PLANTS[case.plant].parameters) as plant:
        plant.start(realisation.inputs[0])
        outputs = run(plant, realisation.inputs, readings=tuple(READINGS), noise=realisation.noise).outputs
    states = {"y": "lateral_position", "dy": "lateral_velocity", "psi": "yaw_angle", "dpsi": "yaw_rate"}
    units = {"y": "m", "dy": "m/s", "psi": "rad", "dpsi": "rad/s"}
    places = output_columns((*READINGS, *states.values(), "speed"))
    return recording_of(
        {
            **{
                name: (outputs[:, places[name]][:, 0] + realisation.noise[:, i], unit)
                for i, (name, unit) in enumerate(READINGS.items())
            },
            "track": (realisation.inputs[:, 0], "m"),
            "speed": (outputs[:, places["speed"]][:, 0], "m/s"),
        },
        truth={
            **{state: (outputs[:, places[name]][:, 0], units[state]) for state, name in states.items()},
            "log_mu0": (np.log(realisation.inputs[:, 1]), "1"),
        },
        period=PERIOD,
        start=PERIOD,
        name=f"lateral {case.test.name}, {case.speed:g} m/s, seed {case.seed}",
    )
