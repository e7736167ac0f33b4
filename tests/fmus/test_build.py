"""From recipe to FMU: reproducible, only when necessary, and with a sentence when it is impossible."""

import shutil
import sys
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import command_line
import pytest
from small_fmus import FEATURES

from railgrip.base.errors import CompilerMissing, InputError, TranslationError
from railgrip.fmus import build as building
from railgrip.fmus.build import build_one, choose
from railgrip.fmus.recipe import differences, read_lock, read_recipes, write_lock

ROOT = Path(building.__file__).parents[1]
RECIPE = """
[Ball]
class = "Features.BouncingBall"
interfaces = ["me", "cs"]
solver = "rodas3"
tolerance = 1e-5
step = 1e-3
"""


@pytest.fixture
def kitchen(tmp_path, own_cache):
    """A modifiable copy of the library, a cookbook, a cache, and a folder for the results."""
    library = tmp_path / "modelica" / "Features"
    shutil.copytree(FEATURES, library)
    (tmp_path / "recipes.toml").write_text(RECIPE)
    book = read_recipes(tmp_path / "recipes.toml")

    def make(book=book, folder="out"):
        return build_one("Ball", "native", tmp_path / folder, book=book, library=library)

    return make, library, tmp_path


def test_the_same_sources_give_the_same_bytes(kitchen):
    """In another folder and at another time: the FMU contains neither paths nor times."""
    make, _, folder = kitchen
    first = make().path.read_bytes()
    shutil.rmtree(folder / "cache")
    again = make(folder="elsewhere")
    assert again.action == "built"
    assert again.path.read_bytes() == first


@pytest.mark.skipif(sys.platform == "win32", reason="has no locks of folders")
def test_builders_at_the_same_time_build_once(kitchen, monkeypatch):
    """As the processes of a campaign that need the same FMU: the others wait, and find what the first has made."""
    make, _, _ = kitchen
    translations = []
    translation_of = building._translation_of

    def slowly(order):
        translations.append(order.name)
        time.sleep(0.3)  # long enough for the others to arrive
        return translation_of(order)

    monkeypatch.setattr(building, "_translation_of", slowly)
    with ThreadPoolExecutor(3) as pool:
        actions = [job.result().action for job in [pool.submit(make) for _ in range(3)]]
    assert translations == ["Ball"]
    assert sorted(actions) == ["built", "current", "current"]


def test_only_changed_sources_are_built_again(kitchen):
    """After a comment Modelica is parsed again but nothing is compiled; after an equation it is compiled."""
    make, library, folder = kitchen
    file = library / "BouncingBall.mo"
    assert make().action == "built"
    assert make().action == "current"
    text = file.read_text()
    file.write_text("// nothing new\n" + text)
    before = (folder / "out" / "Ball.fmu").stat().st_mtime_ns
    assert make().action == "unchanged"
    assert (folder / "out" / "Ball.fmu").stat().st_mtime_ns == before
    assert make().action == "current"
    file.write_text(text.replace("e = 0.7", "e = 0.8"))
    assert make().action == "built"
    (folder / "loose.toml").write_text(RECIPE.replace("1e-5", "1e-4"))
    assert make(read_recipes(folder / "loose.toml")).action == "built"
    assert make().action == "current", "what was built before is still there"


def test_a_refused_class_leaves_no_fmu(kitchen):
    make, library, folder = kitchen
    file = library / "BouncingBall.mo"
    file.write_text(file.read_text().replace("der(v) = -g", "der(v) = -delay(g + h, 0.1)"))
    with pytest.raises(TranslationError, match=r"BouncingBall\.mo:\d+: .*delay is not supported"):
        make()
    assert not (folder / "out" / "Ball.fmu").exists()


def test_a_misspelt_name_is_answered_with_the_nearest():
    with pytest.raises(InputError, match=r"has no FMU named 'TwoPartTran'.*did you mean TwoPartTrain"):
        read_recipes()["TwoPartTran"]


def test_openmodelica_is_used_if_available_and_reported_missing_on_request(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert choose("auto") == "native"
    with pytest.raises(CompilerMissing, match="omc is not on the PATH"):
        choose("openmodelica")
    (tmp_path / "omc").write_text("#!/bin/sh\n")
    (tmp_path / "omc").chmod(0o755)
    assert choose("auto") == "openmodelica"
    assert choose("native") == "native"


def test_the_lock_file_reads_back_and_differences_are_reported(tmp_path, kitchen):
    make, _, folder = kitchen
    interface = make().interface
    book = read_recipes(folder / "recipes.toml")
    file = tmp_path / "lock.toml"
    write_lock(book, {"Ball": interface}, file)
    locked = read_lock(file)
    assert differences("Ball", locked, interface) == []
    assert interface["states"] == {"h": "", "v": ""}
    assert interface["event_indicators"] == 1
    moved = interface | {"states": {"h": "m", "v": ""}, "event_indicators": 2}
    assert differences("Ball", locked, moved) == [
        "event_indicators was 1, is 2",
        "states: h was '', is 'm'",
    ]
    assert differences("New", locked, interface) == ["is not in lock.toml"]


def test_update_writes_the_lock_of_what_was_built(kitchen, monkeypatch, capfd):
    make, _, folder = kitchen
    artifact = make()
    monkeypatch.setattr("railgrip.cli.fmus.read_recipes", lambda: read_recipes(folder / "recipes.toml"))
    monkeypatch.setattr("railgrip.cli.fmus.build", lambda names, compiler: [artifact])
    monkeypatch.setattr("railgrip.cli.fmus.write_lock", partial(write_lock, file=folder / "lock.toml"))
    done = command_line.done(capfd, "build", "--check", "--update")
    assert done.code == 0, done.err
    assert done.out.endswith("lock.toml written\n1 FMUs are valid\n")
    assert differences("Ball", read_lock(folder / "lock.toml"), artifact.interface) == []


def test_list_prints_every_recipe_completely_without_a_terminal(command):
    output = command("build", "--list")
    assert output.code == 0
    for name, recipe in tomllib.loads((ROOT / "fmus" / "recipes.toml").read_text()).items():
        assert f" {name} " in output.out
        assert f" {recipe['class']} " in output.out


def test_the_program_imports_nothing_from_the_current_folder(tmp_path):
    for name in ("typer", "railgrip", "rumoca", "json"):
        (tmp_path / f"{name}.py").write_text("open('ran', 'w').close()\nraise ImportError('a trap')\n")
    program = Path(sys.executable).with_name("railgrip")
    done = command_line.ran([program, "build", "--list"], tmp_path)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    "command",
    [
        ("railgrip", "build", "ContactPoint", "--compiler", "native"),
        ("railgrip", "run", str(ROOT / "harness/scenario/library/trapezoid.toml")),
    ],
    ids=["build", "run"],
)
def test_both_command_lines_without_a_c_compiler_exit_with_3(tmp_path, command):
    """An interpreter without the ziglang of site-packages, which is hidden, and with an empty PATH."""
    hide = (
        "import sys, importlib.util as u; real = u.find_spec;"
        "u.find_spec = lambda n, *a: None if n == 'ziglang' else real(n, *a);"
        f"from {command[0]}.__main__ import main;"
        f"sys.argv = {list(command)}; main()"
    )
    nothing = {"PATH": str(tmp_path), "CC": "", "RAILGRIP_CACHE": str(tmp_path / "cache")}
    done = command_line.ran([sys.executable, "-c", hide], tmp_path, **nothing)
    assert done.returncode == 3, done.stderr
    assert "Traceback" not in done.stderr
    assert "no C compiler" in done.stderr


def test_only_the_cache_counts_as_built(kitchen):
    """An FMU that somebody left in the output folder is neither used nor preserved."""
    make, _, folder = kitchen
    (folder / "out").mkdir()
    (folder / "out" / "Ball.fmu").write_text("from a stranger")
    done = make()
    assert done.action == "built"
    assert done.interface["class"] == "Features.BouncingBall"
    assert done.path.read_bytes() != b"from a stranger"
