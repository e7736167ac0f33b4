"""An archive beyond the limits is refused before it is unpacked, and its description before it is parsed."""

import stat
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tiny_fmu import repacked, tied, tiny, xml, zipped
from wrong import table

from railgrip.base.errors import FmuError
from railgrip.base.limits import FmuLimits
from railgrip.fmi import CoSimulation, describe

MIB = 1 << 20


def with_more(foundry: Path, folder: Path, *entries: tuple[str | zipfile.ZipInfo, bytes]) -> Path:
    """Return the well-behaved FMU with additional entries in its archive."""
    file = folder / "more.fmu"
    file.write_bytes(tiny(foundry).read_bytes())
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries:
            archive.writestr(name, content, zipfile.ZIP_DEFLATED)
    return file


@pytest.mark.parametrize(("limits", "sentence"), table(__file__, "tables.toml")["limits"])
def test_each_limit_is_reported_in_a_sentence_that_names_it(
    foundry: Path, tmp_path: Path, limits: dict[str, int], sentence: str
):
    file = with_more(foundry, tmp_path, ("resources/zeros", b"\0" * 20 * MIB))
    describe(file, FmuLimits(ratio=1000))
    with pytest.raises(FmuError) as error:
        describe(file, FmuLimits(**{"ratio": 1000} | limits))
    assert str(error.value).startswith(f"{file}: ")
    assert sentence in str(error.value)


@pytest.mark.skipif(sys.platform != "linux", reason="the largest size is read from /proc")
def test_a_description_beyond_its_limit_is_refused(tmp_path: Path):
    file = tmp_path / "large.fmu"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("modelDescription.xml", b" " * (33 * MIB))
    with pytest.raises(FmuError, match=r"modelDescription\.xml has 33 MiB, allowed are 32; raise description_mib"):
        describe(file)


def test_a_description_of_two_gibibytes_takes_no_memory(tmp_path: Path):
    file = tmp_path / "bomb.fmu"
    with (
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("modelDescription.xml", "w", force_zip64=True) as stream,
    ):
        for _ in range(2048):
            stream.write(b" " * MIB)
    code = (
        "import sys; from pathlib import Path; from railgrip.base.errors import FmuError\n"
        "from railgrip.fmi import describe\n"
        # `ru_maxrss` of a new process is that of its parent, here of all tests.
        "largest = lambda: int(Path('/proc/self/status').read_text().partition('VmHWM:')[2].split()[0])\n"
        "before = largest()\n"
        "try: describe(Path(sys.argv[1]))\n"
        "except FmuError as error: print(error)\n"
        "print(largest() - before)\n"
    )
    result = subprocess.run([sys.executable, "-c", code, str(file)], capture_output=True, text=True, check=False)
    sentence, more = result.stdout.splitlines()
    assert "modelDescription.xml has 2048 MiB, allowed are 32; raise description_mib" in sentence
    assert int(more) < 50_000, "KiB"


def test_overlapping_entries_are_counted_separately(foundry: Path, tmp_path: Path):
    """A small archive whose directory names the same megabytes a thousand times."""
    file = with_more(foundry, tmp_path, ("resources/zeros", b"\0" * 15 * MIB))
    with zipfile.ZipFile(file, "a") as archive:
        (original,) = (entry for entry in archive.infolist() if entry.filename == "resources/zeros")
        for number in range(1000):
            twin = zipfile.ZipInfo(f"resources/z{number}")
            for name in ("compress_type", "CRC", "compress_size", "file_size", "header_offset", "flag_bits"):
                setattr(twin, name, getattr(original, name))
            archive.filelist.append(twin)
            archive.NameToInfo[twin.filename] = twin
        archive._didModify = True
    with pytest.raises(FmuError, match=r"the archive unpacks to 1\d{4} MiB, allowed are 2048"):
        describe(file)


LINK = zipfile.ZipInfo("resources/link")
LINK.external_attr = (stat.S_IFLNK | 0o777) << 16


def renamed(rename: Callable[[str], str]) -> Callable[[Path, Path], Path]:
    """Return a function that writes the well-behaved FMU with other paths in its archive."""
    return lambda foundry, folder: repacked(
        tiny(foundry), folder / "again.fmu", lambda name, content: (rename(name), content)
    )


def test_paths_that_begin_with_the_present_folder_are_accepted(foundry: Path, tmp_path: Path):
    """A zip of '.' has './modelDescription.xml'; the train steps as in its usual archive."""
    description = describe(renamed(lambda name: f"./{name}")(foundry, tmp_path))
    with CoSimulation(description, tied(description), period=0.1, parameters={}) as plant:
        plant.start(np.zeros(1))
        assert plant.step(np.zeros(1))[0] == pytest.approx(np.exp(-0.2), rel=1e-12)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_folder_may_occur_twice_and_a_file_may_not_under_two_spellings(foundry: Path, tmp_path: Path):
    describe(with_more(foundry, tmp_path, ("extra/", b""), ("extra/note.txt", b"1"), ("extra/", b"")))
    with pytest.raises(FmuError, match=r"has 'extra/note\.txt' twice"):
        describe(with_more(foundry, tmp_path, ("extra/note.txt", b"1"), ("./extra/note.txt", b"2")))


@pytest.mark.parametrize(
    "change",
    [
        ('modelName="Tiny"', 'modelName="Tiny" colour="blue"'),
        ('Real start="2" min="0.1" max="10"', 'Real min="0.1" max="10"'),
        ('<LogCategories>', '<VendorNotes/><LogCategories>'),
        ('unit="km/h"', 'unit="furlong"'),
    ],
    ids=["attribute", "no start", "element", "unit"],
)  # fmt: skip
def test_a_harmless_defect_is_reported_and_the_fmu_runs(foundry: Path, change: tuple[str, str]):
    """FMPy refuses these when it validates, and runs them when it does not."""
    description = describe(tiny(foundry, description=xml(state_unit="km/h").replace(*change)))
    assert description.blemishes.startswith("modelDescription.xml is not valid FMI 2.0: ")
    plain = describe(tiny(foundry, description=xml(state_unit="km/h")))
    assert plain.blemishes == ""
    assert [*description.variables] == [*plain.variables]
    assert description.states == plain.states


def with_a_wrong_bit(foundry: Path, folder: Path) -> Path:
    content = bytearray(tiny(foundry).read_bytes())
    content[content.index(b"fmiModelDescription")] ^= 0xFF  # stored uncompressed by the fixture
    (folder / "damaged.fmu").write_bytes(content)
    return folder / "damaged.fmu"


BOMB = b'<!DOCTYPE s [<!ENTITY a "lol"><!ENTITY b "' + 100 * b"&a;" + b'">]><s>' + 100 * b"&b;" + b"</s>"
OUTSIDE = b'<!DOCTYPE s [<!ENTITY a SYSTEM "file:///etc/passwd">]><s>&a;</s>'
TWICE = b'<s><Connector name="v" kind="output"/><Connector name="v" kind="input"/></s>'
SYSTEMS = [
    *({"SystemStructure.ssd": text} for text in (b"", b"<ssd:System", BOMB, OUTSIDE, TWICE, b"\xff\xfe")),
    *({name: b"<s/>"} for name in ("systemstructure.SSD", "System/SystemStructure.ssd", "Winter.ssd")),
    *(
        {"SystemStructure.ssd": b"<s/>", name: b"?"}
        for name in ("modelDescription.xml", "resources/inner.ssp", "a.ssv")
    ),
]


def packed(entries: dict[str, str | bytes]) -> Callable[[Path, Path], Path]:
    return lambda _, folder: zipped(folder / "system.fmu", entries)


def more(name: str | zipfile.ZipInfo, content: bytes = b"") -> Callable[[Path, Path], Path]:
    return lambda foundry, folder: with_more(foundry, folder, (name, content))


DESCRIPTION = "modelDescription.xml"


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        *((packed(entries), r"is a system by SSP; .* name the FMU that you need in") for entries in SYSTEMS),
        (packed({"SystemStructure.ssd": b"", "../evil": b""}), "'../evil' of the archive would be unpacked outside"),
        *((more(name), r"more\.fmu: entry '.*evil' of the archive would be unpacked outside")
          for name in ("../evil", "resources/../../evil", "/etc/evil", "C:/evil", "resources\\..\\evil")),
        (more(LINK, b"/etc/passwd"), r"entry 'resources/link' of the archive is a link or device"),
        (more(DESCRIPTION, xml().encode()), r"the archive has 'modelDescription\.xml' twice"),
        (packed({"readme.txt": "hello"}), r"not an FMU: the archive has no modelDescription\.xml"),
        (packed({DESCRIPTION: "<fmiModel"}), r"modelDescription\.xml is not XML"),
        (packed({DESCRIPTION: xml(version="1.0")}), r"this is FMI 1\.0; export it again"),
        (packed({DESCRIPTION: xml(version="3.0")}), r"not valid FMI 3\.0: "),
        (packed({DESCRIPTION: xml().replace('name="gain"', 'name="rate"')}), r"not valid FMI 2\.0: "),
        *((packed({DESCRIPTION: xml(), **others}), "it has no binaries at all")
          for others in ({"sources/tiny.c": ""}, {"binaries/": "", "binaries/linux32/": ""})),
        (lambda _, folder: folder / "absent.fmu", r"absent\.fmu: there is no such file; correct the path, or build it"),
        (lambda *_: Path(__file__), r"test_fmu_archive\.py: not an FMU: it is not a zip archive"),
        (with_a_wrong_bit, r"damaged\.fmu: the archive is damaged, 'modelDescription\.xml'"),
        (renamed(lambda name: name.replace("/tiny.", "/Tiny.")), r"/tiny\.\w+ is missing; .*/Tiny\.\w+\. .* same case"),
        (renamed(lambda name: name.replace("/", "\\")), r"'binaries\\.*' of the archive has a backslash, .* '/'"),
        (renamed(lambda name: f"Train/{name}"), r"is in the folder 'Train' of the archive; pack the content"),
        (lambda foundry, _: tiny(foundry, platform="win32"), r"no binary for this platform, .* has binaries for win32"),
    ],
)  # fmt: skip
def test_a_wrong_archive_is_refused_with_the_remedy(foundry: Path, tmp_path: Path, make, sentence: str):
    with pytest.raises(FmuError, match=sentence):
        describe(make(foundry, tmp_path))
