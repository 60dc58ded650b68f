"""Replay: rebuild a recording's scenario, repeat its commands, and compare the messages byte for byte."""

from __future__ import annotations

import tempfile
import time
import warnings
import weakref
from collections import Counter, defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from uwsim.base.commands import bound_command
from uwsim.base.journal import JUMPS
from uwsim.channels import Channel, Table
from uwsim.channels.calls.services import SET_STREAM
from uwsim.channels.delivery.pictures import Stream
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.own_types import MAP_CHANGES
from uwsim.link import seen_channels
from uwsim.recording.capsule import unpack
from uwsim.recording.commands import COMMANDS, Command, command_of
from uwsim.recording.diff import differences
from uwsim.recording.mcap_sink import SURVEY
from uwsim.recording.messages import Recorded
from uwsim.recording.moments import Moments
from uwsim.recording.pings import NAME, ping_channel, survey_ping
from uwsim.recording.reader import Recording
from uwsim.recording.recorder import MAP_TYPE, STATE, state_digest
from uwsim.recording.watch import Watch
from uwsim.scenario.fingerprint import BuildWarning, warn_of_other_build
from uwsim.simulator.simulator import Simulator


class Pacer:
    """Waits until a simulated time is due.

    The schedule starts with the first call and after simulated time goes back.
    """

    def __init__(self, speed: float | Literal["max"]) -> None:
        """speed: simulated seconds per wall-clock second, or "max". Raises ValueError."""
        if speed != "max" and not 1e-3 <= speed <= 1e6:  # false for NaN as well
            raise ValueError(f"speed = {speed:g}: must be in [0.001, 1000000], or max")
        self._speed = speed
        self._zero_s = 0.0
        self._last_ns: int | None = None

    def wait(self, time_ns: int) -> None:
        """Wait until the given simulated time is due."""
        if self._speed == "max":
            return
        due_s = 1e-9 * time_ns / self._speed
        if self._last_ns is None or time_ns < self._last_ns:
            self._zero_s = time.monotonic() - due_s
        self._last_ns = time_ns
        time.sleep(max(self._zero_s + due_s - time.monotonic(), 0.0))


OnTime = Callable[[int], None]
"""Called with the simulated time before each recorded message is compared; may wait to control the pace."""


@dataclass
class ReplayResult:
    """The result of a replay. sim: the simulator at the end. messages: number of messages compared, by channel.

    commands: number of commands issued. difference: the first difference, or None if everything is bit-identical.
    state_compared: whether the final state was compared, which requires a recording that was closed properly and
    replayed to its end. left_out: messages missing from the recording because writing was too slow or pictures were
    late. not_compared: channels that do not depend on the simulator alone, such as the pace relative to the wall clock.
    """

    sim: Simulator
    messages: Counter[str] = field(default_factory=Counter)
    left_out: Counter[str] = field(default_factory=Counter)
    commands: int = 0
    difference: str | None = None
    state_compared: bool = False
    not_compared: list[str] = field(default_factory=list)


def new_simulator(recording: Recording, threads: int | None = None) -> Simulator:
    """Return a simulator for the recording's scenario, in its initial state.

    Raises ValueError if this build cannot provide one.
    """
    if STATE not in recording.attachments:
        raise ValueError(f"recording '{recording.path}': holds no {STATE}")
    folder = tempfile.TemporaryDirectory(prefix="uwsim-replay-")
    sim = Simulator(unpack(recording.attachments, Path(folder.name)), threads=threads)
    weakref.finalize(sim, folder.cleanup)  # meshes are read again later, for example for the hull cut out of pings
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildWarning)  # the warning about the recording itself is enough
        sim.restore_state(recording.attachments[STATE])
    warn_of_other_build(f"recording '{recording.path}'", recording.start.build)
    return sim


def replay(
    recording: Recording | str | Path,
    *,
    from_s: float = 0.0,
    until_s: float | None = None,
    threads: int | None = None,
    on_time: OnTime | None = None,
    on_start: Callable[[Simulator], None] = lambda sim: None,
) -> ReplayResult:
    """Repeat a recorded run and compare it with the recording, up to the first difference.

    from_s, until_s: simulated times between which messages are compared. on_start: called with the simulator before
    its first step. Raises ValueError or OSError.
    """
    recording = recording if isinstance(recording, Recording) else Recording(recording)
    if until_s is not None and not from_s <= until_s:
        raise ValueError(f"until = {until_s} s: must be at least from = {from_s} s")
    repeated = _Replay(recording, threads, round(from_s * 1e9), on_time)
    on_start(repeated.result.sim)
    return repeated.run(None if until_s is None else round(until_s * 1e9))


def offered_channels(recording: Recording, sim: Simulator) -> tuple[Table, list[Channel]]:
    """Return a table with the recording's options, and the channels that were available to the recorder."""
    start = recording.start
    table = Table(
        sim,
        origin=start.origin,
        truth=start.truth,
        tf=start.tf,
        frame_prefix=start.frame_prefix,
        tf_rate_hz=start.tf_rate_hz,
        joint_frames=start.joint_frames,
        thruster_topics=True,  # which cost nothing unless they were recorded
    )
    known = seen_channels(sim, table) if start.through_link else table.channels
    for key, stream in start.streams.items():
        table.pictures.set_stream(key, stream)
    if start.kind != SURVEY:  # a survey has its own ping times: its pings are repeated at their recorded times
        known = known + [ping_channel(pings) for pings in table.pings.values()]
    return table, known


def execute(sim: Simulator, table: Table | None, command: Command) -> None:
    """Apply a recorded command to a simulator at its current tick. Raises ValueError.

    table: the table whose pictures were recorded, or None.
    """
    try:
        if command.name in JUMPS:
            getattr(sim, command.name)(**command.arguments)
        elif command.name == SET_STREAM:
            arguments = dict(command.arguments)
            if table is not None:
                table.pictures.set_stream(arguments.pop("key"), Stream(**arguments))
        else:
            bound_command(command.name, command.arguments)(sim)
    except (KeyError, TypeError) as error:  # for arguments that no recorder writes
        raise ValueError(f"{command.name}: {error}") from None


class _Replay:
    """A replay in progress. _replayed: replayed messages not yet compared."""

    def __init__(self, recording: Recording, threads: int | None, from_ns: int, on_time: OnTime | None) -> None:
        self._recording = recording
        self._from_ns = from_ns
        self._on_time = on_time
        self._sim = sim = new_simulator(recording, threads)
        self.result = ReplayResult(sim)
        self._epoch = 0  # number of jumps in time so far
        self._replayed: dict[str, deque[tuple[int, int, bytes]]] = defaultdict(deque)  # epoch, time, data
        self._is_survey = recording.start.kind == SURVEY
        start = recording.start
        self._table, known = offered_channels(recording, sim)
        table = self._table
        pictures = [channel for channel in table.channels if channel.delivery.late]
        chosen = [channel for channel in known if channel.name in recording.channels and channel.direction == "out"]
        unlike = {MAP_TYPE, MAP_CHANGES} if start.map_is_older else set()  # has pings from before the recording
        on_wall_clock = recording.was_on_wall_clock
        chosen = [c for c in chosen if not (c.delivery.pieced and on_wall_clock) and c.type not in unlike]
        self._compared = {channel.name for channel in chosen}
        own = {COMMANDS, *(channel.name for channel in known if channel.direction == "in")}
        own |= {NAME} if self._is_survey else set()
        self.result.not_compared = sorted(recording.channels.keys() - self._compared - own)
        self._late = {channel.name for channel in chosen if channel.delivery.late and on_wall_clock}
        self._may_lack = bool(recording.dropped) or not recording.complete
        late = recording.messages(*self._late) if self._late else ()
        self._moments = Moments(sim, pictures, table.pictures, (one for one in late if one.time_ns >= from_ns))
        watched = [channel for channel in chosen if channel.name not in self._late]
        self._watch = Watch(sim, watched, self._collect, self._jumped)

    def run(self, until_ns: int | None) -> ReplayResult:
        self._watch.start()
        self._moments.start()
        try:
            ended = self._repeat(until_ns)
        finally:
            self._moments.stop()
            self._watch.stop()
        end = self._recording.end
        if ended and end and self.result.difference is None:
            self._count_what_is_left()
            self._advance(end.tick)
            self.result.state_compared = True
            if self.result.difference is None and state_digest(self._sim) != end.state:
                self.result.difference = f"tick {end.tick}: the simulator's state at the end is another"
        return self.result

    def _count_what_is_left(self) -> None:
        """Count the replayed messages after the last recorded message of each channel."""
        for topic, replayed in self._replayed.items():
            if replayed and not self._may_lack:
                tick = replayed[0][1] // self._recording.step_ns
                self.result.difference = f"tick {tick}, /{topic}: the replay says what was not recorded"
                return
            self.result.left_out[topic] += len(replayed)
        self.result.left_out = +self.result.left_out

    def _repeat(self, until_ns: int | None) -> bool:
        """Step through the recording; return whether its end was reached."""
        for recorded in self._recording.messages():
            if until_ns is not None and recorded.time_ns > until_ns:
                return False
            if self._on_time is not None:
                self._on_time(recorded.time_ns)
            if recorded.topic == COMMANDS:
                self._execute(command_of(recorded.message))
            elif recorded.topic in self._compared:
                self._advance(recorded.time_ns // self._recording.step_ns)
                if recorded.time_ns >= self._from_ns:
                    self._compare(recorded)
            elif recorded.topic == NAME and self._is_survey:
                self._advance(recorded.time_ns // self._recording.step_ns)
                self._compare_data(recorded, bytes(encode(survey_ping(self._sim))))
            if self.result.difference is not None:
                return False
        return True

    def _execute(self, command: Command) -> None:
        self._advance(command.tick)
        self.result.commands += 1
        try:
            execute(self._sim, self._table, command)
        except ValueError as error:
            raise ValueError(f"recording '{self._recording.path}': tick {command.tick}: {error}") from None
        self._moments.again()

    def _advance(self, tick: int) -> None:
        if tick > self._sim.tick:
            self._sim.step(tick - self._sim.tick)

    def _jumped(self, name: str, arguments: dict[str, Any]) -> None:
        self._epoch += name in JUMPS

    def _collect(self, channel: Channel, message: Any) -> None:
        data = bytes(encode(message))
        if self._sim.time_ns >= self._from_ns:
            self._replayed[channel.name].append((self._epoch, self._sim.time_ns, data))

    def _compare(self, recorded: Recorded) -> None:
        topic, now = recorded.topic, (self._epoch, recorded.time_ns)
        where = f"tick {recorded.time_ns // self._recording.step_ns}, /{topic}"
        if topic in self._late:
            if not self._moments.shows(recorded):
                self.result.difference = f"{where}: the replay sees another picture at the time of its stamp"
            self.result.messages[topic] += 1
            return
        replayed = self._replayed[topic]
        while replayed and replayed[0][:2] < now:
            replayed.popleft()
            self.result.left_out[topic] += 1
            if not self._may_lack:
                self.result.difference = f"{where}: the replay says something at a time at which nothing was recorded"
                return
        if not replayed or replayed[0][:2] != now:
            self.result.difference = f"{where}: the replay says nothing"
            return
        self._compare_data(recorded, replayed.popleft()[2])

    def _compare_data(self, recorded: Recorded, data: bytes) -> None:
        self.result.messages[recorded.topic] += 1
        if data != recorded.data:
            where = f"tick {recorded.time_ns // self._recording.step_ns}, /{recorded.topic}"
            self.result.difference = f"{where}: recorded, replayed: {differences(recorded.type, recorded.data, data)}"
