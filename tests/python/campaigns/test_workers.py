"""Workers: results, deaths and retries; signals, which end at once what has nothing to keep, and jobs at a pause."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import distributed
import pandas as pd
import psutil
import pytest

from command_line import UWSIM, hears_ctrl_c
from uwsim.base.folder_lock import LOCK
from uwsim.campaigns.sweeps import run_sweep
from uwsim.campaigns.sweeps.table import TABLE
from uwsim.campaigns.workers import Workers, dask_workers, open_workers
from uwsim.campaigns.workers.dask_workers import SCRATCH, scratch_folder
from uwsim.campaigns.workers.job_progress import job_progress
from uwsim.campaigns.workers.ledger import LEDGER
from waiting import until
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
        pid = until(lambda: told.exists() and told.read_text(), "the job", limit_s=300.0)
        os.kill(int(pid), number)

    disturber = threading.Thread(target=disturb)
    disturber.start()
    done = work(crew, tell_and_take_long, {k: (k, str(told)) for k in range(6)})
    disturber.join()
    assert {k: each.result for k, each in done.items()} == {k: {"value": k} for k in range(6)}
    died = number != signal.SIGINT  # sent to the whole group; workers leave SIGINT to the main process
    assert done[0].trials == 1 + died


def test_no_other_client_is_admitted(crew: Any) -> None:
    """It could run programs as this user: only this process has the certificate."""
    for address in (crew._client.scheduler.address, *crew._client.scheduler_info()["workers"]):
        with pytest.raises((OSError, TypeError)):
            distributed.Client(address.replace("tls://", "tcp://"), timeout=2, set_as_default=False)


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


def started(*words: str | Path, cwd: Path | None = None) -> subprocess.Popen:
    """Start a command in a session of its own, which Ctrl-C reaches."""
    return subprocess.Popen(
        [*UWSIM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=hears_ctrl_c, cwd=cwd,
    )  # fmt: skip


def begun(path: Path, out: Path) -> subprocess.Popen:
    """Start a sweep and wait until its first runs are finished."""
    process, ledger = started("sweep", path, "--out", out, "--workers", "1", "--no-report"), out / LEDGER
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
    _, said = process.communicate(timeout=300)
    assert process.returncode == 130, said
    assert "--resume continues" in said and "Traceback" not in said
    assert 2 <= len(pd.read_parquet(out / TABLE)) < 8
    assert run_sweep(path, out, workers=0, resume=True, report=False).failed == 0
    assert pd.read_parquet(out / TABLE)["run"].tolist() == list(range(8))


def test_a_sweep_that_is_killed_resumes_and_leaves_no_processes(tmp_path: Path) -> None:
    path, out = slow_sweep(tmp_path)
    process = begun(path, out)
    process.kill()
    process.communicate(timeout=300)
    until(lambda: not in_session(process.pid), "the end of its workers", limit_s=300.0)
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
    """It comes to all processes, as from a terminal, while that of the worker is imported."""
    path, out = slow_sweep(tmp_path)
    process = started("sweep", path, "--out", out, "--workers", "1", "--no-report")
    while not any("spawn_main" in " ".join(each.cmdline()) for each in psutil.Process(process.pid).children()):
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_has_nothing_to_keep_ends_at_once(number: signal.Signals) -> None:
    with (
        pytest.raises(KeyboardInterrupt),
        job_progress("frames") as progress,
        progress.abandonable("flying"),
    ):
        os.kill(os.getpid(), number)
        time.sleep(10.0)


def test_the_line_of_an_interrupted_command_names_what_is_kept(tmp_path: Path) -> None:
    (tmp_path / "stay.py").write_text(
        "from uwsim.missions import wait\n\ndef mission(vehicle):\n    vehicle.undock()\n    yield wait(0.5)\n"
    )
    words = ["compare", "stay.py", "--scenario", "pool", "--seeds", "1000", "--voxel", "1", "--out", "out"]
    process = started(*words, cwd=tmp_path)
    assert "seed 0" in process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 130
    assert errors.splitlines()[-1] == "uwsim: interrupted; finished flights are kept: --resume flies the rest"


def test_an_interruption_that_a_command_leaves_to_the_program_is_one_line() -> None:
    code = (
        "import typer; from uwsim.cli import main, program\n"
        "def raises(): raise KeyboardInterrupt\n"
        "command = typer.main.get_command(typer.Typer(callback=raises, invoke_without_command=True))\n"
        "program.Program.get_command = lambda *_: command\n"
        "main()"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, "bench"], capture_output=True, text=True, timeout=300, check=False
    )
    assert (ended.returncode, ended.stderr) == (130, "uwsim: interrupted\n")


def test_jobs_end_at_their_next_pause() -> None:
    with job_progress("frames") as progress:
        with progress.abandonable("flying"):
            pass
        os.kill(os.getpid(), signal.SIGINT)
        assert progress.stop_requested()
