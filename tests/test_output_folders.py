"""A user's files in a folder named by --out are not changed: railgrip replaces and removes only its own files."""

import json
import os
from pathlib import Path

import pytest
from command_line import done
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from railgrip.base.errors import RecordError
from railgrip.base.records import RECORD, adopt, claim, discard, make_folder, require_free, require_own

SHORT = ("--set", "limits.horizon=2 s")
ESTIMATION = Path(__file__).parents[1] / "harness/estimation/library/rig_own.toml"
COMMANDS = {
    "run": (("run", "trapezoid", *SHORT), ("stop.json", "trace.nc")),
    "campaign": (("campaign", "table1", *SHORT), ("campaign.json", "index.html", "table1.json", "table1.md")),
    "stop of a campaign": (("campaign", "table1", *SHORT), ("trapezoid-ideal-slip_two_state/trace.nc",)),
    "study": (("study", "pad_monitor"), ("index.html", "anything.csv")),
    "estimate": (("estimate", str(ESTIMATION)), ("estimates.nc", "estimates.png")),
    "observability": (("observability", str(ESTIMATION)), ("observability.csv", "observability.png")),
    "export": (("export", "plain", "--library"), ("plain.h", "notes.txt")),
}


def test_a_folder_of_another_user_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write everywhere
    with pytest.raises(RecordError, match=r"cannot be written there: no permission; make the folder writable, or name"):
        make_folder(tmp_path)


@pytest.mark.parametrize(("command", "name"), [(name, file) for name, (_, files) in COMMANDS.items() for file in files])
def test_an_obstructing_file_is_reported_before_anything_runs(
    command: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # Names in modules that import them come first: a module imported while its source is replaced would keep the
    # replacement for later tests.
    for place in (
        "campaign.sweep.run_stop",
        "cli.estimation.estimate_of",
        "campaign.workers.pool",
        "simulate.run.run_stop",
    ):
        monkeypatch.setattr(f"railgrip.{place}", lambda *_, **__: pytest.fail("it was run"))
    file = tmp_path / "site" / name
    file.parent.mkdir(parents=True)
    file.write_text("mine")
    result = done(capsys, *COMMANDS[command][0], "--out", str(tmp_path / "site"))
    assert result.refuses(f"contains files that railgrip has not written ({file.name})")
    assert [path for path in (tmp_path / "site").rglob("*") if path.is_file()] == [file]
    assert file.read_text() == "mine"


names = st.sampled_from(["index.html", "stop.pdf", "trace.nc", "stop.json", "figures/a.png", "notes.txt"])


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=100)
@given(own=st.sets(names), ours=st.sets(names), gone=st.sets(names))
def test_only_recorded_files_are_replaced_and_removed(
    own: set[str], ours: set[str], gone: set[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("site")
    for name in own:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("mine")
    if own & ours:
        with pytest.raises(RecordError, match="has not written"):
            claim(folder, *ours)
    else:
        claim(folder, *ours)
        for name in ours:
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text("a result")
        require_free(folder, *ours)
        discard(folder, gone)
        assert {name for name in ours if (folder / name).exists()} == ours - gone
        if any("/" not in name for name in own):
            with pytest.raises(RecordError, match="has not written"):
                require_own(folder)
    assert all((folder / name).read_text() == "mine" for name in own)


@pytest.mark.parametrize(
    "record", [b"", b"[", b"[]", b'{"written": 1}', b'{"written": ["../mine", 3]}', b"[" * 200_000]
)
def test_an_invalid_record_claims_no_files(record: bytes, tmp_path: Path) -> None:
    folder = tmp_path / "site"
    folder.mkdir()
    (folder / RECORD).write_bytes(record)
    (folder / "index.html").write_text("mine")
    (tmp_path / "mine").write_text("mine")
    with pytest.raises(RecordError, match="has not written"):
        claim(folder, "index.html")
    with pytest.raises(RecordError, match="leads out of the folder"):
        discard(folder, ["../mine"])
    assert (tmp_path / "mine").exists()


@pytest.mark.skipif(os.name != "posix", reason="links of POSIX")
def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "figures").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(RecordError, match="leads out of the folder"):
        claim(tmp_path / "site", "figures/a.png")
    assert not list((tmp_path / "elsewhere").iterdir())


STOP = {"scenario_digest": "0", "sha256": "0"}
CAMPAIGN = {"name": "a", "description": "", "stops": []}
PAGE = '<p class="question">?</p>\n<h2>Provenance</h2>'
EARLIER = {
    "a stop": ({"stop.json": json.dumps(STOP), "trace.nc": ""}, ["stop.json", "trace.nc"]),
    "a campaign": ({"campaign.json": json.dumps(CAMPAIGN), "a.md": ""}, ["campaign.json", "a.md"]),
    "a study": ({"index.html": PAGE, "a.csv": ""}, ["index.html", "a.csv"]),
    "figures of a study": ({"figures.json": '[{"name": "a", "value": 1, "unit": "m"}]'}, ["figures.json"]),
}


@pytest.mark.parametrize("kind", EARLIER)
def test_results_of_the_first_release_are_replaced(kind: str, tmp_path: Path) -> None:
    """They have no record and are recognised by their contents."""
    contents, files = EARLIER[kind]
    for name, content in contents.items():
        (tmp_path / name).write_text(content)
    claim(tmp_path, *files)
    for name in files:
        (tmp_path / name).write_text("mine")
        (tmp_path / RECORD).unlink(missing_ok=True)
    with pytest.raises(RecordError, match="has not written"):
        claim(tmp_path, *files)


def test_a_page_of_the_user_next_to_a_stop_of_the_first_release_is_kept(tmp_path: Path) -> None:
    for name, content in {"stop.json": json.dumps(STOP), "index.html": "mine", "stop.pdf": "mine"}.items():
        (tmp_path / name).write_text(content)
    discard(tmp_path, ["stop.json", "index.html", "stop.pdf"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["index.html", "stop.pdf"]


def test_a_folder_that_railgrip_named_is_adopted_once(tmp_path: Path) -> None:
    (tmp_path / "estimates.nc").write_text("earlier")
    adopt(tmp_path, "estimates.nc", "estimates.png")
    require_free(tmp_path, "estimates.nc")
    (tmp_path / "estimates.png").write_text("mine")
    adopt(tmp_path, "estimates.nc", "estimates.png")
    with pytest.raises(RecordError, match=r"\(estimates\.png\)"):
        require_free(tmp_path, "estimates.nc", "estimates.png")
