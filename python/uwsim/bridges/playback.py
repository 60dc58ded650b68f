"""Plays a recording's messages to rosbridge clients, without a simulator."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from uwsim.bridges.rosbridge.server import RosbridgeServer
from uwsim.channels.guest import GuestService, GuestTopic, Node
from uwsim.recording.commands import COMMANDS
from uwsim.recording.mcap_sink import is_latched
from uwsim.recording.pacer import Pacer
from uwsim.recording.reader import Recording

SETTLE_S = 0.5  # in which the last messages reach the clients


class Player:
    """A recording as a guest of a rosbridge server: it offers the recorded topics."""

    name = "/playback"
    services: Sequence[GuestService] = ()

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._node: Node | None = None
        self.topics = {
            info.name: GuestTopic(info.name, info.type, latched=is_latched(recording.metadata(info.name)))
            for info in recording.channels.values()
            if info.name != COMMANDS
        }

    def connect(self, node: Node) -> None:
        """Offer the topics."""
        self._node = node
        node.offer_topics(self.topics.values())

    def left(self, client: str) -> None:
        """Do nothing: it plays to whoever listens."""

    def play(self, pacer: Pacer, from_ns: int, until_ns: int | None) -> int:
        """Publish each message when it is due; return how many. Latched ones from before from_ns go first."""
        assert self._node is not None
        sent = 0
        for recorded in self._recording.messages(*self.topics):
            if until_ns is not None and recorded.time_ns > until_ns:
                break
            if recorded.time_ns >= from_ns:
                pacer.wait(recorded.time_ns)
            elif not self.topics[recorded.topic].latched:
                continue
            self._node.publish(recorded.topic, recorded.message, recorded.time_ns)
            sent += 1
        return sent


def play(
    recording: Recording,
    pacer: Pacer,
    *,
    host: str = "127.0.0.1",
    port: int = 9090,
    from_s: float = 0.0,
    until_s: float | None = None,
    wait: bool = False,
    say: Callable[[str], object] = lambda text: None,
) -> None:
    """Send every message once, at a pace of simulated time; return after the last. Raises ValueError, OSError.

    from_s, until_s: simulated times; latched messages from before are sent at once. wait: for the first client.
    """
    player = Player(recording)
    with RosbridgeServer(None, host=host, port=port, guests=[player]) as server:
        say(f"{recording.path} at {server.url}")
        while wait and not server.sessions:
            time.sleep(0.05)
        sent = player.play(pacer, round(from_s * 1e9), None if until_s is None else round(until_s * 1e9))
        time.sleep(SETTLE_S)
    say(f"{sent:,} messages of {len(player.topics)} channels")
