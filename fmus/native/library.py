"""Modelica libraries that a class uses: where they are found, which version, and which part of them.

A library is searched among those that the user names, then in the folders of the environment variable MODELICAPATH
(section 13.3 of the Modelica Language Specification, version 3.6), then in the folders where OpenModelica installs
libraries. Only RailBraking is part of this project. Of a large library only the files of used classes are read.

Digests cover everything that a compiled class depends on.
"""

import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import Final

from railgrip.base import cache, units
from railgrip.base.errors import InputError
from railgrip.base.files import LARGEST_TABLE, read_bytes
from railgrip.base.programs import find_program
from railgrip.fmus.native.classes import KINDS

# Resolved, because rumoca treats a library that it finds by two paths as two libraries.
MODELICA = (Path(__file__).parents[2] / "modelica").resolve()
LIBRARY = MODELICA / "RailBraking"
LARGEST_WHOLE = 1 << 20
"""Largest size of a library [bytes] that the front end reads as a whole; it takes about a second for this size."""


def require_class_name(name: str) -> None:
    """Raise an error for a class name with quoted identifiers: it becomes part of file names and of omc's script.

    Raises:
        InputError: It has a quoted identifier or characters other than letters, digits and underscores.
    """
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", name, flags=re.ASCII):
        raise InputError(
            f"{name!r} is not the name of a Modelica class: it has letters, digits and underscores, with dots between "
            "packages, such as MyLib.MyTrain."
        )


def is_trusted(library: Path) -> bool:
    """Return whether a library is from this project: built-in, or generated into the user's cache."""
    return any(library.is_relative_to(folder) for folder in (MODELICA, cache.folder() / "modelica"))


def library_digest(library: Path) -> str:
    """Return a digest over the names and contents of a library's Modelica files, or of one file."""
    if not library.is_dir():
        return hashlib.sha256(read_bytes(library, LARGEST_TABLE)).hexdigest()
    out = hashlib.sha256()
    for file in modelica_files(library):
        out.update(file.relative_to(library.parent).as_posix().encode() + b"\0")
        out.update(read_bytes(file) + b"\0")
    return out.hexdigest()


def modelica_files(library: Path) -> list[Path]:
    """Return the Modelica files and files `package.order` of a library's folder, or its only file.

    Folders without `package.mo` are no packages (13.4.1). Hidden files and links to files that do not exist are made by
    editors, version control and archives.

    Raises:
        InputError: The library contains a folder twice, by a link.
    """
    if not library.is_dir():
        return [library]
    found, names_of = list[Path](), dict[Path, str]()
    for folder, folders, names in os.walk(library, followlinks=True):
        here = Path(folder)
        _require_one_name(here, folder, names_of)
        folders[:] = [name for name in folders if name[0] != "." and (here / name / "package.mo").is_file()]
        named = [name for name in names if name[0] != "." and (name.endswith(".mo") or name == "package.order")]
        found += [here / name for name in named if (here / name).exists()]
    return sorted(found)


def _require_one_name(folder: Path, name: str, names_of: dict[Path, str]) -> None:
    # A link to a folder around it gives that further names without end; `names_of` has those of real paths.
    real = folder.resolve()
    if names_of.setdefault(real, name) != name:
        raise InputError(f"{folder}: the library contains the folder {real} twice; remove the link that leads to it.")


def library_of(file: Path) -> Path:
    """Return the library of a file: the folder of a `package.mo`, else the file itself."""
    return file.parent if file.name == "package.mo" else file


def sources_digest(library: Path) -> str:
    """Return a digest over everything that a class of a library may use: the library itself, and RailBraking."""
    own = library_digest(library)
    return own if library == LIBRARY else hashlib.sha256(f"{own} {library_digest(LIBRARY)}".encode()).hexdigest()


def digest(parts: Iterable[str]) -> str:
    """Return the SHA-256 of texts, each followed by a zero byte."""
    out = hashlib.sha256()
    for part in parts:
        out.update(part.encode() + b"\0")
    return out.hexdigest()


@lru_cache(maxsize=1)
def compiler_digest() -> str:
    """Return a digest over the source of the built-in compiler and the versions of packages that it uses."""
    here = Path(__file__).parent
    files = sorted(file for file in here.rglob("*") if file.suffix in (".py", ".c", ".h", ".toml", ".jinja"))
    base = Path(units.__file__)
    files += [base, base.with_name("system.py"), units.DEFINITIONS]
    packages = [version(name) for name in ("rumoca", "casadi", "numpy", "scipy")]
    return digest([*packages, *(file.read_text(encoding="utf-8") for file in files)])


VARIABLE: Final = "MODELICAPATH"
_STANDARD: Final = ("Modelica", "ModelicaServices")
"""Libraries that are missed even if no `uses` annotation declares them."""


@dataclass(frozen=True, slots=True)
class FoundLibrary:
    """A library on disk: its folder with `package.mo`, or its only file, and its version, '' without one."""

    name: str
    path: Path
    version: str


@dataclass(frozen=True, slots=True)
class UsedLibraries:
    """What a class uses of libraries other than its own and RailBraking.

    Attributes:
        libraries: The libraries, by name.
        texts: File, from the name of its library on → the text of the classes that may be used.
    """

    libraries: Mapping[str, FoundLibrary]
    texts: Mapping[str, str]

    @property
    def names(self) -> frozenset[str]:
        """Names of the libraries."""
        return frozenset(name.partition("/")[0] for name in self.texts)

    def write(self, folder: Path) -> None:
        """Write the texts to files below a folder."""
        for name, text in self.texts.items():
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(text.encode())


def name_of(library: Path) -> str:
    """Return the name of a library, without the version that may be part of the name of its folder."""
    return (library.name if library.is_dir() else library.stem).partition(" ")[0]


def is_read_whole(library: Path) -> bool:
    """Return whether the front end reads all of a class's own library; of a larger one only what the class uses."""
    return not library.is_dir() or sum(file.stat().st_size for file in modelica_files(library)) <= LARGEST_WHOLE


def used_libraries(class_name: str, library: Path, others: Sequence[Path] = ()) -> UsedLibraries:
    """Return the used part of other libraries, and of the class's library if that is too large to be read as a whole.

    Args:
        class_name: Full name of the class; its library is read as a whole with an empty name.
        library: Folder or file of its library.
        others: Further libraries that the user names.

    Raises:
        InputError: A library is missing, or only other versions of it exist; or a file of it is not readable.
    """
    if is_trusted(library):
        return UsedLibraries({}, {})
    return _LibrarySearch(class_name, library, others).result()


def uses_digest(library: Path, others: Sequence[Path] = (), class_name: str = "") -> str:
    """Return a digest over everything that a class of a library may use; arguments and errors as `used_libraries`."""
    used = used_libraries(class_name, library, others)
    is_part = bool(class_name) and not is_trusted(library) and not is_read_whole(library)
    own = sources_digest(LIBRARY if is_part else library)
    return digest([own, *(part for text in used.texts.items() for part in text)]) if used.texts else own


def used_paths(class_name: str, library: Path, others: Sequence[Path] = ()) -> tuple[Path, ...]:
    """Return the folders or files of the libraries that a class uses; arguments and errors as `used_libraries`."""
    return tuple(found.path for found in used_libraries(class_name, library, others).libraries.values())


def file_digest(file: Path) -> str:
    """Return a digest of a file; of a `package.mo` or another Modelica file, of everything that its classes may use."""
    library = library_of(file)
    own = library_digest(library)
    texts = used_libraries("", library).texts if file.suffix == ".mo" else {}
    return digest([own, *(part for text in texts.items() for part in text)]) if texts else own


class _LibrarySearch:
    """The search for one class; `required` is the version of each library in `uses`, with the file that has it."""

    def __init__(self, class_name: str, library: Path, others: Sequence[Path]) -> None:
        self.library, self.own = library, name_of(library)
        self.others = others
        self.found: dict[str, FoundLibrary] = {}
        self.required: dict[str, tuple[str, Path]] = {}
        self.used = UsedClasses()
        self.top = {self.own, LIBRARY.name}
        words: set[str] = set()
        if class_name and not is_read_whole(library):
            self._note_uses(library / "package.mo")
            self.used.offer(self.own, lambda: library)
            words |= set(class_name.split("."))
        else:
            files = modelica_files(library)
            self._note_uses(library / "package.mo" if library.is_dir() else library)
            for file in (one for one in files if one.suffix == ".mo"):
                inside, declared = words_of(file)
                words |= inside
                self.top |= declared if not library.is_dir() else set()
        for name in {*self.required, *_STANDARD, *_names_on(others)} - self.top:
            self.used.offer(name, partial(self._find, name))
        self.used.use(words)

    def result(self) -> UsedLibraries:
        return UsedLibraries(self.found, self.used.texts())

    def _note_uses(self, file: Path) -> None:
        if not file.is_file():
            return
        text = read_bytes(file).decode(errors="replace")
        for match in re.finditer(r"\buses\s*\(", text):
            uses = text[match.start() : end_of_brackets(text, match.start())]
            for name, stated in re.findall(r"(\w+)\s*\(\s*version\s*=\s*\"([^\"]*)\"", uses):
                # OpenModelica writes "default" for a library without a version.
                self.required.setdefault(name, ("" if stated == "default" else stated, file))
            for name in re.findall(r"[(,]\s*(\w+)\s*(?=[,)])", uses):
                self.required.setdefault(name, ("", file))

    def _find(self, name: str) -> Path | None:
        version, file = self.required.get(name, ("", Path()))
        candidates = list(_candidates(name, self.others))
        if not candidates:
            if name not in self.required and name not in _STANDARD:
                return None
            raise InputError(
                f"{self.library}: uses the library {name}, which was not found in {_places()}. Name its folder with "
                f"--library, or the folder that contains it in the environment variable {VARIABLE}."
            )
        fitting = [one for one in candidates if not version or _is_compatible(one, version)]
        if not fitting:
            there = ", ".join(f"{one.version or 'no version'} in {one.path}" for one in candidates[:3])
            raise InputError(
                f"{file}: the annotation uses names version {version} of {name}; found was {there}. Name a copy of "
                f"version {version} with --library or its folder in {VARIABLE}, or change the annotation."
            )
        exact = [one for one in fitting if _plain(one.version) == _plain(version)]
        self.found[name] = (exact or fitting)[0]
        path = self.found[name].path
        before = set(self.required)
        self._note_uses(path / "package.mo" if path.is_dir() else path)
        for further in set(self.required) - before - self.top:
            self.used.offer(further, partial(self._find, further))
        return path


def _plain(version: str) -> str:
    return version.partition("+")[0]  # OpenModelica's copies are 4.0.0+maint.om


def _is_compatible(one: FoundLibrary, version: str) -> bool:
    if _plain(one.version) == _plain(version):
        return True
    text = read_bytes(one.path / "package.mo" if one.path.is_dir() else one.path).decode(errors="replace")
    return version in re.findall(r"\bnoneFromVersion\s*=\s*\"([^\"]*)\"", text)


def _candidates(name: str, others: Sequence[Path]) -> Iterator[FoundLibrary]:
    for path in others:
        if name_of(path) == name:
            yield FoundLibrary(name, path, _version_of(path))
    for folder in search_folders():
        here = [folder / name, folder / f"{name}.mo"]
        here += sorted(folder.glob(f"{name} *"), key=_order, reverse=True)
        for path in here:
            if (path / "package.mo").is_file() or (path.suffix == ".mo" and path.is_file()):
                yield FoundLibrary(name, path.resolve(), _version_of(path))


def _order(path: Path) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", path.stem)]


def _version_of(path: Path) -> str:
    named = path.name.removesuffix(".mo").partition(" ")[2]
    if named:
        return named
    text = read_bytes(path / "package.mo" if path.is_dir() else path).decode(errors="replace")
    match = re.search(r"\b(?:uses|conversion)\s*\(", text)
    while match is not None:  # their versions are those of other libraries
        text = text[: match.start()] + text[end_of_brackets(text, match.start()) :]
        match = re.search(r"\b(?:uses|conversion)\s*\(", text)
    match = re.search(r"[(,]\s*version\s*=\s*\"([^\"]*)\"", text)
    return match[1] if match else ""


def _names_on(others: Sequence[Path]) -> set[str]:
    names = {name_of(path) for path in others}
    for folder in search_folders():
        for entry in folder.iterdir():
            if entry.suffix == ".mo" or (entry / "package.mo").is_file():
                names.add(name_of(entry))
    return names


def search_folders() -> tuple[Path, ...]:
    """Return the folders in which libraries are searched: those of MODELICAPATH, then those of OpenModelica."""
    named = [Path(entry).absolute() for entry in os.environ.get(VARIABLE, "").split(os.pathsep) if entry]
    return tuple(folder for folder in (*named, *folders_of_openmodelica()) if folder.is_dir())


def folders_of_openmodelica() -> Iterator[Path]:
    """Yield the folders in which OpenModelica installs libraries."""
    yield Path("~/.openmodelica/libraries").expanduser()
    omc = find_program("omc")
    if omc is not None:
        yield Path(omc).resolve().parents[1] / "lib" / "omlibrary"


def _places() -> str:
    folders = search_folders()
    return ", ".join(map(str, folders)) if folders else f"any folder, because {VARIABLE} is not set"


_TOKEN = re.compile(
    r"""//[^\n]*|/\*.*?\*/|"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|\d[\w.]*|[^\W\d]\w*|[;(){}\[\]]""", re.DOTALL
)
CLASS_WORDS = frozenset(KINDS.split("|"))
CLASS_PREFIXES = frozenset(
    ["redeclare", "final", "inner", "outer", "replaceable", "encapsulated", "partial", "expandable", "pure", "impure"]
)
_STATEMENTS = frozenset(["if", "for", "when", "while"])
_DEEPEST = 100
"""Maximum depth of nested classes; the recursion of Python ends at a thousand."""
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


BYTE_ORDER_MARK = "\ufeff"


def read_utf_8(path: Path) -> str:
    """Return the text of a Modelica file, with a byte order mark if it has one.

    Raises:
        InputError: The file is not readable, or not in UTF-8.
    """
    content = read_bytes(path)
    try:
        return content.decode()
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}:{line}: the text is not UTF-8; save the file as UTF-8.") from error


def scan(path: Path) -> ScannedFile:
    """Return the classes of a file.

    Raises:
        InputError: The file is not in UTF-8, or the beginnings and ends of its classes do not match, or they are nested
            too deeply.
    """
    text = read_utf_8(path).removeprefix(BYTE_ORDER_MARK)
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
        elif depth == 0 and word in CLASS_PREFIXES:
            prefix = start if prefix < 0 else prefix
        elif depth == 0 and word in CLASS_WORDS:
            kind, name = _name(tokens, word)
            opened = ScannedClass(name[0], is_package=kind == "package", start=start if prefix < 0 else prefix)
            opened.is_complete = _IS_SHORT.match(text, name.end()) is not None
            stack[-1].children.append(opened)
            stack.append(opened)
            if len(stack) > _DEEPEST:
                line = text.count("\n", 0, start) + 1
                raise InputError(f"{path}:{line}: more than {_DEEPEST} nested classes; write fewer levels of packages.")
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
        if match[0] in CLASS_WORDS:
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
        self._names_of: dict[Path, str] = {}

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
        if is_folder:
            _require_one_name(path, name, self._names_of)
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
