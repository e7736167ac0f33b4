"""Creates the train FMU of faulty.c, well-behaved or with one fault."""

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import fmpy
from tiny_fmu import HEADERS

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
    rows = [
        *(('input" variability="continuous', name, unit, ' start="0"') for name, unit in inputs),
        ('parameter" variability="fixed" initial="exact', "start_speed", "m/s", ' start="20"'),
        *(('output" variability="continuous" initial="calculated', name, unit, "") for name, unit in outputs),
    ]
    variables = "\n".join(
        f'<ScalarVariable name="{names.get(name, name)}" valueReference="{reference}" causality="{how}">'
        f'<Real unit="{unit}"{start}/></ScalarVariable>'
        for reference, (how, name, unit, start) in enumerate(rows)
    )
    unknowns = "".join(f'<Unknown index="{i}"/>' for i in range(len(inputs) + 2, len(rows) + 1))
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            '<fmiModelDescription fmiVersion="2.0" modelName="FaultyFmu" guid="{faulty_fmu}"',
            f'    generationTool="{tool}" variableNamingConvention="structured">',
            '<CoSimulation modelIdentifier="faulty_fmu" canHandleVariableCommunicationStepSize="true"/>',
            "<UnitDefinitions>",
            *(f'<Unit name="{name}">{base}</Unit>' for name, base in UNITS.items()),
            "</UnitDefinitions>",
            '<LogCategories><Category name="logStatusError"/></LogCategories>',
            f"<ModelVariables>{variables}</ModelVariables>",
            f"<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
            "</ModelStructure>",
            "</fmiModelDescription>",
        ]
    )


def stop_of_plant(
    file: Path, plant: Path | str, controller: str = "full_brake", *, trust: bool = True, more: str = ""
) -> Path:
    """Write the scenario of a short stop of a plant, named like its file, with `more` text below [vehicle]."""
    vehicle = f'[vehicle]\nplant = "{plant}"\ntrust = {str(trust).lower()}\n{more}\n'
    file.write_text(f'name = "{file.stem}"\nseed = 1\n{vehicle}{quick_stop(controller)}')
    return file


def quick_stop(controller: str) -> str:
    """Return the tables of a scenario behind [vehicle]: a short stop on good rail, steps of 10 ms, no estimator."""
    return f"""
[start]
speed = "36 km/h"
[adhesion]
kind = "constant"
polach = "dry"
mu0 = 0.3
[sensors]
kind = "ideal"
[actuation]
kind = "ideal"
[estimator]
kind = "none"
[controller]
kind = "{controller}"
[periods]
communication = "10 ms"
estimator = "10 ms"
controller = "10 ms"
trace = "10 ms"
[limits]
horizon = "30 s"
stop_speed = "0.1 m/s"
alpha_max = "tsi"
"""
