"""Playback of a recording's messages to bridge clients, without a simulator."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.playback.feed import PlayedFeed, channels_of
from uwsim.bridges.plug import Context
from uwsim.bridges.requested import Bridges
from uwsim.bridges.rosbridge.server import RosbridgeServer
from uwsim.recording.reader import Recording
from uwsim.recording.replay import Pacer

SETTLE_S = 0.5  # time for the last messages to reach the clients


def play(
    recording: Recording,
    pacer: Pacer,
    *,
    port: int = ROSBRIDGE_PORT,
    from_s: float = 0.0,
    until_s: float | None = None,
    wait: bool = False,
    bridges: Bridges | None = None,
    say: Callable[[str], object] = lambda text: None,
    **access: Any,
) -> None:
    """Send every message once, at the pacer's speed; return after the last one. Raises ValueError or OSError.

    from_s, until_s: the simulated times to play. Latched messages from before from_s are sent immediately. wait:
    whether to wait for the first rosbridge client or the first subscriber on another bridge. access: host, origins,
    token, certfile and keyfile, as in RosbridgeServer. bridges: further bridges, prepared.
    """
    feed = PlayedFeed(channels_of(recording))
    channels = list(feed.channels.values())
    with ExitStack() as stack:
        server = stack.enter_context(RosbridgeServer(None, port=port, channels=channels, feed=feed, **access))
        others = [] if bridges is None else bridges.open(stack, Context(channels, feed, access=access))
        say(", ".join((f"{recording.path} at {server.url}", *others)))
        while wait and not server.sessions and not feed.is_wanted:
            time.sleep(0.05)
        sent = _send(recording, feed, pacer, round(from_s * 1e9), None if until_s is None else round(until_s * 1e9))
        time.sleep(SETTLE_S)
    say(f"{sent:,} messages of {len(channels)} channels")


def _send(recording: Recording, feed: PlayedFeed, pacer: Pacer, from_ns: int, until_ns: int | None) -> int:
    """Send each message when it is due, after the latched messages from before from_ns. Return the number sent."""
    sent = 0
    for recorded in recording.messages(*feed.channels):
        channel = feed.channels[recorded.topic]
        if until_ns is not None and recorded.time_ns > until_ns:
            break
        if recorded.time_ns >= from_ns:
            pacer.wait(recorded.time_ns)
        elif not channel.delivery.latched:
            continue
        feed.play(channel, recorded)
        sent += 1
    return sent
