"""The debriefing films of recorded attempts, made on request in processes of their own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import threading
import time
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.channels.guest import Values
from uwsim.exercises.certified import read_sheet
from uwsim.exercises.sheet import SCORE
from uwsim.exercises.words import languages
from uwsim.operator.station.flights.flights import FOLDER
from uwsim.recording.glance import glance

FILM = "debrief.webp"
NICENESS = 10  # the flight has priority
RECORDED_S, TURN_S = 10.0, 0.2  # the longest wait for the recording's last second, and between two looks
SHARE = re.compile(r"(\d{1,3}) %")


class Films:
    """The films of the flights that hold an attempt at an exercise from its begin: those that a score sheet names.

    folder: of the score sheets' folders, which get the films, and of the flights. Methods may be called on any thread.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._making: dict[str, Making] = {}  # the latest of each flight
        self._lock = threading.Lock()

    def state(self, flight: str) -> Values:
        """Return the state of a flight's film.

        exercise: the title of the exercise, or "" for another flight, which has no film. film: "offered", "making" or
        "made", or "". film_share: of it that has been made, 0 to 1. film_trouble: why it could not be made, or "".
        """
        return self._state(flight, self._sheets().get(flight))

    def listed(self, flights: list[Values]) -> list[Values]:
        """Return entries of flights with the states of their films; none is offered that could not be made."""
        sheets, found = self._sheets(), []
        for each in flights:
            state = self._state(each["name"], sheets.get(each["name"]))
            found.append(each | state | ({"film": ""} if each["refused"] and state["film"] == "offered" else {}))
        return found

    def make(self, flight: str, language: object) -> None:
        """Begin to make a flight's film. It shows what has been recorded by then. Raises ValueError."""
        if language not in languages():
            raise ValueError(f"language = {str(language)[:20]!r}: must be one of {', '.join(languages())}")
        folder = self._sheet(flight)
        recording = self._folder / FOLDER / flight
        if not recording.exists():
            raise ValueError(f"flight {flight} is not kept, as one without any commands")
        with self._lock:
            if any(making.is_alive for making in self._making.values()):
                raise ValueError("film: one is being made already")
            self._making[flight] = Making(recording, folder, str(language))

    def read(self, flight: str) -> bytes:
        """Return a flight's film. Raises ValueError or OSError."""
        return (self._sheet(flight) / FILM).read_bytes()

    def close(self) -> None:
        """Abandon a film that is being made."""
        with self._lock:
            for making in self._making.values():
                making.stop()

    def _state(self, flight: str, sheet: tuple[Path, str] | None) -> Values:
        if sheet is None:
            return {"exercise": "", "film": "", "film_share": 0.0, "film_trouble": ""}
        folder, title = sheet
        making = self._making.get(flight)
        is_being_made = making is not None and making.is_alive
        film = "making" if is_being_made else "made" if (folder / FILM).exists() else "offered"
        share, trouble = (0.0, "") if making is None else (making.share, making.trouble)
        return {"exercise": title, "film": film, "film_share": share, "film_trouble": trouble}

    def _sheet(self, flight: str) -> Path:
        if (sheet := self._sheets().get(flight)) is None:
            raise ValueError(f"flight = {flight[:60]!r}: must be one from the begin of an attempt that has ended")
        return sheet[0]

    def _sheets(self) -> dict[str, tuple[Path, str]]:
        """Return the folder of the score sheet and the exercise's title of each flight that has one."""
        found = {}
        for path in self._folder.glob(f"sheet-*/{SCORE}"):
            try:
                recording, title = _summary(path, path.stat().st_mtime_ns)
            except (ValueError, OSError):  # changed by hand, or removed meanwhile
                continue
            if recording:
                found[recording] = (path.parent, title)
        return found


@lru_cache(1000)
def _summary(path: Path, changed_ns: int) -> tuple[str, str]:
    sheet = read_sheet(path)
    return str(sheet.get("recording", "")), sheet["title"]


class Making:
    """The making of a film of a recording, which may still grow or be ended, with the score sheet in a folder.

    share: of it that has been made, 0 to 1. trouble: why it could not be made, or "".
    """

    def __init__(self, recording: Path, folder: Path, language: str) -> None:
        self._recording, self._folder, self._language = recording, folder, language
        self.share, self.trouble = 0.0, ""
        self._process: subprocess.Popen[str] | None = None
        self._is_stopped = False
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._make, name="uwsim-film", daemon=True)
        self._thread.start()

    @property
    def is_alive(self) -> bool:
        """True while the film is being made."""
        return self._thread.is_alive()

    def stop(self) -> None:
        """Abandon the film."""
        with self._lock:
            self._is_stopped = True
            if self._process is not None:
                self._process.kill()

    def _make(self) -> None:
        try:
            with TemporaryDirectory() as folder:
                self._run(self._copied(Path(folder)))
        except (ValueError, OSError) as error:
            self.trouble = f"the film could not be made: {error}"

    def _copied(self, folder: Path) -> Path:
        """Return a copy of the recording once the attempt's end is in it."""
        end_s, limit_s = read_sheet(self._folder / SCORE)["time_s"], time.monotonic() + RECORDED_S
        while glance(self._recording).duration_s < end_s - TURN_S and time.monotonic() < limit_s:
            time.sleep(TURN_S)
        return Path(shutil.copyfile(self._recording, folder / self._recording.name))

    def _run(self, recording: Path) -> None:
        command = [sys.executable, "-m", "uwsim", "exercise", "film", str(recording)]
        options = {"sheet": self._folder / SCORE, "out": self._folder / FILM, "lang": self._language, "threads": 1}
        command += [word for name, value in options.items() for word in (f"--{name}", str(value))]
        with self._lock:
            if self._is_stopped:
                raise ValueError("the station was stopped")
            process = self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
            )
        os.setpriority(os.PRIO_PROCESS, process.pid, NICENESS)
        last = ""
        with process:
            for line in process.stdout or ():
                last = line.strip() or last
                if (found := SHARE.fullmatch(last)) is not None:
                    self.share = 0.01 * int(found[1])
        if process.returncode:
            raise ValueError(last)
