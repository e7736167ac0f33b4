"""Stops on a Dask cluster: another worker repeats the work of a lost one, and results are collected in one place."""

import math
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

# `make install` puts Dask here: next to the environment, not into it.
sys.path.append(str(Path(sys.prefix) / "cluster"))

import dask
from command_line import exit_code
from distributed import Client, LocalCluster
from distributed.utils import json_load_robust
from one_process import Here
from synthetic_runner import run_stop
from waiting import LONGEST, until

from railgrip.base.errors import InputError, RailgripError
from railgrip.campaign.run import CampaignRun, run_campaigns
from railgrip.campaign.work import work
from railgrip.campaign.workers import cluster, collect
from railgrip.report.stop import read_stop
from railgrip.scenario.campaign import load_campaign

LINES = """
name = "few"
scenarios = ["wet.toml"]
[sweep]
seed = [1, 2, 3, 4, 5, 6]
"""


def slowly(scenario, progress=None, notify=lambda sentence: None):
    """Run the stop of `synthetic_runner` after a delay in which its worker may be killed."""
    time.sleep(0.5)
    return run_stop(scenario)


def first_alone(scenario, progress=None, notify=lambda sentence: None):
    """Run the first stop at once; others wait in the folder until the scheduler has been killed."""
    folder = Path(os.environ["FIRST_ALONE"])
    try:
        (folder / "first").touch(exist_ok=False)
    except FileExistsError:
        until((folder / "killed").exists)
    return run_stop(scenario)


@pytest.fixture(autouse=True, scope="module")
def _patience():
    """Wait long for connections: on a busy machine a new worker imports its modules for a minute."""
    with dask.config.set({"distributed.comm.timeouts.connect": "300s", "distributed.scheduler.worker-ttl": None}):
        yield


@pytest.fixture(scope="module")
def two_workers(_patience):
    """A cluster that replaces a killed worker."""
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster_here:
        yield cluster_here


@pytest.fixture
def few(project):
    """The file of a campaign of six stops."""
    (project / "few.toml").write_text(LINES, encoding="utf-8")
    return project / "few.toml"


@pytest.fixture
def campaign(few):
    return load_campaign(few)


def test_a_killed_worker_loses_no_results(campaign, two_workers, tmp_path, monkeypatch):
    monkeypatch.setattr("railgrip.campaign.workers._ANSWER", LONGEST)
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
    assert {report.state for report in repeats} == {"found"}  # so no scheduler was contacted


def test_a_stop_of_a_cluster_is_written_here_and_a_task_given_up_says_what_to_do(campaign, tmp_path, monkeypatch):
    """The cluster is replaced by this process; further tests have a real one."""
    monkeypatch.setattr("railgrip.campaign.workers.cluster", lambda scheduler: nullcontext((Here(), lambda: None)))
    runs, said = [CampaignRun(campaign, tmp_path / "out")], []
    (reports,) = run_campaigns(runs, run_stop, scheduler="tcp://nobody:1", notify=said.append)
    assert len(said) == len(reports)
    assert [report.state for report in reports] == ["done"] * 6
    for stop in campaign.stops:
        assert read_stop(tmp_path / "out" / stop.name).digest == stop.scenario.digest()
    lost = Future()
    lost.cancel()
    lost.set_running_or_notify_cancel()
    ((task, error),) = collect({lost: "a stop"})
    assert task == "a stop"
    assert str(error).startswith("the Dask scheduler ended; start it and its workers and repeat the command")


@pytest.mark.usefixtures("in_process")
def test_a_killed_scheduler_loses_no_results(campaign, tmp_path, monkeypatch, capfd):
    """Finished stops are kept, the others are reported in one sentence, and the next run executes only these."""
    monkeypatch.setattr("railgrip.campaign.workers._ANSWER", LONGEST)
    monkeypatch.setenv("FIRST_ALONE", str(tmp_path))
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    at = ["--scheduler-file", str(tmp_path / "scheduler.json"), "--no-dashboard"]
    here = [sys.executable, "-m", "dask", "scheduler", "--host", "127.0.0.1", "--port", "0", *at]
    there = [sys.executable, "-m", "dask", "worker", "--nthreads", "1", "--no-nanny", *at]

    def kill(report):
        scheduler.kill()
        (tmp_path / "killed").touch()

    quiet = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(here, **quiet) as scheduler, subprocess.Popen(there, **quiet) as worker:
        try:
            (first,) = run_campaigns(
                [CampaignRun(campaign, tmp_path / "out")],
                first_alone,
                scheduler=json_load_robust(tmp_path / "scheduler.json")["address"],
                notify=kill,
            )
        finally:
            scheduler.kill()
            worker.kill()
    states = [report.state for report in first]
    assert states.count("done") == 1
    assert all(
        "the Dask scheduler ended; start it and its workers and repeat" in report.sentence
        for report in first
        if report.state != "done"
    )
    assert "Traceback" not in capfd.readouterr().err
    repeated: list[Any] = []
    run_campaigns([CampaignRun(campaign, tmp_path / "out")], first_alone, workers=1, notify=repeated.append)
    assert [report.state for report in repeated].count("found") == 1
    assert len(list((tmp_path / "out").glob("*/stop.json"))) == 6


def test_cases_of_a_study_run_on_the_cluster_and_are_kept_locally(two_workers, own_cache):
    for _ in range(2):
        with work("etcs", scheduler=two_workers.scheduler_address) as own:
            assert own.map(math.sqrt, [4.0, 9.0]) == [2.0, 3.0]
            run_count = own.run_count
    assert run_count == 0


def test_a_silent_scheduler_and_multithreaded_workers_are_refused(monkeypatch):
    monkeypatch.setattr("railgrip.campaign.workers._ANSWER", 1.0)
    with pytest.raises(InputError, match="no Dask scheduler answers there"), cluster("tcp://127.0.0.1:1"):
        pass
    monkeypatch.setattr("railgrip.campaign.workers._ANSWER", LONGEST)
    with (
        LocalCluster(
            n_workers=1, threads_per_worker=2, processes=False, protocol="tcp", dashboard_address=":0"
        ) as cluster_here,
        pytest.raises(InputError, match="a worker has 2 threads"),
        cluster(cluster_here.scheduler_address),
    ):
        pass


def test_a_scheduler_without_workers_is_reported_and_the_wait_is_limited(campaign, tmp_path, monkeypatch, capfd):
    """The warning is printed once, the command ends after the limit, and it can be repeated."""
    # The warning comes at once, but connecting may take its time.
    monkeypatch.setattr("railgrip.campaign.workers._ANSWER", 0.0)
    monkeypatch.setattr(
        "distributed.Client", lambda *place, **options: Client(*place, **options | {"timeout": LONGEST})
    )
    monkeypatch.setattr("railgrip.campaign.workers._WITHOUT_WORKERS", 3.0)
    with LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=":0") as cluster_here:
        address = cluster_here.scheduler_address
        begin = time.monotonic()
        with pytest.raises(RailgripError, match="has had no worker for 3 s; start some with `dask worker") as end:
            run_campaigns([CampaignRun(campaign, tmp_path / "out")], slowly, scheduler=address, notify=lambda _: None)
        assert time.monotonic() - begin > 3.0
        assert end.value.exit_code == 3
        assert capfd.readouterr().err.count(f"--scheduler {address}: has no worker; waiting 3 s for one") == 1


def test_a_campaign_of_the_command_line_runs_on_the_cluster(few, two_workers, tmp_path, monkeypatch):
    monkeypatch.setattr("railgrip.cli.campaigns.runner", lambda import_from: slowly)
    monkeypatch.setattr("railgrip.campaign.workers.workers", None)  # no local process may be started
    arguments = ["campaign", few, "--out", tmp_path / "out", "--panels", "none"]
    assert exit_code(*arguments, "--scheduler", two_workers.scheduler_address) == 0
    assert len(list((tmp_path / "out").glob("*/stop.json"))) == 6


@pytest.mark.parametrize("command", [["campaign", "table1"], ["study", "type_test"], ["study", "estimators"]])
@pytest.mark.parametrize("address", ["foo", "tcp://foo", "foo:bar", "tcp://:8786"])
def test_a_text_that_is_not_an_address_is_refused_before_anything_runs(command, address, tmp_path, capfd):
    assert exit_code(*command, "--scheduler", address, "--out", tmp_path / "out") == InputError.exit_code
    assert f"--scheduler {address}: is not an address; write tcp://HOST:PORT" in capfd.readouterr().err
    assert not list(tmp_path.rglob("stop.json"))


def test_a_study_without_cases_refuses_a_cluster(tmp_path, capfd):
    command = ("study", "bench", "--scheduler", "tcp://127.0.0.1:8786", "--out", tmp_path / "out")
    assert exit_code(*command) == InputError.exit_code
    assert "study bench has no cases for a cluster" in capfd.readouterr().err
    assert not (tmp_path / "out").exists()
