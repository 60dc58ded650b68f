"""Dask workers: job results, worker deaths and retries, and sweeps that are interrupted or killed."""

import os
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import psutil
import pytest

from command_line import UWSIM
from uwsim.base.folder_lock import LOCK
from uwsim.campaigns.sweeps import run_sweep
from uwsim.campaigns.sweeps.table import TABLE
from uwsim.campaigns.workers import Workers, dask_workers, open_workers
from uwsim.campaigns.workers.dask_workers import SCRATCH, scratch_folder
from uwsim.campaigns.workers.ledger import LEDGER
from worker_jobs import die_at_three, double, fail_at_first, tell_and_take_long

SLOW = """
import time
from uwsim.missions import wait

def mission(vehicle, effort=0.1):
    time.sleep(0.3)
    yield wait(0.1)
    return effort
"""


@pytest.fixture(scope="module")
def crew() -> Iterator[Workers]:
    with open_workers(2) as workers:
        yield workers


def work(crew: Workers, function, jobs: dict, retries: int = 1) -> dict:
    done = crew.finished(function, jobs, retries=retries, stop_requested=lambda: False)
    return {each.job: each for each in done}


def test_every_job_is_done_once(crew: Workers) -> None:
    done = work(crew, double, {k: k for k in range(50)})
    assert {k: each.result for k, each in done.items()} == {k: {"value": 2 * k} for k in range(50)}


def test_a_job_that_kills_its_worker_is_given_up_and_the_others_are_done(crew: Workers) -> None:
    done = work(crew, die_at_three, {k: k for k in range(8)})
    assert done.pop(3).result is None
    assert {k: each.result for k, each in done.items()} == {k: {"value": k} for k in range(8) if k != 3}


def test_what_may_go_away_is_tried_again(crew: Workers, tmp_path: Path) -> None:
    done = work(crew, fail_at_first, {0: str(tmp_path / "flag")})
    assert (done[0].result, done[0].trials) == ({"value": 1}, 2)


@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGTERM, signal.SIGINT], ids=lambda number: number.name)
def test_a_worker_that_gets_a_signal_costs_no_job(crew: Workers, tmp_path: Path, number: signal.Signals) -> None:
    told = tmp_path / "pid"

    def disturb() -> None:
        while not told.exists() or not told.read_text():
            time.sleep(0.01)
        os.kill(int(told.read_text()), number)

    disturber = threading.Thread(target=disturb)
    disturber.start()
    done = work(crew, tell_and_take_long, {k: (k, str(told)) for k in range(6)})
    disturber.join()
    assert {k: each.result for k, each in done.items()} == {k: {"value": k} for k in range(6)}
    died = number != signal.SIGINT  # sent to the whole group; workers leave SIGINT to the main process
    assert done[0].trials == 1 + died


def test_workers_listen_on_this_machine_alone(crew: Workers) -> None:
    own = psutil.Process()
    found = [
        c.laddr.ip
        for process in (own, *own.children(recursive=True))
        for c in process.net_connections("tcp")
        if c.status == psutil.CONN_LISTEN
    ]
    assert found and set(found) == {"127.0.0.1"}


def slow_sweep(folder: Path) -> tuple[Path, Path]:
    (folder / "slow.py").write_text(SLOW)
    path = folder / "sweep.yaml"
    path.write_text("scenario: pool\nmission: slow.py\nvary: {mission.effort: {low: 0, high: 1, steps: 8}}\n")
    return path, folder / "out"


def begun(path: Path, out: Path) -> subprocess.Popen:
    """Start a sweep in its own session and wait until its first runs are finished."""
    command = [*UWSIM, "sweep", str(path), "--out", str(out), "--workers", "1", "--no-report"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    ledger = out / LEDGER
    while not ledger.exists() or ledger.read_bytes().count(b"\n") < 3:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    return process


def in_session(session: int) -> list[psutil.Process]:
    found = []
    for process in psutil.process_iter():
        try:
            if os.getsid(process.pid) == session and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
        except (OSError, psutil.Error):
            continue
    return found


def test_ctrl_c_ends_cleanly_and_resumes(tmp_path: Path) -> None:
    path, out = slow_sweep(tmp_path)
    process = begun(path, out)
    os.killpg(process.pid, signal.SIGINT)  # like a terminal: to the whole process group
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert "--resume continues" in said and "Traceback" not in said
    assert 2 <= len(pd.read_parquet(out / TABLE)) < 8
    assert run_sweep(path, out, workers=0, resume=True, report=False).failed == 0
    assert pd.read_parquet(out / TABLE)["run"].tolist() == list(range(8))


def test_a_sweep_that_is_killed_resumes_and_leaves_no_processes(tmp_path: Path) -> None:
    path, out = slow_sweep(tmp_path)
    process = begun(path, out)
    process.kill()
    process.communicate(timeout=60)
    end = time.monotonic() + 60
    while in_session(process.pid) and time.monotonic() < end:
        time.sleep(0.1)
    assert in_session(process.pid) == []
    assert not run_sweep(path, out, workers=0, resume=True, report=False).interrupted
    assert pd.read_parquet(out / TABLE)["result"].notna().sum() == 8


def test_what_killed_clusters_left_is_removed_at_the_next_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    killed = tmp_path / f"{SCRATCH}killed"
    killed.mkdir()
    (killed / LOCK).touch()
    with scratch_folder() as living, scratch_folder():
        assert Path(living).is_dir() and not killed.exists()
    assert not list(tmp_path.iterdir())


def test_ctrl_c_while_workers_start_prints_no_traceback(tmp_path: Path) -> None:
    """It comes to all processes, as from a terminal, while those of the workers are imported."""
    path, out = slow_sweep(tmp_path)
    process = subprocess.Popen(
        [*UWSIM, "sweep", str(path), "--out", str(out), "--workers", "2", "--no-report"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    while sum("spawn_main" in " ".join(each.cmdline()) for each in psutil.Process(process.pid).children()) < 2:
        assert process.poll() is None, process.communicate()
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "Traceback" not in errors and "KeyboardInterrupt" not in errors and "interrupted" in errors


def test_workers_that_are_gone_for_good_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if each died while it was restarted, which Dask does not try twice."""
    monkeypatch.setattr(dask_workers, "PROCESSLESS_S", 0.5)
    with open_workers(1) as crew:
        (nanny,) = crew._own.workers.values()
        nanny.auto_restart = False
        monkeypatch.setattr(type(nanny), "_on_worker_exit", gone)
        with pytest.raises(OSError, match="all workers have died"):
            work(crew, die_at_three, {3: 3})


async def gone(nanny: object, code: int) -> None:
    """In place of a restart."""
