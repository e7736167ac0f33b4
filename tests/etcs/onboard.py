"""Trains and lines for tests of braking curves."""

from railgrip.supervision.limits import BrakingCase
from railgrip.supervision.line import Line, Target
from railgrip.supervision.model import TrainData, model_of
from railgrip.supervision.national import NationalValues

FAR = 20_000.0
"""Location of targets [m]: gradients that begin at 0 are under the train on every curve."""


def train_data(emergency=((0.0, 1.0),), service=((0.0, 0.8),), *, k_dry=1.0, k_wet=1.0, **changes):
    """A train by its curves, rows of speed [m/s] and deceleration [m/s2]."""
    table = {
        "name": "train",
        "source": "a test",
        "length": 200,
        "maximum_speed": 90,
        "brake_position": "passenger P",
        "emergency": [{"above": v, "deceleration": a, "k_dry": k_dry, "k_wet": k_wet} for v, a in emergency],
        "service": [{"above": v, "deceleration": a} for v, a in service],
        "emergency_time": 5,
        "service_time": 5,
        "traction_cut_off_time": 1,
    }
    return TrainData.model_validate(table | changes)


def percent_data(percentage, position, length, speed, **changes):
    """A train by its brake percentage [%], its speed in km/h."""
    table = {
        "name": "train",
        "source": "a test",
        "length": length,
        "maximum_speed": speed / 3.6,
        "brake_position": position,
        "brake_percentage": percentage / 100,
        "traction_cut_off_time": 10,
    }
    return TrainData.model_validate(table | changes)


def case_of(data, *targets, national=None, **line):
    """A case from the data of a train, targets as kind, location and speed [km/h], and keys of the line."""
    of = [Target(kind=kind, at=at, speed=speed / 3.6) for kind, at, speed in targets]
    return BrakingCase(model_of(data), NationalValues(**(national or {})), Line.model_validate({"target": of} | line))
