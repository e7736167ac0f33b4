"""The order of events in a stop, in Python: the loop in C must be bit-identical to it.

Plant, filter and law are in Python; sensors, driver, faults and rail are those of the loop.
"""

import math

import numpy as np
from kernel_calls import drive, holds, read, show, transmit
from synthetic import LAYOUT

from railgrip.base.errors import PlantFailed
from railgrip.controllers.observation import Observation
from railgrip.scenario.outcome import Outcome
from railgrip.vehicle.signals import DEVIATIONS, ESTIMATED_STATES, INNOVATION

AT, READ = LAYOUT.output, LAYOUT.reading


def is_due(k, every):
    """Return whether sample k is the first at or after a multiple of `every` samples, which may be fractional."""
    return k // every > (k - 1) // every


def brake(parts):
    """Run a stop; return its outcome and the number of rows in the recorder."""
    clock, recorder, belief = parts.clock, parts.recorder, parts.estimator
    columns = recorder.columns
    keep = lambda k, name, values: recorder.rows[k].__setitem__(columns[name], values)
    inputs, demand, command, driver_demand = np.zeros(LAYOUT.inputs), np.zeros(4), np.zeros(4), np.zeros(4)
    parts.rail.write_inputs(inputs)
    truth = parts.plant.start(inputs)
    latest = fresh = None
    innovation, moved, pressure = (0.0, 0.0), False, parts.full
    for k in range(clock.samples + 1):
        try:
            truth = parts.plant.step(inputs) if k else truth
        except PlantFailed:
            return Outcome.PLANT_FAILED, k
        if not holds(parts.plausibility, k, truth, inputs):
            return Outcome.IMPLAUSIBLE, k
        recorder.rows[k, recorder.block(LAYOUT.signals["output"])] = truth
        recorder.rows[k, recorder.block(LAYOUT.signals["input"])] = inputs
        keep(k, "demand", demand)
        if parts.driver:
            keep(k, "driver_demand", driver_demand)
            pressure = drive(parts.driver, k, truth)
        due = k % clock.sensors == 0
        reading = read(parts.sensors, k // clock.sensors, truth) if due else np.full(LAYOUT.readings, np.nan)
        reading = show(parts.faults, k, reading) if parts.faults else reading
        recorder.rows[k, recorder.block(LAYOUT.signals["reading"])] = reading
        new = ~np.isnan(reading)
        if belief and latest is None:
            belief.filter.inputs[:4] = reading[READ["cylinder_pressure"]]
        elif belief:
            fresh = reading if fresh is None else np.where(new, reading, fresh)
        latest = reading if latest is None else np.where(new, reading, latest)
        if belief and k and is_due(k, clock.estimator):
            belief.filter.readings[:] = fresh[belief.reading_places]
            try:
                belief.filter.advance()
            except ArithmeticError:
                return Outcome.DIVERGED, k
            innovation = belief.filter.squared_innovation, belief.filter.selection.sum()
            belief.filter.inputs[:4], fresh = latest[READ["cylinder_pressure"]], None
            if np.diagonal(belief.filter.covariance)[[*belief.adhesion, *belief.pad_friction]].min() < 0.0:
                return Outcome.DIVERGED, k
        if belief:
            mean, variance = belief.filter.mean, np.diagonal(belief.filter.covariance)
            of_groups = [belief.wheelset_speed, belief.adhesion, belief.pad_friction]
            recorder.rows[k, recorder.block(ESTIMATED_STATES)] = mean[np.concatenate([[belief.speed], *of_groups])]
            squares = variance[np.concatenate(of_groups[1:])]
            squares[:4] += (belief.load_deviation * mean[belief.adhesion]) ** 2
            recorder.rows[k, recorder.block(DEVIATIONS)] = np.sqrt(squares)
            keep(k, "estimate_slip", slip_of(mean[belief.speed], belief.wheel_radius, mean[belief.wheelset_speed]))
            recorder.rows[k, recorder.block(INNOVATION)] = innovation
        if is_due(k, clock.controller):
            seen = observation(parts, k, latest, pressure)
            demand = parts.controller.decide(seen)
            if parts.limits:
                demand = np.clip(demand, 0.0, parts.limits.maximum)
            if parts.train_level:
                demand = parts.train_level.decide(seen, demand)
            if not math.isfinite(sum(demand)):
                return Outcome.CONTROLLER_FAILED, k + 1
            driver_demand = pressure.copy() if parts.driver else driver_demand
            limited = np.minimum(demand, pressure) if parts.driver else demand
            measured = latest[READ["cylinder_pressure"]]
            command = limited if parts.valves is None else parts.valves.command(limited, measured)
            inputs[LAYOUT.input["command"]] = command
        if parts.faults:
            inputs[LAYOUT.input["command"]] = transmit(parts.faults, k, truth, command)
        speed = float(truth[AT["speed"]][0])
        moved = moved or speed > parts.stop_speed
        if speed <= parts.stop_speed and (moved or pressure.any()):
            return Outcome.STANDSTILL, k + 1
        parts.rail.advance(k * clock.period, truth)
        parts.rail.write_inputs(inputs)
        if parts.driver:
            inputs[LAYOUT.input["track_force"]] += parts.driver.struct.pointer.force
    return Outcome.HORIZON, clock.samples + 1


def observation(parts, k, latest, pressure):
    """Return the input of a law, from the filter or else from the readings."""
    belief, time = parts.estimator, k * parts.clock.period
    acceleration, measured = float(latest[READ["acceleration"]][0]), latest[READ["cylinder_pressure"]]
    if belief is None:
        speed, wheels, estimates = float(latest[READ["speed"]][0]), latest[READ["wheelset_speed"]], (None, None)
        readings = wheels
    else:
        mean, variance = belief.filter.mean, np.diagonal(belief.filter.covariance)
        speed, wheels = float(mean[belief.speed]), mean[belief.wheelset_speed]
        estimates = mean[belief.adhesion], mean[belief.pad_friction]
        lost = variance[belief.wheelset_speed] > (1.0 / np.array(belief.wheel_radius)) ** 2
        readings = np.where(lost, np.nan, wheels)
    slip = slip_of(speed, parts.wheel_radius if belief is None else belief.wheel_radius, wheels)
    return Observation(time, speed, acceleration, readings, slip, belief is not None, *estimates, measured, pressure)


def slip_of(speed, radius, wheels):
    return np.zeros(4) if speed < 0.05 else 1.0 - np.array(radius) * wheels / speed
