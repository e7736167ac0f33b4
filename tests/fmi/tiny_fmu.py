"""Creates the tiny FMU of tiny.c, well-behaved or with one fault, with any modelDescription.xml."""

import zipfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import fmpy
import numpy as np

from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.prediction import Prediction
from railgrip.fmi import Binding, Description, Port, bind
from railgrip.fmus.native.toolchain import shared_library

GUID = "{7d1c6f0e-tiny}"
HEADERS = Path(fmpy.__file__).parent / "c-code"
SOURCES = {
    name: (Path(__file__).parent / name).read_text()
    for name in ("tiny.c", "curved.c", "stepped.c", "quiet.h", "reals_only.h")
}

UNITS = """
  <UnitDefinitions>
    <Unit name="km/h"><BaseUnit m="1" s="-1" factor="0.2777777777777778"/></Unit>
    <Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit>
    <Unit name="bar"><BaseUnit kg="1" m="-1" s="-2" factor="1e5"/></Unit>
    <Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
  </UnitDefinitions>"""

LOGS = '\n  <LogCategories><Category name="logStatusError"/></LogCategories>'

WAYS = {
    "CoSimulation": '<CoSimulation modelIdentifier="tiny" canGetAndSetFMUstate="true" '
    'canHandleVariableCommunicationStepSize="true"/>',
    "ModelExchange": '<ModelExchange modelIdentifier="tiny" providesDirectionalDerivative="true"/>',
}


def row(name: str, reference: int, causality: str, variability: str, initial: str, value: str) -> str:
    """Return a variable of a description; `value` is its element without brackets."""
    how = f' initial="{initial}"' if initial else ""
    return (
        f'    <ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
        f'variability="{variability}"{how}><{value}/></ScalarVariable>'
    )


def xml(
    *,
    version: str = "2.0",
    ways: tuple[str, ...] = ("ModelExchange", "CoSimulation"),
    state_unit: str = "",
    input_unit: str = "",
    output_unit: str = "",
    relative: bool = False,
    indicators: int = 0,
) -> str:
    """Return a modelDescription.xml for tiny.c.

    Args:
        version: fmiVersion it claims.
        ways: Interfaces it offers.
        state_unit: Unit of x, '' for none.
        input_unit: Unit of u.
        output_unit: Unit of y.
        relative: x is a difference.
        indicators: Event indicators it claims.
    """

    def real(unit: str = "", more: str = "") -> str:
        return "Real" + (f' unit="{unit}"' if unit else "") + more

    difference = ' relativeQuantity="true"' if relative else ""
    rows = [
        row("x", 0, "output", "continuous", "exact", real(state_unit, f' start="1"{difference}')),
        row("der(x)", 1, "local", "continuous", "calculated", real(more=' derivative="1"')),
        row("u", 2, "input", "continuous", "", real(input_unit, ' start="0"')),
        row("rate", 3, "parameter", "fixed", "exact", real(more=' start="2" min="0.1" max="10"')),
        row("gain", 4, "parameter", "fixed", "exact", real(more=' start="3"')),
        row("y", 5, "output", "continuous", "calculated", real(output_unit)),
        row("flag", 6, "output", "discrete", "calculated", "Boolean"),
        row("count", 7, "output", "discrete", "calculated", "Integer"),
        row("label", 8, "parameter", "fixed", "exact", 'String start="tiny"'),
        row("allowed", 9, "parameter", "fixed", "exact", 'Integer start="3"'),
    ]
    if "CoSimulation" in ways:  # a prediction has no discrete inputs
        rows.append(row("mode", 10, "input", "discrete", "", 'Integer start="0"'))
    interfaces = "\n  ".join(WAYS[w] for w in ways)
    unknowns = {"Outputs": (1, 6, 7, 8), "Derivatives": (2,), "InitialUnknowns": (2, 6, 7, 8)}
    more = f'variableNamingConvention="structured" numberOfEventIndicators="{indicators}"'
    return model_description("Tiny", interfaces + UNITS + LOGS, rows, unknowns, more=more, version=version)


def model_description(
    model: str, head: str, rows: Iterable[str], unknowns: Mapping[str, Iterable[int]], *, more: str,
    version: str = "2.0", guid: str = GUID,
) -> str:  # fmt: skip
    """Return a modelDescription.xml.

    Args:
        model: Its name.
        head: Interfaces, and definitions in front of the variables.
        rows: Variables by `row`.
        unknowns: Element of the structure → numbers of variables, from 1.
        more: Further attributes.
        version: fmiVersion.
        guid: Identifier, which the library compares.
    """
    index = '<Unknown index="{}"/>'.format
    structure = [f"<{name}>{''.join(map(index, numbers))}</{name}>" for name, numbers in unknowns.items()]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="{version}" modelName="{model}" guid="{guid}" {more}>',
            f"  {head}",
            "  <ModelVariables>",
            *rows,
            "  </ModelVariables>",
            f"  <ModelStructure>{''.join(structure)}</ModelStructure>",
            "</fmiModelDescription>",
        ]
    )


def packed(file: Path, description: str, library: Path, binary: str) -> Path:
    """Write an FMU of a description and a library, whose place below `binaries` is given without its suffix."""
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{binary}{fmpy.sharedLibraryExtension}")
    return file


def per_second(name: str, factor: float) -> str:
    """Return a description in which x has a unit of this name that is defined as a factor times 1/s."""
    definition = f'<UnitDefinitions>\n<Unit name="{name}"><BaseUnit s="-1" factor="{factor}"/></Unit>'
    return xml(state_unit=name).replace("<UnitDefinitions>", definition)


def zipped(file: Path, members: Mapping[str, str | bytes]) -> Path:
    """Write an archive of contents by name."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return file


def repacked(source: Path, file: Path, change: Callable[[str, bytes], tuple[str, bytes]]) -> Path:
    """Write a copy of an FMU whose entries, name and content, are changed by a function."""
    with zipfile.ZipFile(source) as original, zipfile.ZipFile(file, "w") as copy:
        for name in original.namelist():
            copy.writestr(*change(name, original.read(name)))
    return file


def tiny(
    folder: Path,
    misbehaviour: str = "WELL",
    *,
    description: str | None = None,
    platform: str = fmpy.platform,
) -> Path:
    """Build the FMU in `folder` and return its file.

    Args:
        folder: Where the FMU is written.
        misbehaviour: A name defined in tiny.c.
        description: Its modelDescription.xml; None for the plain one.
        platform: Folder of the binary inside the FMU.
    """
    library = shared_library(
        {"tiny.c": SOURCES["tiny.c"], "quiet.h": SOURCES["quiet.h"]},
        f"tiny_{misbehaviour.lower()}",
        include=(HEADERS,),
        flags=(f"-DMISBEHAVIOUR={misbehaviour}", f'-DTINY_GUID="{GUID}"', "-D_POSIX_C_SOURCE=200809L"),
    )
    return packed(folder / f"{misbehaviour.lower()}.fmu", description or xml(), library, f"{platform}/tiny")


def tied(description: Description) -> Binding:
    """Return the binding of u, x and y under their own names."""
    plain = {"unit": "1", "size": 0, "needed": True}
    return bind(
        description,
        inputs=[Port(name="u", **plain)],
        outputs=[Port(name="x", **plain), Port(name="y", **plain)],
    )


CURVED_OUTPUTS = ("y[1]", "y[2]")
K = 1.7
"""Value of the parameter of both FMUs below, whose equations are these."""


def derivative(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the derivative of the states (3,) with inputs (2,)."""
    a, b, c = x
    return np.array([-K * a + u[0], a * b + np.sin(c), b - c**3 + u[1]])


def derivative_by_state(x: np.ndarray) -> np.ndarray:
    """Return its derivative by the states (3, 3)."""
    a, b, c = x
    return np.array([[-K, 0, 0], [b, a, np.cos(c)], [0, 1, -3 * c**2]])


def check_filter_in_c(model: Prediction, period: float) -> None:
    """Require that the filter in C equals that in numpy with the FMU as its prediction."""
    rng = np.random.default_rng(4)
    arguments = model, np.full(3, 1e-3), np.full(2, 1e-2), period
    fast, plain = CompiledFilter(*arguments), ExtendedKalmanFilter(*arguments)
    belief = fast.start(np.array([0.1, 0.3, -0.2]), np.full(3, 0.1))
    for _ in range(50):
        inputs, readings = rng.normal(size=2), rng.normal(size=2)
        expected = plain.step(belief, inputs, readings)
        belief = fast.step(belief, inputs, readings)
        # The same sums in another order, of numbers of size one.
        np.testing.assert_allclose(belief.mean, expected.mean, atol=1e-13)
        np.testing.assert_allclose(belief.covariance, expected.covariance, atol=1e-13)


_WRONG = ["-Dcos=sin"]  # only directional derivatives have a cosine


def curved(folder: Path, *, directional: bool = True, forgets: bool = False, wrong: bool = False) -> Path:
    """Build the smooth model-exchange FMU of curved.c in `folder` and return its file; `forgets` is said there.

    With `wrong`, as for `stepped`, an entry of its directional derivatives is another one.
    """
    library = shared_library(
        {name: SOURCES[name] for name in ("curved.c", "quiet.h", "reals_only.h")},
        f"curved_{forgets}_{wrong}",
        include=(HEADERS,),
        flags=(f'-DTINY_GUID="{GUID}"', *(["-DFORGETS"] if forgets else []), *_WRONG[:wrong]),
    )
    attribute = ' providesDirectionalDerivative="true"' if directional else ""
    sent = [row(n, 11 + i, "local", "continuous", "calculated", "Real") for i, n in enumerate(("sent", "asked"))]
    text = _curved_xml(f'<ModelExchange modelIdentifier="curved"{attribute}/>', sent)
    return packed(folder / f"curved_{directional}_{forgets}_{wrong}.fmu", text, library, f"{fmpy.platform}/curved")


def stepped(
    folder: Path, variant: int = 0, *, flags: str = 'canGetAndSetFMUstate="true"', directional: bool = True,
    lists_states: bool = True, wrong: bool = False,
) -> Path:  # fmt: skip
    """Build the co-simulation FMU of stepped.c in `folder` and return its file.

    Args:
        folder: Folder of the file.
        variant: Sum of the variants in stepped.c.
        flags: Further attributes of CoSimulation.
        directional: It offers directional derivatives.
        lists_states: ModelStructure has the derivatives of the states.
        wrong: An entry of its directional derivatives is another one.
    """
    library = shared_library(
        {name: SOURCES[name] for name in ("stepped.c", "quiet.h", "reals_only.h")},
        f"stepped_{variant}_{wrong}",
        include=(HEADERS,),
        flags=(f'-DTINY_GUID="{GUID}"', f"-DVARIANT={variant}", *_WRONG[:wrong]),
    )
    attribute = ' providesDirectionalDerivative="true"' if directional else ""
    text = _curved_xml(f'<CoSimulation modelIdentifier="curved"{attribute} {flags}/>', [], lists_states=lists_states)
    file = folder / f"stepped_{variant}_{directional}_{lists_states}_{wrong}_{len(flags)}.fmu"
    return packed(file, text, library, f"{fmpy.platform}/curved")


def _curved_xml(interface: str, more: list[str], *, lists_states: bool = True) -> str:
    rows = [row(n, i, "local", "continuous", "exact", 'Real start="0" nominal="1"') for i, n in enumerate("abc")]
    rows += [
        row(f"der({n})", 3 + i, "local", "continuous", "calculated", f'Real derivative="{i + 1}"')
        for i, n in enumerate("abc")
    ]
    rows += [row(f"u[{i + 1}]", 6 + i, "input", "continuous", "", 'Real start="0"') for i in range(2)]
    rows += [row(f"y[{i + 1}]", 8 + i, "output", "continuous", "calculated", "Real") for i in range(2)]
    rows.append(row("k", 10, "parameter", "fixed", "exact", 'Real start="1"'))
    derivatives = {"Derivatives": (4, 5, 6)} if lists_states else {}
    unknowns = {"Outputs": (9, 10), **derivatives, "InitialUnknowns": (4, 5, 6, 9, 10)}
    return model_description("Curved", interface, rows + more, unknowns, more='numberOfEventIndicators="0"')
