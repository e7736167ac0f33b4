"""Noises of the estimators: those of sensors and physics, times factors that were searched on training cases."""

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from typing import Final

from railgrip.estimators.tuning import NOISE_SETS, NoiseSet
from railgrip.studies.estimators.recordings import Sensors

FILE: Final = "noises.toml"
"""Factors of each estimator, in the folder `library` of this package; written by `--tune`."""

READINGS: Final[Mapping[Sensors, Mapping[str, float]]] = {
    "ideal": {"speed": 1e-3, "wheelset_speed": 1e-2, "acceleration": 1e-2, "deflection": 1e-5},
    "service": {"speed": 0.1, "wheelset_speed": 0.15, "acceleration": 0.05, "deflection": 2e-4},
    "worn": {"speed": 0.2, "wheelset_speed": 0.3, "acceleration": 0.08, "deflection": 4e-4},
}
"""Sensors → standard deviation of each reading, in its unit. A wheelset speed has the error of a tooth pitch at
50 rad/s; the bias of the accelerometer is a state."""

OUTLIER_LIMITS: Final[Mapping[str, float]] = {"wheelset_speed": 20.0}
"""Reading → largest innovation that is used, in standard deviations; all other readings are always used.

A sensor that reads 0 is far beyond this limit, the beginning of a slide is not; on the training cases a limit of 5
rejects slides. The radar has no limit: a stuck one moves the estimate before it is rejected, and then the correct
readings that follow are rejected."""

PROCESS_FACTORS: Final = {"group_adhesion": "alpha", "pad_friction": "mu_b", "wheelset_speed": "w", "d": "d"}
READING_FACTORS: Final = {"wheelset_speed": "wheelset_speed", "acceleration": "acceleration"}
ALL: Final = "all"
FACTORS: Final = (ALL, *PROCESS_FACTORS.values(), *READING_FACTORS.values())
"""Factors of standard deviations that are searched; those of process noises have the symbol of the state.

`all` multiplies every one: the gains of a Kalman filter remain, its deviations change.
"""

SEARCHED: Final = ("fmu", "reduced", "disturbed", "loaded", "force_balance", "disturbance_observer")
"""Estimators for which the factors are searched. All others contain an extended Kalman filter over the prediction of
`fmu`, or equal it there, and have its noises."""


def noise_of(estimator: str, sensors: Sensors, factors: Mapping[str, float] | None = None) -> NoiseSet:
    """Return the noises of an estimator for a class of sensors.

    Args:
        estimator: Name in the study; an unknown one has the noises of `fmu`.
        sensors: Class of sensors.
        factors: Factors by name, 1 where omitted; None for those of the file.
    """
    chosen = factors_of(estimator, sensors) if factors is None else factors
    physical, common = NOISE_SETS["loaded_service"], chosen.get(ALL, 1.0)
    # The process noise of adhesion of a prediction with a track force, see noises.toml.
    process = {**physical.process, "group_adhesion": NOISE_SETS["disturbed_service"].process["group_adhesion"]}

    def scaled(values: Mapping[str, float], keys: Mapping[str, str]) -> dict[str, float]:
        return {
            name: value * common * (chosen.get(keys[name], 1.0) if name in keys else 1.0)
            for name, value in values.items()
        }

    return NoiseSet(
        name=f"{estimator}, {sensors} sensors",
        process=scaled(process, PROCESS_FACTORS),
        readings=scaled(READINGS[sensors], READING_FACTORS),
        start=scaled(physical.start, {}),
    )


def factors_of(estimator: str, sensors: Sensors) -> Mapping[str, float]:
    """Return the factors of an estimator from the file; empty if the file lacks it."""
    text = (files("railgrip.studies.estimators") / "library" / FILE).read_text(encoding="utf-8")
    return tomllib.loads(text).get(estimator if estimator in SEARCHED else "fmu", {}).get(sensors, {})
