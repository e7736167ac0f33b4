"""Steps exported FMUs to standstill with FMPy alone: python docs/examples/loop_in_fmpy.py FOLDER.

The folder holds plant.fmu, track.fmu, sensors.fmu and onboard.fmu of one scenario, from `railgrip export`.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from fmpy import extract, instantiate_fmu, read_model_description

PERIOD = 1e-3
"""[periods] communication of the scenario [s]."""

COMMANDS = {"demand": "pressure_command", "command": "valve_command"}
"""What the plant calls the outputs of what is on board."""


class Part:
    """One FMU, unpacked into a folder, which keeps its outputs by name."""

    def __init__(self, path: Path, folder: Path) -> None:
        description = read_model_description(str(path))
        variables = description.modelVariables
        self.reference = {variable.name: variable.valueReference for variable in variables}
        self.inputs = [variable.name for variable in variables if variable.causality == "input"]
        self.outputs = [variable.name for variable in variables if variable.causality == "output"]
        self.fmu = instantiate_fmu(extract(str(path), str(folder)), description, fmi_type="CoSimulation")
        is_fmi_3 = description.fmiVersion.startswith("3")
        self.get, self.set = (
            (self.fmu.getFloat64, self.fmu.setFloat64) if is_fmi_3 else (self.fmu.getReal, self.fmu.setReal)
        )
        if not is_fmi_3:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def show(self) -> dict[str, float]:
        return dict(zip(self.outputs, self.get([self.reference[name] for name in self.outputs]), strict=True))

    def step(self, sample: int, values: dict[str, float]) -> dict[str, float]:
        """Take a step from a sample on with these inputs, and return the outputs at its end."""
        names = [name for name in self.inputs if name in values]
        self.set([self.reference[name] for name in names], [values[name] for name in names])
        self.fmu.doStep(currentCommunicationPoint=sample * PERIOD, communicationStepSize=PERIOD)
        return self.show()


def braking_distance(folder: Path, stop_speed: float = 0.1) -> float:
    """Return how far the train of the FMUs in a folder goes before it is no faster than `stop_speed` [m/s]."""
    with TemporaryDirectory(ignore_cleanup_errors=True) as unpacked:  # FMPy would leave what it unpacks
        names = ("plant", "track", "sensors", "onboard")
        return _distance(*(Part(folder / f"{name}.fmu", Path(unpacked) / name) for name in names), stop_speed)


def _distance(plant: Part, track: Part, sensors: Part, onboard: Part, stop_speed: float) -> float:
    truth, sample = plant.show(), 0
    while truth["speed"] > stop_speed:
        values = track.step(sample, truth)
        values |= sensors.step(sample, truth)
        for name, value in onboard.step(sample, values).items():
            quantity, bracket, group = name.partition("[")
            values[COMMANDS.get(quantity, quantity) + bracket + group] = value
        truth = plant.step(sample, values)
        sample += 1
    return truth["distance"]


if __name__ == "__main__":
    print(f"{braking_distance(Path(sys.argv[1])):.2f} m")
