"""Recording: reads a file message by message, even if the process that wrote it was killed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcap.records import Message

from uwsim.channels.ros.cdr import encode, schema
from uwsim.channels.ros.message_types import resolve
from uwsim.channels.ros.own_types import OWN_TYPES
from uwsim.recording import tables
from uwsim.recording.commands import COMMANDS, Command, command_of
from uwsim.recording.contents import NOT_OURS, read_contents, read_messages
from uwsim.recording.mcap_sink import END, START, SURVEY, VERSION, metadata_of
from uwsim.recording.messages import ChannelInfo, Recorded
from uwsim.recording.metadata import End, Start, checked
from uwsim.recording.pings import NAME as PINGS
from uwsim.recording.pings import taken_ping

if TYPE_CHECKING:
    import pandas
    import pyarrow
    import xarray

    from uwsim.recording.derived import Derived, Make


class Recording:
    """A recording written by a Recorder in .mcap format.

    start, end: the metadata at both ends; end is None if the run was killed. complete: whether the file was closed
    properly. attachments: keyed by name. channels: the recorded channels. derived: channels that are derived from a
    survey's pings and can be read by name as well.
    """

    def __init__(self, path: str | Path) -> None:
        """Read everything except the messages. Raises ValueError if the file is not a recording, or OSError."""
        self.path = Path(path)
        if self.path.suffix == ".bag":
            raise ValueError(f"recording '{path}': ROS 1 bags cannot be read; record to .mcap instead")
        contents = read_contents(self.path)
        metadata = contents.metadata
        if START not in metadata:
            raise ValueError(f"recording '{path}': {NOT_OURS}, or is still empty")
        self._require_our_version(metadata[START])
        self.complete, self.attachments = contents.complete, contents.attachments
        self._channels, self._schemas = contents.channels, contents.schemas
        self._counts, self._chunks = contents.counts, contents.chunks
        self._last_ns = contents.last_ns
        try:
            self.start = checked(Start, metadata[START])
            self.end = checked(End, metadata[END]) if END in metadata and contents.is_whole else None
        except ValueError as error:
            raise ValueError(f"recording '{path}': {error}") from None
        self._require_our_types()

    def __repr__(self) -> str:
        whole = "" if self.complete else ", incomplete"
        return (
            f"<Recording '{self.path}': {len(self._channels)} channels, {sum(self._counts.values())} messages{whole}>"
        )

    @cached_property
    def channels(self) -> dict[str, ChannelInfo]:
        """The recorded channels, keyed by name."""
        found = {}
        for number, channel in self._channels.items():
            name = channel.topic.removeprefix("/")
            rate = channel.metadata.get("rate_hz") or None
            kind = self._schemas[channel.schema_id].name
            count = self._counts.get(number, 0)
            found[name] = ChannelInfo(name, kind, count, None if rate is None else float(rate))
        return found

    @cached_property
    def derived(self) -> dict[str, ChannelInfo]:
        """The channels, keyed by name, that were not recorded but can be derived from a survey's pings."""
        if self._derived is None:
            return {}
        count = self.channels[PINGS].message_count
        return {
            channel.name: ChannelInfo(channel.name, channel.type, count, channel.rate_hz)
            for channel in self._derived.channels.values()
            if channel.name not in self.channels
        }

    @cached_property
    def _derived(self) -> Derived | None:
        if self.start.kind != SURVEY or PINGS not in self.channels:
            return None
        from uwsim.recording.derived import Derived  # imported here: rarely needed, and it builds a sonar

        return Derived(self)

    def info(self, topic: str) -> ChannelInfo:
        """Return information about a channel, recorded or derived. Raises ValueError if it is unknown."""
        name = self._named(topic)
        return self.channels[name] if name in self.channels else self.derived[name]

    def metadata(self, topic: str) -> dict[str, str]:
        """Return a channel's metadata from the file: QoS, type hash, rate, description. Raises ValueError."""
        name = self._named(topic)
        if name in self.channels:
            (number,) = self._numbers((name,))
            return dict(self._channels[number].metadata)
        assert self._derived is not None
        return metadata_of(self._derived.channels[name])

    @property
    def step_ns(self) -> int:
        """The duration of a step in nanoseconds."""
        return round(self.start.step_s * 1e9)

    @property
    def end_tick(self) -> int | None:
        """The tick of the end or, if the file was cut off, of its last whole chunk; None if it has no chunk."""
        if self.end is not None:
            return self.end.tick
        return None if self._last_ns is None else self._last_ns // self.step_ns

    @property
    def dropped(self) -> dict[str, int]:
        """The number of messages dropped on each channel because writing was too slow."""
        return {} if self.end is None else self.end.dropped

    @property
    def was_on_wall_clock(self) -> bool:
        """Whether the simulation may have run ahead of its pictures, so that their times depend on the machine.

        Assumed to be True for a run that was killed.
        """
        end = self.end
        return self.start.on_wall_clock or end is None or bool(end.on_wall_clock)

    @property
    def notes(self) -> dict[str, Any]:
        """Values that apply to the whole run. Values known only at its end are missing if the file was cut off."""
        return (self.end or self.start).notes

    def messages(self, *topics: str) -> Iterator[Recorded]:
        """Yield the messages on these topics, by default all recorded topics, in recording order.

        Messages derived from a ping follow it. Raises ValueError for an unknown topic.
        """
        names = [self._named(topic) for topic in topics]
        made = [name for name in names if name not in self.channels]
        wanted = self._numbers(name for name in names if name in self.channels) if names else set(self._channels)
        makers = self._derived.makers(made) if made and self._derived is not None else {}
        sources = self._numbers((PINGS,)) if makers else set()
        read = wanted | sources
        for message in read_messages(self.path, [chunk for chunk in self._chunks if chunk.channels & read]):
            if message.channel_id not in read:
                continue
            recorded = self._recorded(message)
            if message.channel_id in wanted:
                yield recorded
            if message.channel_id in sources:
                yield from self._made(recorded, makers)

    def _made(self, ping: Recorded, makers: Mapping[str, Make]) -> Iterator[Recorded]:
        """Yield the messages derived from a ping."""
        taken = taken_ping(ping.message)
        for name, make in makers.items():
            yield Recorded(name, self.derived[name].type, ping.time_ns, bytes(encode(make(taken))))

    def commands(self) -> Iterator[Command]:
        """Yield the commands in the order in which they took effect."""
        for recorded in self.messages(COMMANDS):
            yield command_of(recorded.message)

    def arrow(self, topic: str) -> pyarrow.Table:
        """Return a channel as an Arrow table; see uwsim.recording.tables."""
        return tables.arrow(self, self._named(topic))

    def pandas(self, topic: str) -> pandas.DataFrame:
        """Return a channel as a pandas DataFrame indexed by simulated seconds; see uwsim.recording.tables."""
        return tables.pandas_frame(self, self._named(topic))

    def xarray(self, topic: str) -> xarray.Dataset:
        """Return a channel as an xarray Dataset, in which arrays remain arrays; see uwsim.recording.tables."""
        return tables.dataset(self, self._named(topic))

    def _named(self, topic: str) -> str:
        name = topic.removeprefix("/")
        if name not in self.channels and name not in self.derived:
            names = ", ".join((*self.channels, *self.derived))
            raise ValueError(f"recording '{self.path}': topic '{topic}': must be one of {names}")
        return name

    def _recorded(self, message: Message) -> Recorded:
        channel = self._channels[message.channel_id]
        kind = self._schemas[channel.schema_id].name
        return Recorded(channel.topic.removeprefix("/"), kind, message.log_time, message.data)

    def _numbers(self, names: Iterable[str]) -> set[int]:
        numbers = {channel.topic.removeprefix("/"): number for number, channel in self._channels.items()}
        return {numbers[name] for name in names}

    def _require_our_version(self, start: Mapping[str, str]) -> None:
        version = start.get("version", "none")
        if version != VERSION:
            raise ValueError(f"recording '{self.path}': has version {version}: this uwsim reads {VERSION}")

    def _require_our_types(self) -> None:
        """Raise ValueError if a channel has no type, or a uwsim type whose fields differ from this version's."""
        for channel in self._channels.values():
            if channel.schema_id not in self._schemas:
                raise ValueError(f"recording '{self.path}': topic '{channel.topic}' has no type")
            try:
                resolve(self._schemas[channel.schema_id].name)
            except ValueError as error:
                raise ValueError(f"recording '{self.path}': topic '{channel.topic}': {error}") from None
        for found in self._schemas.values():
            if found.name in OWN_TYPES and _fields(found.data.decode()) != _fields(schema(found.name).text):
                raise ValueError(
                    f"recording '{self.path}': {found.name} has other fields in this version of uwsim than in the "
                    f"build that wrote it, {self.start.build}"
                )


def _fields(text: str) -> list[str]:
    """Return the lines of a message definition without its comments, which may change."""
    return [line for each in text.splitlines() if (line := " ".join(each.split("#")[0].split()))]
