"""FMUs for FMI 3.0: the same C code with other function names, and another modelDescription.xml."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import replace

from railgrip.fmus.native.code import RUNTIME
from railgrip.fmus.native.description import attributes_text
from railgrip.fmus.native.package import Source

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
    head = {name: text for name, text in root.attrib.items() if name not in removed} | {"fmiVersion": "3.0"}
    interface = root.find("CoSimulation")
    assert interface is not None
    flags = {_FLAGS[name]: text for name, text in interface.attrib.items() if name in _FLAGS}
    variables = root.findall("ModelVariables/ScalarVariable")
    references = [variable.attrib["valueReference"] for variable in variables]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            # `Source.of` fills in the token.
            f'<fmiModelDescription instantiationToken=""{attributes_text(head)}>',
            f"  <CoSimulation{attributes_text(flags)}/>",
            *(
                ET.tostring(part, encoding="unicode").rstrip()
                for name in ("UnitDefinitions", "LogCategories", "DefaultExperiment")
                for part in root.findall(name)
            ),
            "  <ModelVariables>",
            *(_variable(variable, references) for variable in variables),
            "  </ModelVariables>",
            "  <ModelStructure>",
            *(line for group, name in _UNKNOWNS.items() for line in _unknowns(root, group, name, references)),
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


def _variable(variable: ET.Element, references: Sequence[str]) -> str:
    inner = variable[0]
    attributes = dict(variable.attrib) | dict(inner.attrib)
    if "derivative" in attributes:
        attributes["derivative"] = references[int(attributes["derivative"]) - 1]
    return f"    <{_TYPES[inner.tag]}{attributes_text(attributes)}/>"


def _unknowns(root: ET.Element, group: str, name: str, references: Sequence[str]) -> Iterator[str]:
    for unknown in root.findall(f"ModelStructure/{group}/Unknown"):
        attributes = {"valueReference": references[int(unknown.attrib["index"]) - 1]}
        if "dependencies" in unknown.attrib:
            places = unknown.attrib["dependencies"].split()
            attributes["dependencies"] = " ".join(references[int(place) - 1] for place in places)
            attributes["dependenciesKind"] = unknown.attrib["dependenciesKind"]
        yield f"    <{name}{attributes_text(attributes)}/>"


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
