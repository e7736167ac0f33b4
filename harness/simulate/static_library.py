"""The onboard part of a scenario as a static library for real-time targets, with readings of its stop to time it on."""

from collections.abc import Iterator
from pathlib import Path

from railgrip.base.files import write_bytes
from railgrip.fmus.native.discrete import WrittenStep
from railgrip.fmus.native.embedded import sources_of_library
from railgrip.fmus.native.package import c_identifier
from railgrip.fmus.native.toolchain import FMU_FLAGS, static_library
from railgrip.scenario.schema import Scenario
from railgrip.simulate.parts_in_c import part_in_c, readings_of


def write_library(scenario: Scenario, folder: Path) -> Iterator[Path]:
    """Write library, header, worst_case.c, readings.csv and the folder `sources`; yield the files.

    Raises:
        ScenarioError: A part of it is not in C, see `part_in_c`.
        CompilerMissing, BuildFailed: From the C compiler.
    """
    system = part_in_c(scenario, "onboard")
    name, files = c_identifier(system.name), sources_of_library(system)
    assert isinstance(system.step, WrittenStep)
    units = (f"{name}.c", *system.step.units)
    names = ",".join(variable.name for variable in system.inputs)
    rows = "\n".join(",".join(map(repr, row)) for row in readings_of(scenario).tolist())
    beside = {f"{name}.h": files[f"{name}.h"], "worst_case.c": files["worst_case.c"]}
    beside["readings.csv"] = f"{names}\n{rows}\n"
    contents = {folder / file: text.encode() for file, text in beside.items()}
    contents |= {folder / "sources" / file: text.encode() for file, text in files.items() if file not in beside}
    contents[folder / "sources" / f"{name}.h"] = contents[folder / f"{name}.h"]
    contents[folder / f"lib{name}.a"] = static_library(files, name, units=units, flags=FMU_FLAGS)
    (folder / "sources").mkdir(parents=True, exist_ok=True)
    for file, content in contents.items():
        write_bytes(file, content)
        yield file
