"""The debriefing film of an attempt at the station, made on request in a process of its own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.channels.guest import Values
from uwsim.exercises.sheet import SCORE
from uwsim.recording.glance import glance

FILM = "debrief.webp"
NICENESS = 10  # the flight has priority
RECORDED_S, TURN_S = 10.0, 0.2  # the longest wait for the recording's last second, and between two looks
SHARE = re.compile(r"(\d{1,3}) %")


class Debriefing:
    """An attempt's film. It shows what the flight's recording has by then, which may still grow or be ended.

    recording: of the flight. folder: of the score sheet, which gets the film. end_s: of the attempt. complain: gets the
    reason why there is no film.
    """

    def __init__(self, recording: Path, folder: Path, end_s: float, complain: Callable[[str], object]) -> None:
        self._recording, self._folder, self._end_s, self._complain = recording, folder, end_s, complain
        self._film, self._share = "offered", 0.0
        self._process: subprocess.Popen[str] | None = None
        self._is_stopped = False
        self._lock = threading.Lock()

    def state(self) -> Values:
        """Return film, "offered", "making" or "made", and the share of it that has been made, 0 to 1."""
        return {"film": self._film, "film_share": self._share}

    def make(self, language: str) -> None:
        """Begin to make it. Raises ValueError if that has begun."""
        with self._lock:
            if self._film != "offered":
                raise ValueError("film: is being made already, or has been")
            self._film, self._share = "making", 0.0
        threading.Thread(target=self._make, args=(language,), name="uwsim-debriefing", daemon=True).start()

    def stop(self) -> None:
        """Abandon a film that is being made."""
        with self._lock:
            self._is_stopped = True
            if self._process is not None:
                self._process.kill()

    def _make(self, language: str) -> None:
        try:
            with TemporaryDirectory() as folder:
                self._run(self._copied(Path(folder)), language)
            self._film = "made"
        except (ValueError, OSError) as error:
            self._film = "offered"
            if not self._is_stopped:
                self._complain(f"the film could not be made: {error}")

    def _copied(self, folder: Path) -> Path:
        """Return a copy of the recording once the attempt's end is in it."""
        if not self._recording.exists():
            raise ValueError(f"flight {self._recording.name} is not kept, as one without any commands")
        limit_s = time.monotonic() + RECORDED_S
        while glance(self._recording).duration_s < self._end_s - TURN_S and time.monotonic() < limit_s:
            time.sleep(TURN_S)
        return Path(shutil.copyfile(self._recording, folder / self._recording.name))

    def _run(self, recording: Path, language: str) -> None:
        command = [sys.executable, "-m", "uwsim", "exercise", "film", str(recording)]
        options = {"sheet": self._folder / SCORE, "out": self._folder / FILM, "lang": language, "threads": 1}
        command += [word for name, value in options.items() for word in (f"--{name}", str(value))]
        with self._lock:
            if self._is_stopped:
                raise ValueError("the simulator was stopped")
            process = self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
            )
        os.setpriority(os.PRIO_PROCESS, process.pid, NICENESS)
        last = ""
        with process:
            for line in process.stdout or ():
                last = line.strip() or last
                if (found := SHARE.fullmatch(last)) is not None:
                    self._share = 0.01 * int(found[1])
        if process.returncode:
            raise ValueError(last)
