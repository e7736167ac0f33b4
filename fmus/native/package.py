"""A system as an FMU: C code compiled for this platform, modelDescription.xml, zipped reproducibly.

An FMU for FMI 3.0 has the same C code with other function names, and another modelDescription.xml.
"""

import hashlib
import io
import platform
import re
import struct
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

from railgrip.base.files import write_bytes
from railgrip.fmus.native import code, description
from railgrip.fmus.native.code import RUNTIME
from railgrip.fmus.native.system import System
from railgrip.fmus.native.toolchain import FAST_BUILD, SUFFIX, TARGETS, Platform, binary

_fmpy = find_spec("fmpy")
assert _fmpy is not None
assert _fmpy.origin is not None
HEADERS = Path(_fmpy.origin).parent / "c-code"
"""Header files of FMI 2.0 and 3.0, which FMPy contains; importing FMPy would take a fifth of a second."""

EPOCH = (1980, 1, 1, 0, 0, 0)
"""Date of every file in the archive, the earliest that the format allows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Everything in an FMU that does not depend on the platform.

    Attributes:
        identifier: Name of the library inside, a C identifier.
        files: C file name → text.
        xml: modelDescription.xml.
        units: Names of the translation units, the files that are compiled; the others are included in them.
        is_fmi_3: Whether it is an FMU for FMI 3, else for FMI 2.
    """

    identifier: str
    files: dict[str, str]
    xml: str
    units: tuple[str, ...] = ("model.c",)
    is_fmi_3: bool = False

    @classmethod
    def of(cls, identifier: str, files: dict[str, str], xml: str, units: tuple[str, ...] = ("model.c",)) -> "Source":
        """Return the sources with a GUID that is a digest over all of them, in `model.c` and in the XML."""
        # Sources that were derived from others have a GUID already, which must not enter the digest.
        model = re.sub(r'#define MODEL_GUID ".*"', '#define MODEL_GUID ""', files["model.c"])
        files = files | {"model.c": model}
        xml = re.sub(r'(guid|instantiationToken)="[^"]*"', r'\1=""', xml, count=1)
        guid = f"{{{hashlib.sha256(chr(0).join([xml, *files.values()]).encode()).hexdigest()[:32]}}}"
        model = model.replace('#define MODEL_GUID ""', f'#define MODEL_GUID "{guid}"')
        xml = re.sub('(guid|instantiationToken)=""', rf'\1="{guid}"', xml, count=1)
        return cls(identifier=identifier, files=files | {"model.c": model}, xml=xml, units=units)

    @property
    def digest(self) -> str:
        """SHA-256 over the C files and the XML."""
        text = "\0".join([self.xml, *(f"{name}\0{content}" for name, content in sorted(self.files.items()))])
        return hashlib.sha256(text.encode()).hexdigest()


def platform_folder() -> str:
    """Return this platform's folder in FMI 2.0, such as linux64."""
    system = {"Linux": "linux", "Darwin": "darwin", "Windows": "win"}[platform.system()]
    return f"{system}{8 * struct.calcsize('P')}"


def tuple_of_platform() -> str:
    """Return this platform's folder in FMI 3.0, its platform tuple, such as x86_64-linux."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    return f"{machine}-{platform.system().lower()}"


def sources(
    system: System,
    *,
    interfaces: tuple[str, ...],
    solver: str = "rodas4",
    tolerance: float = 1e-6,
    step: float = 1e-3,
) -> Source:
    """Return the C code and modelDescription.xml of a system.

    Args:
        system: The system.
        interfaces: "me", "cs" or both.
        solver: "rodas3" or "rodas4", for co-simulation.
        tolerance: Relative error of an internal step.
        step: Suggested communication step [s].
    """
    identifier = c_identifier(system.class_name)
    files = code.c_sources(system, interfaces=interfaces, solver=solver, tolerance=tolerance)
    units = tuple(name for name in ("model.c", code.ELIMINATION) if name in files)
    xml = description.write(
        system, identifier=identifier, interfaces=interfaces, solver=solver, tolerance=tolerance, step=step, files=units
    )
    return Source.of(identifier, files, xml, units)


def c_identifier(name: str) -> str:
    """Return a C identifier made from a name, short enough for the name of a file."""
    return re.sub(r"^(?=\d)|\W", "_", name, flags=re.ASCII)[:100]


def pack(source: Source, path: Path, *, flags: tuple[str, ...] = FAST_BUILD, platforms: Sequence[str] = ()) -> Path:
    """Write an FMU to a file; arguments and errors are those of `archive_bytes`."""
    write_bytes(path, archive_bytes(source, flags=flags, platforms=platforms))
    return path


def archive_bytes(source: Source, *, flags: tuple[str, ...] = FAST_BUILD, platforms: Sequence[str] = ()) -> bytes:
    """Return the content of an FMU; the same sources give the same bytes.

    Args:
        source: Sources of the FMU.
        flags: Flags of the C compiler.
        platforms: Keys of `toolchain.TARGETS`; empty for this platform.

    Raises:
        CompilerMissing: No C compiler was found.
        BuildFailed: The C compiler failed.
    """

    def library(target: Platform | None) -> bytes:
        return binary(
            source.files, source.identifier, units=source.units, include=[HEADERS], flags=flags, target=target
        )

    targets = {name: TARGETS[name] for name in platforms}
    if targets:
        with ThreadPoolExecutor(2) as pool:
            folders = [name if source.is_fmi_3 else target.folder for name, target in targets.items()]
            suffixes = [target.suffix for target in targets.values()]
            libraries = [*zip(folders, suffixes, pool.map(library, targets.values()), strict=True)]
    else:
        libraries = [(tuple_of_platform() if source.is_fmi_3 else platform_folder(), SUFFIX, library(None))]
    members = {"modelDescription.xml": source.xml.encode()}
    members |= {f"binaries/{folder}/{source.identifier}{suffix}": content for folder, suffix, content in libraries}
    members |= {f"sources/{name}": text.encode() for name, text in source.files.items()}
    return zip_files(members)


def zip_files(members: Mapping[str, bytes]) -> bytes:
    """Return an archive of files by name; the same files give the same bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, member in sorted(members.items()):
            archive.writestr(zipfile.ZipInfo(name, EPOCH), member, zipfile.ZIP_DEFLATED)
    return content.getvalue()


_TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}
_FLAGS = {
    "modelIdentifier": "modelIdentifier", "canGetAndSetFMUstate": "canGetAndSetFMUState",
    "canSerializeFMUstate": "canSerializeFMUState", "providesDirectionalDerivative": "providesDirectionalDerivatives",
    "canHandleVariableCommunicationStepSize": "canHandleVariableCommunicationStepSize",
}  # fmt: skip
"""Attributes of CoSimulation and their names in FMI 3.0."""

_UNKNOWNS = {"Outputs": "Output", "Derivatives": "ContinuousStateDerivative", "InitialUnknowns": "InitialUnknown"}


def as_fmi_3(source: Source) -> Source:
    """Return a co-simulation FMU for FMI 2.0 as one for FMI 3.0; names and value references are unchanged."""
    files = source.files | {
        "fmi3.c": (RUNTIME / "fmi3.c").read_text(encoding="utf-8"),
        "model.c": source.files["model.c"] + '#include "fmi3.c"\n',
    }
    converted = Source.of(source.identifier, files, _convert_description(ET.fromstring(source.xml)), source.units)
    build = _build_description(converted.identifier, converted.units)
    # Added after the GUID is computed: the build description follows from the rest.
    return replace(converted, files=converted.files | {"buildDescription.xml": build}, is_fmi_3=True)


def _convert_description(root: ET.Element) -> str:
    removed = ("guid", "numberOfEventIndicators")
    head = {name: text for name, text in root.attrib.items() if name not in removed}
    # `Source.of` fills in the token.
    out = ET.Element("fmiModelDescription", {"instantiationToken": ""} | head | {"fmiVersion": "3.0"})
    interface = root.find("CoSimulation")
    assert interface is not None
    ET.SubElement(
        out, "CoSimulation", {_FLAGS[name]: text for name, text in interface.attrib.items() if name in _FLAGS}
    )
    out.extend(
        part for name in ("UnitDefinitions", "LogCategories", "DefaultExperiment") for part in root.findall(name)
    )
    variables = root.findall("ModelVariables/ScalarVariable")
    references = [variable.attrib["valueReference"] for variable in variables]
    listed = ET.SubElement(out, "ModelVariables")
    for variable in variables:
        inner = variable[0]
        attributes = variable.attrib | inner.attrib
        if "derivative" in attributes:
            attributes["derivative"] = references[int(attributes["derivative"]) - 1]
        ET.SubElement(listed, _TYPES[inner.tag], attributes)
    structure = ET.SubElement(out, "ModelStructure")
    for group, name in _UNKNOWNS.items():
        for unknown in root.findall(f"ModelStructure/{group}/Unknown"):
            attributes = {"valueReference": references[int(unknown.attrib["index"]) - 1]}
            if "dependencies" in unknown.attrib:
                places = unknown.attrib["dependencies"].split()
                attributes["dependencies"] = " ".join(references[int(place) - 1] for place in places)
                attributes["dependenciesKind"] = unknown.attrib["dependenciesKind"]
            ET.SubElement(structure, name, attributes)
    ET.indent(out)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(out, encoding="unicode")}\n'


def _build_description(identifier: str, units: Sequence[str]) -> str:
    files = "".join(f'      <SourceFile name="{unit}"/>\n' for unit in units)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<fmiBuildDescription fmiVersion="3.0">\n'
        f'  <BuildConfiguration modelIdentifier="{identifier}">\n'
        f'    <SourceFileSet language="C99">\n{files}    </SourceFileSet>\n'
        "  </BuildConfiguration>\n"
        "</fmiBuildDescription>\n"
    )
