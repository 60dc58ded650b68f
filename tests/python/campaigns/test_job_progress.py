"""Ctrl-C ends at once what has nothing to keep, and lets jobs end at their next pause."""

import os
import signal
import time

import pytest

from uwsim.base.stoppable import stop_on_signals
from uwsim.campaigns.workers.job_progress import job_progress


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_has_nothing_to_keep_ends_at_once(number: signal.Signals, capfd: pytest.CaptureFixture[str]) -> None:
    with (
        pytest.raises(KeyboardInterrupt),
        job_progress("frames") as progress,
        stop_on_signals(progress),
        progress.abandonable("flying"),
    ):
        os.kill(os.getpid(), number)
        time.sleep(10.0)
    assert "interrupted\n" in capfd.readouterr().err


def test_jobs_end_at_their_next_pause() -> None:
    with job_progress("frames") as progress, stop_on_signals(progress):
        with progress.abandonable("flying"):
            pass
        os.kill(os.getpid(), signal.SIGINT)
        assert progress.stop_requested()
