"""Temporary folders go with their process, however it ended."""

import os
import sys
import tempfile

import pytest

from railgrip.campaign.workers import workers
from railgrip.files import locked, scratch

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the locks are POSIX")


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


@pytest.mark.parametrize("purpose", ["fmu", "workers"])
def test_what_a_killed_run_left_is_removed_by_the_next(temporary, purpose):
    """A folder in use, here by this very process, stays, and so does one of a user."""
    stale, used = (temporary / f"railgrip-{purpose}-{number}-x" for number in (1, os.getpid()))
    own = temporary / f"railgrip-{purpose}-results"
    for folder in (stale, used, own):
        (folder / "binaries").mkdir(parents=True)
        os.utime(folder, (0, 0))
    with locked(used), scratch(purpose) as mine:
        assert sorted(temporary.iterdir()) == sorted([used, own, mine])
    assert sorted(temporary.iterdir()) == sorted([used, own])


def test_what_workers_unpack_goes_with_their_pool(temporary):
    left = temporary / "railgrip-workers-1-abc" / "railgrip-fmu-2-def"
    left.mkdir(parents=True)
    os.utime(left.parent, (0, 0))
    with workers(1) as pool:
        assert not left.exists()
        folder = pool.submit(tempfile.gettempdir).result()
        assert folder.startswith(str(temporary / f"railgrip-workers-{os.getpid()}-"))
    assert list(temporary.iterdir()) == []
