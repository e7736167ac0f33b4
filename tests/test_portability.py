"""POSIX-only functions are looked up where they are used: the same sources run on Windows and macOS."""

import ast
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import ran
from project_files import ROOT, trees

from railgrip.base import cache, programs
from railgrip.fmus.native import toolchain
from railgrip.scenario.load import load, scenario_of

POSIX_MODULES = {"fcntl", "grp", "posix", "pwd", "resource", "termios"}
POSIX_NAMES = {
    "os": {"O_NOFOLLOW", "fork", "geteuid", "getloadavg", "getpgid", "getuid", "killpg", "setsid", "wait4"},
    "signal": {"SIGCHLD", "SIGHUP", "SIGKILL", "SIGUSR1", "SIGUSR2", "SIGXCPU", "pthread_sigmask"},
}
POSIX_FILES = {
    "harness/fmi/keeper.py",  # a separate process for a foreign FMU
    "harness/fmi/isolation.py",  # starts that process, and refuses to on other systems
    "tools/suites.py",  # forks for each class
}


def functions(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.iter_child_nodes(tree):
        yield node
        if not isinstance(node, ast.FunctionDef):
            yield from functions(node)


def test_posix_only_names_are_used_only_after_a_check():
    """A function that uses one checks `os.name` or the name; no module imports one at its top."""
    for path, (text, tree) in trees().items():
        if path.relative_to(ROOT).as_posix() in POSIX_FILES:
            continue
        top = {name.name for node in tree.body if isinstance(node, ast.Import) for name in node.names}
        assert not top & POSIX_MODULES, path
        for part in functions(tree):
            if isinstance(part, ast.ClassDef | ast.If | ast.Try | ast.With):
                continue
            used = {
                f"{node.value.id}.{node.attr}"
                for node in ast.walk(part)
                if isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.attr in POSIX_NAMES.get(node.value.id, ())
            }
            if used:
                segment = ast.get_source_segment(text, part) or ""
                assert "os.name" in segment or "hasattr(" in segment, (path, part.lineno, used)


def test_text_files_are_read_and_written_in_a_stated_encoding():
    """On Windows the default depends on the language. ruff's PLW1514 finds fewer of these calls."""
    for path, (_, tree) in trees().items():
        for node in ast.walk(tree):
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
                continue
            stated = {keyword.arg for keyword in node.keywords}
            # The first argument of `read_text` is the encoding, or the name of a file of a distribution.
            reads = node.func.attr == "read_text" and not node.args
            if reads or (node.func.attr == "write_text" and len(node.args) == 1):
                assert "encoding" in stated, (path, node.lineno)
            if node.func.attr in ("run", "Popen", "check_output") and stated & {"text", "universal_newlines"}:
                assert "encoding" in stated, (path, node.lineno)


def test_on_windows_the_compiler_of_the_wheel_gets_no_option_that_it_refuses(monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(toolchain, "SUFFIX", ".dll")
    monkeypatch.setattr(toolchain.platform, "system", lambda: "Windows")
    commands = []

    def run(command, folder, name):
        commands.append(command)
        (folder / "half.dll").write_bytes(b"MZ")
        return 0, ""

    monkeypatch.setattr(toolchain, "_run", run)
    assert toolchain.binary({"half.c": "double half(double x) { return 0.5 * x; }\n"}, "half") == b"MZ"
    (command,) = commands
    assert command[: len(toolchain._ZIG)] == list(toolchain._ZIG)
    assert not {"-fPIC", "-fvisibility=hidden", "-Wl,--build-id=none"} & set(command)
    assert "half.dll" in command


def test_a_library_loaded_on_windows_may_be_cached_again(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "cache"))
    first = cache.keep("libraries", "key", "half.dll", b"content")

    def refuse(self, target):
        raise PermissionError(13, "in use")

    monkeypatch.setattr(Path, "replace", refuse)
    assert cache.keep("libraries", "key", "half.dll", b"content") == first
    assert [file.name for file in first.parent.iterdir()] == ["half.dll"]


def test_a_failed_translation_is_reported_on_systems_without_signals():
    """Windows ends a process whose stack overflows with a large positive code."""
    code = "import signal; [delattr(signal, n) for n in ('SIGXCPU', 'SIGKILL') if hasattr(signal, n)]; "
    code += "from railgrip.fmus.native.separate_process import _process_failure as sentence; "
    code += "print(sentence(3221225725, ''))"
    done = ran([sys.executable, "-c", code])
    assert "exit code 3221225725" in done.stdout, done.stderr


def test_a_system_without_an_address_space_limit_still_translates(monkeypatch):
    resource = pytest.importorskip("resource")
    limits = []

    def refuse(what, value):
        limits.append(what)
        if what == resource.RLIMIT_AS:
            raise ValueError("current limit exceeds maximum limit")  # macOS

    monkeypatch.setattr(resource, "setrlimit", refuse)
    programs.limit_resources({"RLIMIT_CPU": 300, "RLIMIT_AS": 4096 << 20, "RLIMIT_CORE": 0})
    assert limits == [resource.RLIMIT_CPU, resource.RLIMIT_AS, resource.RLIMIT_CORE]


def test_a_scenario_may_extend_one_on_another_drive(tmp_path, monkeypatch):
    """A file on D: extends one of the library on C:, so no relative path between them exists."""
    library = tmp_path / "library"
    library.mkdir()
    (library / "base.toml").write_text('extends = "plain"\n[vehicle]\ntrain = "train.toml"\n', encoding="utf-8")
    shutil.copy(ROOT / "harness/scenario/trains/vt642.toml", library / "train.toml")
    (tmp_path / "mine.toml").write_text('extends = "library/base.toml"\n', encoding="utf-8")
    assert load(tmp_path / "mine.toml").resolved()["vehicle"]["train"] == "library/train.toml"

    def refuse(path, start):
        raise ValueError("path is on mount 'C:', start on mount 'D:'")

    monkeypatch.setattr(os.path, "relpath", refuse)
    entry = load(tmp_path / "mine.toml").resolved()["vehicle"]["train"]
    assert entry == (library / "train.toml").as_posix()
    assert scenario_of(load(tmp_path / "mine.toml").resolved(), directory=Path("/"), origin="there")


def test_output_into_a_pipe_accepts_all_characters(tmp_path):
    """On Windows the encoding of a pipe depends on the language and has no Greek letters."""
    (tmp_path / "run.csv").write_text("time [s],ω [rad/s]\n0,1\n1,2\n2,3\n", encoding="utf-8")
    words = ["-m", "railgrip", "inspect", tmp_path / "run.csv", "--for", "rig_own"]
    done = ran([sys.executable, *words], PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    assert "ω [rad/s]" in done.stdout


@pytest.mark.skipif(os.name == "nt", reason="a shell script as compiler")
def test_a_compiler_behind_a_compiler_cache_keeps_its_archiver(tmp_path, monkeypatch):
    """Of `ccache cc` only the last word is that of `zig cc`, which archives with `zig ar`; a cache runs no `ar`."""
    wrapper = tmp_path / "ccache"
    wrapper.write_text('#!/bin/sh\n[ "$1" = cc ] && exec "$@"\nexit 1\n')
    wrapper.chmod(0o755)
    monkeypatch.setenv("CC", f"{wrapper} cc")
    library = toolchain.static_library({"one.c": "int one(void) { return 1; }"}, "one", units=("one.c",))
    assert library.startswith(b"!<arch>")
