"""Any malformed part of an FMU's archive or modelDescription.xml is reported in a sentence that names the file."""

import os
import re
import zipfile
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tiny_fmu import tiny, xml, zipped
from wrong import table, words

from railgrip.base.errors import FmuError, RailgripError
from railgrip.fmi import Description, Port, bind, describe
from railgrip.fmi.draft import draft_mapping
from railgrip.fmi.instance import assignments

FUZZ = int(os.environ.get("RAILGRIP_FUZZ", "30"))
TEXT = xml(state_unit="km/h", input_unit="bar", output_unit="degC", indicators=1)
ATTRIBUTES = list(re.finditer(r' ([\w:]+)="([^"]*)"', TEXT))
ELEMENTS = list(re.finditer(r"<(\w+)[^<>]*/>|<(\w+)[^>]*>(?:(?!<\2).)*?</\2>", TEXT, re.DOTALL))
ODD = [
    "", "abc", "-1", "99999999999999", "4294967296", "1e400", "nan", "NaN", "inf", "INF", "0", "true", "1 2", "9.9",
    "&#160;", "１", "²", "x" * 5000, "&#10;", "1_000", "0x10", "2.0", "../../x", "Integer", "&#x10FFFF;",
]  # fmt: skip


@pytest.fixture(scope="module")
def members(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    with zipfile.ZipFile(tiny(tmp_path_factory.mktemp("well"))) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("malformed") / "bad.fmu"


def packed(members: dict[str, bytes], description: str, file: Path) -> Path:
    return zipped(file, members | {"modelDescription.xml": description.encode()})


def use(file: Path) -> Description:
    """Do everything with an FMU that precedes running its code."""
    description = describe(file)
    signals = {name: Port(name=name, unit=unit, size=0, needed=True) for name, unit in UNITS.items()}
    bind(description, inputs=[signals["u"]], outputs=[signals["x"], signals["y"]])
    assignments(description, {"rate": 5.0, "label": "x", "allowed": 3})
    draft_mapping(description, {"u": (signals["u"], "input"), "x": (signals["x"], "output")})
    return description


def outcome(file: Path) -> str:
    """Return whether an FMU was used or refused; any other exception is raised."""
    try:
        use(file)
    except RailgripError as refusal:
        return "refused" if file.name in str(refusal) else str(refusal)
    return "used"


UNITS = {"u": "Pa", "x": "m/s", "y": "K"}


def test_the_unmutated_description_is_accepted(members: dict[str, bytes], place: Path):
    assert use(packed(members, TEXT, place)).variables["y"].reference == 5
    assert len(ATTRIBUTES) > 80


def mutations():
    replaced = st.tuples(st.sampled_from(ATTRIBUTES), st.sampled_from(ODD) | st.from_regex(r"\A[!#-%'-;=?-~]{0,8}\Z"))
    attribute = replaced.map(lambda c: (c[0].start(), c[0].end(), f' {c[0][1]}="{c[1]}"'))
    absent = st.sampled_from(ATTRIBUTES).map(lambda m: (m.start(), m.end(), ""))
    element = st.sampled_from(ELEMENTS).flatmap(
        lambda m: st.sampled_from(["", m[0] * 2, "<Vendor/>", m[0].replace("<", "<x", 1)]).map(
            lambda text: (m.start(), m.end(), text)
        )
    )
    return attribute | absent | element


def mutated(changes: list[tuple[int, int, str]]) -> str:
    text, end = TEXT, len(TEXT)
    for first, last, new in sorted(changes, reverse=True):
        if last <= end:
            text, end = text[:first] + new + text[last:], first
    return text


@settings(max_examples=FUZZ, deadline=None)
@given(changes=st.lists(mutations(), min_size=1, max_size=3))
@example(changes=[(TEXT.index("UTF-8"), TEXT.index("UTF-8") + 5, "nonsense")])
def test_a_mutated_description_is_used_or_refused_in_a_sentence(
    members: dict[str, bytes], place: Path, changes: list[tuple[int, int, str]]
):
    assert outcome(packed(members, mutated(changes), place)) in ("used", "refused")


DEEP = ["more than 64 elements inside each other", "<ModelVariables>", "<VendorAnnotations>" + "<a>" * 100_000]


@pytest.mark.parametrize(("sentence", "old", "new"), [*table(__file__, "wrong_descriptions.toml")["rows"], DEEP])
def test_the_sentence_names_the_fault(members: dict[str, bytes], place: Path, sentence: str, old: str, new: str):
    assert old in TEXT
    with pytest.raises(FmuError, match=words(sentence)):
        use(packed(members, TEXT.replace(old, new, 1), place))


def test_the_need_for_the_exporting_tool_is_reported(members: dict[str, bytes], place: Path):
    text = TEXT.replace("<CoSimulation ", '<CoSimulation needsExecutionTool="true" ')
    assert (
        "needs the tool that made it on this machine (needsExecutionTool)"
        in use(packed(members, text, place)).blemishes
    )


@settings(max_examples=FUZZ, deadline=None)
@given(st.integers(0), st.binary(min_size=1, max_size=4), st.booleans())
def test_a_damaged_archive_is_reported(members: dict[str, bytes], place: Path, where: int, damage: bytes, cut: bool):
    with zipfile.ZipFile(place, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    content = place.read_bytes()
    where %= len(content)
    place.write_bytes(content[:where] + damage + (b"" if cut else content[where + len(damage) :]))
    assert outcome(place) in ("used", "refused")
