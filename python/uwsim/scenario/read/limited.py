"""Other people's readers of files in a process of their own, with limits: they read much, but may crash or hang."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path


def run_limited(script: Path, reader: str, *arguments: str, memory_bytes: int, cpu_s: int) -> bytes:
    """Return what a script of this folder prints; its last two arguments are the limits, which it sets itself.

    reader: the library that it uses, for messages. Raises ValueError with the reason if it failed.
    """
    command = [sys.executable, "-I", str(script), *arguments, str(memory_bytes), str(cpu_s)]
    ran = subprocess.run(command, capture_output=True, check=False, stdin=subprocess.DEVNULL)
    if ran.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        raise ValueError(f"{reader} had not read it after {cpu_s} s")
    if ran.returncode < 0:
        raise ValueError(f"{reader} crashed on it ({signal.Signals(-ran.returncode).name})")
    if ran.returncode:
        lines = ran.stderr.decode(errors="replace").strip().splitlines()
        raise ValueError(lines[-1] if lines else f"{reader} gave up")
    return ran.stdout
