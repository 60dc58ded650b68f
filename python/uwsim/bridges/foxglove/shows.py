"""The /scene/* topics. They determine when scenes are built and when they are sent again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial
from typing import TypeVar

from foxglove.messages import SceneUpdate

from uwsim.bridges.foxglove.life import life
from uwsim.bridges.foxglove.places import ORIGIN_M, Follow, Leave, Vector, publish_truth, received_places, true_places
from uwsim.bridges.foxglove.scenes import Bodies, MapBlocks, Tracks, hulls, lake
from uwsim.bridges.foxglove.tethers import tethers
from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Job, Line, Outgoing
from uwsim.live import LiveSimulator
from uwsim.simulator.moving_shapes import moving_shapes, shape_poses, swarm_places, swarms
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.tether import TetherReading

BODIES_S = 0.2  # between two looks for what moves, in simulated time
WAITING = 64  # updates per queue; none should be dropped, since each builds on the previous ones

T = TypeVar("T")
Send = Callable[[int, bytes], object]
"""Sends a message, passed with its simulated time [ns]."""
SendAll = Callable[[str, int, bytes], object]
"""Sends a topic's message to all its subscribers."""
Make = Callable[[int], SceneUpdate | None]
"""Makes a scene at a time [ns]."""
Offer = Callable[[Make, int], object]
"""Has a scene made for all subscribers, at a time [ns]."""


class Show:
    """One scene topic.

    now_ns: returns the time of the complete scene. whole: returns it, at that time, for a new client, if there is any.
    follow: starts to offer changes; returns a function that ends this. Scenes are made on the writer thread.
    """

    def __init__(
        self, outgoing: Outgoing, send: SendAll, now_ns: Callable[[], int], topic: str, whole: Make | None,
        follow: Callable[[Offer], Leave] | None,
    ) -> None:  # fmt: skip
        self.topic = topic
        self._outgoing, self._now_ns, self._whole, self._follow = outgoing, now_ns, whole, follow
        self._line: Line[Job] = Line(topic, WAITING)
        self._send = partial(send, topic)
        self._leave: Leave | None = None

    def begin(self, newcomer: Send) -> None:
        """Send the complete scene to a new client, and subsequent changes to all clients."""
        if self._whole is not None:
            self._write(Line(self.topic, 1), newcomer, self._whole, self._now_ns())
        if self._follow is not None and self._leave is None:
            self._leave = self._follow(partial(self._write, self._line, self._send))

    def end(self) -> None:
        """Stop sending, since the last client has left."""
        if self._leave is not None:
            self._leave()
            self._leave = None

    def _write(self, line: Line[Job], send: Send, make: Make, time_ns: int) -> None:
        def write() -> bool:
            update = make(time_ns)
            if update is not None:
                send(time_ns, update.encode())
            return True

        self._outgoing.offer(line, write)


def _still(make: Callable[[], SceneUpdate]) -> Make:
    """Return a scene that does not change, and is made once."""
    made = cache(make)
    return lambda time_ns: made()


def _grown(tracks: Tracks, listen: Callable[[Follow], Leave]) -> Callable[[Offer], Leave]:
    """Return a function that offers tracks as they grow."""
    return lambda offer: listen(lambda now, time_ns: offer(partial(tracks.grown, now), time_ns))


def _moving(
    live: LiveSimulator, read: Callable[[Simulator], T], make: Callable[[T, int], SceneUpdate | None]
) -> Callable[[Offer], Leave]:
    """Return a function that offers what moves, as it truly is. read: returns it, on the stepping thread."""

    def follow(offer: Offer) -> Leave:
        def show(found: tuple[T, int]) -> None:
            offer(partial(make, found[0]), found[1])

        return live.every(BODIES_S, lambda sim: (read(sim), sim.time_ns), show).cancel

    return follow


def _poses(sim: Simulator) -> dict[str, Vector]:
    return dict(zip((body.name for body in moving_shapes(sim.scenario)), shape_poses(sim), strict=True))


def _tethers(sim: Simulator) -> dict[str, TetherReading]:
    return {name: tether.read() for name, tether in sim.tethers.items()}


def _drawn_tethers(live: LiveSimulator, now: dict[str, TetherReading], time_ns: int) -> SceneUpdate:
    return tethers(now, live.simulator.scenario, time_ns)


def _map(outgoing: Outgoing, send: SendAll, feed: Readings, channel: Channel) -> Show:
    """Return a vehicle's map, block by block: the feed offers all of it at first."""
    blocks = MapBlocks()

    def follow(offer: Offer) -> Leave:
        def take(reading: Reading) -> None:
            offer(lambda time_ns: blocks.changed(reading), reading.time_ns)

        leave = feed.listen(channel, take)

        def end() -> None:
            leave()
            blocks.forget()

        return end

    topic = f"scene/{channel.name.removesuffix('map_changes')}map"
    return Show(outgoing, send, blocks.time_ns, topic, lambda time_ns: blocks.whole(), follow)


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
    found: list[Show] = []
    if live is not None:
        show = partial(Show, outgoing, send, lambda: live.simulator.time_ns)
        found = _shows_of_world(show, live, channels, feed, origin_m)
    maps = [channel for channel in channels if channel.name.rpartition("/")[2] == "map_changes"]
    return [*found, *(_map(outgoing, send, feed, channel) for channel in maps)]


def _shows_of_world(
    show: Callable[[str, Make | None, Callable[[Offer], Leave] | None], Show], live: LiveSimulator,
    channels: Sequence[Channel], feed: Readings, origin_m: Vector,
) -> list[Show]:  # fmt: skip
    sim, scenario = live.simulator, live.simulator.scenario
    alone = len(scenario.vehicles) == 1
    frames = {entry.name: _body_frame("" if alone else f"{entry.name}/", channels) for entry in scenario.vehicles}
    own, true, bodies = Tracks(), Tracks(), Bodies(scenario)
    found = [
        show("scene/lake", _still(lambda: lake(scenario)), None),
        show("scene/vehicles", _still(lambda: hulls(scenario, frames)), None),
        show("scene/track", own.whole, _grown(own, received_places(live, channels, feed, origin_m))),
    ]
    if sim.link is not None:
        return found
    if publish_truth(channels):
        found.append(show("scene/true_track", true.whole, _grown(true, true_places(live))))
    if moving_shapes(scenario):
        found.append(show("scene/objects", bodies.whole, _moving(live, _poses, bodies.moved)))
    if sim.tethers:
        found.append(show("scene/tethers", None, _moving(live, _tethers, partial(_drawn_tethers, live))))
    if swarming := swarms(sim):
        read = partial(swarm_places, found=swarming)
        found.append(show("scene/life", None, _moving(live, read, partial(life, swarming))))
    return found


def _body_frame(prefix: str, channels: Sequence[Channel]) -> str:
    """Return the frame of a vehicle's commands, which may have a different prefix."""
    found = (channel.frame_id for channel in channels if f"/{channel.name}".endswith(f"/{prefix}cmd_vel"))
    return next(found, f"{prefix}base_link")
