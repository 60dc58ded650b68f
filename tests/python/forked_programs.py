"""`uwsim` as processes of their own, without its second of imports: they are forked from one process that has them."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

PATIENCE_S = 180.0
REQUEST_BYTES = 1 << 20


class Program:
    """A command that runs. pid: its process; stdout, stderr: its output, as text."""

    def __init__(self, programs: "Programs", words: list[str], env: Mapping[str, str]) -> None:
        self._programs = programs
        (out, out_end), (err, err_end) = os.pipe(), os.pipe()
        self.stdout, self.stderr = open(out), open(err)  # noqa: PTH123, SIM115  # closed by `end`
        self.pid = programs.ask({"words": words, "env": dict(env)}, out_end, err_end)
        os.close(out_end)
        os.close(err_end)

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """Send it a signal; return its exit code, negative if a signal ended it, and the rest of its stderr."""
        with self.stdout, self.stderr:
            os.kill(self.pid, number)
            return self._programs.ask({"wait": self.pid}), self.stderr.read()


class Programs:
    """The process that has the imports, and those that are forked from it. It starts with the first of them."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def _start(self) -> subprocess.Popen[str]:
        self._socket, theirs = socket.socketpair(type=socket.SOCK_SEQPACKET)
        with theirs:
            command = [sys.executable, __file__, str(theirs.fileno())]
            # Pipes, as the programs have: Python's files remember whether they can be seeked.
            pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
            return subprocess.Popen(command, pass_fds=[theirs.fileno()], text=True, **pipes)

    def close(self) -> None:
        """End it and those that still run."""
        if self._process is not None:
            self._socket.close()
            self._process.communicate(timeout=PATIENCE_S)
            self._process = None

    def ask(self, request: Any, *files: int) -> int:
        """Send a request with open files; return the answer, a number."""
        self._process = self._process or self._start()
        socket.send_fds(self._socket, [json.dumps(request).encode()], list(files))
        answer = self._socket.recv(64)
        assert answer, self._process.communicate()[1]
        return int(answer)

    @contextmanager
    def running(self, *words: str | Path, env: Mapping[str, str] = os.environ) -> Iterator[Program]:
        """Run `uwsim` with these words; kill it if it is still running at the end."""
        program = Program(self, [str(word) for word in words], env)
        try:
            yield program
        finally:
            if not program.stdout.closed:
                program.end(signal.SIGKILL)

    @contextmanager
    def greeted(self, *words: str | Path, env: Mapping[str, str] = os.environ) -> Iterator[tuple[Program, str]]:
        """Run `uwsim` until the end of the block; yield it and its first line, which servers print when they listen."""
        with self.running(*words, env=env) as program:
            greeting = program.stdout.readline()
            assert greeting, program.end(signal.SIGKILL)[1]
            yield program, greeting
            if not program.stdout.closed:
                program.end()


def next_program(requests: socket.socket) -> list[str]:
    """Fork for each request; return its words in the process that becomes the program."""
    pids: set[int] = set()
    while True:
        data, files, *_ = socket.recv_fds(requests, REQUEST_BYTES, 2)
        if not data:
            break
        request = json.loads(data)
        if "wait" in request:
            pids.remove(request["wait"])
            answer = os.waitstatus_to_exitcode(ended_status(request["wait"]))
        elif not (answer := os.fork()):
            requests.close()
            os.environ.clear()
            os.environ.update(request["env"])
            for own, given in zip((1, 2), files, strict=True):
                os.dup2(given, own)
            os.closerange(3, max(files) + 1)
            return list(request["words"])
        else:
            pids.add(answer)
        for file in files:
            os.close(file)
        requests.send(str(answer).encode())
    for pid in pids:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
    sys.exit()


def ended_status(pid: int) -> int:
    """Wait for the end of a process, which is killed if it does not end; return its status."""
    end_s = time.monotonic() + PATIENCE_S
    while True:
        found, status = os.waitpid(pid, os.WNOHANG)
        if found:
            return status
        if time.monotonic() > end_s:
            os.kill(pid, signal.SIGKILL)
        time.sleep(0.005)


if __name__ == "__main__":
    sys.path.pop(0)  # this folder, which is not on a user's path
    import uwsim.bridges.rosbridge
    import uwsim.bridges.rosbridge.client
    import uwsim.cli.program
    import uwsim.live
    import uwsim.operator.station  # noqa: F401
    from uwsim.channels.ros.message_types import ros1_typestore, typestore
    from uwsim.cli import main
    from uwsim.scenario import load

    for once in (typestore, ros1_typestore, lambda: load("pool")):  # which takes each process half a second
        once()

    sys.argv = ["uwsim", *next_program(socket.socket(fileno=int(sys.argv[1])))]
    main()
