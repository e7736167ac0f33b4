"""Creates the train FMU of faulty.c, well-behaved or with one fault."""

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import fmpy
from tiny_fmu import HEADERS, LOGS, model_description, row

from railgrip.fmus.native.toolchain import shared_library

HERE = Path(__file__).parent
SOURCES = {name: (HERE / name).read_text() for name in ("faulty.c", "quiet.h", "reals_only.h")}
UNITS = {
    "bar": '<BaseUnit kg="1" m="-1" s="-2" factor="1e5"/>',
    "km/h": '<BaseUnit m="1" s="-1" factor="0.2777777777777778"/>',
    "Pa": '<BaseUnit kg="1" m="-1" s="-2"/>',
    "m": '<BaseUnit m="1"/>',
    "m/s": '<BaseUnit m="1" s="-1"/>',
    "m/s2": '<BaseUnit m="1" s="-2"/>',
    "rad/s": '<BaseUnit rad="1" s="-1"/>',
    "1": "<BaseUnit/>",
}


def faulty_fmu(
    folder: Path,
    misbehaviour: str = "WELL",
    *,
    speed_unit: str = "m/s",
    pressure_unit: str = "Pa",
    names: Mapping[str, str] = MappingProxyType({}),
    tool: str = "a hand",
    forged: bytes = b"",
    defined: Sequence[str] = (),
) -> Path:
    """Build the FMU in `folder` and return its file.

    Args:
        folder: Where the FMU is written.
        misbehaviour: A name defined in faulty.c.
        speed_unit: Declared unit of its speed.
        pressure_unit: Declared unit of its pressures.
        forged: What FORGES writes.
        names: Name in railgrip → name of that variable in the FMU.
        tool: Declared generation tool.
        defined: Names defined in faulty.c with other values, as 'RADIUS=0.46'.
    """
    library = shared_library(
        SOURCES,
        "_".join(["faulty_fmu", misbehaviour.lower(), *(d.replace("=", "_") for d in defined)]),
        include=(HEADERS,),
        flags=tuple(
            f"-D{name}"
            for name in (f"MISBEHAVIOUR={misbehaviour}", f"FORGED={','.join(map(str, forged or b'0'))}", *defined)
        ),
    )
    file = folder / f"{misbehaviour.lower()}.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", _description(speed_unit, pressure_unit, names, tool))
        archive.write(library, f"binaries/{fmpy.platform}/faulty_fmu{fmpy.sharedLibraryExtension}")
    return file


def _description(speed_unit: str, pressure_unit: str, names: Mapping[str, str], tool: str) -> str:
    inputs = [(f"pressure_command[{i}]", pressure_unit) for i in range(1, 5)] + [
        (f"mu0[{i}]", "1") for i in range(1, 7)
    ]
    outputs = [
        *(("distance", "m"), ("speed", speed_unit), ("acceleration", "m/s2")),
        *((f"wheelset_speed[{i}]", "rad/s") for i in range(1, 5)),
        *((f"cylinder_pressure[{i}]", pressure_unit) for i in range(1, 5)),
    ]
    given = [
        *((name, unit, "input", "continuous", "", ' start="0"') for name, unit in inputs),
        ("start_speed", "m/s", "parameter", "fixed", "exact", ' start="20"'),
        *((name, unit, "output", "continuous", "calculated", "") for name, unit in outputs),
    ]
    rows = [
        row(names.get(name, name), reference, *how, f'Real unit="{unit}"{start}')
        for reference, (name, unit, *how, start) in enumerate(given)
    ]
    numbers = range(len(inputs) + 2, len(rows) + 1)
    definitions = "".join(f'<Unit name="{name}">{base}</Unit>' for name, base in UNITS.items())
    return model_description(
        "FaultyFmu",
        '<CoSimulation modelIdentifier="faulty_fmu" canHandleVariableCommunicationStepSize="true"/>'
        f"<UnitDefinitions>{definitions}</UnitDefinitions>{LOGS}",
        rows,
        {"Outputs": numbers, "InitialUnknowns": numbers},
        more=f'generationTool="{tool}" variableNamingConvention="structured"',
        guid="{faulty_fmu}",
    )


def stop_of_plant(
    file: Path, plant: Path | str, controller: str = "full_brake", *, trust: bool = True, more: str = ""
) -> Path:
    """Write the scenario of a short stop of a plant, named like its file, with `more` text below [vehicle]."""
    vehicle = f'[vehicle]\nplant = "{plant}"\ntrust = {str(trust).lower()}\n{more}\n'
    file.write_text(f'name = "{file.stem}"\nextends = "plain"\n{vehicle}{quick_stop(controller)}')
    return file


def quick_stop(controller: str) -> str:
    """Return tables of a scenario that extends `plain`: a short stop on good rail, steps of 10 ms, no estimator."""
    return f"""
[start]
speed = "36 km/h"
[adhesion]
mu0 = 0.3
[estimator]
kind = "none"
[controller]
kind = "{controller}"
[periods]
communication = "10 ms"
estimator = "10 ms"
controller = "10 ms"
[limits]
horizon = "30 s"
"""
