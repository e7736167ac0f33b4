"""C structs, and the arrays that their pointers refer to, as C source for a standalone program."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railgrip.fmus.native.c_library import WORD, Struct

_MAXIMUM_GAP = 4
"""Maximum distance of two nonzero words in one run: up to three zeros are shorter in C than a new run."""

_POINTING = """
typedef char pointers_have_8_bytes[sizeof(void *) == 8 ? 1 : -1];

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


def in_c(root: Struct, headers: Iterable[str]) -> str:
    """Return C code that copies a struct, and everything that it points to, into words of 8 bytes.

    It defines MEMORY, the number of words, and

        static void lay(unsigned long long *memory);      writes their present values, without pointers
        static void point(unsigned long long *memory);    writes pointers, valid until the words are moved

    Arrays that only pointers to constants refer to are tables that all copies share. Pointers to functions are null.

    Args:
        root: The struct; arrays that it points to contain numbers.
        headers: Texts of the headers that declare its type and the types of its fields.
    """
    regions = [*_regions(root, set())]
    constants = _constants(headers)
    # A pointer: its region, word and field, and the region that it points into with the offset there [bytes].
    links = [
        (number, word, field, target, int(region.words[word]) - regions[target].address)
        for number, region in enumerate(regions)
        for word, field in region.pointers.items()
        for target, other in enumerate(regions)
        if 0 <= int(region.words[word]) - other.address < WORD * other.words.size
    ]
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
        f"    aim({places[number]} + {word}, (const char *)({places[target]}) + {offset});"
        for number, word, _, target, offset in links
    ]
    return "\n".join([*tables, *_write_words(np.concatenate(words)), _POINTING, *lines, "}", ""])


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
