"""Libraries that a class uses: found, in the right version, read as far as necessary, and part of every cache key."""

import math
import os
from pathlib import Path

import pytest
from small_fmus import write_files

from railgrip.base.errors import InputError
from railgrip.fmus import openmodelica
from railgrip.fmus.build import build_class
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.library import LARGEST_WHOLE, UsedClasses, file_digest, scan, used_libraries
from railgrip.fmus.recipe import Recipe


def other(rate: float | str, annotation: str = "") -> str:
    """Return the library that the train uses."""
    model = f"model Rate Real x(start=0, fixed=true); equation der(x) = {rate}; end Rate;"
    return f"package Other {model} {f'annotation({annotation});' if annotation else ''} end Other;"


def rate_library(folder: Path, rate: float, version: str = "") -> None:
    name, annotation = (f"Other {version}", f'version="{version}"') if version else ("Other", "")
    write_files(folder, {f"{name}/package.mo": other(rate, annotation)})


def train(folder: Path, uses: str = "Other") -> Path:
    text = f"package Mine model Train Other.Rate r; output Real y = r.x; end Train; annotation(uses({uses})); end Mine;"
    return write_files(folder, {"Mine/package.mo": text}) / "Mine"


def rate_of(library: Path) -> float:
    return float(lower("Mine.Train", library).derivative(0, [0], [], [])[0])


@pytest.fixture
def shelf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder in MODELICAPATH, which is the only place of libraries."""
    folder = tmp_path / "shelf"
    folder.mkdir()
    monkeypatch.setenv("MODELICAPATH", str(folder))
    monkeypatch.setattr("railgrip.fmus.native.library.folders_of_openmodelica", tuple)
    return folder


def test_a_changed_library_in_modelicapath_is_compiled_again(shelf: Path, tmp_path: Path) -> None:
    mine = train(tmp_path)
    rate_library(shelf, 1)
    first = build_class("Mine.Train", mine, compiler="native")
    before = file_digest(mine / "package.mo")
    assert rate_of(mine) == 1
    assert build_class("Mine.Train", mine, compiler="native").action == "current"
    rate_library(shelf, 7)
    assert build_class("Mine.Train", mine, compiler="native").path != first.path
    assert rate_of(mine) == 7
    assert file_digest(mine / "package.mo") != before


def test_a_library_that_several_libraries_use_is_read_once(shelf: Path, tmp_path: Path) -> None:
    """As ModelicaServices, which the class may use itself, too."""
    services = "package ModelicaServices constant Real k = 6; end ModelicaServices;"
    using = other("ModelicaServices.k", "uses(ModelicaServices)")
    write_files(shelf, {"Other/package.mo": using, "ModelicaServices/package.mo": services})
    assert rate_of(train(tmp_path)) == 6


def test_a_change_of_what_is_not_used_leaves_the_fmu(shelf: Path, tmp_path: Path) -> None:
    mine = train(tmp_path)
    rate_library(shelf, 1)
    before = file_digest(mine / "package.mo")
    write_files(shelf, {"Other/Further.mo": "within Other; model Further end Further;"})
    assert file_digest(mine / "package.mo") == before


def test_another_place_of_the_same_library_gives_the_same_fmu(
    shelf: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = train(tmp_path)
    rate_library(shelf, 3)
    first = build_class("Mine.Train", mine, compiler="native")
    shelf.rename(tmp_path / "moved")
    monkeypatch.setenv("MODELICAPATH", os.pathsep.join([str(tmp_path / "none"), str(tmp_path / "moved")]))
    assert build_class("Mine.Train", mine, compiler="native").path == first.path


def test_a_missing_library_is_refused_with_the_ways_to_name_it(shelf: Path, tmp_path: Path) -> None:
    text = "model Drive Modelica.Mechanics.Rotational.Components.Inertia inertia(J=1); end Drive;"
    file = write_files(tmp_path, {"Drive.mo": text}) / "Drive.mo"
    with pytest.raises(InputError, match=r"Drive\.mo.*Modelica.*not found.*--library.*MODELICAPATH"):
        build_class("Drive", file, compiler="native")
    with pytest.raises(InputError, match=r"Mine.*Other.*not found.*--library.*MODELICAPATH"):
        lower("Mine.Train", train(tmp_path))


def test_a_library_that_is_declared_and_not_used_may_be_missing(shelf: Path, tmp_path: Path) -> None:
    text = (
        'model M Real x(start=0, fixed=true); equation der(x) = 2; annotation(uses(Modelica(version="4.0.0"))); end M;'
    )
    file = write_files(tmp_path, {"M.mo": text}) / "M.mo"
    assert float(lower("M", file).derivative(0, [0], [], [])[0]) == 2


def test_the_version_in_uses_is_chosen(shelf: Path, tmp_path: Path) -> None:
    rate_library(shelf, 1, "1.0.0")
    rate_library(shelf, 2, "2.0.0+maint.om")
    rate_library(shelf, 10, "10.0.0")
    assert rate_of(train(tmp_path, 'Other(version="1.0.0")')) == 1
    assert rate_of(train(tmp_path, 'Other(version="2.0.0")')) == 2
    assert rate_of(train(tmp_path, "Other")) == 10
    with pytest.raises(InputError, match=r"names version 3\.0\.0 of Other; found was 10\.0\.0 in .*--library"):
        rate_of(train(tmp_path, 'Other(version="3.0.0")'))


def test_a_version_is_accepted_that_needs_no_conversion(shelf: Path, tmp_path: Path) -> None:
    # Section 18.8.2 of the specification: noneFromVersion.
    annotation = 'uses(Else(version="9")), conversion(noneFromVersion="1.0.0"), version="1.1.0"'
    write_files(shelf, {"Other/package.mo": other(5, annotation)})
    assert rate_of(train(tmp_path, 'Other(version="1.0.0")')) == 5
    assert rate_of(train(tmp_path, 'Other(version="1.1.0")')) == 5
    with pytest.raises(InputError, match=r"version 9 of Other; found was 1\.1\.0"):
        rate_of(train(tmp_path, 'Other(version="9")'))


def test_openmodelica_loads_the_libraries_that_were_found(shelf: Path, tmp_path: Path) -> None:
    rate_library(shelf, 1, "1.0.0")
    mine = train(tmp_path)
    further = [found.path for found in used_libraries("Mine.Train", mine).libraries.values()]
    text = openmodelica.script(Recipe.of_class("Mine.Train", "cs"), mine, derivatives=False, further=further)
    loaded = [line for line in text.splitlines() if "loadFile" in line]
    assert [Path(line.split('"')[1]).parent.name for line in loaded] == ["RailBraking", "Other 1.0.0", "Mine"]


def test_one_file_libraries_of_several_versions_may_be_in_one_folder(shelf: Path, tmp_path: Path) -> None:
    for version, rate in (("", 1), ("9.8.0", 2), ("9.9.0", 3), ("10.0.0", 4)):
        conversion = 'conversion(noneFromVersion="9.7.0")' if version in ("9.8.0", "9.9.0") else ""
        write_files(shelf, {f"Other {version}".strip() + ".mo": other(rate, conversion)})
    assert rate_of(train(tmp_path, 'Other(version="default")')) == 1
    assert rate_of(train(tmp_path, 'Other(version="9.8.0")')) == 2
    assert rate_of(train(tmp_path, 'Other(version="10.0.0")')) == 4
    assert rate_of(train(tmp_path, 'Other(version="9.7.0")')) == 3


def test_a_library_may_be_in_a_folder_with_any_name(shelf: Path, tmp_path: Path) -> None:
    rate_library(shelf / "größer als", 6, "1.0.0")
    mine = train(tmp_path).rename(tmp_path / "Mine 1.2")
    other = shelf / "größer als" / "Other 1.0.0" / "package.mo"
    fmu = build_class("Mine.Train", [mine / "package.mo", other], compiler="native").path
    assert fmu == build_class("Mine.Train", [other, mine], compiler="native").path
    rate_library(shelf, 5, "2.0.0")
    # A library that is named precedes those that are found.
    assert build_class("Mine.Train", [mine, other], compiler="native").path == fmu


def test_a_file_in_another_encoding_is_refused_only_if_it_is_used(shelf: Path, tmp_path: Path) -> None:
    rate_library(shelf, 9)
    (shelf / "Other" / "Waage.mo").write_bytes('within Other; model Waage "größer" end Waage;'.encode("latin-1"))
    assert rate_of(train(tmp_path)) == 9
    mine = train(tmp_path)
    (mine / "package.mo").write_text(
        (mine / "package.mo").read_text().replace("Real y", "Other.Waage w; output Real y")
    )
    with pytest.raises(InputError, match=r"Waage\.mo:1: the text is not UTF-8"):
        rate_of(mine)


LIBRARY = {
    "Big/package.mo": 'package Big "end Big; model Unused" extends Big.Icons.Package; '
    "constant Real two = 2; // model Unused\n /* model Unused */ "
    "type Slip = Real(min=0); end Big;",
    "Big/Icons.mo": "within Big; package Icons partial package Package end Package; "
    "model Unused end Unused; end Icons;",
    "Big/Parts/package.mo": "within Big; package Parts extends Big.Icons.Package; "
    "model Base replaceable model Law = Gentle; Law law; model Gentle Real gain = 1; end Gentle; end Base;"
    "model Strong extends Base.Gentle(gain = 3); end Strong; model Unused end Unused; end Parts;",
    "Big/Parts/Body.mo": "within Big.Parts; model Body import Big.Functions.*; import F = Big.Functions.half; "
    "import Big.Functions.{triple}; extends Base(redeclare model Law = Strong); Slip s(start=0, fixed=true); "
    "Real v[2] = {1, 2}; equation der(s) = if noEvent(s > 1e3) then v[end] else triple(F(square(two)))*law.gain; "
    "end Body;",
    "Big/Functions/package.mo": "within Big; package Functions "
    "function half input Real u; output Real y; algorithm y := u/2; end half; "
    "function square input Real u; output Real y; algorithm for i in 1:1 loop y := u*u; end for; end square; "
    "function Unused input Real u; output Real y; algorithm y := u; end Unused; end Functions;",
    "Big/Functions/triple.mo": "within Big.Functions; function triple extends Scaled; algorithm y := 3*u; end triple;",
    "Big/Functions/Scaled.mo": "within Big.Functions; partial function Scaled input Real u; output Real y; end Scaled;",
    "Big/Unused/package.mo": "within Big; package Unused model Wrong Missing missing; end Wrong; end Unused;",
    "Big/Size.mo": "within Big; package Size end Size; // " + "-" * LARGEST_WHOLE,
}


def test_classes_are_found_in_every_way_of_the_language(shelf: Path, tmp_path: Path) -> None:
    library = write_files(tmp_path, LIBRARY) / "Big"
    part = read("Big.Parts.Body", library)
    texts = used_libraries("Big.Parts.Body", library).texts
    assert not any("Unused" in name or "model Unused end" in text for name, text in texts.items())
    # triple(half(square(2))) * 3 by hand.
    assert float(lower("Big.Parts.Body", library).derivative(0, [0], [], [])[0]) == 3 * (2 * 2 / 2) * 3
    for unread in ("Unused/package.mo", "Size.mo"):
        (library / unread).unlink()
    whole = read("Big.Parts.Body", library)
    assert [v["name"] for v in part.variables] == [v["name"] for v in whole.variables]


def test_a_text_that_is_cut_keeps_its_lines(shelf: Path, tmp_path: Path) -> None:
    text = "package P\n  model A\n    Real x;\n  end A;\n  model B\n  end B;\nend P;\n"
    file = write_files(tmp_path, {"P.mo": text}) / "P.mo"
    used = UsedClasses()
    used.offer("P", lambda: file)
    used.use(["P", "B"])
    (kept,) = used.texts().values()
    assert kept.splitlines()[4:] == text.splitlines()[4:]
    assert "Real x" not in kept


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("operator record C operator 'constructor' function f end f; end 'constructor'; end C;", ["C"]),
        ("model A extends B; end A; model extends M(x=1) end M;", ["A", "M"]),
        ('type E = enumeration(end_, model_) "doc; end"; type T = Real;', ["E", "T"]),
        ("replaceable model R end R constrainedby S(x = {1, 2}); pure function g end g;", ["R", "g"]),
        ("model 'a b' Real 'end'; equation if true then 'end' = 1e3; end if; end 'a b';", ["'a b'"]),
        ("model W equation when {initial(), time > 1} then x[end] = 1; end when; end W; block V end V;", ["W", "V"]),
    ],
)
def test_the_classes_of_a_file_are_told_apart(tmp_path: Path, text: str, names: list[str]) -> None:
    file = write_files(tmp_path, {"F.mo": f"package F {text} end F;"}) / "F.mo"
    (package,) = scan(file).root.children
    assert [child.name for child in package.children] == names
    assert all(child.end > child.start for child in package.children)


def test_functions_with_language_builtin_are_those_of_the_language(shelf: Path, tmp_path: Path) -> None:
    functions = "".join(
        f'function {name} input Real u; output Real y; external "builtin" y = {name}(u); end {name}; '
        for name in ("sin", "exp", "log")
    )
    functions += (
        'function atan2 input Real a; input Real b; output Real y; external "builtin" y = atan2(a, b); end atan2;'
    )
    functions += 'function swapped input Real a; input Real b; output Real y; external "builtin" y = atan2(b, a); '
    write_files(shelf, {"Maths/package.mo": f"package Maths {functions} end swapped; end Maths;"})
    text = "model M Real x(start=0.5, fixed=true); equation der(x) = {}; end M;"
    formula = "Maths.sin(x) + Maths.exp(x)*Maths.log(x) + Maths.atan2(x, 3)"
    file = write_files(tmp_path, {"M.mo": text.format(formula)}) / "M.mo"
    exact = math.sin(0.5) + math.exp(0.5) * math.log(0.5) + math.atan2(0.5, 3)
    assert float(lower("M", file).derivative(0, [0.5], [], [])[0]) == pytest.approx(exact, rel=1e-15)
    # The external call decides about the order of arguments.
    file.write_text(text.format("Maths.swapped(x, 3)"))
    assert float(lower("M", file).derivative(0, [0.5], [], [])[0]) == pytest.approx(math.atan2(3, 0.5), rel=1e-15)
