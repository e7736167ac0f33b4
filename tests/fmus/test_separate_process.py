"""Modelica of a user that cannot be compiled is refused in a sentence, whatever it does to the compiler."""

import sys
from pathlib import Path

import pytest
from waiting import is_running, until

from railgrip.base.errors import BuildFailed, InputError
from railgrip.fmus.build import build_class
from railgrip.fmus.native import lower, separate_process, toolchain
from railgrip.fmus.native.library import LIBRARY

CALL = separate_process.call
"""The function that tests/conftest.py replaces."""

DECAY = "model M Real x(start=1, fixed=true); equation der(x) = {}; end M;"
DOUBLED = (
    "package P model A0 Real x(start=1, fixed=true); equation der(x) = -x; end A0; "
    + "".join(f"model A{i + 1} A{i} a; A{i} b; end A{i + 1}; " for i in range(22))
    + "model M A22 a; end M; end P;"
)
REFUSED = {
    "5,000 nested calls": (DECAY.format("sin(" * 5000 + "x" + ")" * 5000), r"M.mo:1: more than 200 nested brackets"),
    "20,000 parentheses": (DECAY.format("(" * 20000 + "x" + ")" * 20000), r"M.mo:1: more than 200 nested brackets"),
    "500 terms": (DECAY.format("+".join(["x"] * 500)), "too long or nested too deeply"),
    "50,000 terms": (
        DECAY.format("+".join(["x"] * 50000)),
        "too long, or an expression or packages that are nested too deeply: its compiler ended with SIG",
    ),
    "3,000 nested packages": (
        "".join(f"package P{k} " for k in range(3000)) + "".join(f"end P{k}; " for k in reversed(range(3000))),
        "packages that are nested too deeply: its compiler ended with SIG",
    ),
    "a component of itself": ("model M M a; Real x(start=1); equation der(x) = -x; end M;", "cyclic class"),
    "0/0": ("model M Real x(start=0/0, fixed=true); equation der(x) = -x; end M;", "is not a finite number"),
    "an empty file": ("", "no file of it declares M"),
    "10⁸ states": (
        "model M Real a[100000000](each start=1); equation der(a) = -a; end M;",
        "M takes more than (2 s|2048 MiB)",
    ),
    "2²² states": (DOUBLED, "P.M takes more than (2 s|2048 MiB)"),
    "too many states": ("model M Real a[20000](each start=1); equation der(a) = -a; end M;", "M takes more than 2 s"),
}


@pytest.fixture(autouse=True)
def _a_separate_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(separate_process, "call", CALL)


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux")
@pytest.mark.parametrize("text", REFUSED)
def test_an_invalid_class_is_refused_in_a_sentence(
    written, text: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    modelica, sentence = REFUSED[text]
    name = "P.M" if modelica.startswith("package P") else "M"
    seconds = 2 if "2 s" in sentence else 600  # a busy machine needs more time
    monkeypatch.setattr(
        separate_process, "LIMITS", separate_process.TranslationLimits(seconds=seconds, memory_mib=2048)
    )
    with pytest.raises(InputError, match=sentence) as refusal:
        build_class(name, written(modelica), compiler="native")
    assert name in str(refusal.value)
    assert "\n  File" not in str(refusal.value)
    assert "Traceback" not in capfd.readouterr().err


def test_a_class_for_a_filter_is_also_confined(written):
    with pytest.raises(InputError, match="M has an expression that is too long"):
        lower("M", written(REFUSED["50,000 terms"][0]))


def test_brackets_in_texts_and_comments_do_not_count(written):
    brackets = "(" * 500
    text = DECAY.format("-x").replace("M Real", f'M "{brackets}" /* {brackets} */ // \'"{brackets}\n Real')
    assert lower("M", written(text)).states[0].name == "x"


def test_translation_in_a_separate_process_gives_the_same_class(written, monkeypatch: pytest.MonkeyPatch):
    from railgrip.fmus.build import translate, translate_here
    from railgrip.fmus.recipe import Recipe

    file = written(DECAY.format("-x"))
    recipe = Recipe.of_class("M", "cs")
    apart = separate_process.call("translate", "M", file, recipe=recipe.model_dump(by_alias=True))
    assert apart == list(translate_here("M", file, recipe.model_dump(by_alias=True)))
    assert translate(recipe, file)[0].xml == apart[0]["xml"]


def test_built_in_classes_are_translated_without_a_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(separate_process, "call", lambda *_, **__: pytest.fail("a process was started"))
    monkeypatch.setenv("RAILGRIP_CACHE", str(tmp_path / "cache"))
    assert lower("RailBraking.FMUs.ContactPoint", LIBRARY).outputs


def test_modules_of_the_current_folder_are_not_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for name in ("json", "rumoca", "railgrip", "casadi"):
        (tmp_path / f"{name}.py").write_text("open('ran', 'w').close()\nraise ImportError('a trap')\n")
    (tmp_path / "M.mo").write_text(DECAY.format("-x - 1"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert lower("M", Path("M.mo")).states
    assert not (tmp_path / "ran").exists()


def test_a_hanging_c_compiler_is_ended(monkeypatch, tmp_path):
    """Its child processes end, too: here the shell's child, if it started at all on a busy machine."""
    child = tmp_path / "child"
    slow = toolchain.Compiler(command=("sh", "-c", f"sleep 3600 & echo $! > {child}; wait", "cc"), version="slow")
    monkeypatch.setattr(toolchain, "compiler", lambda: slow)
    monkeypatch.setattr(toolchain, "LONGEST", 1.0)
    with pytest.raises(BuildFailed, match=r"takes more than 1.0 s to compile endless; divide the class"):
        toolchain.binary({"endless.c": ""}, "endless")
    for process in child.read_text().split() if child.exists() else ():
        until(lambda process=int(process): not is_running(process))


def test_a_panic_of_the_front_end_is_a_sentence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """A panic of Rust reaches Python as an exception that is not an Exception."""

    class PanicException(BaseException):
        pass

    def panic(*_: object):
        raise PanicException("index out of bounds")

    monkeypatch.setattr("railgrip.fmus.native.equations.lower_here", panic)
    answer = separate_process._answer("lower", "M", tmp_path, {})
    assert "M: the built-in compiler fails on this class" in answer["refusal"]
