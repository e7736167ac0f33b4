"""Check the zip archive of an FMU before anything in it is unpacked or parsed.

The declared sizes can be trusted: Python's zipfile never returns more bytes than an archive declares.
"""

import hashlib
import shutil
import stat
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from xml.parsers import expat

from railgrip.base.errors import FmuError
from railgrip.base.limits import MIB, FmuLimits

DESCRIPTION = "modelDescription.xml"
_HARMLESS = 16 * MIB
"""Size in bytes below which the compression ratio is not checked."""
_DEPTH = 64
"""Maximum depth of nested elements; FMI itself needs six, annotations of tools may be deeper."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outline:
    """Result of a first pass over modelDescription.xml.

    Attributes:
        version: FMI version in the file, or None.
        tool: Generation tool in the file, or ''.
        step: Suggested communication step [s], as written, or ''.
        variables: Number of variables.
        references: Value references of all variables, as written.
        relative: Names of Real variables that are differences; FMPy does not see that attribute.
        indices: Variables that ModelStructure references, with the line; by number, in FMI 3.0 by value reference.
    """

    version: str | None
    tool: str
    step: str
    variables: int
    references: frozenset[str]
    relative: frozenset[str]
    indices: tuple[tuple[str, int], ...]


def digest(path: Path) -> str:
    """Return the SHA-256 of a file, hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def members(path: Path, limits: FmuLimits) -> frozenset[str]:
    """Return the names of all files in an archive after checking it.

    Raises:
        FmuError: The file is not an archive, is damaged, exceeds a limit, or has an entry with an unsafe path.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            _require_harmless(path, entries, limits)
            corrupt = archive.testzip()
    except zlib.error as error:
        raise FmuError(f"{path}: the archive is damaged ({error}); copy or export the FMU again.") from error
    except (zipfile.BadZipFile, OSError, EOFError, NotImplementedError, RuntimeError) as error:
        raise FmuError(f"{path}: not an FMU: it is not a zip archive ({error}).") from error
    if corrupt is not None:
        raise FmuError(f"{path}: the archive is damaged, '{corrupt}' does not match its checksum.")
    names = frozenset(_plain(entry) for entry in entries if not entry.is_dir())
    # SystemStructure.ssd or a variant of it; those in folders of an FMU are its resources.
    if any(name.lower().endswith(".ssd") for name in names if DESCRIPTION not in names or "/" not in name):
        raise FmuError(
            f"{path}: is a system by SSP; railgrip exports such systems but does not import them. Unpack it and name "
            "the FMU that you need in its folder resources."
        )
    if DESCRIPTION not in names:
        inside = sorted(name for name in names if PurePosixPath(name).name == DESCRIPTION)
        raise FmuError(
            f"{path}: not an FMU: {DESCRIPTION} is in the folder '{PurePosixPath(inside[0]).parent}' of the archive; "
            "pack the content of that folder, not the folder itself."
            if inside
            else f"{path}: not an FMU: the archive has no {DESCRIPTION}."
        )
    return names


def _plain(entry: zipfile.ZipInfo) -> str:
    """Return the path of an entry; some tools begin all paths with './'."""
    return entry.filename.removeprefix("./")


def read_description(path: Path) -> bytes:
    """Return modelDescription.xml of an archive that `members` accepts."""
    with zipfile.ZipFile(path) as archive:
        return archive.read(_entry_of_description(archive))


def read_sources(path: Path) -> dict[str, str]:
    """Return the C files in the folder `sources` of an archive, file name → text."""
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if name.startswith("sources/") and name.endswith((".c", ".h"))]
        return {name.removeprefix("sources/"): archive.read(name).decode() for name in names}


def _entry_of_description(archive: zipfile.ZipFile) -> zipfile.ZipInfo:
    return next((e for e in archive.infolist() if _plain(e) == DESCRIPTION), None) or archive.getinfo(DESCRIPTION)


def extract(path: Path, folder: Path, include: Callable[[str], bool]) -> None:
    """Unpack the files of an archive that `members` accepts whose paths are included."""
    with zipfile.ZipFile(path) as archive:
        for entry in archive.infolist():
            name = _plain(entry)
            if entry.is_dir() or not include(name):
                continue
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(entry) as source, target.open("wb") as copy:
                shutil.copyfileobj(source, copy)


def _require_harmless(path: Path, entries: list[zipfile.ZipInfo], limits: FmuLimits) -> None:
    if len(entries) > limits.files:
        raise _beyond(path, f"the archive has {len(entries)} entries", limits, "files")
    names: set[str] = set()
    for entry in entries:
        name = entry.orig_filename
        portable = name.replace("\\", "/")
        if ":" in name or portable.startswith("/") or ".." in PurePosixPath(portable).parts:
            raise FmuError(f"{path}: entry '{name}' of the archive would be unpacked outside its folder.")
        if portable != name:
            raise FmuError(
                f"{path}: entry '{name}' of the archive has a backslash, and a zip archive separates folders by '/'; "
                "pack the FMU again with a tool that writes '/'."
            )
        if stat.S_IFMT(entry.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise FmuError(f"{path}: entry '{name}' of the archive is a link or device; pack the file itself.")
        if _plain(entry) in names:
            raise FmuError(f"{path}: the archive has '{_plain(entry)}' twice.")
        if not entry.is_dir():  # a folder that occurs twice is the same folder
            names.add(_plain(entry))
        if _plain(entry) == DESCRIPTION and entry.file_size > limits.description_mib * MIB:
            raise _beyond(path, f"{DESCRIPTION} has {_mib(entry.file_size)}", limits, "description_mib")
        if entry.file_size > limits.member_mib * MIB:
            raise _beyond(path, f"'{entry.filename}' unpacks to {_mib(entry.file_size)}", limits, "member_mib")
    total = sum(entry.file_size for entry in entries)
    if total > limits.unpacked_mib * MIB:
        raise _beyond(path, f"the archive unpacks to {_mib(total)}", limits, "unpacked_mib")
    size = path.stat().st_size
    if total > _HARMLESS and total > limits.ratio * size:
        raise _beyond(path, f"the archive unpacks to {total / size:.0f} times its size", limits, "ratio")


def outline(path: Path, limits: FmuLimits) -> Outline:
    """Parse modelDescription.xml as a stream, before a tree of it is built.

    Raises:
        FmuError: The file is not XML, has a document type, or exceeds a limit of variables or depth.
    """
    head: dict[str, str] = {}
    step = ""
    relative: set[str] = set()
    indices: list[tuple[str, int]] = []
    references: set[str] = set()
    depth = variables = 0
    section = variable = ""
    parser = expat.ParserCreate()

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth, step, variables, section, variable
        depth += 1
        if depth == 1:
            head.update(attributes)
        if name == "DefaultExperiment":
            step = attributes.get("stepSize", "")
        if depth > _DEPTH:
            raise FmuError(f"{path}: {DESCRIPTION} has more than {_DEPTH} elements inside each other.")
        if depth == 2:
            section = name
        if name == "ScalarVariable" or (depth == 3 and section == "ModelVariables"):
            variables, variable = variables + 1, attributes.get("name", "")
            references.add(attributes.get("valueReference", ""))
            if variables > limits.variables:
                raise _beyond(path, f"{DESCRIPTION} has more than {limits.variables} variables", limits, "variables")
        if name in ("Real", "Float32", "Float64") and attributes.get("relativeQuantity") in ("true", "1"):
            relative.add(variable)
        if name == "Unknown" or (depth == 3 and section == "ModelStructure" and "valueReference" in attributes):
            first = attributes.get("valueReference" if name != "Unknown" else "index", "")
            numbers = (first, *attributes.get("dependencies", "").split())
            indices.extend((number, parser.CurrentLineNumber) for number in numbers)

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = lambda *_: _refuse_document_type(path)
    try:
        with zipfile.ZipFile(path) as archive, archive.open(_entry_of_description(archive)) as stream:
            while piece := stream.read(1 << 16):
                parser.Parse(piece, False)
            parser.Parse(b"", True)
    except (expat.ExpatError, LookupError) as error:  # LookupError: the XML names an unknown encoding
        raise FmuError(f"{path}: {DESCRIPTION} is not XML: {error}.") from error
    return Outline(
        version=head.get("fmiVersion"),
        tool=head.get("generationTool", ""),
        step=step,
        variables=variables,
        references=frozenset(references),
        relative=frozenset(relative),
        indices=tuple(indices),
    )


def _refuse_document_type(path: Path) -> None:
    raise FmuError(f"{path}: {DESCRIPTION} has a document type, which FMI does not; remove it.")


def _mib(size: int) -> str:
    return f"{size / MIB:.0f} MiB"


def _beyond(path: Path, excess: str, limits: FmuLimits, key: str) -> FmuError:
    return FmuError(
        f"{path}: {excess}, allowed are {getattr(limits, key)}; raise {key} under [limits.fmu] if you trust it."
    )
