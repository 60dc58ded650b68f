"""The /scene/* topics. They determine when scenes are built and when they are sent again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Generic, TypeVar

from foxglove.messages import SceneUpdate

from uwsim.bridges.foxglove.life import life
from uwsim.bridges.foxglove.places import ORIGIN_M, Follow, Leave, Vector, publish_truth, received_places, true_places
from uwsim.bridges.foxglove.scenes import Bodies, MapBlocks, Positions, Tracks, hulls, lake
from uwsim.bridges.foxglove.tethers import tethers
from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Job, Line, Outgoing
from uwsim.live import LiveSimulator
from uwsim.simulator.moving_shapes import moving_shapes, shape_poses
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.swarms import Swarm, swarm_places, swarms
from uwsim.simulator.tether import TetherReading

BODIES_S = 0.2  # between two looks for what moves, in simulated time
WAITING = 64  # updates per queue; none should be dropped, since each builds on the previous ones

T = TypeVar("T")
Send = Callable[[int, bytes], object]
"""Sends a message, passed with its simulated time [ns]."""
SendAll = Callable[[str, int, bytes], object]
"""Sends a topic's message to all its subscribers."""


class Show:
    """One scene topic. begin: called whenever a client subscribes. end: called when the last client has left."""

    def __init__(self, topic: str, outgoing: Outgoing, send: SendAll) -> None:
        self.topic = topic
        self._outgoing = outgoing
        self._line: Line[Job] = Line(topic, WAITING)
        self._send = partial(send, topic)

    def begin(self, newcomer: Send) -> None:
        """Send the complete scene to a new client, and subsequent changes to all clients."""

    def end(self) -> None:
        """Stop sending."""

    def _offer(self, make: Callable[[], SceneUpdate | None], time_ns: int, newcomer: Send | None = None) -> None:
        """Build a scene on the writer thread, and send it to the new client only or to all clients."""
        send = newcomer or self._send

        def write() -> bool:
            update = make()
            if update is not None:
                send(time_ns, update.encode())
            return True

        self._outgoing.offer(Line(self.topic, 1) if newcomer else self._line, write)


class StillShow(Show):
    """A scene that does not change. It is built once, and sent to each subscriber."""

    def __init__(
        self,
        topic: str,
        outgoing: Outgoing,
        send: SendAll,
        live: LiveSimulator,
        make: Callable[[], SceneUpdate],
    ) -> None:
        super().__init__(topic, outgoing, send)
        self._live = live
        self._make = make
        self._made: SceneUpdate | None = None

    def begin(self, newcomer: Send) -> None:
        """Send the scene."""
        self._offer(self._scene, self._live.simulator.time_ns, newcomer)

    def _scene(self) -> SceneUpdate:
        if self._made is None:
            self._made = self._make()
        return self._made


class TrackShow(Show):
    """The vehicle tracks since the first subscription."""

    def __init__(
        self, topic: str, outgoing: Outgoing, send: SendAll, live: LiveSimulator, listen: Callable[[Follow], Leave]
    ) -> None:
        super().__init__(topic, outgoing, send)
        self._live = live
        self._listen = listen
        self._tracks = Tracks()
        self._leave: Leave | None = None

    def begin(self, newcomer: Send) -> None:
        """Send all segments now, and later those that have grown."""
        time_ns = self._live.simulator.time_ns
        self._offer(lambda: self._tracks.whole(time_ns), time_ns, newcomer)
        if self._leave is None:
            self._leave = self._listen(self._grow)

    def end(self) -> None:
        """Stop recording positions."""
        if self._leave is not None:
            self._leave()
            self._leave = None

    def _grow(self, now: Positions, time_ns: int) -> None:
        self._offer(lambda: self._tracks.grown(now, time_ns), time_ns)


class BodyShow(Show):
    """Loose bodies and links of arms at their true poses."""

    def __init__(self, outgoing: Outgoing, send: SendAll, live: LiveSimulator) -> None:
        super().__init__("scene/objects", outgoing, send)
        self._live = live
        self._bodies = Bodies(live.simulator.scenario)
        self._leave: Leave | None = None

    def begin(self, newcomer: Send) -> None:
        """Send all bodies now, and later those that have moved."""
        time_ns = self._live.simulator.time_ns
        self._offer(lambda: self._bodies.whole(time_ns), time_ns, newcomer)
        if self._leave is None:
            self._leave = self._live.every(BODIES_S, _poses, lambda found: self._move(*found)).cancel

    def end(self) -> None:
        """Stop reading poses."""
        if self._leave is not None:
            self._leave()
            self._leave = None

    def _move(self, now: dict[str, Vector], time_ns: int) -> None:
        self._offer(lambda: self._bodies.moved(now, time_ns), time_ns)


def _poses(sim: Simulator) -> tuple[dict[str, Vector], int]:
    names = [body.name for body in moving_shapes(sim.scenario)]
    found = dict(zip(names, shape_poses(sim), strict=True))
    return found, sim.time_ns


class MovingShow(Show, Generic[T]):
    """Things that move all the time, as they truly are.

    read: returns them, on the stepping thread. make: returns their scene at a time [ns], on the writer thread.
    """

    def __init__(
        self,
        topic: str,
        outgoing: Outgoing,
        send: SendAll,
        live: LiveSimulator,
        read: Callable[[Simulator], T],
        make: Callable[[T, int], SceneUpdate],
    ) -> None:
        super().__init__(topic, outgoing, send)
        self._live, self._read, self._make = live, read, make
        self._leave: Leave | None = None

    def begin(self, newcomer: Send) -> None:
        """Start to send; a new client gets them with all others."""
        if self._leave is None:
            self._leave = self._live.every(BODIES_S, lambda sim: (self._read(sim), sim.time_ns), self._show).cancel

    def end(self) -> None:
        """Stop reading."""
        if self._leave is not None:
            self._leave()
            self._leave = None

    def _show(self, found: tuple[T, int]) -> None:
        now, time_ns = found
        self._offer(lambda: self._make(now, time_ns), time_ns)


def _tether_show(outgoing: Outgoing, send: SendAll, live: LiveSimulator) -> Show:
    def read(sim: Simulator) -> dict[str, TetherReading]:
        return {name: tether.read() for name, tether in sim.tethers.items()}

    def make(now: dict[str, TetherReading], time_ns: int) -> SceneUpdate:
        return tethers(now, live.simulator.scenario, time_ns)

    return MovingShow("scene/tethers", outgoing, send, live, read, make)


def _life_show(outgoing: Outgoing, send: SendAll, live: LiveSimulator, found: Sequence[Swarm]) -> Show:
    return MovingShow("scene/life", outgoing, send, live, partial(swarm_places, found=found), partial(life, found))


class MapShow(Show):
    """A vehicle's map, block by block."""

    def __init__(self, topic: str, outgoing: Outgoing, send: SendAll, feed: Readings, channel: Channel) -> None:
        super().__init__(topic, outgoing, send)
        self._feed = feed
        self._channel = channel
        self._blocks = MapBlocks()
        self._time_ns = 0  # time of the most recent changes
        self._leave: Callable[[], None] | None = None

    def begin(self, newcomer: Send) -> None:
        """Send all blocks now, and later those that have changed."""
        if self._leave is None:
            self._leave = self._feed.listen(self._channel, self._receive)
        else:
            self._offer(self._blocks.whole, self._time_ns, newcomer)

    def end(self) -> None:
        """Stop listening."""
        if self._leave is not None:
            self._leave()
            self._leave = None

    def _receive(self, reading: Reading) -> None:
        self._time_ns = reading.time_ns
        self._offer(lambda: self._blocks.changed(reading), reading.time_ns)


def shows_of(
    live: LiveSimulator | None,
    channels: Iterable[Channel],
    feed: Readings,
    outgoing: Outgoing,
    send: SendAll,
    origin_m: Vector = ORIGIN_M,
) -> list[Show]:
    """Return the shows for a simulator. Without a simulator, return only those that can be derived from channels.

    origin_m: the world's origin in odom (3,).
    """
    channels = list(channels)
    found = [] if live is None else _shows_of_world(live, channels, feed, outgoing, send, origin_m)
    for channel in channels:
        if channel.name.rpartition("/")[2] == "map_changes":
            prefix = channel.name.removesuffix("map_changes")
            found.append(MapShow(f"scene/{prefix}map", outgoing, send, feed, channel))
    return found


def _shows_of_world(
    live: LiveSimulator,
    channels: Sequence[Channel],
    feed: Readings,
    outgoing: Outgoing,
    send: SendAll,
    origin_m: Vector,
) -> list[Show]:
    scenario, has_link = live.simulator.scenario, live.simulator.link is not None
    alone = len(scenario.vehicles) == 1
    has_truth = not has_link and publish_truth(channels)
    frames = {entry.name: _body_frame("" if alone else f"{entry.name}/", channels) for entry in scenario.vehicles}
    return [
        StillShow("scene/lake", outgoing, send, live, lambda: lake(scenario)),
        StillShow("scene/vehicles", outgoing, send, live, lambda: hulls(scenario, frames)),
        TrackShow("scene/track", outgoing, send, live, received_places(live, channels, feed, origin_m)),
        *([TrackShow("scene/true_track", outgoing, send, live, true_places(live))] if has_truth else []),
        *([BodyShow(outgoing, send, live)] if moving_shapes(scenario) and not has_link else []),
        *([_tether_show(outgoing, send, live)] if live.simulator.tethers and not has_link else []),
        *([_life_show(outgoing, send, live, found)] if (found := swarms(live.simulator)) and not has_link else []),
    ]


def _body_frame(prefix: str, channels: Sequence[Channel]) -> str:
    """Return the frame of a vehicle's commands, which may have a different prefix."""
    found = (channel.frame_id for channel in channels if f"/{channel.name}".endswith(f"/{prefix}cmd_vel"))
    return next(found, f"{prefix}base_link")
