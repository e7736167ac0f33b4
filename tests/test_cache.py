"""Compiled code is loaded only unchanged, and only from places that nobody but the user can write to."""

import ctypes
import os
import time
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType
from typing import Any

import pytest

from railgrip.base import cache
from railgrip.base.errors import InputError
from railgrip.fmus.native import equations, toolchain
from railgrip.fmus.native.toolchain import shared_library

ONE = {"one.c": '__attribute__((visibility("default"))) int one(void) { return 1; }'}
posix = pytest.mark.skipif(os.name != "posix", reason="owners and modes are those of POSIX")


def test_a_cached_file_is_found_unchanged(own_cache):
    assert cache.find("libraries", "key", "a.so") is None
    path = cache.keep("libraries", "key", "a.so", b"content")
    assert path.is_relative_to(own_cache)
    assert cache.find("libraries", "key", "a.so") == path
    assert path.read_bytes() == b"content"
    assert cache.find("libraries", "key", "b.so") is None
    assert cache.find("libraries", "other", "a.so") is None


def test_a_changed_library_is_compiled_again_and_not_loaded(own_cache):
    first = shared_library(ONE, "one")
    first.write_bytes(first.read_bytes()[:-1] + b"x")
    again = shared_library(ONE, "one")
    assert again == first
    assert ctypes.CDLL(str(again)).one() == 1


@posix
@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_writable_by_others_is_not_loaded(own_cache, mode):
    cache.keep("libraries", "key", "a.so", b"content").chmod(mode)
    assert cache.find("libraries", "key", "a.so") is None


@posix
@pytest.mark.parametrize("depth", range(4))
def test_a_folder_writable_by_others_is_refused_in_a_sentence(own_cache, depth):
    path = cache.keep("libraries", "key", "a.so", b"content")
    path.parents[depth].chmod(0o777)
    for use in (cache.find, lambda *where: cache.keep(*where, b"content")):
        with pytest.raises(InputError, match="others can write in it; remove it, or name another"):
            use("libraries", "key", "a.so")


@posix
@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root can give a file away")
def test_a_file_of_another_user_is_not_loaded(own_cache):
    os.chown(cache.keep("libraries", "key", "a.so", b"content"), 12345, 12345)
    assert cache.find("libraries", "key", "a.so") is None
    os.chown(own_cache, 12345, 12345)
    with pytest.raises(InputError, match="is not yours"):
        cache.find("libraries", "key", "a.so")


def test_a_link_is_not_followed(own_cache, tmp_path):
    path = cache.keep("libraries", "key", "a.so", b"content")
    elsewhere = tmp_path / "elsewhere"
    path.rename(elsewhere)
    path.symlink_to(elsewhere)
    assert cache.find("libraries", "key", "a.so") is None


def test_concurrent_writers_may_cache_the_same_file(own_cache):
    with ThreadPoolExecutor(8) as pool:
        paths = set(pool.map(lambda _: cache.keep("libraries", "key", "a.so", b"content" * 10000), range(64)))
    assert paths == {cache.find("libraries", "key", "a.so")}
    assert [file.name for file in paths.pop().parent.iterdir()] == ["a.so"]


@posix
def test_what_several_need_at_once_is_compiled_and_translated_once(own_cache, monkeypatch):
    """Threads wait for each other like processes: each has opened the locked folder itself."""
    made: list[str] = []

    def counted(module: ModuleType, name: str, result: Any) -> None:
        def make(*arguments: Any, **options: Any) -> Any:
            made.append(name)
            time.sleep(0.1)  # without a lock, all threads have found nothing by then
            return result

        monkeypatch.setattr(module, name, make)

    counted(toolchain, "binary", b"compiled")
    counted(equations, "lower_here", "translated")
    monkeypatch.setattr(equations.Model, "from_bytes", lambda content: content)
    with ThreadPoolExecutor(4) as pool:
        libraries = list(pool.map(lambda _: shared_library(ONE, "one").read_bytes(), range(4)))
        models = list(pool.map(lambda _: equations.lower("RailBraking.Plants.Wagon"), range(4)))
    assert (libraries, models) == ([b"compiled"] * 4, [b"translated"] * 4)
    assert made == ["binary", "lower_here"]


def test_the_least_recently_used_files_are_removed_beyond_the_limit(own_cache, monkeypatch):
    monkeypatch.setattr(cache, "LARGEST", 25_000)
    paths = [cache.keep("lives", f"{number}", "a.json", b"%d" % number * 10_000) for number in range(4)]
    for number, file in enumerate(paths):
        os.utime(file, (1e9 + number, 1e9 + number))
    os.utime(paths[2], (4e9, 4e9))  # the clock has been put back since
    assert cache.find("lives", "0", "a.json") == paths[0]  # used just now
    young = cache.keep("lives", "young", "a.json", b"y" * 30_000)
    cache.prune(own_cache)
    assert [file.exists() for file in (*paths, young)] == [True, False, False, False, True]
    assert not paths[1].parents[1].exists()
