"""Run the `uwsim` command in this process, which avoids repeated imports, or in a separate one, as a user would."""

import contextlib
import functools
import io
import json
import logging
import os
import resource
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from unittest import mock

import typer

from uwsim.cli import main

UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]
BLANK = [
    sys.executable,
    "-c",
    "from uwsim.figures import style; style._fit = lambda figure, canvas: figure.clear()\n"
    "from uwsim.figures import truth_and_map; truth_and_map.PANEL_PIXELS = 160\n"
    "from uwsim.cli import main; main()",
]
"""The command with blank figures, which otherwise take most of a short survey's time."""
get_command_once = functools.cache(typer.main.get_command)
"""Typer rebuilds the whole command tree on each call, which takes longer than running most commands."""


def uwsim(*arguments: str | Path, cwd: str | Path = ".") -> subprocess.CompletedProcess[str]:
    """Run the command to completion in this process."""
    words = [str(word) for word in arguments]
    out, err = (io.TextIOWrapper(io.BytesIO(), write_through=True) for _ in range(2))
    with left_as_found(), contextlib.chdir(cwd), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            with mock.patch.object(sys, "argv", ["uwsim", *words]):
                main()
        except SystemExit as ended:
            code = ended.code
    texts = [stream.buffer.getvalue().decode() for stream in (out, err)]
    return subprocess.CompletedProcess(words, code, *texts)


@contextlib.contextmanager
def left_as_found() -> Iterator[None]:
    """Restore the process-wide state that a command changes, and route log messages to stderr instead of pytest."""
    signals = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    try:
        with (
            Path(os.devnull).open() as nothing,
            warnings.catch_warnings(),
            mock.patch.object(logging.root, "handlers", []),
            mock.patch.dict(os.environ),
            mock.patch.object(sys, "path", list(sys.path)),
            mock.patch.object(sys, "stdin", nothing),
            mock.patch.object(typer.main, "get_command", get_command_once),
        ):
            yield
    finally:
        for number, handler in signals.items():
            signal.signal(number, handler)


def uwsim_process(
    *arguments: str, command: Sequence[str] = UWSIM, **options: object
) -> subprocess.CompletedProcess[str]:
    """Run the command to completion in a separate process. options: arguments of subprocess.run."""
    return subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=600, check=False, **options)


SEVERAL = """
import json, sys
from command_line import uwsim
for words in json.loads(sys.argv[1]):
    done = uwsim(*words)
    print(json.dumps([words, done.returncode, done.stdout, done.stderr]))
"""


def uwsim_in_another_process(
    *commands: Sequence[str | Path], env: Mapping[str, str]
) -> list[subprocess.CompletedProcess[str]]:
    """Run commands to completion, one after the other, in one separate process with this environment."""
    folders = os.pathsep.join([*filter(None, [env.get("PYTHONPATH")]), str(Path(__file__).parent)])
    lists = json.dumps([[str(word) for word in words] for words in commands])
    done = subprocess.run(
        [sys.executable, "-c", SEVERAL, lists], env={**env, "PYTHONPATH": folders}, stdout=subprocess.PIPE, text=True,
        timeout=600, check=True,
    )  # fmt: skip
    return [subprocess.CompletedProcess(*json.loads(line)) for line in done.stdout.splitlines()]


def error_line(result: subprocess.CompletedProcess[str]) -> str:
    """Return the single stderr line of a failed command."""
    assert result.returncode != 0
    assert "Traceback" not in result.stderr
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    return lines[0]


def start_survey(out: Path, *options: str) -> subprocess.Popen[str]:
    """Start a survey with 20 autosaves per second."""
    command = [*UWSIM, "survey", *options, "--out", str(out), "--autosave", "0.05"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a running process has created a file."""
    while not path.exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def hears_ctrl_c() -> None:
    """Restore the default SIGINT handler (for use as preexec_fn): background jobs inherit an ignored SIGINT."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def files_limited_to(size_bytes: int) -> Callable[[], None]:
    """Return a preexec_fn that limits the file size, so that writes beyond it fail as on a full disk.

    The process writes no bytecode: Python would keep truncated files of it, which all others would fail to import.
    """

    def limit() -> None:
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, size_bytes))

    return limit
