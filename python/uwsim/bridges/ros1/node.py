"""Ros1Node: a live simulator as a node of ROS 1, by Debian's rospy, without a bridge."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

from uwsim.bridges.ros1.raw_types import raw_type, read_message
from uwsim.bridges.ros1.rospy_module import load_rospy, require_master
from uwsim.bridges.ros1.services import offer_service
from uwsim.channels import Channel, Service, keep_up, require_live
from uwsim.channels.feed import Feed, Reading, Readings
from uwsim.channels.messages import to_bytes
from uwsim.live import LiveSimulator, NotRunningError

NAME = "uwsim"
CLOCK = "clock"
DEPTH = 10  # messages that wait for a slow subscriber; the oldest give way
WAITING = 256  # readings on their way to rospy; the oldest give way
COMMAND_BYTES_MAX = 1 << 20

logger = logging.getLogger("uwsim.ros1")


class Ros1Node:
    """The node /uwsim, whose topics are the channels of a live simulator; services as std_srvs or JSON topics.

        with LiveSimulator("lake") as live, Ros1Node(live, channels(live.simulator), services(live.simulator)):
            ...

    A channel is read while somebody subscribes to it. Messages are encoded and published on a thread of their own;
    rospy keeps a queue for each subscriber, so that none delays the others or the steps. One node a process, as rospy
    has it. live: None with the feed of a recording, to which nobody can say anything. Raises ValueError without rospy
    or a master.
    """

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Sequence[Channel],
        services: Sequence[Service] = (),
        *,
        feed: Readings | None = None,
    ) -> None:
        self._rospy = rospy = load_rospy()
        self.master = require_master()
        self._live = live
        self._feed = feed or Feed(require_live(live))
        self._ends: dict[str, Callable[[], None]] = {}
        self._publishers: dict[str, Any] = {}
        self._lock = threading.Lock()
        self._waiting: deque[Reading] = deque(maxlen=WAITING)
        self._arrived = threading.Condition()
        self._stopping = False
        # Its own log would replace ours; the master's use_sim_time would make rospy wait for our clock.
        rospy.init_node(NAME, argv=[], disable_signals=True, disable_rostime=True)
        if any(channel.name == CLOCK and channel.direction == "out" for channel in channels):
            rospy.set_param("/use_sim_time", True)
        self._thread = threading.Thread(target=self._publish, name="uwsim-ros1", daemon=True)
        self._thread.start()
        self._going_on = keep_up(live, channels)
        self._topics = [self._join(channel) for channel in channels]
        self._topics += [offer_service(rospy, require_live(live), service) for service in services]

    def close(self) -> None:
        """Leave the graph: the master and all subscribers are told."""
        if self._stopping:
            return
        for subscription in self._going_on:
            subscription.cancel()
        with self._lock:
            for end in self._ends.values():
                end()
            self._ends.clear()
        with self._arrived:
            self._stopping = True
            self._arrived.notify_all()
        self._thread.join(5.0)
        self._rospy.signal_shutdown("uwsim ends")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _join(self, channel: Channel) -> Any:
        rospy, name, kind = self._rospy, "/" + channel.name, raw_type(channel.type)
        if channel.direction == "in":
            return rospy.Subscriber(
                name, kind, lambda received: self._apply(channel, received.data), queue_size=DEPTH, tcp_nodelay=True
            )

        class Demand(rospy.SubscribeListener):  # type: ignore[misc, name-defined]
            def peer_subscribe(demand, topic: str, publish: Any, publish_to_peer: Any) -> None:  # noqa: N805
                self._demand(channel, wanted=True)

            def peer_unsubscribe(demand, topic: str, peers: int) -> None:  # noqa: N805
                self._demand(channel, wanted=peers > 0)

        with self._lock:  # a subscriber that waits already must find the publisher
            publisher = self._publishers[channel.name] = rospy.Publisher(
                name, kind, Demand(), latch=channel.latched, queue_size=DEPTH, tcp_nodelay=True
            )
        return publisher

    def _demand(self, channel: Channel, *, wanted: bool) -> None:
        """Begin or end to read a channel. On rospy's threads."""
        with self._lock:
            if wanted and channel.name not in self._ends and not self._stopping:
                try:
                    self._ends[channel.name] = self._feed.listen(channel, self._take)
                except NotRunningError:
                    logger.warning("topic '%s': the simulator does not run", channel.name)
            elif not wanted and channel.name in self._ends and not channel.latched:
                self._ends.pop(channel.name)()

    def _take(self, reading: Reading) -> None:
        """Queue a reading, on the simulator's thread."""
        with self._arrived:
            self._waiting.append(reading)
            self._arrived.notify()

    def _publish(self) -> None:
        while True:
            with self._arrived:
                while not self._waiting and not self._stopping:
                    self._arrived.wait()
                if self._stopping:
                    return
                reading = self._waiting.popleft()
            try:
                self._publishers[reading.channel.name].publish(
                    raw_type(reading.channel.type)(to_bytes(reading.message, ros=1))
                )
            except Exception:
                if not self._stopping:
                    logger.exception("topic '%s': could not be published", reading.channel.name)

    def _apply(self, channel: Channel, data: bytes) -> None:
        """Apply a command, on a thread of rospy's. What cannot be done is said on /rosout."""
        try:
            if len(data) > COMMAND_BYTES_MAX:
                raise ValueError(f"{len(data)} bytes: must be {COMMAND_BYTES_MAX} at most")
            channel.apply(require_live(self._live), read_message(data, channel.type))
        except (ValueError, RuntimeError) as error:
            self._rospy.logwarn(f"/{channel.name}: {error}")
