"""The onboard part of a scenario, compiled for a Cortex-M7, inspected, and run in an emulator."""

import ctypes
import re
import subprocess
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Final

import numpy as np

from railgrip.base.arrays import Matrix, Vector
from railgrip.base.errors import BuildFailed, CompilerMissing
from railgrip.base.programs import environment_of_programs, find_program
from railgrip.fmus.native.discrete import WrittenStep, sources_of_library
from railgrip.fmus.native.package import c_identifier
from railgrip.fmus.native.toolchain import FAST_BUILD, shared_library
from railgrip.scenario.schema import Scenario
from railgrip.simulate.export.c_parts import part_in_c, readings_of

DATA: Final = Path(__file__).with_name("cortex_m7")
"""Folder of start-up code, layout of memory, a train, and reasons of MISRA findings."""
PREFIX: Final = "arm-none-eabi-"
EMULATOR: Final = "qemu-system-arm"
PACKAGES: Final = "Debian's packages are gcc-arm-none-eabi, libnewlib-arm-none-eabi, qemu-system-arm and cppcheck"
_CORE: Final = ("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard")
_LANGUAGE: Final = ("-std=gnu99", "-O2", "-fno-math-errno", "-ffunction-sections", "-fdata-sections")
_INSPECTED: Final = ("-fstack-usage", "-fcallgraph-info=su", "-Wvla", "-Wstack-usage=65536", "-Werror")
_OWN: Final = ("-Wall", "-Werror", "-fno-tree-loop-distribute-patterns")
"""Otherwise GCC replaces the loop of memset by a call of memset."""
_SHIFT: Final = 3
"""An instruction takes 2**_SHIFT ns in the emulator; a tick of its 25 MHz clock is 40 ns."""
INSTRUCTIONS_PER_TICK: Final = 40 / 2**_SHIFT
_TO_SINGLE: Final = (
    "#define STEP step_plain\n",
    "#include <string.h>\n#include <tgmath.h>\n#define double float\n#define STEP step_single\n",
)
_AROUND_SINGLE: Final = """
#undef double
int step_plain(double *block)
{
    float single[BLOCK] __attribute__((aligned(16)));
    for (int i = 0; i < BLOCK; i++)
        single[i] = (float)block[i];
    const int failure = step_single(single);
    for (int i = 0; i < BLOCK; i++)
        block[i] = single[i];
    return failure;
}
"""
_LOOP: Final = r"\b(for) *\(([^;{}]*;[^;{}]*;[^{};]*?)\)\s*[\w{(*&+-]|\b(while|do|goto)\b"
_COUNTING: Final = (
    r"(?:\s*(?:int|long long|unsigned|unsigned long long) \w+ = [^;]*)?;\s*\w+ *(?:[<>]=?)[^;]*; *\w+(?:\+\+|--)"
)
"""A loop, and the head of one whose variable is compared with a bound and changes by one."""
_LOOPS: Final = 100_000
"""Loops of two instructions each whose ticks target.c counts."""


def missing_programs(*more: str) -> list[str]:
    """Return the names of the programs that this machine lacks."""
    return [name for name in (f"{PREFIX}gcc", EMULATOR, *more) if find_program(name) is None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A run of the onboard part in the emulator.

    Attributes:
        outputs: Outputs of each step, shape (steps, outputs).
        instructions: Instructions of each step, shape (steps,).
        failed: First step that failed; the outputs end before it. None if all succeeded.
        stack: Bytes of the stack that the steps wrote.
        of_loop: Measured instructions of a loop over its true number.
    """

    outputs: Matrix
    instructions: Vector
    failed: int | None
    stack: int
    of_loop: float


class TargetBuild:
    """The onboard part of a scenario as C, for a Cortex-M7 and for this machine."""

    def __init__(self, scenario: Scenario, folder: Path, rows: int | None = None) -> None:
        """Write the C code into a folder.

        Args:
            scenario: The scenario.
            folder: An existing folder.
            rows: Number of readings; those of the whole stop unless given.

        Raises:
            ScenarioError: A part is not in C.
        """
        system = part_in_c(scenario, "onboard")
        assert isinstance(system.step, WrittenStep)
        self.folder, self.name = folder, c_identifier(system.name)
        self.files = sources_of_library(system)
        self.units = (f"{self.name}.c", *system.step.units)
        self.readings = np.ascontiguousarray(readings_of(scenario)[:rows])
        self.parameters, self.outputs = len(system.parameters), [variable.name for variable in system.outputs]
        names = f'#include "{self.name}.h"\n' + "".join(
            f"typedef {self.name}_{kind} {kind};\n" for kind in ("State", "Inputs", "Outputs")
        )
        names += f"#define START_LIBRARY {self.name}_start\n#define STEP_LIBRARY {self.name}_step\n"
        texts = {name: (DATA / name).read_text(encoding="utf-8") for name in ("target.c", "target.ld")}
        for name, text in {**self.files, **texts, "target.c": names + texts["target.c"]}.items():
            (folder / name).write_text(text, encoding="utf-8")
        (folder / "readings.bin").write_bytes(self.readings.tobytes())

    def compile(self, *flags: str, is_single: bool = False) -> None:
        """Compile the library and the program.

        Args:
            flags: Flags after those of the library.
            is_single: Whether the step of the filter computes in single precision, on a copy of its memory.

        Raises:
            CompilerMissing: There is no cross compiler.
            BuildFailed: It reports an error, or a function needs a stack of unknown size.
        """
        for unit in self.units:
            more = flags
            if unit == "plain.c":
                text = self.files[unit]
                if is_single:
                    more = (*flags, "-fsingle-precision-constant")
                    text = text.replace(*_TO_SINGLE) + _AROUND_SINGLE
                (self.folder / unit).write_text(text, encoding="utf-8")
            self._call(f"{PREFIX}gcc", *_CORE, *_LANGUAGE, "-ffp-contract=off", *_INSPECTED, *more, "-c", unit)
        objects = [f"{Path(unit).stem}.o" for unit in self.units]
        self._call(f"{PREFIX}gcc", *_CORE, *_LANGUAGE, *_OWN, "-c", "target.c")
        # Neither start files nor the C library: what is undefined then, the library takes from elsewhere.
        self._call(f"{PREFIX}gcc", *_CORE, "-nostdlib", "-nostartfiles", "-Wl,--gc-sections", "-T", "target.ld",
            "target.o", *objects, "-lm", "-lgcc", "-o", "target.elf")  # fmt: skip

    def run(self) -> Measured:
        """Run the program in the emulator over the readings.

        Raises:
            CompilerMissing: There is no emulator.
            BuildFailed: The program failed.
        """
        self._call(EMULATOR, "-M", "mps2-an500", "-nographic", "-semihosting-config", "enable=on,target=native",
            "-icount", f"shift={_SHIFT}", "-kernel", "target.elf")  # fmt: skip
        rows = np.fromfile(self.folder / "outputs.bin").reshape(-1, len(self.outputs) + 2)
        (loop, none), steps, last = rows[0, -2:], rows[1:-1], rows[-1]
        if len(steps) != len(self.readings):
            raise BuildFailed(f"{self.name}: the program ended after {len(steps)} of {len(self.readings)} steps.")
        failed = next(iter(np.flatnonzero(steps[:, -1]).tolist()), None)
        return Measured(
            outputs=steps[:failed, :-2],
            instructions=(steps[:failed, -2] - none) * INSTRUCTIONS_PER_TICK,
            failed=failed,
            stack=int(last[-2]),
            of_loop=(loop - none) * INSTRUCTIONS_PER_TICK / (2 * _LOOPS),
        )

    def run_here(self) -> Matrix:
        """Return the outputs of this machine for the readings, shape (steps, outputs)."""
        library = ctypes.CDLL(
            str(shared_library(self.files, self.name, units=self.units, flags=(*FAST_BUILD, "-fvisibility=default")))
        )
        words = re.search(r"memory\[(\d+)\]", self.files[f"{self.name}.h"])
        assert words is not None
        state = np.zeros(max(self.parameters, 1) + 1 + int(words[1]))
        outputs = np.zeros((len(self.readings), len(self.outputs)))
        start, step = library[f"{self.name}_start"], library[f"{self.name}_step"]
        start(ctypes.c_void_p(state.ctypes.data))
        for row, result in zip(self.readings, outputs, strict=True):
            if step(*(ctypes.c_void_p(each.ctypes.data) for each in (state, row, result))):
                raise BuildFailed(f"{self.name}: a step failed on this machine.")
        return outputs

    def sizes(self) -> dict[str, int]:
        """Return the bytes of flash of the linked library and program, `flash`, and of the library's state, `state`."""
        sections = self._call(f"{PREFIX}size", "-A", "target.elf")
        state = re.search(r"^\w+ (\w+) b onboard$", self._call(f"{PREFIX}nm", "-S", "target.elf"), re.MULTILINE)
        assert state is not None
        flash = re.findall(r"^\.(?:text|ARM\.exidx|data) +(\d+)", sections, re.MULTILINE)
        return {"flash": sum(map(int, flash)), "state": int(state[1], 16)}

    def linked(self) -> list[str]:
        """Return the functions that the linker took from the libraries of mathematics and of the compiler."""
        units = (*self.units, "target.c")
        own = {name for u in units for name in re.findall(r" [A-TV-Za-z] (\S+)$", self._symbols(u), re.MULTILINE)}
        return sorted({*re.findall(r" [TtWw] (\S+)$", self._call(f"{PREFIX}nm", "target.elf"), re.MULTILINE)} - own)

    def variables(self) -> list[str]:
        """Return the variables of the library that all states would share."""
        text = "".join(map(self._symbols, self.units))
        return re.findall(r" [BbCDdGgSs] (\S+)$", text, re.MULTILINE)

    def loops(self) -> tuple[int, list[str]]:
        """Return the number of loops that count, and the heads of all others, after the preprocessor."""
        texts = [self._call(f"{PREFIX}gcc", *_CORE, *_LANGUAGE, "-E", "-P", unit) for unit in self.units]
        heads = re.findall(_LOOP, "".join(texts))
        others = [head or word for _, head, word in heads if word or not re.fullmatch(_COUNTING, head)]
        return len(heads) - len(others), others

    def misra(self) -> dict[str, set[tuple[str, str]]]:
        """Return the findings of cppcheck: rule of MISRA C:2012 → places, each as file and line with column.

        Raises:
            CompilerMissing: There is no cppcheck.
        """
        found = self._call("cppcheck", "--quiet", "--addon=misra", "--std=c99", "--platform=unspecified",
            "--template={file}\t{line}:{column}\t{id}", "--template-location=", *self.units,
            is_stderr=True)  # fmt: skip
        rules: dict[str, set[tuple[str, str]]] = {}
        for file, place, rule in re.findall(r"^(\S+)\t(\S+)\tmisra-c2012-(\S+)$", found, re.MULTILINE):
            rules.setdefault(rule, set()).add((file, place))
        return rules

    def _symbols(self, unit: str) -> str:
        return self._call(f"{PREFIX}nm", f"{Path(unit).stem}.o")

    def stack(self) -> int:
        """Return the bytes of stack of the deepest calls of a step, without those of the compiler's functions.

        Raises:
            BuildFailed: A function calls itself, directly or through others.
        """
        calls, own = self._calls()
        known: dict[str, int] = {}
        try:
            for function in TopologicalSorter({name: set[str]() for name in own} | calls).static_order():
                deeper = (known[each] for each in calls.get(function, ()))
                known[function] = own.get(function, 0) + max(deeper, default=0)
        except CycleError as error:
            raise BuildFailed(f"{self.name}: {' calls '.join(reversed(error.args[1]))}.") from error
        return max(known[f"{self.name}_{entry}"] for entry in ("start", "step"))

    def _calls(self) -> tuple[dict[str, set[str]], dict[str, int]]:
        """Return the functions that each function calls, and its own stack [bytes].

        A call through a pointer may go to the functions in the tables of constants that the caller uses, and to those
        whose addresses are in its own code; without either, to all whose addresses are stored in memory.
        """
        calls, own, through_pointer = dict[str, set[str]](), dict[str, int](), set[str]()
        uses, functions = dict[str, set[str]](), set[str]()
        for unit in self.units:
            graph = (self.folder / unit).with_suffix(".ci").read_text(encoding="utf-8")
            for title, size, kind in re.findall(r'title: "(\S+)" label: "[^"]*\\n(\d+) bytes \((\w+)', graph):
                if kind != "static":
                    raise BuildFailed(f"{self.name}: the stack of {title} is {kind}, not static.")
                own[_plain(title)] = int(size)
            for source, target in re.findall(r'sourcename: "(\S+)" targetname: "(\S+)"', graph):
                if target == "__indirect_call":
                    through_pointer.add(_plain(source))
                else:
                    calls.setdefault(_plain(source), set()).add(_plain(target))
            text = self._call(f"{PREFIX}readelf", "-rW", f"{Path(unit).stem}.o")
            for section, entries in re.findall(r"'\.rel\.([^']+)'(.*?)(?=\nRelocation|\Z)", text, re.DOTALL):
                # The address of a function or table; calls have relocations of other kinds.
                found = re.findall(r"R_ARM_(?:ABS32|THM_MOV\w+) +\w+ +(\S+)", entries)
                uses.setdefault(section, set()).update(each.removeprefix(".") for each in found)
        functions = {f"text.{function}" for function in own} | {*own}
        tables = {name: used for name, used in uses.items() if not name.startswith("text.")}
        stored = {each for name, used in uses.items() if name.startswith("text.") for each in used & functions}
        for function in through_pointer:
            mine = uses.get(f"text.{function}", set[str]())
            reached = mine.union(*(tables[each] for each in mine if each in tables)) & functions or stored
            calls.setdefault(function, set()).update(each.removeprefix("text.") for each in reached)
        return calls, own

    def _call(self, program: str, *arguments: str, is_stderr: bool = False) -> str:
        found = find_program(program)
        if found is None:
            raise CompilerMissing(f"{program} is not on the PATH; {PACKAGES}.")
        process = subprocess.run(
            [found, *arguments], cwd=self.folder, env=environment_of_programs(), stdin=subprocess.DEVNULL,
            capture_output=True, encoding="utf-8", errors="replace", timeout=900.0, check=False,
        )  # fmt: skip
        if process.returncode:
            raise BuildFailed(f"{program} failed in {self.folder}:\n{(process.stderr or process.stdout)[:2000]}")
        return process.stderr if is_stderr else process.stdout


def _plain(title: str) -> str:
    return title.rpartition(":")[2]
