"""Plays a recording's messages to clients of bridges, without a simulator."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

from uwsim.bridges.played_feed import PlayedFeed, channels_of
from uwsim.bridges.rosbridge.server import RosbridgeServer
from uwsim.channels import Channel
from uwsim.channels.guest import GuestService, GuestTopic, Node
from uwsim.recording.pacer import Pacer
from uwsim.recording.reader import Recording

SETTLE_S = 0.5  # in which the last messages reach the clients

Join = Callable[[ExitStack, Sequence[Channel], PlayedFeed], Sequence[str]]
"""Opens further bridges to channels and their feed, to be closed with the stack; returns where they are, in words."""


class Player:
    """A recording as a guest of a rosbridge server, to which it offers the recorded topics, and as a feed of others."""

    name = "/playback"
    services: Sequence[GuestService] = ()

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._node: Node | None = None
        self.feed = PlayedFeed(channels_of(recording))
        self.channels = self.feed.channels

    def connect(self, node: Node) -> None:
        """Offer the topics."""
        self._node = node
        node.offer_topics(
            GuestTopic(channel.name, channel.type, channel.description, channel.latched)
            for channel in self.channels.values()
        )

    def demanded(self) -> None:
        """Take note of nothing: a recording is read as it plays."""

    def left(self, client: str) -> None:
        """Do nothing: it plays to whoever listens."""

    def play(self, pacer: Pacer, from_ns: int, until_ns: int | None) -> int:
        """Publish each message when it is due; return how many. Latched ones from before from_ns go first."""
        assert self._node is not None
        sent = 0
        for recorded in self._recording.messages(*self.channels):
            channel = self.channels[recorded.topic]
            if until_ns is not None and recorded.time_ns > until_ns:
                break
            if recorded.time_ns >= from_ns:
                pacer.wait(recorded.time_ns)
            elif not channel.latched:
                continue
            reading = self.feed.play(channel, recorded)
            if channel.latched or self._node.is_wanted(channel.name):
                self._node.publish(channel.name, reading.message, recorded.time_ns, channel.catch_up)
            sent += 1
        return sent


def play(
    recording: Recording,
    pacer: Pacer,
    *,
    port: int = 9090,
    from_s: float = 0.0,
    until_s: float | None = None,
    wait: bool = False,
    join: Join = lambda stack, channels, feed: (),
    say: Callable[[str], object] = lambda text: None,
    **access: Any,
) -> None:
    """Send every message once, at a pace of simulated time; return after the last. Raises ValueError, OSError.

    from_s, until_s: simulated times; latched messages from before are sent at once. wait: for the first client of
    rosbridge, or the first subscriber elsewhere. access: host, origins, token, certfile and keyfile, as of a
    RosbridgeServer.
    """
    player = Player(recording)
    with ExitStack() as stack:
        server = stack.enter_context(RosbridgeServer(None, port=port, guests=[player], **access))
        others = join(stack, list(player.channels.values()), player.feed)
        say(", ".join((f"{recording.path} at {server.url}", *others)))
        while wait and not server.sessions and not player.feed.is_wanted:
            time.sleep(0.05)
        sent = player.play(pacer, round(from_s * 1e9), None if until_s is None else round(until_s * 1e9))
        time.sleep(SETTLE_S)
    say(f"{sent:,} messages of {len(player.channels)} channels")
