"""Tape: readings that the simulation writes by itself, and the messages made of them many at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.agenda import NEVER
from uwsim.channels import Channel
from uwsim.channels.ros.columns import encode_all
from uwsim.channels.taped import Make, Rows, Track
from uwsim.live import Subscription
from uwsim.simulator.simulator import Simulator


class Messages(NamedTuple):
    """Messages of a channel in CDR, and when they were read, (n,) [ns]."""

    channel: Channel
    times_ns: NDArray[np.uint64]
    data: list[bytes]


class Notes:
    """The rows of a channel that are noted at each of its readings, instead of a message."""

    def __init__(self, sim: Simulator, note: Callable[[Simulator], NDArray[np.float64]]) -> None:
        self._times_ns: list[int] = []
        self._values: list[NDArray[np.float64]] = []
        self._sim = sim
        self._reading = Subscription(sim, None, note, self._append)

    def take(self, tick: int) -> None:
        """Note a row."""
        self._reading.take(tick)

    def _append(self, row: NDArray[np.float64]) -> None:
        self._times_ns.append(self._sim.time_ns)
        self._values.append(row)

    def rows(self) -> Rows:
        """Return the rows."""
        times_ns = np.array(self._times_ns, np.uint64)
        values = np.array(self._values) if self._values else np.empty((0, 0))
        return Rows(times_ns, times_ns, values, np.ones(len(times_ns), bool))


class Tape:
    """The readings of some channels at all multiples of their periods, from its creation until `end`.

    taped: the places of those channels among all that were given. The others must be read: those without `taped`, those
    of which something moves that no tape has, and all while a fault or a broken tether may cut off a vehicle, or a
    source such as an autopilot makes the steps, whose frames a file has between its messages. notes: by place, those of
    the taped channels of which numbers must be noted whenever they are due.
    """

    def __init__(self, sim: Simulator, channels: Sequence[Channel], period_ns: Callable[[Channel], int | None]) -> None:
        self._sim, self._tape = sim, _core.Tape()
        self._tracks: dict[tuple[Track, int], int] = {}
        self._taped: list[tuple[int, Channel, Make, list[int]]] = []
        self.notes: dict[int, Notes] = {}
        alone = sim.lockstep.is_free and not sim.tethers
        if alone and sim.faults.due_tick == NEVER and not sim.faults.active:
            for rank, channel in enumerate(channels):
                period = period_ns(channel)
                if channel.taped is not None and period is not None and (make := channel.taped.begin(sim)) is not None:
                    if channel.taped.note is not None:
                        self.notes[rank] = Notes(sim, channel.taped.note)
                    tracks = [self._index(track, period) for track in channel.taped.tracks]
                    self._taped.append((rank, channel, make, tracks))
        self.taped = frozenset(rank for rank, *_ in self._taped)
        if self._tracks:
            sim.attach_tape(self._tape)

    def _index(self, track: Track, period_ns: int) -> int:
        """Return the index of a track, which channels with the same period share."""
        found = self._tracks.get((track, period_ns))
        if found is None:
            found = self._tracks[track, period_ns] = self._added(track, period_ns)
        return found

    def _added(self, track: Track, period_ns: int) -> int:
        if not track.vehicle:
            return self._tape.add_time(period_ns)
        vehicle = list(self._sim.vehicles).index(track.vehicle)
        if not track.sensor:
            return self._tape.add_motion(vehicle, period_ns)
        return self._tape.add_sensor(
            vehicle, list(self._sim.vehicles[track.vehicle].sensors).index(track.sensor), period_ns
        )

    def end(self) -> Iterator[Messages]:
        """Stop writing, and yield the messages of each channel."""
        self._sim.detach_tape(self._tape)
        rows = {track: Rows(*self._sim.take_rows(self._tape, track)) for track in self._tracks.values()}
        for rank, channel, make, tracks in self._taped:
            own = [self.notes[rank].rows()] if rank in self.notes else [rows[track] for track in tracks]
            if len(own[0].times_ns):
                times_ns, message = make(own)
                yield Messages(channel, times_ns, encode_all(message, len(times_ns)))
