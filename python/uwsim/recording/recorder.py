"""Recorder: writes a simulator's messages and commands to a file, from which the run can be replayed."""

from __future__ import annotations

import fnmatch
import hashlib
import json
import logging
import os
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from uwsim.base.arguments import plain
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.base.journal import JUMPS
from uwsim.channels import Channel, Table
from uwsim.channels.delivery.feed import Feed, Reading
from uwsim.channels.ros.own_types import MAP_CHANGES
from uwsim.link import is_seen
from uwsim.live import LiveSimulator
from uwsim.recording.bag_sink import BagSink
from uwsim.recording.capsule import fingerprint, pack
from uwsim.recording.commands import COMMANDS, Command, JoinedFrames, command_message, end_tick
from uwsim.recording.derived import FROM_PINGS
from uwsim.recording.mcap_sink import LIVE, VERSION, McapSink
from uwsim.recording.pings import ping_channel
from uwsim.recording.sink import LAST, WAITING_BYTES, Held, Sink, WritingQueue
from uwsim.recording.watch import Messages, Watch
from uwsim.scenario.fingerprint import build_fingerprint
from uwsim.simulator.simulator import Simulator

STATE = "start.state"
MAP_TYPE = "octomap_msgs/msg/Octomap"

logger = logging.getLogger("uwsim.recording")


class Recorder:
    """Records a simulator's channels, commands, seed and scenario, from `start` to `close`.

        with LiveSimulator("lake") as live, Recorder(live, "run.mcap"):
            ...

    path: a new file, .mcap, or .bag for ROS 1 (which cannot be replayed). topics, without: patterns of channels to
    record and to omit, such as "camera/*". By default, all channels are recorded except raw and rectified pictures. If
    is_light, pictures, maps and the paper's topics beside the usual ones are omitted, which a replay can provide. For a
    survey, pictures and channels derived from the pings (FROM_PINGS and the map) are omitted, which readers can
    provide; see Recording.derived. shared: a server's channel table, so that pings and pictures are taken only once; by
    default a new one. feed: the feed of other sinks, such as a ROS 2 node, which then share the recorder's readings.
    kind: LIVE or SURVEY. written: channels whose messages come only from `write`. notes: plain values for the metadata.

    Messages are encoded on the simulator's thread and written on another. At wall-clock speed, steps never wait:
    messages that do not fit into the queue (queue_bytes) are dropped, counted in `dropped` and reported. At maximum
    speed, steps wait instead, and nothing is lost. For a Simulator, most messages are made from a tape, some time after
    they were read (see Watch). If the process is killed, all but the last second of its steps survives. Raises
    ValueError or OSError.
    """

    def __init__(
        self,
        simulator: Simulator | LiveSimulator,
        path: str | Path,
        *,
        topics: Sequence[str] | None = None,
        without: Sequence[str] = (),
        shared: Table | None = None,
        feed: Feed | None = None,
        kind: str = LIVE,
        written: Sequence[Channel] = (),
        notes: Mapping[str, Any] | None = None,
        is_light: bool = False,
        queue_bytes: int = WAITING_BYTES,
    ) -> None:
        self._live = simulator if isinstance(simulator, LiveSimulator) else None
        self._sim = simulator.simulator if isinstance(simulator, LiveSimulator) else simulator
        self.path = Path(path)
        if self.path.suffix not in (".mcap", ".bag"):
            raise ValueError(f"recording '{path}': must end in .mcap, or in .bag for ROS 1")
        self._feed = feed
        self._kind = kind
        self._is_light = is_light
        self._queue_bytes = queue_bytes
        self._notes = dict(notes or {})
        self.dropped: Counter[str] = Counter()
        self._sequences: Counter[str] = Counter()
        self._on_wall_clock = False  # at any time since the start
        self._written = list(written)
        self._patterns = topics, without
        self._lock = threading.Lock()
        self._table = Table(self._sim, may_wait=self._may_wait) if shared is None else shared
        self._channels = self._chosen(topics, without)
        self._watch: Watch | None = None
        self._queue: WritingQueue | None = None
        self._sink: Sink | None = None
        self._frames = JoinedFrames()
        self._tapes = self._live is None and feed is None and self.path.suffix == ".mcap"  # nothing else waits for them
        self._ranks = {channel.name: rank for rank, channel in enumerate(self._channels)}
        self._held = Held()
        self._commands = Channel(COMMANDS, "std_msgs/msg/String", "out", "each command with its tick, as JSON")

    def __repr__(self) -> str:
        return f"<Recorder of {len(self._channels)} channels to '{self.path}'>"

    def _chosen(self, topics: Sequence[str] | None, without: Sequence[str]) -> list[Channel]:
        given = self._table.channels
        self._through_link = is_seen(self._sim, given)
        outgoing = [channel for channel in given if channel.direction == "out"]
        if self._kind == LIVE:
            if self._is_light and topics is None:
                twice = self._table.published if self._table.has_standard else frozenset()
                outgoing = [each for each in outgoing if not (_is_heavy(each) or each.name in twice)]
            outgoing += [ping_channel(pings) for pings in self._table.pings.values()]
        elif topics is None:
            outgoing = [channel for channel in outgoing if not self._follows(channel)]
        names = [channel.name for channel in outgoing] + [
            channel.name for channel in given if channel.direction == "in"
        ]
        for pattern in (*(topics or ()), *without):
            if not fnmatch.filter(names, pattern.removeprefix("/")):
                raise ValueError(
                    f"recording: topic '{pattern}': no channel has that name; there are {', '.join(names)}"
                )
        return [channel for channel in outgoing if self._is_chosen(channel)]

    def _follows(self, channel: Channel) -> bool:
        """Return whether a survey channel can be derived from the pings or (like pictures) from a replay."""
        from_pings = {self._table.sources[0].topic(name) for name in FROM_PINGS}
        is_truth_again = channel.name.endswith("ground_truth/odom")
        return _is_heavy(channel) or channel.name in from_pings or is_truth_again

    def _is_chosen(self, channel: Channel) -> bool:
        topics, without = self._patterns
        is_wanted = not channel.delivery.on_request if topics is None else _matches(channel, topics)
        return is_wanted and not _matches(channel, without)

    def _may_wait(self) -> bool:
        """Return whether steps may wait for the recording, which they may except at wall-clock speed."""
        return self._live is None or self._live.speed == "max"

    @property
    def error(self) -> OSError | None:
        """Why nothing more can be written, such as a full disk, or None."""
        return None if self._queue is None else self._queue.error

    def start(self, measured: AbstractContextManager[object] | None = None) -> Self:
        """Create the file and start recording; return self. Raises OSError or ValueError.

        measured: entered while channels are read and messages encoded, such as a stage's measurement.
        """
        if self._queue is not None:
            raise RuntimeError("the recorder has been started already")
        self._on_simulator(lambda sim: self._begin(sim, measured))
        return self

    def close(self) -> None:
        """Stop recording and finish the file. Raises OSError if anything could not be written."""
        if self._queue is None:
            return
        end = self._on_simulator(self._end)  # between steps, so that each tick is recorded completely
        queue, self._queue = self._queue, None
        try:
            queue.close(end)
        except OSError as error:
            raise OSError(f"recording '{self.path}': ends early: {error.strerror or error}") from error
        finally:
            is_kept = self._is_kept()
        if not is_kept:
            raise FileNotFoundError(f"recording '{self.path}': is lost: it was deleted during recording")
        if self.dropped:
            logger.warning("%s: %d messages were left out: %s", self.path, self.dropped.total(), dict(self.dropped))

    def try_close(self) -> OSError | None:
        """Close the file, and return any error, so that the caller can save other results before reporting it."""
        try:
            self.close()
        except OSError as error:
            return error
        return None

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the file."""
        self.close()

    def record_received(self, channels: Iterable[Channel]) -> list[Channel]:
        """Return a server's channels, wrapped so that messages received on them, such as /cmd_vel, are also recorded.

        Call this before `start`. These messages are for readers; a replay uses only the resulting commands.
        """
        return [self._recorded(channel) if channel.direction == "in" else channel for channel in channels]

    def _recorded(self, channel: Channel) -> Channel:
        if not self._is_chosen(channel):
            return channel
        self._written.append(channel)

        def apply(live: LiveSimulator, message: Any) -> object:
            result = channel.apply(live, message)
            self.write(channel, message)
            return result

        return replace(channel, apply=apply)

    def write(self, channel: Channel, message: Any) -> None:
        """Record a message at the current time on a channel that is not read automatically."""
        self._put(self._reading(channel, message), needed=False)

    def note(self, **notes: Any) -> None:
        """Add plain values to the metadata at the end of the file."""
        self._notes |= notes

    def _on_simulator(self, function: Callable[[Simulator], Any]) -> Any:
        """Call a function while no step is in progress."""
        if self._live is not None and self._live.running:
            return self._live.read(function).result()
        return function(self._sim)

    def _begin(self, sim: Simulator, measured: AbstractContextManager[object] | None) -> None:
        self._table.refresh()  # a replay has no data from before the recording
        self._sink = self._new_sink(sim)
        self._descriptor = os.open(self.path, os.O_RDONLY | os.O_CLOEXEC)
        for channel in (self._commands, *self._written, *self._channels):
            self._sink.add_channel(channel)
        self._queue = WritingQueue(self._sink, self._queue_bytes)
        tape = self._record_taped if self._tapes else None
        self._watch = Watch(sim, self._channels, self._record_reading, self._record_command, measured, tape)
        self._watch.start()

    def _end(self, sim: Simulator) -> dict[str, str]:
        assert self._watch is not None
        self._watch.stop()
        with self._lock:
            self._put_frames(self._frames.taken())
            self._put_held()
        return {
            "tick": str(sim.tick),
            "state": state_digest(sim),
            "dropped": json.dumps(self.dropped),
            "on_wall_clock": json.dumps(self._on_wall_clock),
            "notes": json.dumps(self._notes),
        }

    def _is_kept(self) -> bool:
        """Return whether the file still exists, even under a different name."""
        links = os.fstat(self._descriptor).st_nlink
        os.close(self._descriptor)
        return links > 0

    def _new_sink(self, sim: Simulator) -> Sink:
        try:
            if self.path.suffix == ".bag":
                return BagSink(self.path)
            contents = pack(sim.scenario)
            contents[STATE] = sim.save_state()
            return McapSink(self.path, self._start_metadata(sim), contents)
        except FileExistsError:
            raise FileExistsError(
                f"recording '{self.path}': exists already: remove it, or choose another name"
            ) from None
        except OSError as error:
            raise OSError(f"recording '{self.path}': cannot be written: {error.strerror or error}") from None

    def _start_metadata(self, sim: Simulator) -> dict[str, str]:
        return {
            "version": VERSION,
            "kind": self._kind,
            "scenario": sim.scenario.name,
            "seed": str(sim.seed),
            "step_s": repr(sim.step_s),
            "tick": str(sim.tick),
            "origin": json.dumps(self._table.origin_m.tolist()),
            "streams": json.dumps({key: asdict(stream) for key, stream in self._table.pictures.streams.items()}),
            "map_is_older": json.dumps(self._table.has_map),
            "truth": json.dumps(self._table.truth),
            "tf": self._table.tf,
            "frame_prefix": self._table.frame_prefix,
            "tf_rate_hz": repr(self._table.tf_rate_hz),
            "joint_frames": json.dumps(self._table.joint_frames),
            "through_link": json.dumps(self._through_link),
            "on_wall_clock": json.dumps(not self._may_wait()),
            "fingerprint": fingerprint(sim.scenario),
            "build": build_fingerprint(),
            "notes": json.dumps(self._notes),
            "begun": datetime.now(UTC).isoformat(timespec="seconds"),
        }

    def _record_reading(self, channel: Channel, message: Any) -> None:
        reading = self._reading(channel, message)
        if self._feed is not None:
            self._feed.share(reading)
        self._put(reading, needed=False, rank=self._ranks[channel.name])

    def _record_taped(self, stretches: Iterable[Messages]) -> None:
        """Queue the messages of a stretch of tape among those that have been held meanwhile."""
        with self._lock:
            for channel, times_ns, data in stretches:
                self._held.add_all(channel.name, times_ns, data, self._ranks[channel.name])
            self._put_held()

    def _record_command(self, name: str, arguments: dict[str, Any]) -> None:
        if name == SERVO_FRAMES:
            with self._lock:
                self._put_frames(self._frames.add(arguments))
            return
        message = command_message(Command(self._sim.tick, name, plain(arguments, name)))
        self._put(self._reading(self._commands, message), needed=True)
        if name in JUMPS:  # the readings after it, at the same time, must not be put before it
            with self._lock:
                self._put_held()

    def _put_frames(self, pieces: Iterable[dict[str, Any]]) -> None:
        """Queue an autopilot's frames, each piece at the tick at which it ends. Called with the lock held."""
        for arguments in pieces:
            tick = end_tick(arguments)
            message = command_message(Command(arguments["from_tick"], SERVO_FRAMES, plain(arguments, SERVO_FRAMES)))
            time_ns = tick * round(self._sim.step_s * 1e9)
            self._enqueue(Reading(self._commands, message, time_ns, tick), needed=True)

    def _reading(self, channel: Channel, message: Any) -> Reading:
        return Reading(channel, message, self._sim.time_ns, self._sim.tick)

    def _put(self, reading: Reading, *, needed: bool, rank: int = LAST) -> None:
        """Queue a message, or hold it until those on the tape before it are known. rank: see `Held`."""
        with self._lock:  # received messages come from other threads, and sequence numbers must follow the queue order
            self._put_frames(self._frames.taken())  # they end at this tick, before its readings and commands
            if self._tapes and self._sink is not None and self._queue is not None:
                self._held.add(reading.channel.name, reading.time_ns, self._sink.encode(reading), rank)
            else:
                self._enqueue(reading, needed=needed)

    def _put_held(self) -> None:
        """Queue messages that have been held. Called with the lock held."""
        messages = self._held.taken(self._sequences)
        if self._queue is not None and messages is not None:
            self._queue.put_all(messages)

    def _next(self, topic: str) -> int:
        """Return the number of a topic's next message."""
        number = self._sequences[topic]
        self._sequences[topic] = number + 1
        return number

    def _enqueue(self, reading: Reading, *, needed: bool) -> None:
        queue, sink = self._queue, self._sink
        if queue is None or sink is None:
            return
        topic, data, waits = reading.channel.name, sink.encode(reading), self._may_wait()
        self._on_wall_clock |= not waits
        is_put = queue.put((topic, reading.time_ns, self._next(topic), data), waits=waits, needed=needed)
        if not is_put:
            if not self.dropped and queue.error is None:
                logger.warning("%s: messages are left out: writing is too slow", self.path)
            self.dropped[topic] += 1


def _is_heavy(channel: Channel) -> bool:
    """Return whether a channel carries pictures (including sonars') or maps, which take most of the time and space."""
    return channel.delivery.late or channel.type in (MAP_TYPE, MAP_CHANGES)


def _matches(channel: Channel, patterns: Sequence[str]) -> bool:
    return any(fnmatch.fnmatchcase(channel.name, pattern.removeprefix("/")) for pattern in patterns)


def state_digest(sim: Simulator) -> str:
    """Return a digest that is the same for two simulators in exactly the same state."""
    return hashlib.blake2b(sim.save_state(), digest_size=16).hexdigest()
