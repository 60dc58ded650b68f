"""Timeline: repeats a recorded run, and saves states from which any moment can be reached quickly."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.commands import NOTE
from uwsim.base.journal import EFFORT, JUMPS
from uwsim.base.texts.value_words import Detail
from uwsim.channels.calls.services import SET_STREAM
from uwsim.recording.commands import COMMANDS, Command, CommandStream, command_of
from uwsim.recording.mcap_sink import LIVE
from uwsim.recording.reader import Recording
from uwsim.recording.recorder import state_digest
from uwsim.recording.replay import execute, new_simulator, offered_channels, replay
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.simulator.failures import Event
from uwsim.simulator.simulator import Simulator

ECHOES = {
    "all_stop": ("all_stop", "all_stop_ends"), "inject_fault": ("fault",), "end_fault": ("fault_ends",), NOTE: (NOTE,),
}  # fmt: skip
"""The events of the run that a command causes at once: it is listed in their place."""


class Happening(NamedTuple):
    """An event of a run. kind: `command`, `alarm` (faults and failsafes, too) or `collision`. text: all in English.

    name: of the command or the event. vehicle: "" for the world. details: names and values in words.
    """

    time_s: float
    kind: str
    text: str
    name: str
    vehicle: str = ""
    details: tuple[Detail, ...] = ()


SPACING_S = 1.0  # simulated time between saved states, doubled whenever they exceed KEPT_BYTES
KEPT_BYTES = 64 << 20
SAMPLE_S = 0.2  # interval between samples of the track
LONGEST_S = 12 * 3600.0
EVENTS_MAX = 500
MERGED_S = 2.0  # the values that one argument of a command takes within this time are one event
UNSEEN = frozenset({EFFORT, SET_STREAM, "start_navigation", "link_send"})
"""Commands that are not events, because they are issued in every period or by programs."""
FROM_LOG = "from_log"
"""The note of a recording that was made of a log: its vehicle is placed every SAMPLE_S, which is not an event."""


class SavedMoment(NamedTuple):
    """A state at a tick, before the commands of this tick. place: index of the first command at or after the tick."""

    tick: int
    state: bytes
    place: int


@dataclass
class Track:
    """The first vehicle's true motion. poses: (n, 7), position in the world [m] and quaternion x, y, z, w."""

    times_s: list[float] = field(default_factory=list)
    poses: list[NDArray[np.float64]] = field(default_factory=list)

    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return times (n,) and poses (n, 7) as arrays."""
        return np.array(self.times_s), np.array(self.poses).reshape(-1, 7)


class Timeline:
    """The moments of a recorded run, from its first tick to its last or, if time was reset, to the first reset.

    Creating a time line simulates the whole run and compares its final state with the recorded state. A run that cannot
    be repeated bit for bit is refused. A recording that was cut off has no final state: it ends with its last whole
    chunk, and each of its messages is compared. go_on: called repeatedly; if it returns False, creation is abandoned
    with a RuntimeError. Raises OSError, or ValueError if the recording was edited, or was made by a different build or
    for a different purpose.

    commands: in order. events: at most EVENTS_MAX. track: sampled every SAMPLE_S.
    """

    def __init__(
        self, recording: Recording, threads: int | None = None, go_on: Callable[[], bool] = lambda: True
    ) -> None:
        self.recording = recording
        self.threads = threads
        self._go_on = go_on
        self._require_repeatable()
        self.commands = list(recording.commands())
        self._ticks = [command.tick for command in self.commands]
        self.events: list[Happening] = []
        self._unseen = UNSEEN | {"place"} if FROM_LOG in recording.start.notes else UNSEEN
        self._stream: CommandStream | None = None
        self.track = Track()
        self.start_tick = recording.start.tick
        self.end_tick = self._end_tick()
        self._saved: list[SavedMoment] = []
        self._retrace(self.simulator())

    @property
    def step_s(self) -> float:
        """The duration of a step [s]."""
        return self.recording.start.step_s

    def simulator(self) -> Simulator:
        """Return a simulator at the first tick. Raises ValueError."""
        sim = new_simulator(self.recording, self.threads)
        if scenario_fingerprint(sim.scenario) != self.recording.start.fingerprint:
            raise self._refusal("its scenario was edited")
        self._read_as_recorded(sim)
        return sim

    def saved_before(self, tick: int) -> SavedMoment:
        """Return the last saved state at or before a tick."""
        return self._saved[max(bisect_right(self._saved, tick, key=lambda saved: saved.tick) - 1, 0)]

    def place(self, tick: int) -> int:
        """Return the index of the first command at or after a tick."""
        return bisect_left(self._ticks, tick)

    def next_command_tick(self, place: int) -> int | None:
        """Return the tick of the command at an index, or None after the last command of this time line."""
        return self._ticks[place] if place < len(self._ticks) and self._ticks[place] < self.end_tick else None

    def execute(self, sim: Simulator, place: int) -> None:
        """Apply the command at an index. Raises ValueError."""
        command = self.commands[place]
        try:
            execute(sim, None, command)
        except ValueError as error:
            raise self._refusal(f"tick {command.tick}: {error}") from None

    def go_to(self, sim: Simulator, tick: int, place: int | None = None) -> int:
        """Move a simulator to a tick, before the tick's commands; return the index of the first of them.

        place: if the simulator has followed this recording so far, the index of the first command that it has not
        received. It then continues without a jump in time if that is quicker. Raises ValueError.
        """
        tick = min(max(tick, self.start_tick), self.end_tick)
        saved = self.saved_before(tick)
        if place is None or not saved.tick <= sim.tick <= tick:
            sim.restore_state(saved.state)
            place = saved.place
        while (due := self.next_command_tick(place)) is not None and due < tick:
            sim.step(max(due - sim.tick, 0))
            self.execute(sim, place)
            place += 1
        sim.step(tick - sim.tick)
        return place

    def _require_repeatable(self) -> None:
        recording = self.recording
        if recording.end_tick is None:
            raise self._refusal("is cut off before its first message")
        if recording.start.kind != LIVE:
            raise self._refusal("is of a survey, which `uwsim replay` repeats")
        build = recording.start.build
        if build != build_fingerprint():
            raise self._refusal(f"was made by another build of uwsim ({build}, this is {build_fingerprint()})")

    def _end_tick(self) -> int:
        assert self.recording.end_tick is not None
        jumps = (k for k, command in enumerate(self.commands) if command.name in JUMPS)
        end = self.recording.end_tick
        if (first := next(jumps, None)) is not None:  # a jump's tick is the tick after the jump
            end = self._last_ns_before_jump() // self.recording.step_ns
            self._ticks = self._ticks[:first]
        duration_s = (end - self.start_tick) * self.step_s
        if not 0.0 <= duration_s <= LONGEST_S:
            raise self._refusal(f"lasts {duration_s:g} s: must last 0 to {LONGEST_S:g} s")
        return end

    def _last_ns_before_jump(self) -> int:
        last_ns = 0
        for recorded in self.recording.messages():
            if recorded.topic == COMMANDS and command_of(recorded.message).name in JUMPS:
                break
            last_ns = max(last_ns, recorded.time_ns)
        return last_ns

    def _retrace(self, sim: Simulator) -> None:
        """Simulate the run, save states, and compare the end."""
        spacing = max(round(SPACING_S / self.step_s), 1)
        sample = max(round(SAMPLE_S / self.step_s), 1)
        vehicle = sim.rov
        collisions, place, kept_bytes = vehicle.collisions, 0, 0
        next_saved = next_sample = sim.tick
        while True:
            if sim.tick >= next_sample or sim.tick == self.end_tick:
                next_sample = sim.tick + sample
                pose = vehicle.pose
                self.track.times_s.append(round(sim.tick * self.step_s, 9))
                self.track.poses.append(np.concatenate([pose.position_world_m, pose.orientation_xyzw]))
                if vehicle.collisions > collisions:
                    self._note(sim.tick, "collision", "collision", "collision")
                collisions = vehicle.collisions
            if sim.tick >= next_saved:
                self._require_wanted()
                self._saved.append(SavedMoment(sim.tick, sim.save_state(), place))
                next_saved = sim.tick + spacing
                kept_bytes += len(self._saved[-1].state)
                if kept_bytes > KEPT_BYTES:
                    self._saved, spacing = self._saved[::2], 2 * spacing
                    kept_bytes = sum(len(each.state) for each in self._saved)
            due = self.next_command_tick(place)
            if due is not None and due <= sim.tick:
                self._note_command(self.commands[place])
                self.execute(sim, place)
                place += 1
                continue
            if sim.tick >= self.end_tick:
                break
            goal = min(self.end_tick, next_sample, next_saved, self.end_tick if due is None else due)
            sim.step(goal - sim.tick)
        commanded = {(command.tick, echo) for command in self.commands for echo in ECHOES.get(command.name, ())}
        own = [each for each in sim.events if each.tick >= self.start_tick and (each.tick, each.name) not in commanded]
        alarms = [_happening(event) for event in own]
        self.events = sorted(self.events + alarms, key=lambda event: event.time_s)[:EVENTS_MAX]
        self._compare_end(sim, place)

    def _compare_end(self, sim: Simulator, place: int) -> None:
        """Continue to the end of the recording (past a reset, if any), and compare the states."""
        end = self.recording.end
        if end is None:
            self._compare_messages()
            return
        for index in range(place, len(self.commands)):
            command = self.commands[index]
            if command.name not in JUMPS:
                sim.step(max(command.tick - sim.tick, 0))
            self.execute(sim, index)
            if command.name in JUMPS:
                self._read_as_recorded(sim)
        sim.step(max(end.tick - sim.tick, 0))
        if state_digest(sim) != end.state:
            raise self._refusal("was edited, or made on another kind of machine: it leads to another state")

    def _compare_messages(self) -> None:
        """Repeat the run once more, and compare all messages."""
        result = replay(self.recording, threads=self.threads, on_time=lambda time_ns: self._require_wanted())
        if result.difference is not None:
            raise self._refusal(f"was edited, or made on another kind of machine: {result.difference}")

    def _require_wanted(self) -> None:
        if not self._go_on():
            raise RuntimeError("the recording is not wanted any more")

    def _read_as_recorded(self, sim: Simulator) -> None:
        """Read the recorded channels once, like the recorder: the first reading of an estimate starts the filter."""
        _, channels = offered_channels(self.recording, sim)
        for channel in channels:
            if channel.name in self.recording.channels and channel.direction == "out" and not channel.delivery.late:
                channel.read(sim)

    def _note_command(self, command: Command) -> None:
        if command.name in self._unseen:
            return
        stream = self._stream
        is_soon = stream is not None and (command.tick - stream.first.tick) * self.step_s < MERGED_S
        if stream is not None and is_soon and (merged := stream.with_next(command)) is not None:
            self._stream = merged
            self.events[-1] = self.events[-1]._replace(text=merged.text, details=tuple(merged.details))
            return
        stream = CommandStream(command, command)
        self._note(command.tick, "command", stream.text, command.name, stream.vehicle, tuple(stream.details))
        self._stream = stream

    def _note(self, tick: int, kind: str, text: str, *more: Any) -> None:
        """Add an event, which ends the stream before it. more: its name, vehicle and details."""
        self._stream = None
        self.events.append(Happening(round(tick * self.step_s, 9), kind, text, *more))

    def _refusal(self, why: str) -> ValueError:
        return ValueError(f"recording '{self.recording.path}': {why}")


def _happening(event: Event) -> Happening:
    return Happening(event.time_s, "alarm", event.text, event.name, event.vehicle, tuple(event.details))
