"""Others' readers run contained: they reach what they were given, whatever a file makes them do."""

import warnings
from pathlib import Path

import pytest

from uwsim.scenario.read import contained

SCRIPT = """
import ctypes, os, resource, signal, socket, subprocess, sys, tempfile, threading, time
def read(words, given, other):
    return {'answer': repr(eval(words))}
"""


def run(folder: Path, words: str, cpu_s: int = 2) -> str:
    for name, text in (("script.py", SCRIPT), ("given", "ours"), ("other", "secret")):
        (folder / name).write_text(text)
    given, other = folder / "given", folder / "other"
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of a kernel without Landlock or seccomp, which the tests need
        script, paths = folder / "script.py", (str(given), str(other))
        return str(contained.run_contained(script, "it", words, *paths, reads=[given], cpu_s=cpu_s)["answer"])


@pytest.mark.parametrize(
    "words, answer",
    [
        ("open(given).read()", "'ours'"),
        ("open(tempfile.mkstemp()[1], 'w').write('x')", "1"),
        ("threading.Thread(target=print).start()", "None"),
        ("os.environ.get('HOME'), os.environ.get('PATH')", "(None, None)"),
        ("__import__('scipy.spatial').__name__", "'scipy'"),
    ],
)
def test_a_reader_has_what_it_needs(words: str, answer: str, tmp_path: Path) -> None:
    assert run(tmp_path, words) == answer


@pytest.mark.parametrize(
    "words",
    [
        "open(other).read()",
        "open(given, 'w')",
        "open(other + '2', 'w')",
        "os.listdir(os.path.dirname(other))",
        "os.chmod(given, 0o777)",
        "open(f'/proc/{os.getppid()}/environ').read()",
        "open('/dev/ptmx')",
        "subprocess.check_output('true')",
        "os.execv('/bin/true', ['true'])",
        "os.execve(os.memfd_create('x'), ['x'], {})",
        "os.fork()",
        "os.kill(os.getppid(), 0)",
        "socket.socket()",
        "socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)",
        "socket.socket(socket.AF_INET, socket.SOCK_DGRAM)",
        "resource.setrlimit(resource.RLIMIT_CPU, (100, 100))",
    ],
)
def test_a_reader_reaches_nothing_else(words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"Permission denied|not permitted|not allowed"):
        run(tmp_path, words)


@pytest.mark.parametrize(
    "words, rule",
    [
        ("bytes(10**9)", r"takes more than 0\.2 GB"),
        ("[None for _ in iter(int, 1)]", r"takes more than 0\.2 GB|had not read it after 1 s"),
        ("open(tempfile.mkstemp()[1], 'r+b').truncate(10**9)", "File too large"),
        ("time.sleep(1000)", "had not read it after 2 s"),
        ("[None for _ in iter(str, 1) if 0]", "had not read it after 1 s"),
        ("os.kill(os.getpid(), signal.SIGKILL)", "was killed while it read it: this machine has too little memory"),
        ("os.abort()", r"crashed on it \(SIGABRT\)"),
    ],
)
def test_memory_time_and_files_are_bounded(
    words: str, rule: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if "sleep" in words:  # else processor time alone ends it, at any load
        monkeypatch.setattr(contained, "WALL_PER_CPU_S", 2)
    monkeypatch.setattr(contained, "MEMORY_BYTES", 200_000_000)
    with pytest.raises(ValueError, match=rule):
        run(tmp_path, words, cpu_s=1)
