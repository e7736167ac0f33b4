"""Named noises for the prediction models of the train: how far equations and sensors are trusted, and why.

A set is a value; change it with `dataclasses.replace` or write your own. Entries are standard deviations,
because people think in those: of a reading in its unit, of a start value in its unit, and of a process in its
unit per √s, the spread that one second of random walk adds.

The size of each entry follows from sensors and physics; Schwarz et al. (2019) tune such numbers by optimisation, the
objective rewarding only what is measured. That the sets work was first seen on stops of the table of braking distances
(trapezoid, sweep, random), so it was asked again on rails that no result is reported of: on the campaign `training`,
with valves and service sensors, a process noise of adhesion, pad friction or wheelset speed three times as large or as
small moves the mean distance of adhesion-based control by −0.13 to +0.27 %. The sets are no optimum, and distances do
not hang on them. The process noise of adhesion is cautious there: mean squared error over variance 0.18 above 10 km/h
and 0.85 with a third of it; that of pad friction is too small for the transducers' offset (see `TRAIN_SERVICE`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from railgrip.errors import EstimatorError
from railgrip.estimators.belief import Vector
from railgrip.estimators.gate import Gate


@dataclass(frozen=True, slots=True)
class Entry:
    """One standard deviation and why it has this size.

    Attributes:
        name: Variable without index: `w` stands for all of `w[1]`, `w[2]`, ….
        deviation: In `unit`, positive.
        unit: Of the deviation.
        reason: What sets the size.
    """

    name: str
    deviation: float
    unit: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseSet:
    """Everything a filter over a prediction is told about noise.

    Attributes:
        name: For reports.
        process: Of the states, per √s.
        readings: Of the outputs.
        start: Of the states at the start.
    """

    name: str
    process: tuple[Entry, ...]
    readings: tuple[Entry, ...]
    start: tuple[Entry, ...]

    def process_noise(self, states: Sequence[str]) -> Vector:
        """Return the densities of independent process noises in (unit of the state)²/s, shape (n,)."""
        return self._squares("process noise", self.process, states)

    def reading_noise(self, outputs: Sequence[str]) -> Vector:
        """Return the variances of independent readings, shape (m,)."""
        return self._squares("reading noise", self.readings, outputs)

    def start_covariance(self, states: Sequence[str]) -> Vector:
        """Return the variances of the states at the start, shape (n,)."""
        return self._squares("start", self.start, states)

    def _squares(self, what: str, entries: Sequence[Entry], names: Sequence[str]) -> Vector:
        """Return the squared deviation of each name, by what stands before its index."""
        deviations = {entry.name: entry.deviation for entry in entries}
        missing = sorted({name.partition("[")[0] for name in names} - deviations.keys())
        if missing:
            raise EstimatorError(
                f"Noise set '{self.name}': no {what} for {', '.join(missing)}; it has {', '.join(deviations)}."
            )
        return np.array([deviations[name.partition("[")[0]] for name in names]) ** 2


def pad_gate(
    *, pad_force: float, A_piston: float, i_rigging: float, eta_rigging: float, F_spring: float, groups: int
) -> Gate:
    """Return the gate that holds the pad friction of a group still while its pads are released.

    Args:
        pad_force: Normal force of both pads of one unit in N below which they count as released; 1–2 kN
            of the 56 kN at full brake: the torque of the pads is then within the errors of the other torques.
        A_piston: Area of a piston, m².
        i_rigging: Force of both pads over force of the piston.
        eta_rigging: Efficiency of the rigging.
        F_spring: Force of return spring and slack adjuster, N.
        groups: Number of brake groups.
    """
    return Gate(
        states=tuple(f"mu_b[{i}]" for i in range(1, groups + 1)),
        inputs=tuple(f"cylinder_pressure[{i}]" for i in range(1, groups + 1)),
        threshold=(pad_force / (eta_rigging * i_rigging) + F_spring) / A_piston,
    )


def pressure_spread(
    *, pad_friction: Vector, pressure: Vector, offset: float, A_piston: float, F_spring: float
) -> Vector:
    """Return the 1σ error that a pressure transducer's offset adds to an estimated pad friction, in its shape.

    The filter cannot know it (see `TRAIN_SERVICE`); whoever compares pad friction with a law, as the brake monitor
    does, adds it to the filter's own deviation, root of the sum of squares. It is the same error in every stop.

    Args:
        pad_friction: Estimated.
        pressure: In the cylinder, Pa; infinite results where it does not press the pads.
        offset: 1σ of the transducer's offset, Pa.
        A_piston: Area of a piston, m².
        F_spring: Force of return spring and slack adjuster, N.
    """
    pressing = np.maximum(np.asarray(pressure) * A_piston - F_spring, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(pad_friction) * offset * A_piston / pressing


START = (
    Entry("v", 0.1, "m/s", "started at the first reading of a sensor of this class"),
    Entry("w", 0.3, "rad/s", "0.1 m/s at the rim, started as rolling"),
    Entry("mu_b", 0.04, "1", "pads spread by 10 % between lots and 5 % between units around 0.35"),
    Entry("alpha", 0.02, "1", "a train that coasts or just begins to brake"),
)
START_SUSPENSION = (
    Entry("dz", 1e-4, "m", "deflection from static on smooth track; braking adds 3 mm"),
    Entry("ddz", 1e-2, "m/s", "0.2 mm at the 6–10 Hz of the primary suspension"),
)

PROCESS = (
    Entry("v", 1e-3, "m/s/√s", "the force balance holds but for wind and the like, 100 N on 84 t"),
    Entry("w", 1e-2, "rad/s/√s", "the torque balance holds but for hysteresis of the rigging"),
    Entry("mu_b", 0.005, "1/√s", "0.35 → 0.40 in a stop of 25 s is 0.05/√25 = 0.01, and it is smooth"),
    Entry(
        "alpha",
        0.1,
        "1/√s",
        "slip control moves adhesion by 0.03 in 0.1 s; a step is followed in milliseconds",
    ),
)
PROCESS_SUSPENSION = (
    Entry("dz", 1e-6, "m/√s", "a kinematic identity; a floor"),
    Entry("ddz", 1e-2, "m/s/√s", "unequal adhesion of coupled wheelsets, car bodies that move a little"),
)
PROCESS_SERVICE = (
    Entry("v", 1e-2, "m/s/√s", "as ideal, and gradients that the accelerometer takes for braking"),
    Entry("w", 1e-2, "rad/s/√s", "as ideal"),
    Entry("mu_b", 0.005, "1/√s", "as ideal"),
    Entry(
        "alpha",
        0.05,
        "1/√s",
        "half the ideal: beside such encoders more is only noise; steps take some 10 ms",
    ),
)

READINGS_IDEAL = (
    Entry("speed", 1e-3, "m/s", "perfect: a floor far below what a slip needs"),
    Entry("wheelset_speed", 1e-2, "rad/s", "perfect: a floor, 4 mm/s at the rim"),
    Entry("acceleration", 1e-2, "m/s2", "perfect: a floor, 0.001 in adhesion"),
)
READINGS_IDEAL_SUSPENSION = (Entry("deflection", 1e-5, "m", "perfect: a floor, 24 N of wheelset load"),)
READINGS_SERVICE = (
    Entry("speed", 0.1, "m/s", "Doppler radar: 0.05–0.15 m/s of noise, 0.2–0.5 % of scale error"),
    Entry("wheelset_speed", 0.2, "rad/s", "pulse timing: 0.05 rad/s from the clock, 0.2–0.5 % from tooth pitch"),
    # A bias is no white noise: claimed at its own size it would be averaged in with a weight of hundreds of readings.
    Entry("acceleration", 0.3, "m/s2", "0.03 of noise; 0.05 of bias counted as what 40 readings in a row share"),
)
READINGS_SERVICE_SUSPENSION = (Entry("deflection", 2e-4, "m", "potentiometer, 0.1–0.3 mm"),)

TRAIN_IDEAL = NoiseSet(
    name="train, ideal sensors",
    process=PROCESS + PROCESS_SUSPENSION,
    readings=READINGS_IDEAL + READINGS_IDEAL_SUSPENSION,
    start=START + START_SUSPENSION,
)
"""For `TrainPrediction` (25 states)."""

TRAIN_SERVICE = NoiseSet(
    name="train, service sensors",
    process=PROCESS_SERVICE + PROCESS_SUSPENSION,
    readings=READINGS_SERVICE + READINGS_SERVICE_SUSPENSION,
    start=START + START_SUSPENSION,
)
"""For `TrainPrediction` (25 states).

What it cannot state: cylinder pressure is an input, and the offset ε of its transducer, constant over a stop, is in
no equation. Readings determine the brake torque, n μ_B r F⊥(p); with a pressure read too high by ε, pad friction comes
out wrong by −μ_B ε A/(p A − F_spring), which no reading tells from a worse pad. The estimated deviation is therefore
that of pad friction *under the pressure as read*; its distance from the true one has another 1σ of `pressure_spread`:
0.012 at 1.9 bar and 0.028 at 1 bar for 0.5 % of 10 bar.

Measured over the trapezoid stop (valves, seed 2021, offsets 11.2, 5.4, 6.5 and −0.3 kPa): mean error of pad friction of
the two coupled groups −0.030 and 0.000 beside a deviation of 0.003, mean NEES 131 and 0.7. Without the offsets −0.001
and 1.4; with any other one of the instruments' errors left out instead, still −0.029 and more than 120. The torque is
right within 1.3 % in the mean for every group and adhesion within 0.002, and it is the torque that a controller
commands. Process noise of pad friction does not help: four times as much leaves the error, brings the NEES to 27 and
costs 2 to 5 m in each scenario.
"""

REDUCED_IDEAL = NoiseSet(name="reduced train, ideal sensors", process=PROCESS, readings=READINGS_IDEAL, start=START)
"""For `TrainPredictionReduced` (13 states)."""

REDUCED_SERVICE = NoiseSet(
    name="reduced train, service sensors", process=PROCESS_SERVICE, readings=READINGS_SERVICE, start=START
)
"""For `TrainPredictionReduced` (13 states)."""

DISTURBED_SERVICE = NoiseSet(
    name="train on an unknown track, service sensors",
    process=(
        *(entry for entry in TRAIN_SERVICE.process if entry.name != "alpha"),
        Entry("alpha", 0.025, "1/√s", "half of what TRAIN_SERVICE says, which was cautious; steps take as long"),
        Entry("d", 0.02, "m/s2/√s", "10 ‰ more of gradient in half a minute"),
        Entry("bias", 0.001, "m/s2/√s", "as good as constant; a floor"),
    ),
    readings=(
        Entry("acceleration", 0.05, "m/s2", "0.03 of noise; the bias is a state"),
        Entry("wheelset_speed", 0.1, "rad/s", "tooth pitch at half the highest speed; what one interval has too much"),
        *(entry for entry in TRAIN_SERVICE.readings if entry.name not in {"acceleration", "wheelset_speed"}),
    ),
    start=(
        *TRAIN_SERVICE.start,
        Entry("d", 0.15, "m/s2", "15 ‰ of gradient"),
        Entry("bias", 0.05, "m/s2", "of an instrument of this class"),
    ),
)
"""For `TrainPredictionDisturbed` (27 states); what is said of `TRAIN_SERVICE` of transducers holds.

The two entries of its own for wheelset speed and adhesion come from the 48 training cases of the type test, under
`slope_seeking`: with those of `TRAIN_SERVICE` the squared innovation is 0.80 of what is expected and the error of
adhesion, without its mean, a quarter of its deviation; with these 0.96 and two fifths. What the train weighs, which no
reading tells, is left out there: see `load_deviation` of a scenario's [estimator]."""

NOISE_SETS = {
    "disturbed_service": DISTURBED_SERVICE,
    "train_ideal": TRAIN_IDEAL,
    "train_service": TRAIN_SERVICE,
    "reduced_ideal": REDUCED_IDEAL,
    "reduced_service": REDUCED_SERVICE,
}
"""The sets by the names that scenario files use."""
