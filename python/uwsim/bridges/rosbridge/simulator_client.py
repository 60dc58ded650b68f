"""RosbridgeClient: connects the simulator to a ROS graph through a rosbridge_server, as the paper's simulator did.

While connected, every topic is read at its rate, since rosbridge does not report whether a topic has subscribers. The
simulator's thread never waits. If the server closes the connection because a message was too large, messages of that
size or larger are no longer sent. A server that refuses everything is not called connected.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Self

from uwsim.bridges.bridge import Bridge
from uwsim.bridges.rare_log import RareLog
from uwsim.bridges.rosbridge.client import Client
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels import Channel, Service
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import queue_of
from uwsim.channels.ros.messages import Ros
from uwsim.live import LiveSimulator, NotRunningError

CLOCK = "clock"


class RosbridgeClient(Bridge):
    """Connects a live simulator to a rosbridge server.

    url: the server's URL, such as "ws://host:9090". channels, services: what to publish, subscribe to and offer. ros:
    the server's ROS generation if it does not show it; by default 1. feed: shared with other sinks. client: with its
    state, see Client. Raises ValueError.
    """

    peer = "a client of the rosbridge server"

    def __init__(
        self,
        live: LiveSimulator,
        url: str,
        *,
        channels: Iterable[Channel],
        services: Iterable[Service] = (),
        ros: Ros | None = None,
        limits: Limits | None = None,
        feed: Readings | None = None,
    ) -> None:
        super().__init__("rosbridge", live, channels, services, feed)
        self.url, rare = url, RareLog(self.log)
        self.client = client = Client(
            url, log=self.log, ros=ros, frame_bytes=(limits or Limits(frame_bytes=16 << 20)).frame_bytes,
            introduced=self._introduced, joined=self._joined, left=self._left, failed=self._failed,
            report=lambda text: rare.warning(f"{url}: {text}"),
        )  # fmt: skip
        for channel in self.outputs.values():
            queue, latch = queue_of(channel.type), channel.delivery.latched
            client.advertise(channel.name, channel.type, latch=latch, queue=queue, drops=channel.drops)
        for channel in self.inputs.values():
            client.subscribe(channel.name, channel.type, partial(self.apply, channel), options={"queue_length": 1})
        for service in self.services.values():
            client.serve(service.name, service.type, partial(self.call, service))
        self.connected, self.connections = client.connected, 0

    def __repr__(self) -> str:
        return f"<RosbridgeClient of {self.url}>"

    @property
    def refusals(self) -> str:
        """Sentences about our requests and messages that the server refuses."""
        return "" if self.client.joining is None else self.client.joining.sentences

    def start(self) -> Self:
        """Start connecting; return self."""
        self.client.start()
        return self

    def __enter__(self) -> Self:
        return self.start()

    def close(self) -> bool:
        """Disconnect and stop the thread."""
        was_open = super().close()
        self.client.close()
        return was_open

    stop = close

    def take(self, reading: Reading) -> None:
        """Queue a reading on the simulator's thread."""
        self.client.publish(reading.channel.name, lambda: reading.message)

    def _introduced(self) -> None:
        if self.client.ros == 1 and CLOCK in self.outputs:  # one parameter for all nodes; in ROS 2 each has its own
            self.client.call("/rosapi/set_param", arguments={"name": "/use_sim_time", "value": "true"})
        try:
            for name in self.outputs:
                self.listen(name)
        except NotRunningError:
            self.log.warning("the simulator does not run")

    def _joined(self) -> None:
        self.connections += 1
        self.log.info("%s: connected, to ROS %d", self.url, self.client.ros)

    def _failed(self, why: str, wait_s: float) -> None:
        self.log.warning("%s: %s; next attempt in %g s", self.url, why, wait_s)

    def _left(self) -> None:
        for name in self.outputs:
            self.leave(name)
        for channel in self.inputs.values():
            self.abandon(channel)
