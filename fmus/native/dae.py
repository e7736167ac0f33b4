"""The front end: rumoca reads Modelica and returns the checked, flat DAE with resolved operands."""

import json
import os
import re
import threading
from codecs import BOM_UTF8
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import rumoca

from railgrip.base.errors import InputError, TranslationError
from railgrip.base.files import read_bytes, read_text, scratch
from railgrip.base.groups import gather
from railgrip.fmus.native.classes import Node, Sources, Tree, read_tree, without_texts
from railgrip.fmus.native.error_places import (
    explain,
    has_class_extends,
    limits,
    nested_arrays,
    places,
    require_readable,
    short,
)
from railgrip.fmus.native.language import require_strict, require_values
from railgrip.fmus.native.library import (
    LIBRARY,
    VARIABLE,
    is_trusted,
    library_of,
    modelica_files,
    name_of,
    sources_digest,
    used_libraries,
)
from railgrip.fmus.native.names import Call, misread_values
from railgrip.fmus.native.rewriting import rewrite
from railgrip.fmus.native.stored_dae import VERSION, convert

_CACHE_OF_RUMOCA = "XDG_CACHE_HOME"
"""Environment variable in which rumoca finds the folder of its cache, on every platform."""

_SECTION = re.compile(r"\b(initial\s+)?(?:equation|algorithm)\b")

Binding = Mapping[tuple[int, int], int]
"""Values of loop variables: (domain, ordinal of the binder) → value."""


@dataclass(frozen=True)
class Dae:
    """A flat Modelica class.

    Attributes:
        class_name: Full Modelica name.
        content: rumoca's checked DAE, see `stored_dae`.
        protected: Names of the variables that are protected, or are in a protected component.
        sources: Source id to (file name, text); spans are byte offsets into the text.
        doubtful: Parameters that are misread unless they have their default, see `names.misread_values`.
    """

    class_name: str
    content: Node
    protected: frozenset[str]
    sources: Mapping[int, tuple[str, bytes]]
    doubtful: list[tuple[str, float | None, str]] = field(default_factory=list[tuple[str, float | None, str]])
    _initial: dict[tuple[int, int], bool] = field(default_factory=dict[tuple[int, int], bool])

    @property
    def expressions(self) -> list[Node]:
        """Expression nodes, indexed by id."""
        return self.content["expressions"]

    @property
    def variables(self) -> list[Node]:
        """Declared variables, arrays whole."""
        return self.content["variables"]

    @property
    def functions(self) -> list[Node]:
        """Modelica functions in static single assignment form."""
        return self.content["functions"]

    @property
    def calls(self) -> list[Call]:
        """All calls of functions, with the functions that the front end takes for them."""
        calls = [node for node in self.expressions if node["operation"]["kind"] == "call"]
        called = [self.functions[node["operation"]["function"]] for node in calls]
        return [(f["name"], f["declaration"], n["provenance"]) for f, n in zip(called, calls, strict=True)]

    def shape(self, value_type: int) -> tuple[int, ...]:
        """Return the dimensions of a value type."""
        return tuple(self.content["value_types"][value_type]["dimensions"])

    def extents(self, domain: int) -> tuple[int, ...]:
        """Return the sizes of an iteration domain."""
        return tuple(map(len, self._ranges(domain)))

    def iterate(self, domain: int, count: int | None = None) -> Iterator[dict[tuple[int, int], int]]:
        """Yield the loop variables, or the first `count` of them, of every point of an iteration domain.

        The last index is the fastest.
        """
        for point in product(*self._ranges(domain)[:count]):
            yield {(domain, ordinal): value for ordinal, value in enumerate(point)}

    def _ranges(self, domain: int) -> list[range]:
        binders = self.content["domains"][domain]["domain"]["binders"]
        return [range(b["lower"], b["upper"] + (1 if b["step"] > 0 else -1), b["step"]) for b in binders]

    def where(self, provenance: Node | None) -> str:
        """Return `file.mo:line` of a node's provenance."""
        span = (provenance or {}).get("span")
        if not span or span["source"] not in self.sources:
            return self.class_name
        name, text = self.sources[span["source"]]
        line = text.count(b"\n", 0, span["start"]) + 1
        return f"{name}:{line}"

    def text(self, provenance: Node | None, *, subscripts: bool = False) -> str:
        """Return the Modelica text of a node, on one line, with the subscripts that follow it if requested."""
        span = (provenance or {}).get("span")
        if not span or span["source"] not in self.sources:
            return "?"
        _, text = self.sources[span["source"]]
        begin, end = span["start"], span["end"]
        # rumoca leaves out the outer parentheses of operands.
        depth = lowest = 0
        for octet in text[begin:end]:
            depth += (octet in b"(") - (octet in b")")
            lowest = min(lowest, depth)
        while lowest < 0 and text[begin - 1 : begin] in (b"(", b" "):
            begin -= 1
            lowest += text[begin : begin + 1] == b"("
            depth += text[begin : begin + 1] == b"("
        while depth > 0 and text[end : end + 1] in (b")", b" "):
            depth -= text[end : end + 1] == b")"
            end += 1
        if subscripts and text[end : end + 1] == b"[":
            end = text.find(b"]", end) + 1
        return " ".join(text[begin:end].decode(errors="replace").split())

    def is_initial(self, provenance: Node) -> bool:
        """Return whether a node is in a section `initial equation` or `initial algorithm`, which rumoca omits."""
        span = provenance.get("span")
        if not span or span["source"] not in self.sources:
            return False
        place = span["source"], span["start"]
        if place not in self._initial:  # a class has many instances, and their assertions the same place
            _, text = self.sources[span["source"]]
            keywords = _SECTION.findall(without_texts(text[: span["start"]].decode(errors="replace")))
            self._initial[place] = bool(keywords) and bool(keywords[-1])
        return self._initial[place]

    def is_read(self, variable: int) -> bool:
        """Return whether an expression refers to a variable."""
        return variable in self._read

    @cached_property
    def _read(self) -> set[int]:
        return {node["operation"].get("coordinate", {}).get("id") for node in self.expressions}

    def refuse(self, construct: str, provenance: Node | None) -> TranslationError:
        """Return the error for an unsupported construct, for the caller to raise."""
        return TranslationError(f"{self.where(provenance)}: {self.class_name}: {construct}")

    def misread_slices(self) -> Iterator[Node]:
        """Yield slices of arrays of components that rumoca 0.10 misreads.

        `a.z[2]` becomes `a[2].z`, and `a.p` through two dimensions the value of p in the class of a.
        """
        names = {v["id"]: v["name"].split(".") for v in self.variables}
        # A name may start in a component of an array, where the class of the component is written once for all.
        ends = {".".join(name[-k:]) for name in names.values() for k in range(2, len(name) + 1)}
        in_arrays = {_without_subscripts(end) for end in ends if "]." in end}
        others = set[tuple[int, int, int]]()  # places of other names; instances of a class have the same places
        for node in self.expressions:
            operation, span = node["operation"], node["provenance"].get("span")
            if operation["kind"] not in ("coordinate", "literal") or not span or span["source"] not in self.sources:
                continue
            place = span["source"], span["start"], span["end"]
            if place in others:
                continue
            _, text = self.sources[span["source"]]
            written = text[span["start"] : span["end"]].decode(errors="replace")
            if _without_subscripts(written) not in in_arrays:
                others.add(place)
                continue
            name = names.get(operation.get("coordinate", {}).get("id"), [])
            end = ".".join(name[-len(_without_subscripts(written).split(".")) :])
            is_same = _without_subscripts(end) == _without_subscripts(written)  # else it is what has this value
            is_indexed = text[span["end"] :].lstrip().startswith(b"[")
            if operation["kind"] == "literal" or (is_same and is_indexed and written.count("[") < end.count("[")):
                yield node

    @cached_property
    def by_span(self) -> dict[tuple[int, int, int], list[Node]]:
        """Expression nodes by source id, begin and end of their text, by which alone time events refer to them."""
        spans = ((node["provenance"]["span"], node) for node in self.expressions)
        return gather(((span["source"], span["start"], span["end"]), node) for span, node in spans)


def read(
    class_name: str, modelica_path: Path | None = None, *, others: Sequence[Path] = (), complete: bool = False
) -> Dae:
    """Flatten and check a Modelica class.

    Args:
        class_name: Full name, such as `RailBraking.Plants.TwoPartTrain`.
        modelica_path: A `.mo` file, or a library's folder with its `package.mo`; RailBraking by default. It may use
            classes of RailBraking; a library declares that with `annotation(uses(RailBraking))` in its `package.mo`.
        others: Further libraries that it may use, besides those that `used_libraries` finds.
        complete: Whether every parameter must have a value.

    Raises:
        InputError: The file or class is missing, or the Modelica code has an error; the message quotes rumoca.
        TranslationError: rumoca misinterprets a construct or fails on it, or a parameter has no value.
    """
    path = LIBRARY if modelica_path is None else Path(modelica_path)
    if path.is_dir():
        path = path / "package.mo"
    if not path.is_file():
        raise InputError(f"{class_name}: there is no Modelica file {path}.")
    used = used_libraries(class_name, library_of(path), others)
    with scratch("build") as folder:
        used.write(folder)
        is_part = path.name == "package.mo" and name_of(path.parent) in used.names
        own = folder / name_of(path.parent) / "package.mo" if is_part else _without_other_files(path, folder)
        try:
            for name in used.names:
                require_readable(folder / name / "package.mo")
            further = folder if used.texts else None
            if not is_trusted(path):
                # The diagnosis of an error takes longer than the translation, and may not be necessary.
                original = own, further
                try:
                    return _read(class_name, *original, complete=complete, is_diagnosed=False)
                except InputError as error:
                    problem = str(error)
                own, further = _rewrite(*original, folder)
                if (own, further) != original:
                    try:
                        return _read(class_name, own, further, complete=complete, is_diagnosed=False)
                    except InputError as error:
                        problem = str(error)
                if "`empty array`" in problem:
                    with suppress(InputError):
                        copy = _rewrite(*original, folder, has_empty_ranges=True)
                        return _read(class_name, *copy, complete=complete, is_diagnosed=False)
            return _read(class_name, own, further, complete=complete)
        except InputError as error:
            # The user does not know the copies.
            raise type(error)(_without_folder(str(error), folder)) from error


def _without_other_files(path: Path, folder: Path) -> Path:
    # The path of a copy of a library without the hidden files and links that rumoca would read or fail on, if any.
    if path.name != "package.mo" or is_trusted(path):
        return path
    files = modelica_files(path.parent)
    if set(path.parent.rglob("*.mo")) <= set(files):
        return path
    for file in files:
        copy = folder / _ORIGINALS / file.relative_to(path.parents[1])
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(read_bytes(file))
    return folder / _ORIGINALS / path.relative_to(path.parents[1])


_COPIES = "rewritten-texts"  # not the name of a library
_ORIGINALS = f"{_COPIES}/originals"
_COPY = f"{_COPIES}/libraries"
_COPY_OF_FILE = f"{_COPIES}/file"


def _rewrite(
    path: Path, further: Path | None, folder: Path, *, has_empty_ranges: bool = False
) -> tuple[Path, Path | None]:
    # The path of the rewritten copy of a file, and the folder of that of further libraries, if any; the same if nothing
    # is rewritten. The copies of libraries are in one folder, that of a single file is in another, because rumoca reads
    # all files next to it.
    end = "-with-empty-ranges" if has_empty_ranges else ""
    copies = folder / f"{_COPY}{end}"
    base = path.parents[1] if path.name == "package.mo" else path.parent
    found = (file.relative_to(folder) for file in folder.rglob("*.mo"))
    files = {folder / file: copies / file for file in found if file.parts[0] != _COPIES}
    if path.name == "package.mo":
        files |= {file: copies / file.relative_to(base) for file in modelica_files(path.parent) if file.suffix == ".mo"}
    else:
        files[path] = folder / f"{_COPY_OF_FILE}{end}" / path.name
    contents = {file: read_bytes(file) for file in files}
    texts = {str(file): content.decode("utf-8-sig", errors="replace") for file, content in contents.items()}
    changed = rewrite(texts, has_empty_ranges=has_empty_ranges)
    marked = [content for content in contents.values() if content.startswith(BOM_UTF8)]
    if not changed and not marked:
        return path, further
    for file, copy in files.items():
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(changed.get(str(file), texts[str(file)]).encode())
    return files[path], copies if copies.is_dir() else None


def _without_folder(message: str, folder: Path) -> str:
    shown = re.sub(rf"(?:{re.escape(str(folder.parent))}/)?{re.escape(folder.name)}/", "", message)
    return re.sub(rf"{_COPIES}/[\w-]+/", "", shown)


def _read(class_name: str, path: Path, further: Path | None, *, complete: bool, is_diagnosed: bool = True) -> Dae:
    # `further` is the folder of all libraries besides RailBraking and that of the class.
    # rumoca reads all files in the folder of a file, so a single file has a name in a folder that does not exist.
    alias = f"single-file/{path.name}"
    parts = [] if further is None else sorted(further.glob("*/package.mo"))
    if path.parent != LIBRARY:
        require_readable(path)
        if any(map(has_class_extends, (path, *parts))):  # rumoca overflows its stack if the class uses it
            _diagnose(class_name, path, alias, further)
    try:
        with _environment_of_rumoca():
            if path.name == "package.mo":
                model = _session(path.parent, further).load(str(path), model=class_name)
            else:
                model = _new_session(further).loads(read_text(path), model=class_name, filename=alias)
            stored = json.loads(model.to_json("dae", pretty=False))
            flat_class = model.to_json("flat", pretty=False)
            flat = _first_object(flat_class, "variables")
    except BaseException as error:
        is_panic = type(error).__name__ == "PanicException"  # of rumoca, no Exception, and nowhere to import from
        if not is_panic and not isinstance(error, rumoca.RumocaError | RuntimeError):
            raise
        if not is_diagnosed:
            raise InputError(str(error)) from error

        def load(text: str, file: Path) -> None:
            # The text of a file of a library counts instead of what is on disk.
            is_single = path.name != "package.mo"
            own = [] if is_single else [path.parent]
            with _environment_of_rumoca():
                _new_session(further, *own).loads(text, model=class_name, filename=alias if is_single else str(file))

        if is_panic:
            sentences = limits(str(error), path, class_name, load) or [_describe_panic(str(error), path, class_name)]
            raise TranslationError("\n".join(sentences)) from error
        message = str(error).replace(alias, str(path))
        message = message if further is None else message.replace(f"{further}{os.sep}", "")
        if nested := nested_arrays(message, path, class_name):
            raise TranslationError("\n".join(nested)) from error
        cause = _diagnose(class_name, path, alias, further)
        if sentences := limits(message, path, class_name, load):
            raise TranslationError("\n".join(sentences)) from error
        message = explain(cause if message.endswith("because resolve/parse failed") and cause else message)
        hints = "".join(f"\n  {place}" for place in places(message, path, class_name))
        where = path if further is None else short(path, path, further)
        is_limit = re.search("supported|could not be evaluated|requires parameter|miscounted", message)
        kind = TranslationError if is_limit else InputError
        raise kind(f"{class_name} does not compile ({where}): {message}{hints}") from error
    if stored["schema_version"] != VERSION:
        raise InputError(
            f"rumoca {rumoca.version()} writes version {stored['schema_version']} of the DAE, this compiler reads "
            f"{VERSION}; install the version of rumoca that is pinned in pyproject.toml."
        )
    content, sources = convert(stored["storage"]), _sources(stored, path, alias, further)
    tree = read_tree(model, class_name, sources)
    protected = frozenset(name for name, variable in flat.items() if variable["is_protected"])
    dae = Dae(class_name=class_name, content=content, protected=protected, sources=sources)
    key = "parameter_branch_selections"
    selections = _first_object(flat_class, key) if f'"{key}":' in flat_class else []
    dae.doubtful.extend(misread_values(tree, flat, selections))
    require_strict(tree, class_name, flat, dae.calls)
    outer = outer_variables(tree, flat)
    require_values(tree, class_name, flat, outer.keys(), complete=complete)
    impossible = connect_outer(content, outer)
    if impossible:
        raise TranslationError(
            f"{class_name}: the outer variable {impossible[0]} is not of the type, size or variability of the inner "
            f"{outer[impossible[0]]} (5.4)."
        )
    return dae


def _without_subscripts(name: str) -> str:
    return re.sub(r"\[[^\]]*\]", "", name)


def _describe_panic(message: str, path: Path, class_name: str) -> str:
    where = short(path, path)
    position = re.search(r"start: BytePos\((\d+)\)", message)
    if position and path.name != "package.mo":  # a library has many files, of which the message has a number only
        where += f":{len(path.read_bytes()[: int(position[1])].splitlines())}"
    detail = re.search(r'detail: "([^"]*)"', message)
    return f"{where}: {class_name}: rumoca, the front end, fails on this class: {detail[1] if detail else message}"


def _sources(stored: Node, path: Path, alias: str, further: Path | None) -> Sources:
    return {
        number: (short(path if name == alias else Path(name), path, further), text.encode())
        for number, name, text in stored["source_map"]["files"]
    }


def _diagnose(class_name: str, path: Path, alias: str, further: Path | None) -> str:
    # Raise an error for what `require_strict` finds, else return the cause of an error of syntax, if it is known.
    # rumoca has a syntax tree of a class that it cannot translate only if another class imports it, and names the cause
    # of some errors of syntax only then.
    name = "Class__with__an__import"
    importing = f"\nmodel {name} import {class_name}; Real x = 1; end {name};\n"
    try:
        with _environment_of_rumoca():
            if path.name == "package.mo":
                session, text = _new_session(further, path.parent), importing
            else:
                session, text = _new_session(further), read_text(path) + importing
            model = session.loads(text, model=name, filename=alias)
            stored = json.loads(model.to_json("dae", pretty=False))
            tree = read_tree(model, class_name, _sources(stored, path, alias, further))
    except (rumoca.RumocaError, RuntimeError) as error:
        message = str(error).replace(alias, str(path)).replace(name, class_name)
        if "unresolved import" in message:
            message = f"there is no class {class_name}"
        return message
    except InputError:
        return ""
    require_strict(tree, class_name, {})
    return ""


_environment = threading.Lock()


@contextmanager
def _environment_of_rumoca() -> Generator[None]:
    # A damaged file in rumoca's cache aborts this process, and the cache saves less than a tenth of the time of a
    # translation. It would read all of the libraries of MODELICAPATH, and `used_libraries` has found the used part.
    # With putenv only rumoca sees the change: Python and the processes that it starts use os.environ.
    with _environment:
        os.putenv(_CACHE_OF_RUMOCA, os.devnull)
        os.unsetenv(VARIABLE)
        try:
            yield
        finally:
            for name in (_CACHE_OF_RUMOCA, VARIABLE):
                if name in os.environ:
                    os.putenv(name, os.environ[name])
                else:
                    os.unsetenv(name)


def _first_object(text: str, key: str) -> Any:
    # Only the first object of that name is parsed; it is a small part of the text.
    name = f'"{key}":'
    return json.JSONDecoder().raw_decode(text, text.index(name) + len(name))[0]


_last = threading.local()
"""The last session of each thread; sessions must not be shared between threads."""


def _session(library: Path, further: Path | None) -> rumoca.Session:
    # Reading a library takes longer than flattening most of its classes, so a session is reused while no file of the
    # library changes; it would not read a changed file again.
    if further is not None:
        return _new_session(further)
    key = (library, sources_digest(library))
    if getattr(_last, "key", None) != key:
        _last.key, _last.session = key, _new_session(None)
    return _last.session


def _new_session(further: Path | None, *own: Path) -> rumoca.Session:
    # One folder with all further libraries: as several roots, rumoca 0.10 does not find one from the other.
    folders = {LIBRARY, *(() if further is None else (further,)), *(p for p in own if p.parent != further)}
    return rumoca.Session(roots=[str(folder) for folder in sorted(folders)])


Names = Mapping[str, str]
"""Name of each outer variable → name of its inner one."""


def outer_variables(tree: Tree, flat: Mapping[str, Node]) -> Names:
    """Return the outer variables of a class.

    Args:
        tree: Declarations of the class and of those that it uses.
        flat: Variables of the flat class by name.
    """
    found: dict[str, str] = {}
    for name, variable in flat.items():
        parts = (variable.get("component_ref") or {}).get("parts") or []
        if parts and _declared(tree, parts[-1], "outer"):
            instance = name.rpartition(".")[0]
            while instance:
                instance = instance.rpartition(".")[0]
                inner = f"{instance}.{parts[-1]['ident']}" if instance else parts[-1]["ident"]
                candidate = (flat.get(inner, {}).get("component_ref") or {}).get("parts")
                if candidate and _declared(tree, candidate[-1], "inner"):
                    found[name] = inner
                    break
    return found


def _declared(tree: Tree, part: Node, prefix: str) -> bool:
    owner = tree.component_of_id.get(part["def_id"])
    return owner is not None and bool(owner[0].components[owner[1]][prefix])


def connect_outer(content: Node, outer: Names) -> list[str]:
    """Give each outer variable of a DAE the value of its inner one, and return those for which that is impossible.

    Args:
        content: rumoca's checked DAE, which is changed.
        outer: See `outer_variables`.
    """
    variables = {v["name"]: v for v in content["variables"]}
    impossible: list[str] = []
    for name, inner in outer.items():
        if name not in variables:
            continue
        mine, other = variables[name], variables.get(inner)
        if other is None or mine["value_type"] != other["value_type"]:
            impossible.append(name)
            continue
        expression = {
            "operation": {"kind": "coordinate", "coordinate": {"kind": other["role"], "id": other["id"]}},
            "domains": frozenset[int](),
            "provenance": mine["declaration"],
        }
        content["expressions"].append(expression)
        number = len(content["expressions"]) - 1
        if mine["role"] in ("parameter", "constant"):
            mine["attributes"] |= {"binding": number, "start": None}
        elif not _define(content, mine["id"], number):
            impossible.append(name)
    return impossible


def _define(content: Node, variable: int, expression: int) -> bool:
    for owner in content["discrete_value_owners"]:
        if owner["targets"] == [variable] and len(owner["branches"]) == 1:
            owner["branches"][0]["values"][0]["value"] = expression
            return True
    return False
