"""Ros1Node: a live simulator as a ROS 1 node through Debian's rospy, without a bridge."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import Any

from uwsim.bridges.bridge import Bridge
from uwsim.bridges.ros1.raw_types import raw_type, read_message
from uwsim.bridges.ros1.rospy_module import load_rospy, require_master
from uwsim.bridges.ros1.services import offer_service
from uwsim.channels import Channel, Service
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Job, Line, Outgoing, queue_of
from uwsim.channels.families.description import descriptions
from uwsim.channels.names import NODE, checked_namespace
from uwsim.channels.ros.messages import to_bytes
from uwsim.live import LiveSimulator

CLOCK = "clock"
DEPTH = 10  # messages queued for a slow subscriber; beyond that, the oldest are dropped


class Ros1Node(Bridge):
    """The node uwsim, whose topics are a live simulator's channels. Its services use std_srvs or JSON topics.

        with LiveSimulator("lake") as live:
            table = Table(live.simulator)
            with Ros1Node(live, table.channels, table.services):
                ...

    A channel is read only while a node subscribes to it. Messages are encoded and published on a separate thread. Since
    rospy keeps a queue for each subscriber, no subscriber delays others or the steps. rospy allows one node per
    process. namespace: that of the node, whose full name must be unique. live: None if the feed plays a recording,
    which accepts no commands. Raises ValueError without rospy or a master.
    """

    peer = "a ROS 1 node"

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Sequence[Channel],
        services: Sequence[Service] = (),
        *,
        feed: Readings | None = None,
        namespace: str = "",
    ) -> None:
        self._rospy = rospy = load_rospy()
        self.master = require_master()
        super().__init__("ros1", live, channels, services, feed)
        if checked_namespace(namespace):  # which rospy otherwise reads from ROS_NAMESPACE, only when it is imported
            rospy.names._set_caller_id(f"/{checked_namespace(namespace)}/unnamed")
        # Otherwise rospy would replace our logging, and, if use_sim_time is set, wait for our clock.
        rospy.init_node(NODE, argv=[], disable_signals=True, disable_rostime=True)
        if CLOCK in self.outputs:
            rospy.set_param("/use_sim_time", True)
        described = {} if live is None else descriptions(channels, live.simulator)
        for name, text in described.items():  # RViz and robot_state_publisher read it as a parameter
            rospy.set_param(f"/{name}", text)
        self._outgoing = Outgoing("uwsim-ros1")
        self._lines: dict[str, Line[Job]] = {
            name: Line(name, queue_of(channel.type), channel.drops) for name, channel in self.outputs.items()
        }
        self._publishers: dict[str, Any] = {}
        self._sequences: Counter[str] = Counter()
        self.start_updates()
        for name in self.outputs:
            with self._lock:  # a waiting subscriber demands the channel immediately, on one of rospy's threads
                self._publishers[name] = self._publisher(name)
        self._subscribers = [self._subscriber(channel) for channel in self.inputs.values()]
        self._offered = [offer_service(rospy, self, service) for service in self.services.values()]

    def close(self) -> bool:
        """Leave the graph; the master and all subscribers are notified."""
        was_open = super().close()
        if was_open:
            self._outgoing.close()
            self._rospy.signal_shutdown("uwsim ends")
        return was_open

    def _publisher(self, name: str) -> Any:
        channel = self.outputs[name]

        class Demand(self._rospy.SubscribeListener):  # type: ignore[misc, name-defined]
            def peer_subscribe(demand, topic: str, publish: Any, publish_to_peer: Any) -> None:  # noqa: N805
                self.demand(name, True)

            def peer_unsubscribe(demand, topic: str, peers: int) -> None:  # noqa: N805
                if not peers and not channel.delivery.latched:  # rospy itself passes on the latest latched message
                    self.demand(name, False)

        return self._rospy.Publisher(
            f"/{name}",
            raw_type(channel.type),
            Demand(),
            latch=channel.delivery.latched,
            queue_size=DEPTH,
            tcp_nodelay=True,
        )

    def _subscriber(self, channel: Channel) -> Any:
        subscriber = self._rospy.Subscriber(
            f"/{channel.name}",
            raw_type(channel.type),
            lambda received: self.receive(channel, received.data, read_message),
            queue_size=DEPTH,
            tcp_nodelay=True,
        )
        remove = subscriber.impl.remove_connection

        def removed(connection: Any) -> None:
            """Detect the departure of the last publisher, for which rospy has no callback."""
            remove(connection)
            if not subscriber.get_num_connections():
                self.abandon(channel)

        subscriber.impl.remove_connection = removed
        return subscriber

    def take(self, reading: Reading) -> None:
        """Queue a reading on the simulator's thread."""
        self._outgoing.offer(self._lines[reading.channel.name], partial(self._publish, reading))

    def _publish(self, reading: Reading) -> bool:
        channel = reading.channel
        data = to_bytes(reading.message, 1, self._sequences[channel.name])
        self._sequences[channel.name] += 1
        self._publishers[channel.name].publish(raw_type(channel.type)(data))
        return True

    def refuse(self, reason: str) -> None:
        """Report a rejected command on /rosout."""
        self._rospy.logwarn(reason)
