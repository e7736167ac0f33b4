"""The Python engine: any mix of parties, sample by sample. It is the reference for faster ones."""

import math
from collections.abc import Callable, Generator, Sequence

import numpy as np

from railgrip.controllers.observation import Observation
from railgrip.errors import ControllerFailed, SensorsFailed
from railgrip.loop.ending import (
    Ending,
    divergence,
    horizon,
    implausibility,
    standstill,
    without_command,
    without_controller,
    without_reading,
)
from railgrip.loop.parties import Parties
from railgrip.loop.plausible import Plausibility
from railgrip.loop.watch import watch_of


def run(parties: Parties, progress: Callable[[float], None] | None = None) -> Ending:
    """Brake with the parties' controller; arguments, errors and results are those of `decisions`."""
    going = decisions(parties, progress)
    try:
        observation = next(going)
        while True:
            try:
                demands = parties.controller.decide(observation)
            except ControllerFailed as failed:
                observation = going.throw(failed)
            else:
                observation = going.send(demands)
    except StopIteration as end:
        return end.value


def decisions(
    parties: Parties, progress: Callable[[float], None] | None = None
) -> Generator[Observation, Sequence[float], Ending]:
    """Brake until the train stands, the horizon is reached, or a party fails in a way that is a result.

    Whenever a decision is due, yields what a controller is shown and is sent the pressures that it demands [Pa]; a
    ControllerFailed that is thrown in instead ends the stop with that outcome.

    What the plant shows is checked before anybody reads it; a sample that cannot be ends the stop and is not kept.

    Each sample: the plant moves on under the commands held since the last one; sensors read; the driver asks; the
    estimator, when due, predicts under the pressures read a sample before and conditions on the new reading; the
    controller, when due, decides. Of its demand and the driver's the lower goes to the actuation. The row of a sample
    holds the truth at its end, the reading and belief then, and what was demanded and sent for it.

    Args:
        parties: Not yet started; their controller is not asked.
        progress: Called with the train speed [m/s] every 0.25 s of simulated time.

    Raises:
        PlantFailed: The plant refused a step; `recorder` holds the rows before.
    """
    layout, plant, rail, sensors = parties.layout, parties.plant, parties.rail, parties.sensors
    actuation, driver, faults, law = parties.actuation, parties.driver, parties.faults, parties.law
    clock, stop_speed, recorder = parties.clock, parties.stop_speed, parties.recorder
    rows, last = recorder.rows, len(recorder.rows) - 1
    truth_columns, input_columns, reading_columns = (
        recorder.block(s) for s in (layout.plant_signals, layout.sent_signals, layout.reading_signals)
    )
    period = clock.period
    report_every = max(round(0.25 / period), 1)
    at_speed, at_distance = layout.output["speed"].start, layout.output["distance"].start
    sent_command, sent_force = layout.input["command"], layout.input["track_force"].start

    inputs = np.zeros(layout.inputs)
    rail.lay(inputs)
    truth = plant.start(inputs)
    rail.meet(truth)
    watch = watch_of(layout, parties.state_estimator, parties.wheel_radius, recorder, driver.pressure)
    demand_columns = recorder.columns.get("demand")
    law_columns = recorder.block(law.signals) if law is not None else None
    driver_columns = recorder.columns["driver_demand"] if driver.has_phases else None
    traction_columns = recorder.columns.get("traction")
    demands = driver_demands = command = (0.0,) * layout.formation.groups
    nothing_new = np.full(layout.readings, np.nan)
    plausibility = Plausibility.before(period, parties.start_speed, parties.slowing)
    time, distance, speed = 0.0, float(truth[at_distance]), float(truth[at_speed])
    count, has_moved = 0, False
    try:
        for k in range(clock.samples + 1):
            if k > 0:
                truth = plant.step(inputs)
            time, distance, speed = k * period, float(truth[at_distance]), float(truth[at_speed])
            if not plausibility.holds(layout, k, truth, inputs):
                return implausibility(plausibility.reason(time), k)
            try:
                reading = nothing_new if k % clock.sensors else sensors.read(k // clock.sensors, truth)
            except SensorsFailed as failed:
                return without_reading(str(failed), k)
            if faults is not None:
                reading = faults.show(k, reading)
            row = rows[min(k, last)]
            row[truth_columns] = truth
            row[input_columns] = inputs
            row[reading_columns] = reading
            if demand_columns is not None:
                row[demand_columns] = demands
            if law is not None:
                row[law_columns] = law.values[law.places]
            if driver_columns is not None:
                row[driver_columns] = driver_demands
                if traction_columns is not None:
                    row[traction_columns] = driver.force
                driver.drive(k, truth)
                watch.driver_demand = driver.pressure
            watch.see(reading)
            if k % clock.estimator == 0:
                problem = watch.believe(time)
                if problem:
                    return divergence(problem, time, k)
            watch.record(row)
            count = k + 1
            if k % clock.controller == 0:
                observation = watch.observation(time)
                try:
                    demands = yield observation
                except ControllerFailed as failed:
                    return without_controller(str(failed), count)
                if not math.isfinite(sum(demands)):  # valve logic would take it for a wish to hold
                    return without_command(demands, time, count)
                demands_with_releases = watch.release(demands)
                if driver_columns is None:
                    command = actuation.command(demands_with_releases, observation.pressure)
                else:
                    driver_demands = driver.pressure.tolist()
                    pairs = zip(demands_with_releases, driver_demands, strict=True)
                    lower = [min(pair) for pair in pairs] if driver.binding else demands_with_releases
                    command = actuation.command(lower, observation.pressure)
                if not math.isfinite(sum(command)):
                    return without_command(command, time, count)
                inputs[sent_command] = command
            if faults is not None:
                inputs[sent_command] = faults.transmit(k, truth, command)
            has_moved = has_moved or speed > stop_speed
            if speed <= stop_speed and (has_moved or driver.pressure.any()):
                return standstill(distance, time, count)
            if progress is not None and k % report_every == 0:
                progress(speed)
            rail.roll(time, truth)
            rail.lay(inputs)
            if driver_columns is not None:
                inputs[sent_force] += driver.force
    finally:
        recorder.written = min(count, len(rows))
        watch.complete(rows[: recorder.written])
    return horizon(speed, distance, clock, count)
