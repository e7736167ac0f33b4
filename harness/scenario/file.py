"""A file that a scenario names: kept as written, found relative to the scenario's folder, identified by its content."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from pydantic import GetCoreSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from railgrip.base.errors import ScenarioError
from railgrip.base.registry import Shelf, not_one_of, shelf
from railgrip.base.units import cut, place, short
from railgrip.fmus.native.used_libraries import file_digest

DIRECTORY = "directory"
"""Key of the validation context for the folder of the scenario file."""


def is_file(path: Path) -> bool:
    """Return whether a path is a file; also for paths that the system rejects, such as one of 5000 characters."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Return whether a path is a folder; as `is_file`."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def locate(entry: str | Path, kind: Shelf, folder: Path = Path(), where: str = "") -> Path:
    """Return the file for an entry: a path relative to a folder, or a bare name in the library, such as `trapezoid`.

    Args:
        entry: Entry as written.
        kind: Kind of library entry.
        folder: Folder that paths are relative to.
        where: Opening words of messages: file and key of the entry.

    Raises:
        ScenarioError: A bare name matches neither a file nor a library entry of this kind.
    """
    path, name = folder / entry, Path(entry)
    if is_file(path) or name.suffix or len(name.parts) != 1:
        return path
    if ours := shelf(kind).get(name.name):
        return ours
    raise ScenarioError(f"{where}{cut(name.name)}: {not_one_of(kind, name.name)}")


def _relative(path: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # on another drive of Windows
        return path.resolve().as_posix()


class OtherFileString(str):
    """A string of a file that another one extends: a path in it is relative to the folder of the file that it is
    written in.

    Attributes:
        folder: Folder of that file.
    """

    __slots__ = ("folder",)
    folder: Path

    @classmethod
    def within(cls, value: Any, folder: Path) -> Any:
        """Return tables, lists or a string with the folder attached to each string that has no folder yet."""
        if isinstance(value, Mapping):
            return {key: cls.within(inner, folder) for key, inner in cast("Mapping[str, Any]", value).items()}
        if isinstance(value, list):
            return [cls.within(inner, folder) for inner in cast("list[Any]", value)]
        if not isinstance(value, str) or isinstance(value, OtherFileString):
            return value
        text = cls(value)
        text.folder = folder
        return text


class NamedFile:
    """A file that a scenario refers to.

    It is not a dataclass, which pydantic would dump as a table.

    Attributes:
        entry: The path as written; results record only this, so that they do not depend on the location of the project.
        path: Path of the file on this machine.
    """

    __slots__ = ("entry", "path")

    def __init__(self, entry: str, path: Path) -> None:
        self.entry, self.path = entry, path

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NamedFile) and (self.entry, self.path) == (other.entry, other.path)

    def __hash__(self) -> int:
        return hash((self.entry, self.path))

    def __repr__(self) -> str:
        return f"NamedFile({self.entry!r}, {self.path!r})"

    def digest(self) -> str:
        """Return the SHA-256 of the content; for a Modelica file, that of all files that its classes may use."""
        return file_digest(self.path)

    @classmethod
    def find(cls, entry: object, info: ValidationInfo) -> "NamedFile":
        """Resolve a string relative to the scenario's folder.

        Raises:
            PydanticCustomError: The entry is not a path, or the file does not exist.
        """
        if isinstance(entry, NamedFile):
            return entry
        if not isinstance(entry, str) or not entry:
            raise PydanticCustomError("file", "is {found}; expected is the path of a file", {"found": short(entry)})
        context = cast("dict[str, Path] | None", info.context) or {}
        directory = context.get(DIRECTORY, Path())
        path = (entry.folder if isinstance(entry, OtherFileString) else directory) / entry
        if not is_file(path):
            is_recipe = path.suffix == ".fmu" and path.parent.parts[-2:] == ("build", "fmus")
            hint = f"; `railgrip build {path.stem}` makes one in build/fmus of the current folder" if is_recipe else ""
            raise PydanticCustomError(
                "file",
                "names '{entry}', but there is no file {path}; a path in a file starts at its folder, one of --set at "
                "the current folder{hint}",
                {"entry": cut(entry), "path": place(path), "hint": hint},
            )
        if isinstance(entry, OtherFileString):
            entry = _relative(path, directory)
        return cls(entry=entry, path=path)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(
            cls.find,
            json_schema_input_schema=core_schema.str_schema(min_length=1),
            serialization=core_schema.plain_serializer_function_ser_schema(lambda file: file.entry, when_used="json"),
        )
