"""Runs hostile command lines, each in a separate process with limits, and judges how they end.

The rules: a line ends by itself with a code of `uwsim.cli.exit_codes`; meaningless values are refused; a refusal takes
at most LIMIT_S and prints one line on stderr; no traceback, no signal, at most MEMORY_MB, and no half-written file.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import resource
import shutil
import signal
import sys
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from hostile.files import make
from hostile.lines import Line

LIMIT_S, LONG_S = 5.0, 60.0
"""Wall time in which a line is refused, and in which a working one ends, on a quiet machine."""
MEMORY_MB, ADDRESS_SPACE_BYTES = 2000.0, 8 << 30
WORKS_ON = frozenset({"validate", "reproduce", "fingerprint", "compare"})
"""Commands that run for minutes: like servers, they are stopped."""
TELL_MORE = frozenset({"sweep", "fleet", "doctor", "validate", "compare", "scenario check", "dataset"})
"""Commands that end with 1 after printing lines of findings."""
PRELOADED = ("cli.map", "mapping", "figures.style")
ALL_PRELOADED = (*PRELOADED, "flight.survey", "flight.fly", "recording", "bridges")


@dataclass(frozen=True)
class Verdict:
    """How a line ended. complaint: the rule that it broke, or ""."""

    line: Line
    code: int
    wall_s: float
    memory_mb: float
    stderr: str
    complaint: str


def preload(only: str) -> None:
    """Import the modules of the commands that begin with `only`, before the first attempt forks from this process."""
    for name in PRELOADED if only.startswith("map") else ALL_PRELOADED:
        importlib.import_module(f"uwsim.{name}")


def load_factor() -> float:
    """Return the slowdown against a quiet machine."""
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    while time.process_time() - cpu_s < 0.05:
        pass
    return max((time.perf_counter() - wall_s) / 0.05, 1.0)


def attempt(line: Line, template: Path, folder: Path, factor: float) -> Verdict:
    """Run a line in `folder`, which starts as a copy of `template` and is removed afterwards."""
    shutil.copytree(template, folder)
    if line.is_about_a_file:
        make(folder / line.value)
    began_s = time.monotonic()
    child = os.fork()
    if child == 0:
        _run(line, folder)
    code, memory_mb, hangs = _ended(child, line, folder, factor)
    wall_s = time.monotonic() - began_s
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # processes that it may have left running
    stderr = (folder / "stderr").read_text(errors="replace")
    complaint = "hangs" if hangs else _complaint(line, code, wall_s / factor, memory_mb, stderr, folder)
    shutil.rmtree(folder)
    return Verdict(line, code, wall_s, memory_mb, stderr, complaint)


def _run(line: Line, folder: Path) -> NoReturn:
    """Run `uwsim` with this line in the child process."""
    code = 1
    try:
        os.setpgid(0, 0)
        for name, mode, number in (("stdin", os.O_RDONLY, 0), ("stdout", os.O_WRONLY, 1), ("stderr", os.O_WRONLY, 2)):
            path = "/dev/null" if number == 0 else str(folder / name)
            os.dup2(os.open(path, mode | os.O_CREAT | os.O_TRUNC if number else mode, 0o600), number)
        os.chdir(folder)
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE_BYTES, ADDRESS_SPACE_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        sys.argv = ["uwsim", *line.words]
        from uwsim.cli import main

        main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.flush()
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.flush()
        os._exit(code)


def _ended(child: int, line: Line, folder: Path, factor: float) -> tuple[int, float, bool]:
    """Wait for the child, and stop it if it may run on.

    Return its code, its memory [MB] and whether it had to be killed.
    """
    runs_on = line.is_server or line.command in WORKS_ON
    told_at_s, kill_at_s = time.monotonic() + LIMIT_S * factor, time.monotonic() + LONG_S * factor
    told = False
    while True:
        ended, status, usage = os.wait4(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status), usage.ru_maxrss / 1e3, False
        now_s = time.monotonic()
        serves = line.is_server and (folder / "stdout").exists() and (folder / "stdout").stat().st_size > 0
        if runs_on and not told and (serves or now_s > told_at_s):
            os.kill(child, signal.SIGTERM)
            told = True
        if now_s > kill_at_s:
            os.killpg(child, signal.SIGKILL)
            _, status, usage = os.wait4(child, 0)
            return os.waitstatus_to_exitcode(status), usage.ru_maxrss / 1e3, True
        time.sleep(0.003)


def _complaint(line: Line, code: int, wall_s: float, memory_mb: float, stderr: str, folder: Path) -> str:
    from uwsim.cli.exit_codes import EXIT_CODES, FAILED, USAGE

    if code < 0:
        return f"ended by {signal.Signals(-code).name}"
    if "Traceback" in stderr:
        return "a traceback"
    if code not in EXIT_CODES:
        return f"exit code {code} is not documented"
    said = [text for text in stderr.splitlines() if text.strip() and not text.startswith("uwsim: warning:")]
    if code in (FAILED, USAGE) and line.command not in TELL_MORE:
        if len(said) != 1 or not said[0].startswith("uwsim: error:"):
            return f"{len(said)} lines on stderr instead of one"
        if wall_s > LIMIT_S:
            return f"was refused after {wall_s:.1f} s"
    if "No such option" in stderr:
        return "attacks nothing"
    if line.is_nonsense and code not in (FAILED, USAGE):
        return "was accepted"
    if memory_mb > MEMORY_MB:
        return f"took {memory_mb:.0f} MB"
    if left := [path.name for path in folder.rglob(".*") if path.name != ".uwsim.lock"]:
        return f"left {left[0]} behind"
    return ""
