"""The `uwsim` command run as a process of its own, as a user runs it."""

import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]


def uwsim(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    """Run the command to its end. options: of subprocess.run."""
    return subprocess.run([*UWSIM, *arguments], capture_output=True, text=True, timeout=600, check=False, **options)


def error_line(result: subprocess.CompletedProcess[str]) -> str:
    """Return the only line on stderr of a command that failed."""
    assert result.returncode != 0
    assert "Traceback" not in result.stderr
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    return lines[0]


def start_survey(out: Path, *options: str) -> subprocess.Popen[str]:
    """Start a survey that is saved 20 times a second."""
    command = [*UWSIM, "survey", *options, "--out", str(out), "--autosave", "0.05"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a running process has made a file."""
    while not path.exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def hears_ctrl_c() -> None:
    """Undo, as a preexec_fn, what who started the tests may have done: a job in the background ignores Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def files_limited_to(size_bytes: int) -> Callable[[], None]:
    """Return a preexec_fn that makes writing beyond a size fail, as a full disk does."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, size_bytes))

    return limit
