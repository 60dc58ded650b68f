"""Judges an exercise flown by a person at the station while the simulator runs, and writes a sheet for each attempt."""

from __future__ import annotations

import logging
import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import TimeoutError as FutureTimeoutError
from pathlib import Path
from typing import Any

from uwsim.channels.authority.rights import AidKind, Rights
from uwsim.channels.guest import Values
from uwsim.exercises import Course, Exercise
from uwsim.exercises.certified import certified_sheet
from uwsim.exercises.course import PERIOD_S
from uwsim.exercises.sheet import SCORE, SHEET, write_sheet
from uwsim.live import LiveSimulator, NotRunningError

LOGGER = logging.getLogger("uwsim.operator.station")
STOP_S = 5.0
PROGRAM_S = 0.5  # a program's single command counts as an aid for this long


class Judged:
    """Judges a live simulator, whose world it closes to clients; see `Rights`.

    An attempt begins when the pilot presses Begin; until then, time stands still. It ends with the exercise, with a
    restart, or with the simulator. folder: receives the score sheets, in subfolders sheet-1, sheet-2 and so on.
    aids: returns the aids in use that the station knows.
    pilot: returns the name of the member who has the controls; another than the one who began makes a score invalid.
    person: the name on the sheet, by default that of the member who began. name: of a packaged
    exercise, or "". following: name and title of the next one that the pilot may start, or empty texts. recording:
    returns the name of the file into which the flight is being recorded, or "".
    """

    def __init__(
        self,
        live: LiveSimulator,
        exercise: Exercise,
        folder: Path,
        rights: Rights,
        *,
        aids: Callable[[], set[AidKind]] = set,
        pilot: Callable[[], str] = str,
        person: str = "",
        name: str = "",
        following: tuple[str, str] = ("", ""),
        recording: Callable[[], str] = str,
    ) -> None:
        self.name, self._following = name, following
        self.live, self._folder, self._aids, self._pilot = live, folder, aids, pilot
        self._person, self._began = person, ""
        self._recording = recording
        outsider = "the program that runs the simulator"
        self.course = Course(exercise, live.simulator, self._command, outsider=outsider, aids=self._aids_in_use)
        self.course.wait_to_begin(1)
        self._acts = Counter[tuple[str, str]]()  # outside acts since the last judgement: by whom, and a text
        self._has_program = False  # whether a program's command is among them
        self._program_s = 0.0  # until when the last of them counts
        self._writing: list[threading.Thread] = []
        self._sheet: Path | None = None
        self._error = ""
        self._lock = threading.Lock()
        rights.close_world(live)
        rights.allow_only([aid.kind for aid in exercise.aids])
        rights.permitted = self._note_program
        rights.stopped = lambda name: self.note_stop("a program", f"/{name}")

    def start(self) -> None:
        """Start judging."""
        self.live.every(PERIOD_S, lambda sim: None, lambda nothing: self._judge())

    def begin(self) -> None:
        """Begin the attempt now. Raises ValueError if it has begun."""

        def act(sim: object) -> None:
            if self.course.has_begun:
                raise ValueError("begin: the attempt has begun: restart for another one")
            self.course.restart()
            self._began = self._pilot()
            self._sheet, self._error = None, ""
            self._judge()  # at time 0, when events may be due

        self.live.read(act).result(STOP_S)
        with self.live.privileged():
            self.live.resume()

    def require_begun(self, act: str) -> None:
        """Raise ValueError unless the pilot has begun the attempt."""
        if not self.course.has_begun:
            raise ValueError(f"{act}: the pilot has not begun: time stands still until then")

    def break_off(self, because: str) -> None:
        """End the attempt before a jump in time, write its sheet, and wait for the pilot to begin another one."""
        with self.live.privileged():
            self.live.pause()
        try:
            self.live.read(lambda sim: self._conclude(because)).result(STOP_S)
        except (NotRunningError, FutureTimeoutError):
            self._conclude(because)

    def stop(self) -> None:
        """End the attempt, and wait for the sheets still being written. Called before the simulator stops."""
        if self.course.has_begun and not self.course.is_over:
            self.break_off("broken off: the simulator was stopped")
        for writing in self._writing:
            writing.join()

    def state(self) -> Values:
        """Return the part of the exercise's state that the pilot may see, and whether the sheet has been written."""
        state: Values = self.live.read(lambda sim: self.course.state()).result()
        next_name, next_title = self._following
        own = {"name": self.name, "has_sheet": self._sheet is not None, "error": self._error}
        return {**state, **own, "next_name": next_name, "next_title": next_title}

    def sheet(self, name: str) -> bytes:
        """Return a file of the latest score sheet. Raises ValueError before the exercise has ended."""
        if self._sheet is None or name not in (SHEET, SCORE):
            raise ValueError("the score sheet is written when the exercise ends")
        return (self._sheet / name).read_bytes()

    def _command(self, name: str, arguments: Any) -> None:
        with self.live.privileged():
            done = self.live.command(name, **arguments)  # at once, since this is the stepping thread
        if (error := done.exception()) is not None:
            self._error = f"an event failed: {error}"
            LOGGER.error("an exercise's event failed: %s", error)

    def _note_program(self, name: str) -> None:
        with self._lock:
            self._acts["a program", f"/{name}"] += 1
            self._has_program = True

    def note_stop(self, by: str, text: str) -> None:
        """Note an all stop of another than the pilot: an outside act, but no aid, since anyone may stop a vehicle."""
        with self._lock:
            self._acts[by, text] += 1

    def _aids_in_use(self) -> set[AidKind]:
        """Return the aids in use. Called on the stepping thread, once for each judgement."""
        with self._lock:
            acts, self._acts = self._acts, Counter()
            has_program, self._has_program = self._has_program, False
        time_s = self.course.time_s
        if (name := self._pilot()) and name != self._began:
            self.course.conduct.note_pilot(name)
        for (by, text), count in acts.items():
            self.course.note_outside(text if count == 1 else f"{text}, {count} times", by, changed=False)
        if has_program:
            self._program_s = time_s + PROGRAM_S
        return self._aids() | ({"program"} if time_s < self._program_s else set())

    def _judge(self) -> None:
        was_over = self.course.is_over
        if self.course.has_begun and self.course.has_jumped_back:
            with self.live.privileged():
                self.live.pause()
            self._conclude("broken off: time was set back")
            return
        self.course.judge()
        if self.course.is_over and not was_over:
            self._write(self.course.concluded(""))

    def _conclude(self, because: str) -> None:
        """Write the sheet of an attempt that is not over, and wait for the next one to begin."""
        course = self.course
        if course.has_begun and not course.is_over:
            self._write(course.concluded(because))
        if course.has_begun:
            course.wait_to_begin(course.attempt + 1)
            self._program_s = 0.0

    def _write(self, course: Course) -> None:
        """Write a sheet on a thread of its own."""
        recording = self._recording() if course.begun_tick == 0 else ""  # from its begin
        sheet = certified_sheet(course, self._person or self._began, recording=recording)
        given = (course, sheet)
        writing = threading.Thread(target=self._write_now, args=given, name="uwsim-sheet", daemon=True)
        writing.start()  # before `close`, on another thread, may join it
        self._writing = [*(each for each in self._writing if each.is_alive()), writing]

    def _write_now(self, course: Course, sheet: Values) -> None:
        try:
            folder = self._new_folder()
            write_sheet(folder, course, sheet)
            self._sheet = folder
        except Exception as error:
            self._error = "; ".join(filter(None, [self._error, f"the score sheet could not be written: {error}"]))
            LOGGER.exception("the score sheet could not be written")

    def _new_folder(self) -> Path:
        self._folder.mkdir(parents=True, exist_ok=True)
        with self._lock:
            taken = {path.name for path in self._folder.glob("sheet-*")}
            number = next(k for k in range(1, len(taken) + 2) if f"sheet-{k}" not in taken)
            folder = self._folder / f"sheet-{number}"
            folder.mkdir()
        return folder
