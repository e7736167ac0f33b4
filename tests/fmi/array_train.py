"""A train of four wheelsets as an FMU 3.0 made by PythonFMU3: its wheelsets are the elements of arrays."""

import math

from pythonfmu3 import CoSimulation, Dimension, Float64, Fmi3Causality, Fmi3SlaveBase, Fmi3Variability, Unit

WHEELS = 4
MASS, INERTIA, RADIUS = 40e3, 100.0, 0.45  # kg, kg.m2 and m of each wheelset
TORQUE = 3.5e-2  # N.m/Pa
FILLING = 0.1  # s
PEAK = 0.02  # creep at maximum adhesion
STEPS = 10  # in a communication step


class ArrayTrain(Fmi3SlaveBase, CoSimulation):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time = 0.0
        self.demand, self.grip = [0.0] * WHEELS, [0.3] * WHEELS
        self.v0 = 20.0
        self.state = [0.0, self.v0, *[self.v0 / RADIUS] * WHEELS, *[0.0] * WHEELS]  # distance, speed, wheels, cylinders
        self.register_units(
            [Unit("m/s", m=1, s=-1), Unit("Pa", kg=1, m=-1, s=-2),
             Unit("rad/s", rad=1, s=-1), Unit("m", m=1),
             Unit("m/s2", m=1, s=-2)]
        )  # fmt: skip
        array = [Dimension(start=str(WHEELS))]
        moving = {"variability": Fmi3Variability.continuous}
        inputs, outputs = (
            moving | {"causality": causality} for causality in (Fmi3Causality.input, Fmi3Causality.output)
        )

        def attribute(name):
            return {"getter": lambda: getattr(self, name), "setter": lambda value: setattr(self, name, value)}

        for variable in (
            Float64("time", causality=Fmi3Causality.independent, **moving),
            Float64("brake_demand", dimensions=array, unit="Pa", **inputs, **attribute("demand")),
            Float64("rail_grip", dimensions=array, **inputs, **attribute("grip")),
            Float64("v0", causality=Fmi3Causality.parameter, variability=Fmi3Variability.fixed, unit="m/s",
                    getter=lambda: self.v0, setter=self.set_start),
            Float64("odometer", unit="m", getter=lambda: self.state[0], **outputs),
            Float64("velocity", unit="m/s", getter=lambda: self.state[1], **outputs),
            Float64("acceleration", unit="m/s2", getter=lambda: self.slopes()[1], **outputs),
            Float64("wheel_speed", dimensions=array, unit="rad/s", getter=lambda: self.state[2:2 + WHEELS], **outputs),
            Float64("brake_pressure", dimensions=array, unit="Pa", getter=lambda: self.state[2 + WHEELS :], **outputs),
        ):  # fmt: skip
            self.register_variable(variable)

    def set_start(self, speed):
        self.v0 = speed
        self.state[1 : 2 + WHEELS] = [speed, *[speed / RADIUS] * WHEELS]

    def slopes(self):
        speed, wheels, cylinders = self.state[1], self.state[2 : 2 + WHEELS], self.state[2 + WHEELS :]
        load, fast = MASS * 9.81 / WHEELS, max(abs(speed), 1.0)
        creep = [(speed - RADIUS * wheel) / fast for wheel in wheels]
        force = [2 * load * mu * s * PEAK / (s * s + PEAK * PEAK) for mu, s in zip(self.grip, creep, strict=True)]
        torque = [TORQUE * pressure * math.tanh(wheel / 0.2) for pressure, wheel in zip(cylinders, wheels, strict=True)]
        return [
            speed,
            -sum(force) / MASS,
            *((RADIUS * f - t) / INERTIA for f, t in zip(force, torque, strict=True)),
            *((demand - pressure) / FILLING for demand, pressure in zip(self.demand, cylinders, strict=True)),
        ]

    def do_step(self, current_time, step_size):
        """Take steps of Heun's method."""
        h = step_size / STEPS
        for _ in range(STEPS):
            start, first = self.state, self.slopes()
            self.state = [x + h * dx for x, dx in zip(start, first, strict=True)]
            self.state = [x + h / 2 * (a + b) for x, a, b in zip(start, first, self.slopes(), strict=True)]
        self.time = current_time + step_size
        return True
