"""Ctrl-C ends at once what has nothing to keep, and lets jobs end at their next pause."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from command_line import UWSIM, hears_ctrl_c
from uwsim.base.stoppable import stop_on_signals
from uwsim.campaigns.workers.job_progress import job_progress


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_has_nothing_to_keep_ends_at_once(number: signal.Signals) -> None:
    with (
        pytest.raises(KeyboardInterrupt),
        job_progress("frames") as progress,
        stop_on_signals(progress),
        progress.abandonable("flying"),
    ):
        os.kill(os.getpid(), number)
        time.sleep(10.0)


def test_the_line_of_an_interrupted_command_names_what_is_kept(tmp_path: Path) -> None:
    (tmp_path / "stay.py").write_text(
        "from uwsim.missions import wait\n\ndef mission(vehicle):\n    vehicle.undock()\n    yield wait(0.5)\n"
    )
    words = ["compare", "stay.py", "--scenario", "pool", "--seeds", "1000", "--voxel", "1", "--out", "out"]
    process = subprocess.Popen(
        [*UWSIM, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        preexec_fn=hears_ctrl_c,
    )
    assert "seed 0" in process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
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
        [sys.executable, "-c", code, "doctor"], capture_output=True, text=True, timeout=60, check=False
    )
    assert (ended.returncode, ended.stderr) == (130, "uwsim: interrupted\n")


def test_jobs_end_at_their_next_pause() -> None:
    with job_progress("frames") as progress, stop_on_signals(progress):
        with progress.abandonable("flying"):
            pass
        os.kill(os.getpid(), signal.SIGINT)
        assert progress.stop_requested()
