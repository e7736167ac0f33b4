"""Who takes part in a stop, and when it ends: what both engines are given."""

from dataclasses import dataclass

from railgrip.loop.driver import Driver
from railgrip.loop.ending import Clock
from railgrip.loop.faults import Faults
from railgrip.loop.plausible import Slowing
from railgrip.loop.ports import Actuation, Controller, DirectEstimator, LawStates, Plant, Rail, Sensors
from railgrip.loop.watch import StateEstimator
from railgrip.signals import Layout
from railgrip.trace.recorder import Recorder


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parties:
    """The parties of one stop, none of them started.

    Attributes:
        layout: Of the vectors that they exchange.
        plant: The simulated truth.
        rail: Friction and force along the track.
        sensors: Instruments.
        state_estimator: None if the controller sees readings only.
        controller: The law; who decides by hand leaves it alone.
        actuation: From demanded pressure to the plant's command.
        driver: The most that may be demanded, and traction.
        faults: Of sensors and brakes, if there are any: what sensors show, and what of a command arrives at the plant.
        wheel_radius: Nominal radii for a slip from readings [m].
        law: What of the controller's states is kept, if any is.
        clock: Periods and horizon.
        slowing: Bounds of what slows the plant beside adhesion.
        start_speed: That the plant was asked to start with [m/s].
        stop_speed: The train stands below this speed [m/s]; one that starts at rest, once it has been faster or brakes
            are asked for.
        recorder: Written from row 0 on; holds clock.samples + 1 rows.
    """

    layout: Layout
    plant: Plant
    rail: Rail
    sensors: Sensors
    state_estimator: StateEstimator | DirectEstimator | None
    controller: Controller
    actuation: Actuation
    driver: Driver
    faults: Faults | None = None
    wheel_radius: tuple[float, ...]
    law: LawStates | None = None
    clock: Clock
    slowing: Slowing
    start_speed: float
    stop_speed: float
    recorder: Recorder
