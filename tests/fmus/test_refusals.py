"""Constructs that the built-in compiler does not translate are refused with file and line, never ignored."""

import re

import pytest
from corpus.case import paragraphs
from small_fmus import write_files

from railgrip.base.errors import InputError, TranslationError
from railgrip.fmus.build import build_class
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.library import modelica_files

REFUSED = [(*comment.split(";", 1), text) for comment, text in paragraphs("refusals.mo")]


@pytest.mark.parametrize(("message", "word", "text"), REFUSED)
def test_an_unsupported_construct_is_refused_with_its_line_and_the_command_for_openmodelica(
    tmp_path, message, word, text, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    file, name = tmp_path / "Model.mo", "P.M" if "package P" in text else "M"
    file.write_text(text)
    with pytest.raises(InputError, match=message.removeprefix("illegal: ")) as refusal:
        build_class(name, file, compiler="native")
    assert not re.search("railgrip-|semantic owner", str(refusal.value)), (
        "a temporary folder, or words of the front end"
    )
    way_out = (
        rf"may be valid Modelica.*\n  railgrip build --compiler openmodelica --library Model.mo {name}\n.*install.md"
    )
    assert bool(re.search(way_out, str(refusal.value))) == (not message.startswith("illegal: "))
    lines = [text.splitlines()[int(line) - 1] for line in re.findall(r"Model\.mo:(\d+):[ \d]", str(refusal.value))]
    assert lines or not word
    assert all(word.strip() in line for line in lines)


def test_a_missing_file_or_class_is_reported(tmp_path, written):
    with pytest.raises(InputError, match=r"no Modelica file .*Nowhere\.mo"):
        lower("M", tmp_path / "Nowhere.mo")
    file = written("model M end M;")
    with pytest.raises(InputError, match="Other does not compile"):
        lower("Other", file)


def test_a_class_with_events_is_not_a_plain_differential_equation(written):
    file = written("model M Real x(start=1,fixed=true); equation der(x) = if x > 0.5 then -1 else -x; end M;")
    with pytest.raises(TranslationError, match="noEvent"):
        lower("M", file)


LIBRARY = {
    "package.mo": "package Lib\nend Lib;\n",
    "B.mo": "within Lib;\nmodel B\n  Real x(start=1, fixed=true);\nequation\n  der(x) = -x;\nend B;\n",
    "S/package.mo": "within Lib;\npackage S\nend S;\n",
    "S/C.mo": "within Lib.S;\nmodel C\n  extends Lib.B;\nend C;\n",
}


ACCEPTED_FILES = {
    "carriage returns": {name: text.replace("\n", "\r\n") for name, text in LIBRARY.items()},
    "byte order marks": {name: f"\ufeff{text}" for name, text in LIBRARY.items()},
    "comments before within": {"B.mo": f"// within X;\n/* within Y; */\n{LIBRARY['B.mo']}"},
    "an empty within": {"package.mo": f"within ;\n{LIBRARY['package.mo']}"},
    "an operator record": {
        "N.mo": "within Lib;\noperator record N\n  Real re;\n  encapsulated operator function '0'\n"
        "    import Lib.N;\n    output N z(re=0);\n  algorithm\n  end '0';\nend N;\n"
    },
}
REFUSED_FILES = {
    # The front end names the component; for a library of many files it does not give the position.
    "a syntax error": ({"B.mo": LIBRARY["B.mo"].replace("-x;", "-x")}, r"Lib/B\.mo:6: unexpected `end`"),
    "an unknown component": ({"B.mo": LIBRARY["B.mo"].replace("-x;", "-h*x;")}, r"Lib/B\.mo:5: der\(x\) = -h\*x;"),
    "an unknown class": (
        {"B.mo": LIBRARY["B.mo"].replace("Real", "Rael")}, r"Lib/B\.mo:3: Rael x\(start=1, fixed=true\);"
    ),
    "a construct": (
        {"B.mo": LIBRARY["B.mo"].replace("equation", "  input Integer k; Integer n =\n pre(k);\nequation")},
        r"Lib/B\.mo:5: Lib\.S\.C: pre of an",
    ),
    "Latin-1": (
        {"B.mo": LIBRARY["B.mo"].replace("B\n", 'B "Räder"\n', 1).encode("latin-1")},
        r"B\.mo:2: the text is not UTF-8; save the file as UTF-8",
    ),
    "UTF-16": ({"B.mo": LIBRARY["B.mo"].encode("utf-16")}, r"B\.mo:1: the text is not UTF-8"),
    "another within": (
        {"B.mo": LIBRARY["B.mo"].replace("Lib", "Other")},
        r"B\.mo:1: the file has `within Other;`, but its folder requires `within Lib;`",
    ),
    "no within": ({"B.mo": LIBRARY["B.mo"].replace("within Lib;", "")}, r"B\.mo:1: the file has no `within`"),
    "the within of another folder": (
        {"S/C.mo": LIBRARY["S/C.mo"].replace("within Lib.S", "within Lib")}, r"C\.mo:1: .* requires `within Lib\.S;`"
    ),
    "a within above the library": (
        {"package.mo": f"within Above;\n{LIBRARY['package.mo']}"}, r"package\.mo:1: .*`within Above;`"
    ),
    "a class of another name": (
        {"B.mo": LIBRARY["B.mo"].replace("model B", "model D").replace("end B", "end D")},
        r"B\.mo:2: the file declares D, but its name requires B",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ACCEPTED_FILES)
def test_a_library_with_unusual_text_files_is_translated(tmp_path, name):
    library = write_files(tmp_path / "Lib", LIBRARY | ACCEPTED_FILES[name])
    assert [v.name for v in lower("Lib.S.C", library).states] == ["x"]


@pytest.mark.parametrize("name", REFUSED_FILES)
def test_a_wrong_file_of_a_library_is_refused_with_its_line(tmp_path, name):
    changed, sentence = REFUSED_FILES[name]
    with pytest.raises(InputError, match=sentence):
        lower("Lib.S.C", write_files(tmp_path / "Lib", LIBRARY | changed))


@pytest.mark.parametrize(
    "name", [".#B.mo", "S/Gone.mo", "._B.mo", ".B.mo", ".git/B.mo", "Resources/Text.mo", "Up", "Empty.mo/a"]
)
def test_files_and_links_that_are_no_classes_are_ignored(tmp_path, name):
    """Locks and copies of editors, archives and version control; folders without `package.mo`."""
    loop = "output Real y[2]; equation for k in {1, 2} loop y[k] = k; end for;"  # which is rewritten
    library = write_files(tmp_path / "Lib", LIBRARY | {"B.mo": LIBRARY["B.mo"].replace("equation", loop)})
    other = library / name
    other.parent.mkdir(exist_ok=True)
    if name.endswith(("#B.mo", "Gone.mo")):
        other.symlink_to("user@host.123:456")
    elif name == "Up":
        other.symlink_to("..")
    else:
        other.write_text("within Elsewhere; model T")
    assert [v.name for v in lower("Lib.S.C", library).states] == ["x"]
    assert other not in modelica_files(library)


@pytest.mark.parametrize("link", ["Self", "S/Up", "S/T"])
@pytest.mark.parametrize("is_other", [False, True])
def test_a_link_to_a_folder_around_it_is_refused(tmp_path, written, link, is_other):
    """In the library of the class, and in one that it uses."""
    library = write_files(tmp_path / "Lib", LIBRARY)
    (library / link).symlink_to({"Self": ".", "S/Up": "..", "S/T": "../S"}[link])
    file = written("model M extends Lib.S.C; Lib.S.T.C a; Lib.Self.B b; Lib.S.Up.B c; end M;")
    with pytest.raises(InputError, match=rf"Lib/{link}: the library contains the folder .* twice; remove the link"):
        read("M" if is_other else "Lib.S.C", file if is_other else library, others=[library] if is_other else ())


def test_a_single_file_with_within_names_its_class(written):
    file = written(LIBRARY["B.mo"], "B.mo")
    assert [v.name for v in lower("Lib.B", file).states] == ["x"]
    with pytest.raises(InputError, match=r"B\.mo:1: the file has `within Lib;`, so its class is Lib\.B"):
        lower("B", file)
