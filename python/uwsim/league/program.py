"""A team's program: a process of its own, at the other end of a private pair of sockets, and its lines of JSON."""

from __future__ import annotations

import contextlib
import os
import pwd
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import orjson

from uwsim.base.atomic_file import write_atomically
from uwsim.base.texts.json_text import json_object

VARIABLE = "UWSIM_COURSE_FD"
"""The environment variable with the number of the program's socket. Nothing else leads to the simulator."""
KEPT = ("PATH", "HOME", "LANG", "LC_ALL", "TMPDIR", "TZ")
PATIENCE_S = 60.0
"""Longest wall time for one answer. A score does not depend on it, unless it is exceeded."""
LINE_BYTES, LOG_BYTES, TAIL_BYTES = 1 << 20, 1 << 20, 600


class ProgramError(Exception):
    """A team's program has ended, is silent, or has answered what it must not."""


class Program:
    """A running program. words: its command. log: the file that receives the end of what it prints, when it has ended.

    It prints into a pipe, and has no file of the referee's: the name of one would state the seed. user: another user of
    this machine as whom it runs, in that user's group and in no other, which takes root. Raises OSError or ValueError.
    """

    def __init__(self, words: Sequence[str], folder: Path, log: Path, user: str | None = None) -> None:
        self._log, self._left, self._said = log, b"", bytearray()
        own, its = socket.socketpair()
        self._socket = own
        own.settimeout(PATIENCE_S)
        kept = {name: value for name, value in os.environ.items() if name in KEPT}
        kept["PATH"] = os.pathsep.join((str(Path(sys.executable).parent), kept.get("PATH", os.defpath)))
        with its:
            environment = kept | {VARIABLE: str(its.fileno()), "PYTHONDONTWRITEBYTECODE": "1"}
            first = sys.executable if words[0] == "python3" else words[0]
            rights: dict[str, Any] = {}
            try:
                if user is not None:
                    rights = {"user": user, "group": pwd.getpwnam(user).pw_gid, "extra_groups": ()}
                self._process = subprocess.Popen(
                    [first, *words[1:]], cwd=folder, env=environment, pass_fds=[its.fileno()], **rights,
                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
                )  # fmt: skip
            except (OSError, ValueError, KeyError) as error:
                own.close()
                whose = "" if user is None else f" as user '{user}', who must be able to read it and its folders"
                raise OSError(f"program '{words[0]}': cannot be started{whose}: {error}") from error
        self._listener = threading.Thread(target=self._listen, args=(self._process.stdout,), daemon=True)
        self._listener.start()

    def _listen(self, pipe: Any) -> None:
        with pipe:
            while more := pipe.read1(1 << 16):
                self._said += more
                del self._said[:-LOG_BYTES]

    def send(self, values: Mapping[str, Any]) -> None:
        """Send a line. Raises ProgramError."""
        try:
            self._socket.sendall(orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY) + b"\n")
        except OSError:
            raise ProgramError(self._why("has ended")) from None

    def receive(self) -> dict[str, Any]:
        """Return the next line. Raises ProgramError."""
        while b"\n" not in self._left:
            try:
                more = self._socket.recv(1 << 16)
            except TimeoutError:
                raise ProgramError(self._why(f"has not answered within {PATIENCE_S:g} s")) from None
            except OSError:
                more = b""
            if not more:
                raise ProgramError(self._why("has ended"))
            self._left += more
            if len(self._left) > LINE_BYTES:
                raise ProgramError(f"the program has sent a line of more than {LINE_BYTES} bytes")
        line, _, self._left = self._left.partition(b"\n")
        try:
            return json_object(line, "the program's answer")
        except ValueError as error:
            raise ProgramError(str(error)) from None

    def _why(self, what: str) -> str:
        with contextlib.suppress(subprocess.TimeoutExpired):
            if self._process.poll() is None and what == "has ended":
                self._process.wait(2.0)
        if self._process.returncode is not None:
            self._listener.join(1.0)
        code, said = self._process.returncode, self._said[-TAIL_BYTES:].decode(errors="replace")
        last = " ".join(said.strip().splitlines()[-1:])
        return f"the program {what}{'' if code is None else f', with exit code {code}'}{f': {last}' if last else ''}"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """End it, and all processes that it has started in its session."""
        self._socket.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(1.0)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._listener.join(1.0)  # longer, if a process that it started lives on elsewhere
        write_atomically(self._log, bytes(self._said))
