"""Stops on a Dask cluster: what a lost worker was doing is done by another, and results come back to one place."""

import math
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

# Where `make install` has it: beside the environment, not in it.
sys.path.append(str(Path(sys.prefix) / "cluster"))

from distributed import LocalCluster
from synthetic_runner import run_stop

from railgrip.base.errors import InputError, RailgripError
from railgrip.campaign.run import CampaignRun, run_campaigns
from railgrip.campaign.work import work
from railgrip.campaign.workers import cluster
from railgrip.cli.main import main
from railgrip.report.stop import read_stop
from railgrip.scenario.campaign import load_campaign

LINES = """
name = "few"
scenarios = ["wet.toml"]
[sweep]
seed = [1, 2, 3, 4, 5, 6]
"""


def slowly(scenario, progress=None, notify=lambda sentence: None):
    """Run the stop that `synthetic_runner` has, after a moment in which its worker may be killed."""
    time.sleep(0.5)
    return run_stop(scenario)


@pytest.fixture(scope="module")
def two_workers():
    """A cluster that starts another worker for one that is killed."""
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster_here:
        yield cluster_here


def test_a_worker_that_is_killed_loses_nothing(project, two_workers, tmp_path):
    (project / "few.toml").write_text(LINES, encoding="utf-8")
    campaign = load_campaign(project / "few.toml")
    victims = []

    def kill(report):
        if not victims:
            victims.append(next(iter(two_workers.workers.values())).pid)
            os.kill(victims[0], signal.SIGKILL)

    (reports,) = run_campaigns(
        [CampaignRun(campaign, tmp_path / "out")], slowly, scheduler=two_workers.scheduler_address, notify=kill
    )
    assert victims
    assert [report.state for report in reports] == ["done"] * 6
    for stop in campaign.stops:
        assert read_stop(tmp_path / "out" / stop.name).digest == stop.scenario.digest()
    repeats = []
    run_campaigns([CampaignRun(campaign, tmp_path / "out")], slowly, scheduler="tcp://nobody:1", notify=repeats.append)
    assert {report.state for report in repeats} == {"found"}  # so nobody was asked


def test_a_scheduler_that_is_killed_loses_nothing(project, tmp_path, capfd):
    """Finished stops stay, the others are reported in a sentence, and the next run does only these."""
    (project / "few.toml").write_text(LINES, encoding="utf-8")
    campaign = load_campaign(project / "few.toml")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    here = [sys.executable, "-m", "dask", "scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    address = f"tcp://127.0.0.1:{port}"
    there = [sys.executable, "-m", "dask", "worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    quiet = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(here, **quiet) as scheduler, subprocess.Popen(there, **quiet) as worker:
        try:
            (first,) = run_campaigns(
                [CampaignRun(campaign, tmp_path / "out")],
                slowly,
                scheduler=address,
                notify=lambda report: scheduler.kill(),
            )
        finally:
            scheduler.kill()
            worker.kill()
    states = [report.state for report in first]
    assert states.count("done") >= 1
    lost = [report for report in first if report.state != "done"]
    assert lost
    assert all("the Dask scheduler ended; start it and its workers and repeat" in report.sentence for report in lost)
    assert "Traceback" not in capfd.readouterr().err
    repeated: list[Any] = []
    run_campaigns([CampaignRun(campaign, tmp_path / "out")], slowly, workers=1, notify=repeated.append)
    assert [report.state for report in repeated].count("found") == states.count("done")
    assert len(list((tmp_path / "out").glob("*/stop.json"))) == 6


def test_cases_of_a_study_run_there_and_are_kept_here(two_workers, own_cache):
    for _ in range(2):
        with work("lateral", scheduler=two_workers.scheduler_address) as own:
            assert own.map(math.sqrt, [4.0, 9.0]) == [2.0, 3.0]
            made = own.run_count
    assert made == 0


def test_who_does_not_answer_and_workers_with_threads_are_refused(monkeypatch):
    monkeypatch.setattr("railgrip.campaign.workers._ANSWER", 1.0)
    with pytest.raises(InputError, match="no Dask scheduler answers there"), cluster("tcp://127.0.0.1:1"):
        pass
    with (
        LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=":0") as cluster_here,
        pytest.raises(InputError, match="a worker has 2 threads"),
        cluster(cluster_here.scheduler_address),
    ):
        pass


def test_a_scheduler_without_workers_is_told_of_and_not_waited_for_for_ever(project, tmp_path, monkeypatch, capfd):
    """The sentence comes once, the end after the limit, and the command may be repeated."""
    monkeypatch.setattr("railgrip.campaign.workers._ANSWER", 1.0)
    monkeypatch.setattr("railgrip.campaign.workers._WITHOUT_WORKERS", 3.0)
    (project / "few.toml").write_text(LINES, encoding="utf-8")
    campaign = load_campaign(project / "few.toml")
    with LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=":0") as cluster_here:
        address = cluster_here.scheduler_address
        begin = time.monotonic()
        with pytest.raises(RailgripError, match="has had no worker for 3 s; start some with `dask worker") as end:
            run_campaigns([CampaignRun(campaign, tmp_path / "out")], slowly, scheduler=address, notify=lambda _: None)
        # Longer than the limit, and far shorter than for ever: a busy machine may take its time.
        assert 3.0 < time.monotonic() - begin < 60.0
        assert end.value.exit_code == 3
        assert capfd.readouterr().err.count(f"--scheduler {address}: has no worker; waiting 3 s for one") == 1


def test_a_campaign_of_the_command_line_runs_on_the_cluster(project, two_workers, tmp_path, monkeypatch):
    monkeypatch.setattr("railgrip.cli.campaigns.runner", lambda import_from: slowly)
    monkeypatch.setattr("railgrip.campaign.workers.workers", None)  # no process may be started here
    (project / "few.toml").write_text(LINES, encoding="utf-8")
    arguments = ["campaign", str(project / "few.toml"), "--out", str(tmp_path / "out"), "--panels", "none"]
    with pytest.raises(SystemExit) as end:
        main([*arguments, "--scheduler", two_workers.scheduler_address])
    assert end.value.code == 0
    assert len(list((tmp_path / "out").glob("*/stop.json"))) == 6


@pytest.mark.parametrize("command", [["campaign", "table1"], ["study", "type_test"], ["study", "papers"]])
@pytest.mark.parametrize("address", ["foo", "tcp://foo", "foo:bar", "tcp://:8786"])
def test_a_text_that_is_not_an_address_is_refused_before_anything_runs(command, address, tmp_path, capfd):
    with pytest.raises(SystemExit) as end:
        main([*command, "--scheduler", address, "--out", str(tmp_path / "out")])
    assert end.value.code == InputError.exit_code
    assert f"--scheduler {address}: is not an address; write tcp://HOST:PORT" in capfd.readouterr().err
    assert not list(tmp_path.rglob("stop.json"))


def test_a_study_without_cases_refuses_a_cluster(tmp_path, capfd):
    with pytest.raises(SystemExit) as end:
        main(["study", "bench", "--scheduler", "tcp://127.0.0.1:8786", "--out", str(tmp_path / "out")])
    assert end.value.code == InputError.exit_code
    assert "study bench has no cases for a cluster" in capfd.readouterr().err
    assert not (tmp_path / "out").exists()
