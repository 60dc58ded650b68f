"""Judges an exercise flown by a person at the station while the simulator runs, and writes a score sheet at the end."""

from __future__ import annotations

import logging
import threading
from pathlib import Path
from typing import Any

from uwsim.channels.guest import Values
from uwsim.exercises import Course, Exercise
from uwsim.exercises.course import PERIOD_S
from uwsim.exercises.sheet import SCORE, SHEET, write_sheet
from uwsim.live import LiveSimulator

LOGGER = logging.getLogger("uwsim.operator.station")


class Judged:
    """Judges a live simulator. folder: receives the score sheets, in subfolders sheet-1, sheet-2 and so on."""

    def __init__(self, live: LiveSimulator, exercise: Exercise, folder: Path) -> None:
        self.live, self._folder = live, folder
        self.course = Course(exercise, live.simulator, self._command)
        self._writing: threading.Thread | None = None
        self._sheet: Path | None = None
        self._error = ""

    def start(self) -> None:
        """Start judging."""
        self.live.every(PERIOD_S, lambda sim: None, lambda nothing: self._judge())

    def stop(self) -> None:
        """Wait for any sheet still being written."""
        if self._writing is not None:
            self._writing.join()

    def state(self) -> Values:
        """Return the part of the exercise's state that the pilot may see, and whether the sheet has been written."""
        state: Values = self.live.read(lambda sim: self.course.state()).result()
        is_written = self.course.is_over and self._sheet is not None
        return {**state, "has_sheet": is_written, "error": self._error}

    def sheet(self, name: str) -> bytes:
        """Return a file from the latest score sheet. Raises ValueError before the exercise has ended."""
        if self._sheet is None or name not in (SHEET, SCORE):
            raise ValueError("the score sheet is written when the exercise ends")
        return (self._sheet / name).read_bytes()

    def _command(self, name: str, arguments: Any) -> None:
        done = self.live.command(name, **arguments)  # at once, since this is the stepping thread
        if (error := done.exception()) is not None:
            self._error = f"an event failed: {error}"
            LOGGER.error("an exercise's event failed: %s", error)

    def _judge(self) -> None:
        was_over = self.course.is_over
        self.course.judge()
        if self.course.is_over and not was_over:
            self._writing = threading.Thread(target=self._write, name="uwsim-sheet", daemon=True)
            self._writing.start()
        elif was_over and not self.course.is_over:  # restarted
            self._sheet, self._error = None, ""

    def _write(self) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            taken = {path.name for path in self._folder.glob("sheet-*")}
            number = next(k for k in range(1, len(taken) + 2) if f"sheet-{k}" not in taken)
            folder = self._folder / f"sheet-{number}"
            write_sheet(folder, self.course)
            self._sheet = folder
        except OSError as error:
            self._error = f"the score sheet could not be written: {error}"
            LOGGER.exception("the score sheet could not be written")
