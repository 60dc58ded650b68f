"""Watch: reads a simulator's channels at their rates, at ticks that do not depend on how it is stepped."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.agenda import NEVER, Rank, next_tick
from uwsim.base.journal import EFFORT, JUMPS
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


OnMessage = Callable[[Channel, Any], object]
OnCommand = Callable[[str, dict[str, Any]], object]
OnTape = Callable[[Iterable[Messages]], object]
STRETCH_S = 10.0
"""The longest simulated time after which what has been taped is passed on."""
STRETCH_WALL_S = 0.5
"""The same in wall time, as far as any channel is read meanwhile."""


class Watch:
    """Forwards all messages on the channels, and all commands, in order.

    Channels are read when `start` is called, after each jump in time and at all multiples of their period, before the
    commands of that tick, so that a replay reads the same messages at the same ticks. A channel without a rate is read
    only at the start and after jumps; of a latched one that returns the same object until it changes, such as a
    vehicle's description, a message is forwarded then and at each change. due_tick: when any channel is read next; all
    are one item of the agenda, which is asked at each step.
    """

    def __init__(
        self,
        sim: Simulator,
        channels: Iterable[Channel],
        receive: OnMessage,
        command: OnCommand | None = None,
        measured: AbstractContextManager[object] | None = None,
        tape: OnTape | None = None,
    ) -> None:
        """Create a watch.

        measured: entered around readings and commands, such as a stage's measurement. tape: if given, channels that can
        be are taped instead of read, and it is called from time to time, and before any command except efforts, with
        the messages since: those until then of all channels are complete.
        """
        self._sim = sim
        self._receive = receive
        self._command = command
        self._measured = measured or nullcontext()
        self._on_tape = tape
        self._step_ns = round(sim.step_s * 1e9)
        given = list(channels)
        self._channels = [channel for channel in given if channel.delivery.follow is None]
        self._followed = [channel for channel in given if channel.delivery.follow is not None]
        self._ends: list[Callable[[], None]] = []
        self._subscriptions = [self._subscription(channel) for channel in self._channels]
        self._read_together: dict[tuple[int | None, ...], list[Subscription | Notes]] = {}
        self._due_ticks = dict.fromkeys((period_ns for period_ns, _ in self._subscriptions), NEVER)
        self._read_now: list[tuple[int | None, Subscription | Notes]] = list(self._subscriptions)
        self._tape: Tape | None = None
        self._stretch_tick, self._stretch_wall_s = NEVER, 0.0
        self._is_reading = False
        self._kept: dict[str, Any] = {}  # the latest message of latched channels, by name
        self.due_tick = NEVER

    def start(self) -> None:
        """Read all channels now, and start watching. Call this on the simulator's thread."""
        with self._measured:
            self._read_all()
        for channel in self._followed:
            assert channel.delivery.follow is not None
            self._ends.append(channel.delivery.follow(self._sim, partial(self._receive, channel)))
        self._sim.journal.listen(self)
        self._sim.agenda.add(self, Rank.OBSERVER, self.act)
        self._sim.lockstep.listeners += (self._begin_tape,)

    def stop(self) -> None:
        """Stop watching."""
        for end in self._ends:
            end()
        self._sim.journal.detach(self)
        self._sim.agenda.remove(self)
        self._sim.lockstep.listeners = tuple(one for one in self._sim.lockstep.listeners if one != self._begin_tape)
        with self._measured:
            self._end_tape()

    def act(self, tick: int) -> None:
        """Read the channels that are due, in order, and pass on what has been taped, if it is time."""
        with self._measured:
            self._read(tuple(period_ns for period_ns, due_tick in self._due_ticks.items() if due_tick <= tick), tick)
            if self._tape is not None and (tick >= self._stretch_tick or time.monotonic() >= self._stretch_wall_s):
                self._end_tape()
                self._begin_tape()

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Forward a command; after a jump in time, read all channels again."""
        with self._measured:
            changes = name != EFFORT and not self._is_reading  # a reading may only start an estimate
            if changes:
                self._end_tape()  # the command may have changed what the messages depend on
            if self._command is not None:
                self._command(name, arguments)
            if name in JUMPS:
                self._read_all()
            elif changes:
                self._begin_tape()

    def _read_all(self) -> None:
        self._kept.clear()
        self._choose(None)
        self._read(tuple(self._due_ticks), self._sim.tick)
        self._begin_tape()

    def _begin_tape(self) -> None:
        """Start a stretch of tape, and read only the channels that are not on it."""
        if self._on_tape is not None:
            self._end_tape()
            self._tape = Tape(self._sim, self._channels, _period_ns)
            self._stretch_tick = self._sim.tick + round(STRETCH_S / self._sim.step_s)
            self._stretch_wall_s = time.monotonic() + STRETCH_WALL_S
            self._choose(self._tape)

    def _end_tape(self) -> None:
        tape, self._tape = self._tape, None
        if self._on_tape is not None and tape is not None:
            self._on_tape(tape.end())

    def _choose(self, tape: Tape | None) -> None:
        """Read from now on all channels but those that are taped, and note what is to be noted of these."""
        taped, notes = (frozenset[int](), dict[int, Notes]()) if tape is None else (tape.taped, tape.notes)
        self._read_now = [
            (period_ns, notes.get(rank, one))
            for rank, (period_ns, one) in enumerate(self._subscriptions)
            if rank not in taped or rank in notes
        ]
        self._read_together.clear()
        before, tick = self._due_ticks, self._sim.tick
        periods_ns = dict.fromkeys(period_ns for period_ns, _ in self._read_now)
        self._due_ticks = {
            period_ns: before.get(period_ns, self._tick_after(period_ns, tick)) for period_ns in periods_ns
        }
        self._schedule()

    def _tick_after(self, period_ns: int | None, tick: int) -> int:
        return NEVER if period_ns is None else next_tick(tick, period_ns, self._step_ns)

    def _schedule(self) -> None:
        self.due_tick = min(self._due_ticks.values(), default=NEVER)
        if self._tape is not None:
            self.due_tick = min(self.due_tick, self._stretch_tick)

    def _read(self, periods_ns: tuple[int | None, ...], tick: int) -> None:
        """Read the channels with these periods that are not taped."""
        for period_ns in periods_ns:
            self._due_ticks[period_ns] = self._tick_after(period_ns, tick)
        self._schedule()
        together = self._read_together.get(periods_ns)
        if together is None:
            together = [one for period_ns, one in self._read_now if period_ns in periods_ns]
            self._read_together[periods_ns] = together
        self._is_reading = True
        for one in together:
            one.take(tick)
        self._is_reading = False

    def _subscription(self, channel: Channel) -> tuple[int | None, Subscription]:
        is_kept = channel.delivery.latched and channel.delivery.is_sampled

        def receive(message: Any) -> None:
            if message is not None and not (is_kept and self._kept.get(channel.name) is message):
                if is_kept:
                    self._kept[channel.name] = message
                self._receive(channel, message)

        period_ns = _period_ns(channel)
        return period_ns, Subscription(self._sim, period_ns, channel.read, receive)


def _period_ns(channel: Channel) -> int | None:
    return None if channel.rate_hz is None else max(round(1e9 / channel.rate_hz), 1)
