"""The classes of large Modelica libraries that a class may use, without the rest of these libraries.

The front end takes minutes for all of the Modelica Standard Library, but a class uses a small part of it. A class of a
library is left out if its simple name occurs nowhere in the text that is kept. However Modelica finds a class (scopes,
imports, inheritance, redeclarations), the simple name is written where it is used. Therefore a class that is left out
would not have been found, and every other name means the same as before. Classes are left out of packages only, because
operators and constructors of records are called without their names. Texts keep their lines, so that places in messages
are those of the library.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from railgrip.base.errors import InputError
from railgrip.base.files import read_bytes

_TOKEN = re.compile(
    r"""//[^\n]*|/\*.*?\*/|"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|\d[\w.]*|[^\W\d]\w*|[;(){}\[\]]""", re.DOTALL
)
_CLASS = frozenset(["class", "model", "record", "block", "connector", "type", "package", "function", "operator"])
_PREFIXES = frozenset(
    ["redeclare", "final", "inner", "outer", "replaceable", "encapsulated", "partial", "expandable", "pure", "impure"]
)
_STATEMENTS = frozenset(["if", "for", "when", "while"])
_IS_SHORT = re.compile(r"\s*=")
_NAMES_FUNCTIONS = re.compile(r"\b(?:derivative|inverse)\b")


@dataclass
class ScannedClass:
    """A class in a file.

    Attributes:
        start: Offset of its first prefix in the text of the file.
        end: Offset after its semicolon.
        words: Identifiers in its text, without the classes in it and without annotations, which are documentation.
    """

    name: str
    is_package: bool
    start: int
    end: int = 0
    is_complete: bool = False
    words: set[str] = field(default_factory=set[str])
    children: list["ScannedClass"] = field(default_factory=list["ScannedClass"])


@dataclass(frozen=True)
class ScannedFile:
    """A file of a library; `root` is a package without a name that contains the classes of the file."""

    path: Path
    text: str
    root: ScannedClass


def scan(path: Path) -> ScannedFile:
    """Return the classes of a file.

    Raises:
        InputError: The file is not in UTF-8, or the beginnings and ends of its classes do not match.
    """
    content = read_bytes(path)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}:{line}: the text is not UTF-8; save the file as UTF-8.") from error
    root = ScannedClass("", is_package=True, start=0, end=len(text))
    stack = [root]
    depth, prefix = 0, -1
    tokens = (match for match in _TOKEN.finditer(text) if match[0][0] not in '"/0123456789')
    for match in tokens:
        word, start = match[0], match.start()
        if word in "([{":
            depth += 1
        elif word in ")]}":
            depth -= 1
        elif word == ";":
            if depth <= 0 and stack[-1].is_complete:
                stack.pop().end = match.end()
            prefix = -1
        elif word == "annotation" and depth == 0:
            end = end_of_brackets(text, match.end())
            if _NAMES_FUNCTIONS.search(text, start, end):
                stack[-1].words.update(re.findall(r"\w+", text[start:end]))
            while next(tokens, match).end() < end:
                pass
        elif depth == 0 and word in _PREFIXES:
            prefix = start if prefix < 0 else prefix
        elif depth == 0 and word in _CLASS:
            kind, name = _name(tokens, word)
            opened = ScannedClass(name[0], is_package=kind == "package", start=start if prefix < 0 else prefix)
            opened.is_complete = _IS_SHORT.match(text, name.end()) is not None
            stack[-1].children.append(opened)
            stack.append(opened)
            prefix = -1
        elif depth == 0 and word == "end":
            name = next(tokens, match)
            if name[0] in _STATEMENTS:
                continue
            if len(stack) == 1 or stack[-1].name != name[0]:
                line = text.count("\n", 0, start) + 1
                raise InputError(f"{path}:{line}: 'end {name[0]}' does not end the class {stack[-1].name or '(none)'}.")
            stack[-1].is_complete = True
        else:
            stack[-1].words.add(word)
            prefix = -1
    if len(stack) > 1:
        raise InputError(f"{path}: the class {stack[-1].name} has no 'end {stack[-1].name};'.")
    return ScannedFile(path, text, root)


def _name(tokens: Iterator[re.Match[str]], kind: str) -> tuple[str, re.Match[str]]:
    # As in `operator record Complex`, `model extends Train`.
    for match in tokens:
        if match[0] in _CLASS:
            kind = match[0]
        elif match[0] != "extends":
            return kind, match
    raise InputError(f"a Modelica file ends after the keyword {kind}.")


def end_of_brackets(text: str, start: int) -> int:
    """Return the offset after the brackets that open next in a Modelica text."""
    depth = 0
    for match in _TOKEN.finditer(text, start):
        if match[0] == "(":
            depth += 1
        elif match[0] == ")":
            depth -= 1
            if depth == 0:
                return match.end()
    return len(text)


def words_of(path: Path) -> tuple[set[str], set[str]]:
    """Return the identifiers in a file, as `ScannedClass.words`, and the names of its classes.

    If the beginnings and ends of classes do not match, which the front end reports, the names are not known.
    """
    try:
        left, words, names = [scan(path).root], set[str](), set[str]()
    except InputError:
        return set(re.findall(r"\w+", read_bytes(path).decode(errors="replace"))), set()
    while left:
        one = left.pop()
        words |= one.words
        names |= {child.name for child in one.children}
        left += one.children
    return words, names


class UsedClasses:
    """The part of libraries that may be found by names in some texts.

    Attributes:
        words: Identifiers in these texts and in all that is kept.
    """

    def __init__(self) -> None:
        self.words: set[str] = set()
        self._waiting: dict[str, list[Callable[[], None]]] = {}
        self._due: list[Callable[[], None]] = []
        self._kept: set[int] = set()
        self._files: dict[str, ScannedFile] = {}

    def use(self, words: Iterable[str]) -> None:
        """Keep all that may be found by names in a text with these identifiers."""
        self._spell(words)
        while self._due:
            self._due.pop()()

    def offer(self, name: str, find: Callable[[], Path | None]) -> None:
        """Offer a library, which is searched when its name is used; `find` returns a folder or file, or None."""

        def keep() -> None:
            path = find()
            if path is not None:
                self._keep_path(path, name)

        self._wait(name, keep)

    def texts(self) -> dict[str, str]:
        """Return the text of each file of which a part is kept, by its name from the name of the library on."""
        return {name: self._text(file) for name, file in sorted(self._files.items())}

    def _spell(self, words: Iterable[str]) -> None:
        for word in set(words) - self.words:
            self.words.add(word)
            self._due += self._waiting.pop(word, ())

    def _wait(self, name: str, keep: Callable[[], None]) -> None:
        if name in self.words:
            self._due.append(keep)
        else:
            self._waiting.setdefault(name, []).append(keep)

    def _keep_path(self, path: Path, name: str) -> None:
        is_folder = path.is_dir()
        file = scan(path / "package.mo" if is_folder else path)
        # The only file of a library becomes a package as well: the front end reads folders.
        self._files[f"{name}/package.mo" if is_folder or "/" not in name else f"{name}.mo"] = file
        for one in file.root.children:
            self._keep_class(one)
        for entry in sorted(path.iterdir()) if is_folder else ():
            if (entry / "package.mo").is_file() or (entry.suffix == ".mo" and entry.name != "package.mo"):
                child = entry.name if entry.is_dir() else entry.stem
                self._wait(child, partial(self._keep_path, entry, f"{name}/{child}"))

    def _keep_class(self, one: ScannedClass) -> None:
        self._kept.add(id(one))
        self._spell(one.words)
        for child in one.children:
            if one.is_package:
                self._wait(child.name, partial(self._keep_class, child))
            else:
                self._keep_class(child)

    def _text(self, file: ScannedFile) -> str:
        pieces, end = list[str](), 0

        def walk(one: ScannedClass) -> None:
            nonlocal end
            for child in one.children:
                if id(child) in self._kept:
                    walk(child)
                else:
                    pieces.append(file.text[end : child.start])
                    pieces.append("\n" * file.text.count("\n", child.start, child.end))
                    end = child.end

        walk(file.root)
        return "".join([*pieces, file.text[end:]])
