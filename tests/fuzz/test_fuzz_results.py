"""Mutated folders of results: each is read or refused in a sentence, and nothing outside the folder is changed."""

import hashlib
import json
import os
import shutil
import tempfile
from contextlib import suppress
from functools import partial
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from test_files_of_users import make_obstacle
from written_campaigns import write_campaign
from wrong import answered, mutate

from railgrip.api import compare
from railgrip.base.errors import RailgripError
from railgrip.report.index import write_report
from railgrip.report.stop import _digest

NAMES = ("trapezoid-ideal-slip_two_state", "trapezoid-ideal-adhesion_based")

many = settings(
    max_examples=int(os.environ.get("RAILGRIP_FUZZ", "10")),
    derandomize="RAILGRIP_FUZZ" not in os.environ,
    phases=(Phase.explicit, Phase.reuse, Phase.generate),  # shrinking takes minutes of drawing
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::UserWarning")

numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.sampled_from([0, -1, 1e-300, 1e300, -0.0, 10**400, 2**63, 2**70]),
)
PATHS = ["../victim", "../../x/evil", "/tmp", ".", "..", "", "a/b", "campaign.json", "figures", "x" * 300, "a\n", "\0"]
texts = st.one_of(st.sampled_from(PATHS), st.text(max_size=10), st.sampled_from(["<script>", "\ud800", "nan", "1e999"]))
values = st.recursive(
    st.one_of(st.none(), st.booleans(), numbers, texts),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(texts, inner, max_size=3)),
    max_leaves=5,
)


@pytest.fixture(scope="module")
def valid(tmp_path_factory):
    """The folder of a campaign of two stops, with an earlier page."""
    folder = tmp_path_factory.mktemp("valid") / "results"
    assert len(write_campaign(folder, lambda stop: stop.name in NAMES).stops) == 2
    write_report(folder, panels="none")
    return folder


def write_table(path, table):
    """Write JSON with the digests that a stop contains: an attacker can compute them."""
    if path.name == "stop.json":
        trace = path.with_name("trace.nc")
        if not isinstance(table, dict):
            return
        if table.get("trace_sha256") and trace.is_file():
            table["trace_sha256"] = hashlib.sha256(trace.read_bytes()).hexdigest()
        table.pop("sha256", None)
        with suppress(ValueError, RecursionError, TypeError):
            table["sha256"] = _digest(table)
    with suppress(OSError):
        path.write_bytes(json.dumps(table).encode(errors="surrogatepass"))


RAW = [b"[" * 200_000, b'{"a":' * 100_000, b"", b"{", b"null", b"\xff\xfe", b"9" * 10_000, b'"\\ud800"', b"NaN"]


def mutate_file(path, outside, draw):
    """Replace a file by something else."""
    content = path.read_bytes()
    path.unlink()
    match draw(st.sampled_from(["raw", "cut", "link", "pipe", "folder", "device", "loop", "missing"])):
        case "raw":
            path.write_bytes(draw(st.sampled_from(RAW)))
        case "cut":
            path.write_bytes(content[: draw(st.integers(0, len(content)))])
        case "link":
            path.symlink_to(outside / "stop" / path.name)
        case obstacle:
            make_obstacle(obstacle, path)


def mutate_trace(path, outside, draw):
    """Change a variable of a trace."""
    with h5py.File(path, "r+") as file:
        name = draw(st.sampled_from(sorted(file)))
        if not isinstance(file.get(name), h5py.Dataset):  # an earlier change
            return
        samples = file[name][()]
        change = draw(st.sampled_from(["gone", "value", "all", "shape", "type", "soft", "external", "source", "group"]))
        if change == "value" and samples.dtype.kind == "f":
            samples.flat[draw(st.integers(0, samples.size - 1))] = draw(st.floats())
            file[name][...] = samples
        elif change == "all" and samples.dtype.kind == "f":
            file[name][...] = draw(st.sampled_from([np.nan, np.inf, 1e300, -1e300, 0.0, -1.0]))
        else:
            del file[name]
            match change:
                case "shape":
                    file[name] = samples.ravel()[: draw(st.integers(0, 3))]
                case "type":
                    file[name] = np.array([b"x"] * 3)
                case "soft":
                    file[name] = h5py.SoftLink("/speed")
                case "external":
                    file[name] = h5py.ExternalLink(str(outside / "stop" / "trace.nc"), "/speed")
                case "source":
                    file.create_dataset(name, (10,), "f8", external=[(str(outside / "secret"), 0, 80)])
                case "group":
                    file.create_group(name)
                case _:
                    pass


def snapshot(folder):
    return {path: (path.lstat().st_mtime_ns, path.read_bytes()) for path in folder.rglob("*") if path.is_file()}


QUESTIONS = {
    "report of a campaign": lambda folder: write_report(folder, panels="none"),
    "report with pages of stops": lambda folder: write_report(folder, panels="abc"),
    "report of a stop": lambda folder: write_report(folder / NAMES[0]),
    "comparison of campaigns": lambda folder: compare(folder, folder).page(),
    "comparison of stops": lambda folder: compare(folder / NAMES[0], folder / NAMES[1]).page(),
}
"""Run everything that reads a folder of results."""


@pytest.mark.skipif(os.name != "posix", reason="links and pipes of POSIX")
@many
@given(data=st.data())
def test_a_mutated_folder_of_results_is_read_or_refused(data, valid):
    draw = data.draw
    with tempfile.TemporaryDirectory() as place:
        folder, outside = Path(place) / "sent", Path(place) / "victim"
        shutil.copytree(valid, folder)
        shutil.copytree(valid / NAMES[0], outside / "stop")
        (outside / "index.html").write_text("mine")
        (outside / "secret").write_bytes(bytes(80))
        question = draw(st.sampled_from(sorted(QUESTIONS)))
        stop = folder / draw(st.sampled_from(NAMES))
        for _ in range(draw(st.integers(1, 2))):
            path = draw(st.sampled_from([folder / "campaign.json", stop / "stop.json", stop / "stop.json"]))
            if not path.is_file():
                continue
            match draw(st.sampled_from(["table", "table", "table", "table", "file", "trace", "folder", "figures"])):
                case "table":
                    with suppress(ValueError, IndexError, RecursionError):  # nothing is left in it
                        table = json.loads(path.read_bytes())
                        mutate(table, draw, values)
                        write_table(path, table)
                case "file":
                    target = draw(st.sampled_from([path, stop / "trace.nc"]))
                    if target.is_file():
                        mutate_file(target, outside, draw)
                case "trace" if (stop / "stop.json").is_file() and (stop / "trace.nc").is_file():
                    with suppress(OSError, ValueError):
                        mutate_trace(stop / "trace.nc", outside, draw)
                        write_table(stop / "stop.json", json.loads((stop / "stop.json").read_bytes()))
                case "folder" if not stop.is_symlink() and question != "report of a stop":  # a link that the user names
                    shutil.rmtree(stop)
                    stop.symlink_to(outside / "stop")
                case "figures" if not (folder / "figures").is_symlink():
                    shutil.rmtree(folder / "figures", ignore_errors=True)
                    (folder / "figures").symlink_to(outside)
                case _:
                    pass
        before = snapshot(outside)
        answered(partial(QUESTIONS[question], folder), longest=3000)
        assert snapshot(outside) == before
        assert {path.name for path in Path(place).iterdir()} == {"sent", "victim"}


@pytest.mark.skipif(os.name != "posix", reason="links of POSIX")
@pytest.mark.parametrize("name", ["../victim", "../../victim", "/absolute", "victim/../../victim", "..", "."])
def test_a_report_writes_no_page_outside_of_its_folder(tmp_path, valid, name):
    """A name in campaign.json is a path: neither it nor a link of a plain name may leave the folder."""
    folder, victim = tmp_path / "deep" / "sent", tmp_path / "deep" / "victim"
    shutil.copytree(valid, folder)
    shutil.copytree(valid / NAMES[0], victim)
    (victim / "index.html").write_text("mine")
    table = json.loads((folder / "campaign.json").read_bytes())
    table["stops"][0]["name"] = str(victim) if name == "/absolute" else name
    (folder / "campaign.json").write_text(json.dumps(table))
    with pytest.raises(RailgripError, match=r"campaign\.json: is not the description of a campaign \(stops\.0\.name"):
        write_report(folder)
    shutil.copy(valid / "campaign.json", folder)
    shutil.rmtree(folder / NAMES[0])
    (folder / NAMES[0]).symlink_to(victim)
    with pytest.raises(RailgripError, match="leads out of the folder"):
        write_report(folder)
    assert (victim / "index.html").read_text() == "mine"
