"""Temporary folders are removed after their process has ended in any way."""

import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from railgrip.base.files import _remove_stale, lock_folder, scratch
from railgrip.campaign.workers import workers

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the locks are POSIX")


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    _remove_stale.cache_clear()
    return tmp_path


NAMES = st.from_regex(r"railgrip-(build|far|fmu|study|workers|unlocked)-[0-9]{1,5}-[a-z0-9_]{8}", fullmatch=True)


def filled(folder):
    """Create a folder with a file in it, two days old."""
    (folder / "binaries").mkdir(parents=True)
    (folder / "binaries" / "kept.txt").write_text("mine")
    two_days_ago = time.time() - 2 * 86400
    os.utime(folder, (two_days_ago, two_days_ago))
    return folder


def abandoned(folder):
    """Create the folder of a killed run: it is marked, and no process holds its lock."""
    filled(folder)
    with scratch("build") as running:
        shutil.copy(next(path for path in running.iterdir() if path.is_file()), folder)
    return folder


@pytest.mark.parametrize("purpose", ["fmu", "workers"])
def test_folders_of_a_killed_run_are_removed_by_the_next_at_once(temporary, purpose):
    """For any purpose. A folder in use, here by this very process, is kept."""
    stale = [
        abandoned(temporary / f"railgrip-{other}-1-abcdef_{number}")
        for number, other in enumerate(("fmu", "workers", "build"))
    ]
    used = abandoned(temporary / f"railgrip-{purpose}-{os.getpid()}-12345678")
    _remove_stale.cache_clear()
    with lock_folder(used), scratch(purpose) as mine:
        assert sorted(temporary.iterdir()) == sorted([used, mine])
    assert list(temporary.iterdir()) == [used]
    assert not any(folder.exists() for folder in stale)


@given(names=st.sets(st.one_of(NAMES, st.sampled_from(["railgrip-study-3-baseline"])), min_size=1, max_size=4))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
def test_a_folder_without_the_mark_is_kept_whatever_its_name(temporary, names):
    """This includes a folder that a link of such a name points to, and one whose mark is itself a link."""
    with tempfile.TemporaryDirectory(dir=temporary) as place, pytest.MonkeyPatch.context() as patch:
        here = Path(place)
        patch.setattr(tempfile, "tempdir", place)
        own = [filled(here / name) for name in names]
        target = abandoned(here / "linked")
        (here / "railgrip-fmu-1-00000000").symlink_to(target)
        mark = next(path.name for path in target.iterdir() if path.is_file())
        (own[0] / mark).symlink_to(target / mark)
        _remove_stale.cache_clear()
        with scratch("study"):
            pass
        for folder in (*own, target):
            assert (folder / "binaries" / "kept.txt").read_text() == "mine"


def test_folders_unpacked_by_workers_are_removed_with_their_pool(temporary):
    left = abandoned(temporary / "railgrip-workers-1-12345678") / "railgrip-fmu-2-12345678"
    left.mkdir()
    _remove_stale.cache_clear()
    with workers(1) as pool:
        assert not left.exists()
        folder = pool.submit(tempfile.gettempdir).result()
        assert folder.startswith(str(temporary / f"railgrip-workers-{os.getpid()}-"))
    assert list(temporary.iterdir()) == []
