"""Flights: the station records every flight automatically, within bounds, and lists the recordings."""

from __future__ import annotations

import logging
import os
import re
import threading
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any

from uwsim.base.journal import EFFORT
from uwsim.base.own_files import remove_own_file
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.guest import Values
from uwsim.channels.table import Table
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder, Recording
from uwsim.recording.glance import glance
from uwsim.recording.mcap_sink import is_being_written
from uwsim.recording.timeline import FROM_LOG, UNSEEN, Timeline
from uwsim.scenario.fingerprint import build_fingerprint

FOLDER = "flights"
COUNT, MEGABYTES = 50, 2000
"""The default bounds: the number of flights, and their total size in MB (10^6 bytes)."""
COUNT_MAX, MEGABYTES_MAX = 10_000, 1_000_000
RECORDED_BY, NAMED = {"recorded_by": "station"}, "named"
"""The notes in the metadata of a flight that was recorded unasked: by the station, under a name.

Only such recordings that still have their name are ever deleted: what a user has named is the user's.
"""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}\.mcap")
CHECK_S = 2.0  # interval between checks of the bounds while recording
OPEN_MAX = 3  # number of time lines cached for later requests
LOGGER = logging.getLogger("uwsim.operator.station")


@dataclass(frozen=True)
class Bounds:
    """Limits on the number of flights kept and on their total size. The oldest flights are deleted first.

    Recordings that the station did not make unasked, or that have another name than it gave them, as copies have, are
    not counted, and never deleted.
    """

    count: int = COUNT
    size_bytes: int = MEGABYTES * 1_000_000

    @classmethod
    def of(cls, text: str) -> Bounds:
        """Parse bounds such as "50,2000", the number of flights and their size in MB. Raises ValueError."""
        found = re.fullmatch(r"(\d{1,6}),(\d{1,8})", text)
        if found is None:
            raise ValueError(f"{text!r}: must be a number of flights and of MB, such as {COUNT},{MEGABYTES}")
        count, megabytes = int(found[1]), int(found[2])
        if count > COUNT_MAX or not 1 <= megabytes <= MEGABYTES_MAX:
            raise ValueError(f"{text!r}: must be 0 to {COUNT_MAX} flights and 1 to {MEGABYTES_MAX} MB")
        return cls(count, megabytes * 1_000_000)

    def __str__(self) -> str:
        return f"at most {self.count} flights and {self.size_bytes / 1e6:g} MB"


@dataclass
class Flights:
    """The flights in a folder, keyed by file name. The station's names begin with the start time.

    refused: the reasons why flights could not be replayed, keyed by name. Methods may be called on any thread.
    """

    folder: Path
    bounds: Bounds = field(default_factory=Bounds)
    threads: int | None = None
    refused: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._lock = threading.Lock()
        self._opening = threading.Lock()
        self._open: OrderedDict[tuple[str, int, int], Timeline] = OrderedDict()
        self.growing: Path | None = None  # the flight being recorded
        self.is_closing = False

    def listed(self) -> list[Values]:
        """Return the flights as entries of the catalog, newest first, except the flight being recorded."""
        return [self._described(path) for path in reversed(self._paths()) if path != self.growing]

    def new_path(self, scenario: str) -> Path:
        """Return the path of a new flight, after making room for it. Raises OSError."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self.make_room(more=1)
        now = datetime.now(UTC)
        what = re.sub("[^A-Za-z0-9_-]", "-", scenario)[:40]
        return self.folder / f"{now:%Y%m%d-%H%M%S}-{now.microsecond // 1000:03d}-{what}.mcap"

    def make_room(self, more: int = 0) -> None:
        """Delete the oldest flights beyond the bounds, but none that this or another station is recording."""
        with self._lock:
            begun, sizes = {}, {}
            for path in self._paths():
                try:
                    stat = path.stat()
                except FileNotFoundError:  # another program has deleted it meanwhile
                    continue
                if path == self.growing:
                    sizes[path] = stat.st_size
                elif (start := _recorded_unasked(path, stat.st_size, stat.st_mtime_ns)) is not None:
                    begun[path], sizes[path] = start, stat.st_size
            for oldest in sorted(begun, key=lambda path: (begun[path], path.name)):
                if len(sizes) + more <= self.bounds.count and sum(sizes.values()) <= self.bounds.size_bytes:
                    break
                if is_being_written(oldest):
                    continue
                oldest.unlink(missing_ok=True)
                del sizes[oldest]
                LOGGER.warning("flight %s is deleted: %s are kept", oldest.name, self.bounds)

    def timeline(self, name: object) -> Timeline:
        """Return a flight's time line, simulating the flight unless the time line is cached.

        Raises ValueError or OSError.
        """
        path = self._path(name)
        with self._opening:
            stat = path.stat()
            key = (path.name, stat.st_size, stat.st_mtime_ns)
            if key not in self._open:
                try:
                    self._open[key] = Timeline(Recording(path), self.threads, lambda: not self.is_closing)
                except (ValueError, OSError) as error:
                    self.refused[path.name] = " ".join(str(error).replace(f"'{path}'", f"'{path.name}'").split())
                    raise ValueError(self.refused[path.name]) from None
            self._open.move_to_end(key)
            while len(self._open) > OPEN_MAX:
                self._open.popitem(last=False)
            return self._open[key]

    def close(self) -> None:
        """Abandon the flight that is being opened."""
        self.is_closing = True

    def _path(self, name: object) -> Path:
        if not isinstance(name, str) or not NAME.fullmatch(name) or not (self.folder / name).is_file():
            raise ValueError(f"flight = {str(name)[:60]!r}: must be one of those listed")
        return self.folder / name

    def _paths(self) -> list[Path]:
        found = [path for path in self.folder.glob("*.mcap") if NAME.fullmatch(path.name) and path.is_file()]
        return sorted(found, key=lambda path: path.name)

    def _described(self, path: Path) -> Values:
        try:
            stat = path.stat()
            described = _summary(path, stat.st_size, stat.st_mtime_ns)
        except OSError as error:
            described = _unreadable(path, 0, error)
        return {**described, "refused": described["refused"] or self.refused.get(path.name, "")}


@lru_cache(COUNT_MAX)
def _recorded_unasked(path: Path, size: int, changed_ns: int) -> str | None:
    """Return when a flight began that the station recorded unasked and named, or None for any other file."""
    try:
        start = glance(path).start
    except (ValueError, OSError):
        return None
    return start.begun if start.notes.items() >= {**RECORDED_BY, NAMED: path.name}.items() else None


@lru_cache(COUNT_MAX)
def _summary(path: Path, size: int, changed_ns: int) -> Values:
    try:
        seen = glance(path)
    except ValueError as error:
        return _unreadable(path, size, error)
    start, end = seen.start, seen.end
    notes = {**start.notes, **(end.notes if end is not None else {})}
    is_other = start.build != build_fingerprint()
    return {
        "name": path.name,
        "scenario": start.scenario,
        "begun": start.begun,
        "duration_s": round(seen.duration_s, 3),
        "cut_off": end is None,
        "size_bytes": size,
        "branched_from": str(notes.get("branched_from", "")),
        "exercise": str(notes.get("exercise", "")),
        "from_log": str(log.get("file", "")) if isinstance(log := notes.get(FROM_LOG), dict) else "",
        "refused": "was made by another build of uwsim" if is_other else "",
    }


def _unreadable(path: Path, size: int, error: Exception) -> Values:
    what = " ".join(str(error).replace(f"'{path}'", f"'{path.name}'").split())
    empty = {"scenario": "", "begun": "", "duration_s": 0.0, "cut_off": False, "size_bytes": size}
    empty |= {"branched_from": "", "exercise": "", "from_log": ""}
    return {"name": path.name, **empty, "refused": what}


class FlightRecording:
    """Records a running simulator automatically. A flight without any commands is not kept.

    notes: metadata for the recording, such as the flight from which it branched.
    """

    def __init__(
        self, live: LiveSimulator, table: Table, feed: Feed, flights: Flights, notes: Mapping[str, Any] | None = None
    ) -> None:
        self._live, self._table, self._feed = live, table, feed
        self._flights, self._notes = flights, {**(notes or {}), **RECORDED_BY}
        self._recorder: Recorder | None = None
        self._is_flown = False
        self._over = threading.Event()
        self._lock = threading.Lock()
        self._trouble = ""

    @property
    def name(self) -> str:
        """The name of the file being written, or "" if nothing is being recorded."""
        return "" if self.path is None else self.path.name

    @property
    def path(self) -> Path | None:
        """The file being written, or None if nothing is being recorded."""
        recorder = self._recorder
        return None if recorder is None or recorder.error is not None else recorder.path

    @property
    def trouble(self) -> str:
        """The reason why nothing is being recorded, or ""."""
        recorder = self._recorder
        error = None if recorder is None else recorder.error
        return self._trouble if error is None else f"the flight is no longer recorded: {error.strerror or error}"

    def start(self) -> None:
        """Begin a recording, unless no flights are to be kept. Errors are logged and stored in `trouble`."""
        flights = self._flights
        if flights.bounds.count == 0:
            return
        with self._lock:
            try:
                path = flights.new_path(self._live.simulator.scenario.name)
                self._is_flown, self._trouble = False, ""
                recorder = Recorder(
                    self._live, path, shared=self._table, feed=self._feed, notes={**self._notes, NAMED: path.name},
                    is_light=True,
                )  # fmt: skip
                flights.growing = path
                self._recorder = recorder.start()
                self._live.simulator.journal.listen(self)
                self._over = threading.Event()
                threading.Thread(target=self._watch, args=(self._over,), name="uwsim-flights", daemon=True).start()
            except (OSError, ValueError) as error:
                flights.growing = None
                self._complain(error)

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Record that the vehicle has been commanded."""
        moves = any(value for key, value in arguments.items() if key != "vehicle")
        if (name == EFFORT and moves) or name not in UNSEEN:
            self._is_flown = True

    def _watch(self, over: threading.Event) -> None:
        """Enforce the bounds while a flight is being recorded.

        If this flight alone exceeds them, or cannot be written any more, end its recording.
        """
        while not over.wait(CHECK_S):
            recorder = self._recorder
            if recorder is None:
                return
            try:
                self._flights.make_room()
                is_too_large = recorder.path.stat().st_size > self._flights.bounds.size_bytes
            except OSError as error:
                self._complain(error)
                return
            if recorder.error is not None:
                self.stop()
            elif is_too_large:
                megabytes = self._flights.bounds.size_bytes / 1e6
                self._trouble = f"the flight is no longer recorded: its recording has reached {megabytes:g} MB"
                LOGGER.warning("%s", self._trouble)
                self.stop()

    def stop(self) -> None:
        """Finish the recording; errors are logged, and stored in `trouble`."""
        with self._lock:
            self._trouble = self.trouble  # so that the reason is there at any moment
            recorder, self._recorder = self._recorder, None
            self._over.set()
            if recorder is None:
                return
            self._live.simulator.journal.detach(self)
            try:
                recorder.close()
                if not self._is_flown:
                    remove_own_file(recorder.path)
                    LOGGER.warning("flight %s is not kept: it has no commands", recorder.path.name)
            except OSError as error:
                self._complain(error)
            self._flights.growing = None

    def _complain(self, error: Exception) -> None:
        text = str(error).replace(f"{self._flights.folder}{os.sep}", "")  # pages need not see the server's folders
        self._trouble = f"the flight is not recorded: {text}"
        LOGGER.error("%s", self._trouble)
