"""Structs that C and Python share: every member stands where the other side looks for it."""

import ctypes

import pytest
from synthetic import LAYOUT

from railgrip.fmu import cosimulation
from railgrip.fmus.native.toolchain import shared_library
from railgrip.loop import compiled, compiled_cycle, driver, faults, library, plausible, rail, sensors

LOOP = {part: (library.KERNEL / part).read_text() for part in (*library._PARTS, "cycle.c", "run.c")}
SOURCES = LOOP | {"cosimulation.c": cosimulation.KERNEL.read_text(), "layout.h": LAYOUT.header()}


@pytest.mark.parametrize(
    ("source", "name", "mirror"),
    [
        ("sensors.c", "Encoder", sensors._Encoder),
        ("sensors.c", "Course", sensors._Course),
        ("sensors.c", "Service", sensors.service_struct(LAYOUT.formation.groups, LAYOUT.formation.wheelsets)),
        ("plausible.c", "Plausibility", plausible.Plausibility),
        ("driver.c", "Phase", driver._Phase),
        ("driver.c", "Driver", driver.driver_struct(LAYOUT.formation.groups)),
        ("rail.c", "Rail", rail._structs(LAYOUT.formation.wheelsets)[0]),
        ("rail.c", "Recovery", rail._structs(LAYOUT.formation.wheelsets)[1]),
        ("rail.c", "Sand", rail._structs(LAYOUT.formation.wheelsets)[2]),
        ("rail.c", "Sander", rail.Sander),
        ("faults.c", "Fault", faults._Fault),
        ("faults.c", "Faults", faults._Faults),
        ("cycle.c", "Formula", compiled_cycle._Formula),
        ("cycle.c", "Cycle", compiled_cycle.cycle_struct(LAYOUT)),
        ("cosimulation.c", "Channel", cosimulation._Channel),
        ("cosimulation.c", "SetStepGet", cosimulation._SetStepGet),
        ("run.c", "Filter", compiled._Filter),
        ("run.c", "Run", compiled._Run),
    ],
)
def test_members_stand_where_c_puts_them(source, name, mirror):
    """What the C compiler says of every member, by name, and of the whole."""
    members = [member for member, _ in mirror._fields_]
    places = ", ".join(f"offsetof({name}, {member.rstrip('_')})" for member in members)
    probe = (
        f'#include <stddef.h>\n#include "{source}"\n'
        f"EXPORT long long place(int which)\n{{\n    static const size_t at[] = {{{places}, sizeof({name})}};\n"
        "    return (long long)at[which];\n}\n"
    )
    parts = [part for part in library._PARTS if part.endswith(".c")]
    units = ("probe.c", *parts) if source == "cycle.c" else ("probe.c",)
    built = ctypes.CDLL(str(shared_library(SOURCES | {"probe.c": probe}, "probe", units=units)))
    built.place.restype = ctypes.c_longlong
    assert [built.place(k) for k in range(len(members))] == [getattr(mirror, member).offset for member in members]
    assert built.place(len(members)) == ctypes.sizeof(mirror)
