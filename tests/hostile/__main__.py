"""Attack every command of `uwsim` with hostile values, and report the lines that broke a rule; see tools/hostile.

Each line runs in a process with limits. The rules: it ends by itself with a code of `uwsim.cli.exit_codes`; meaningless
values are refused; a refusal takes at most LIMIT_S and prints one line on stderr; no traceback, no signal, at most
MEMORY_MB, and no half-written file. Not as root, which can write to folders that must be read-only here.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import random
import resource
import shlex
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path
from typing import Annotated, NamedTuple, NoReturn

import typer

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a process with threads must not fork

from tests.hostile.lines import FILES, Line, lines, prepare

LIMIT_S, LONG_S = 5.0, 60.0
"""Wall time in which a line is refused, and in which a working one ends, on a quiet machine."""
MEMORY_MB, ADDRESS_SPACE_BYTES = 2000.0, 8 << 30
WORKS_ON = frozenset({"validate", "reproduce", "scenario fingerprint", "compare"})
"""Commands that run for minutes: like servers, they are stopped."""
WITH_FINDINGS = frozenset({"sweep", "fleet", "ros doctor", "validate", "compare", "scenario check", "dataset"})
"""Commands that end with 1 after printing lines of findings."""
PRELOADED = ("cli.map", "mapping", "figures.style")
ALL_PRELOADED = (*PRELOADED, "flight.survey", "flight.fly", "recording", "bridges")


class Verdict(NamedTuple):
    """How a line ended. complaint: the rule that it broke, or ""."""

    line: Line
    code: int
    wall_s: float
    memory_mb: float
    stderr: str
    complaint: str


def main(
    only: Annotated[str, typer.Option(help="Only commands that begin with this, such as map.")] = "",
    sample: Annotated[int, typer.Option(min=0, help="The number of lines, chosen by the seed; 0: all.")] = 0,
    seed: Annotated[int, typer.Option(help="The seed of the choice.")] = 0,
    part: Annotated[str, typer.Option(help="K/N: the Kth of N parts, from 0, for several processes.")] = "0/1",
    files: Annotated[bool, typer.Option("--files", help="Only the lines that name a hostile file.")] = False,
    each: Annotated[bool, typer.Option("--each", help="Report how every line ended.")] = False,
) -> None:
    """Attack, judge and count."""
    preload(only)
    chosen = [line for line in lines() if line.command.startswith(only)]
    chosen = [line for line in chosen if line.is_about_a_file or not files]
    if sample:
        chosen = random.Random(seed).sample(chosen, min(sample, len(chosen)))
    k, n = map(int, part.split("/"))
    chosen = chosen[k::n]
    codes: Counter[int] = Counter()
    broken: list[Verdict] = []
    began_s = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="uwsim-hostile-") as folder:
        template = Path(folder) / "template"
        template.mkdir()
        prepare(template)
        for number, line in enumerate(chosen):
            verdict = attempt(line, template, Path(folder) / "run", load_factor())
            codes[verdict.code] += 1
            if verdict.complaint:
                broken.append(verdict)
            if verdict.complaint or each:
                show(verdict)
            elif number % 100 == 99:
                typer.echo(f"{number + 1} of {len(chosen)} lines, {time.monotonic() - began_s:.0f} s", err=True)
    by_code = ", ".join(f"{count} with {code}" for code, count in sorted(codes.items()))
    typer.echo(f"{len(chosen)} lines, {len(broken)} broke the law; they ended {by_code}")
    raise typer.Exit(1 if broken else 0)


def show(verdict: Verdict) -> None:
    words = (word if len(word) < 80 else word[:40] + "..." for word in verdict.line.words)
    typer.echo(f"uwsim {shlex.join(words).encode(errors='replace').decode()}")
    broken = f", BROKE THE LAW: {verdict.complaint}" if verdict.complaint else ""
    typer.echo(f"    ended with {verdict.code}{broken} ({verdict.wall_s:.1f} s, {verdict.memory_mb:.0f} MB)")
    for text in verdict.stderr.strip().splitlines()[-3:]:
        typer.echo(f"    | {text[:200]}")


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
        FILES[Path(line.value).stem](folder / line.value)
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
    stop_at_s, kill_at_s = time.monotonic() + LIMIT_S * factor, time.monotonic() + LONG_S * factor
    is_stopped = False
    while True:
        ended, status, usage = os.wait4(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status), usage.ru_maxrss / 1e3, False
        now_s = time.monotonic()
        serves = line.is_server and (folder / "stdout").exists() and (folder / "stdout").stat().st_size > 0
        if runs_on and not is_stopped and (serves or now_s > stop_at_s):
            os.kill(child, signal.SIGTERM)
            is_stopped = True
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
    if code in (FAILED, USAGE) and line.command not in WITH_FINDINGS:
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


if __name__ == "__main__":
    typer.run(main)
