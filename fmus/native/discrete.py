"""A CasADi function (state, input) → (state, output), or a step in C, as a discrete-time co-simulation FMU.

It exports an estimator or controller written in CasADi to other tools, with the same C code generator, packager and
compiler as for Modelica classes, and a small runtime (`runtime/discrete.c`). A communication step of one period calls
the function once: outputs at its end follow from the inputs set at its beginning.

The same C code without FMI (`runtime/embedded.c`) is a static library with a header, for real-time targets, and a
program that times it: the caller owns the state, and nothing is allocated. The memory of a part of the loop, structs
and the arrays that their pointers refer to, becomes C source.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from math import isnan

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import InputError
from railgrip.base.groups import gather
from railgrip.base.names import ElementName
from railgrip.base.system import SampledSystem, Variable
from railgrip.fmus.native.c_source import string_literal, table
from railgrip.fmus.native.code import RUNTIME
from railgrip.fmus.native.description import Writer, document
from railgrip.fmus.native.loops import with_loops
from railgrip.fmus.native.package import Source, c_identifier
from railgrip.fmus.native.toolchain import WORD, Struct

PARTS = ("discrete.c", "instance.c", "status.c")

_KEYWORDS = """
auto bool break case catch char class const continue default delete do double else enum explicit export extern false
float for friend goto if inline int long namespace new operator private protected public register restrict return
short signed sizeof static struct switch template this throw true try typedef typename union unsigned using virtual
void volatile while
"""
"""Keywords of C99 and C++ that could be names."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WrittenStep:
    """A step in C, with its own memory.

    Attributes:
        text: C code that defines MEMORY, `lay` and `sample`; see `runtime/discrete.c`.
        files: Files that it includes, file name → text.
        units: Names of the files that are compiled separately.
    """

    text: str
    files: Mapping[str, str]
    units: tuple[str, ...] = ()


def sources(system: SampledSystem, waits: int = 0, hidden: frozenset[str] = frozenset()) -> Source:
    """Return C code and modelDescription.xml of a system, ready for `package.pack`.

    Args:
        system: A system with a period; its step is a casadi.Function or a `WrittenStep`.
        waits: Number of leading inputs of which one must be nonzero for the first period to begin; 0 begins at once.
        hidden: Names of parameters that are not listed in modelDescription.xml, in addition to those without a value.

    Raises:
        InputError: The period is not positive, names are not unique, or the step has other sizes.
    """
    _check(system)
    # The data of a vehicle that the scenario does not give; the step does not depend on them.
    hidden |= {variable.name for variable in system.parameters if isnan(variable.start)}
    identifier = c_identifier(system.name)
    files = {"model.c": _code(system, waits)}
    files |= {part: (RUNTIME / part).read_text(encoding="utf-8") for part in PARTS}
    units: tuple[str, ...] = ("model.c",)
    if isinstance(system.step, WrittenStep):
        files |= system.step.files
        units += system.step.units
    return Source.of(identifier, files, _xml(system, hidden, identifier, units), units)


def _check(system: SampledSystem) -> None:
    if not system.period > 0:
        raise InputError(f"{system.name}: the period must be a positive time, got {system.period} s.")
    names = [v.name for v in (*system.states, *system.inputs, *system.parameters, *system.outputs)]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{system.name}: more than one variable is named {', '.join(twice)}.")
    step = system.step
    if isinstance(step, WrittenStep):
        return
    arguments = [step.numel_in(i) for i in range(step.n_in())]
    results = [step.numel_out(i) for i in range(step.n_out())]
    sizes = [len(system.states), len(system.inputs), len(system.parameters)]
    result_sizes = [len(system.states), len(system.outputs)]
    # The last arguments may be omitted if they are empty.
    if arguments + [0] * (3 - len(arguments)) != sizes or results != result_sizes:
        raise InputError(
            f"{system.name}: a step function takes (state, input, parameter) of {sizes} numbers and gives "
            f"(state, output) of {result_sizes}; this one takes {arguments} and gives {results}."
        )


def straight_step(name: str, step: ca.Function, sizes: Sequence[int]) -> str:
    """Return C code of a step (state, input, parameter) → (state, output), whose last arguments may be omitted.

    Args:
        name: Name of the C function.
        step: The step.
        sizes: Numbers of states, inputs and parameters.
    """
    # Expanded to scalar operations, and with all three inputs, so that no argument is a null pointer.
    every = [ca.SX.sym(argument, size) for argument, size in zip("xup", sizes, strict=True)]
    arguments = every[: step.n_in()]
    following, output = step.expand().call(arguments) if arguments else ([], [])
    return with_loops(ca.Function(name, every, [ca.densify(following), ca.densify(output)], {"cse": True}))


def _code(system: SampledSystem, waits: int) -> str:
    groups = {"x": system.states, "u": system.inputs, "p": system.parameters, "y": system.outputs}
    sizes = {f"N{name.upper()}": len(group) for name, group in groups.items()}
    if isinstance(system.step, WrittenStep):
        step = system.step.text
    else:
        step = straight_step("f_step", system.step, [*sizes.values()][:3])
    numbers = sizes | {
        "PERIOD": repr(float(system.period)), "WAITS": waits, "MODEL_GUID": string_literal("")
    }  # fmt: skip
    return "\n".join(
        [
            "/* Generated; do not edit. */",
            *(f"#define {name} {value}" for name, value in numbers.items()),
            "#include <math.h>",
            *(table("double", f"start_{name}", [v.start for v in group]) for name, group in groups.items()),
            "#include <string.h>",
            step,
            '#include "discrete.c"',
            "",
        ]
    )


def _xml(system: SampledSystem, hidden: frozenset[str], identifier: str, units: Sequence[str]) -> str:
    w = Writer()
    place = 0
    for group, causality, variability, initial in (
        (system.states, "local", "discrete", "exact"),
        (system.inputs, "input", "discrete", None),
        (system.parameters, "parameter", "fixed", "exact"),
        (system.outputs, "output", "discrete", "exact"),
    ):
        for v in group:
            place += 1
            if v.name in hidden:
                continue
            bounds = {"min": v.minimum, "max": v.maximum}
            attributes = {"unit": v.unit} if v.unit else {}
            attributes |= {key: repr(float(value)) for key, value in bounds.items() if value is not None}
            w.add(
                v.name, place, causality=causality, variability=variability, initial=initial, start=v.start,
                description=v.description, attributes=attributes,
            )  # fmt: skip
    every = (*system.states, *system.inputs, *system.parameters, *system.outputs)
    first = len(every) - len(system.outputs) + 1
    return document(
        {
            "fmiVersion": "2.0",
            "modelName": system.name,
            "guid": "",
            "description": system.description,
            "generationTool": f"railgrip (CasADi {version('casadi')})",
            "variableNamingConvention": "structured",
        },
        {
            "CoSimulation": {
                "modelIdentifier": identifier,
                "canHandleVariableCommunicationStepSize": "true",
                "canNotUseMemoryManagementFunctions": "true",
                "canGetAndSetFMUstate": "true",
                "canSerializeFMUstate": "true",
            }
        },
        units={"1", "s"} | {v.unit for v in every if v.unit},
        categories={"logStatusError": "Why a call failed"},
        experiment={"stepSize": repr(float(system.period))},
        rows=w.rows,
        structure={"Outputs": [f'      <Unknown index="{w.index[first + k]}"/>' for k in range(len(system.outputs))]},
        files=units,
    )


_FUNCTION = re.compile(r"^(?!typedef)(?:\w+ )+\*?(\w+)\(.*\);$", re.MULTILINE)
"""A declaration in a header of the loop."""

_HEADER = """/* {description}.

   Generated by `railgrip export --library`; do not edit. One step is one period of {period!r} s. Nothing is allocated,
   no variable is shared: a program may have any number of states, and step each from one thread at a time.

   Inputs are held over the period; outputs are decided on them at once. Set a reading to NaN where a sensor has nothing
   new. Parameters may be changed between {name}_start and the first step, but for periods. */
#ifndef {guard}
#define {guard}

#ifdef __cplusplus
extern "C" {{
#endif

#define {name}_PERIOD {period!r} /* s */

{structs}

typedef struct {{
    {name}_Parameters parameters;
    long long sample; /* steps so far */
    unsigned long long memory[{memory}];
}} {name}_State;

/* Make a state that of the first sample, with the scenario's parameters. */
void {name}_start({name}_State *state);

/* Take one step; return 0, or 1 where the estimate has diverged: the state must be started anew then. */
int {name}_step({name}_State *state, const {name}_Inputs *inputs, {name}_Outputs *outputs);

#ifdef __cplusplus
}}
#endif

#endif
"""


def sources_of_library(system: SampledSystem) -> dict[str, str]:
    """Return the C code of a system without FMI, file name → text: header, `NAME.c`, further files and `worst_case.c`.

    Raises:
        InputError: The step is not a `WrittenStep`.
    """
    if not isinstance(system.step, WrittenStep):
        raise InputError(f"{system.name}: only a part whose memory is in C can be a library.")
    name = c_identifier(system.name)
    step = system.step
    words = re.search(r"^#define MEMORY (\d+)$", step.text, re.MULTILINE)
    assert words is not None
    structs = {"Inputs": system.inputs, "Outputs": system.outputs, "Parameters": system.parameters}
    header = _HEADER.format(
        name=name,
        guard=f"{name.upper()}_H",
        description=system.description,
        period=float(system.period),
        memory=words[1],
        structs="\n\n".join(_struct(f"{name}_{kind}", variables) for kind, variables in structs.items()),
    )
    # Prefixed, so that functions of the loop cannot clash with functions of the program. `step_plain` is declared in
    # `step.text`, not in a header.
    headers = "\n".join(text for file, text in step.files.items() if file.endswith(".h"))
    functions = sorted({*_FUNCTION.findall(headers), "step_plain"})
    prefix = "".join(f"#define {function} {name}_{function}\n" for function in functions)
    names = f'#include "{name}.h"\n' + "".join(f"typedef {name}_{kind} {kind};\n" for kind in ("State", *structs))
    names += f"#define START {name}_start\n#define STEP {name}_step\n#define PERIOD {name}_PERIOD\n"
    body = "\n".join(
        [
            prefix + "#include <math.h>\n#include <string.h>\n" + names,
            table("double", "start_p", [v.start for v in system.parameters]),
            step.text,
            (RUNTIME / "embedded.c").read_text(encoding="utf-8"),
        ]
    )
    files = {file: prefix + text if file in step.units else text for file, text in step.files.items()}
    timing = f'#define _POSIX_C_SOURCE 200809L\n{names}#define LIBRARY "{name}"\n'
    timing += (RUNTIME / "worst_case.c").read_text(encoding="utf-8")
    return files | {f"{name}.h": header, f"{name}.c": body, "worst_case.c": timing}


def _struct(name: str, variables: Sequence[Variable]) -> str:
    return "\n".join(["typedef struct {", *_fields(variables), f"}} {name};"])


def _fields(variables: Sequence[Variable]) -> Iterator[str]:
    if not variables:
        yield "    double none; /* C has no empty structs */"
    taken = set[str](_KEYWORDS.split())
    for name, elements in gather((ElementName.of(each.name).array, each) for each in variables).items():
        first = elements[0]
        size = f"[{len(elements)}]" if first.name.endswith("]") else ""
        member = c_identifier(name)
        member = member.lower() if member.isupper() else member  # macros of headers are in capitals
        while member in taken:
            member += "_"
        taken.add(member)
        comment = f"{first.unit or '1'}: {first.description}".replace("*/", "* /")
        yield f"    double {member}{size}; /* {comment} */"


_MAXIMUM_GAP = 4
"""Maximum distance of two nonzero words in one run: up to three zeros are shorter in C than a new run."""

_POINTING = """
typedef char pointers_fit_in_words[sizeof(void *) <= 8 ? 1 : -1];
typedef char words_are_aligned[offsetof(struct { char c; double x; long long y; }, y) == 16 ? 1 : -1];

static void aim(unsigned long long *pointer, const void *target)
{
    memcpy(pointer, &target, sizeof target);
}

static void point(unsigned long long *memory)
{"""


@dataclass(frozen=True, slots=True)
class _Region:
    """A struct, or an array that a pointer refers to.

    Attributes:
        address: Address in this process.
        words: Content.
        pointers: Index of each word that is a pointer → its field, `Type.field`.
    """

    address: int
    words: NDArray[np.uint64]
    pointers: dict[int, str]


def memory_in_c(root: Struct, headers: Iterable[str]) -> str:
    """Return C code that copies a struct, and everything that it points to, into words of 8 bytes.

    It defines MEMORY, the number of words, and

        static void lay(unsigned long long *memory);      writes their present values, without pointers
        static void point(unsigned long long *memory);    writes pointers, valid until the words are moved

    Arrays that only pointers to constants refer to are tables that all copies share. Pointers to functions are null.

    Args:
        root: The struct; arrays that it points to contain numbers.
        headers: Texts of the headers that declare its type and the types of its fields.
    """
    regions, links = _linked(root)
    constants = _constants(headers)
    changing = {0} | {target for _, _, field, target, _ in links if field not in constants}
    places, tables, words = dict[int, str](), list[str](), list[NDArray[np.uint64]]()
    for number, region in enumerate(regions):
        if number in changing or region.pointers:
            places[number] = f"memory + {sum(word.size for word in words)}"
            words.append(region.words.copy())
            words[-1][[*region.pointers]] = 0
        else:
            places[number] = f"table_{number}"
            tables.append(_table("unsigned long long", f"table_{number}", map(hex, region.words.tolist())))
    lines = [
        f"    aim({places[number]} + {word}, (const char *)({places[target]}){f' + {offset}' if offset else ''});"
        for number, word, _, target, offset in links
    ]
    return "\n".join(["#include <stddef.h>", *tables, *_write_words(np.concatenate(words)), _POINTING, *lines, "}", ""])


def align_pointers(header: str) -> str:
    """Return a header whose structs have the same layout where pointers have 4 bytes as where they have 8."""
    return re.sub(
        r"typedef struct \{.*?\n\}",
        lambda struct: re.sub(r"(?m)^    (?=[\w ]+\*)", "    __attribute__((aligned(8))) ", struct[0]),
        header,
        flags=re.DOTALL,
    )


def _linked(root: Struct) -> tuple[list[_Region], list[tuple[int, int, str, int, int]]]:
    """Return the regions of a struct, and its pointers: region, word, field, and target with the offset there [bytes].

    Pointers to functions, and to memory that no field of a struct was set to, have no target and are left out.
    """
    regions = [*_regions(root, set())]
    return regions, [
        (number, word, field, target, int(region.words[word]) - regions[target].address)
        for number, region in enumerate(regions)
        for word, field in region.pointers.items()
        for target, other in enumerate(regions)
        if 0 <= int(region.words[word]) - other.address < WORD * other.words.size
    ]


@dataclass(frozen=True, slots=True)
class MemoryImage:
    """A struct and everything that it points to, as words of 8 bytes that may be placed anywhere.

    Attributes:
        words: Content; pointers are zero.
        links: Pointers: word, and offset of the target in the image [bytes], shape (n, 2).
        places: Address in this process of a struct or array → its first word.
    """

    words: NDArray[np.uint64]
    links: NDArray[np.int32]
    places: Mapping[int, int]


def memory_image(root: Struct) -> MemoryImage:
    """Return the memory image of a struct; arrays that it points to contain numbers."""
    regions, links = _linked(root)
    firsts = np.cumsum([0, *(region.words.size for region in regions)])
    words = [region.words.copy() for region in regions]
    for copied, region in zip(words, regions, strict=True):
        copied[[*region.pointers]] = 0
    return MemoryImage(
        np.concatenate(words),
        np.array([(firsts[n] + word, WORD * firsts[to] + offset) for n, word, _, to, offset in links], dtype=np.int32),
        {region.address: int(first) for region, first in zip(regions, firsts[:-1], strict=True)},
    )


def _regions(struct: Struct, known: set[int]) -> Iterator[_Region]:
    if struct.address in known:
        return
    known.add(struct.address)
    yield _Region(struct.address, _words(struct.content), struct.pointers())
    for target in struct.targets():
        if isinstance(target, Struct):
            yield from _regions(target, known)
            continue
        while isinstance(target.base, np.ndarray):  # views of one array share one region
            target = target.base
        if target.ctypes.data not in known:
            known.add(target.ctypes.data)
            yield _Region(target.ctypes.data, _words(target.tobytes()), {})


def _words(content: bytes) -> NDArray[np.uint64]:
    return np.frombuffer(content + bytes(-len(content) % WORD), dtype=np.uint64)


def _constants(headers: Iterable[str]) -> set[str]:
    fields = set[str]()
    for text in headers:
        bare = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
        for body, name in re.findall(r"typedef struct \{([^}]*)\} (\w+);", bare):
            fields |= {
                f"{name}.{field}"
                for declaration in body.split(";")
                if declaration.split()[:1] == ["const"]
                for field in re.findall(r"\*\s*(\w+)", declaration)
            }
    return fields


def _write_words(words: NDArray[np.uint64]) -> list[str]:
    # Long runs of zeros are omitted, because `lay` clears the memory first.
    used = np.flatnonzero(words)
    runs = np.split(used, np.flatnonzero(np.diff(used) > _MAXIMUM_GAP) + 1)
    spans = [(int(run[0]), int(run[-1]) + 1) for run in runs if run.size]
    return [
        f"#define MEMORY {words.size}",
        _table("unsigned long long", "content", (hex(w) for begin, end in spans for w in words[begin:end].tolist())),
        _table("int", "spans", (str(number) for span in spans for number in span)),
        "static void lay(unsigned long long *memory)",
        "{",
        "    const unsigned long long *next = content;",
        "    memset(memory, 0, MEMORY * sizeof *memory);",
        f"    for (int k = 0; k < {len(spans)}; k++)",
        "        for (int i = spans[2 * k]; i < spans[2 * k + 1]; i++) memcpy(memory + i, next++, 8);",
        "}",
    ]


def _table(kind: str, name: str, entries: Iterable[str]) -> str:
    # One entry more, because C has no empty arrays.
    every: Sequence[str] = [*entries, "0"]
    lines = ",\n".join(", ".join(every[i : i + 8]) for i in range(0, len(every), 8))
    return f"static const {kind} {name}[] = {{\n{lines}\n}};"
