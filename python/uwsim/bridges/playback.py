"""Plays a recording's messages to rosbridge clients, without a simulator."""

from __future__ import annotations

import time
from collections.abc import Callable

from uwsim.bridges.rosbridge.server import RosbridgeServer
from uwsim.channels import Channel
from uwsim.recording.mcap_sink import is_latched
from uwsim.recording.pacer import Pacer
from uwsim.recording.reader import Recording
from uwsim.recording.recorder import COMMANDS

SETTLE_S = 0.5  # in which the last messages reach the clients


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
    with RosbridgeServer(None, host=host, port=port) as server:
        topics = [info for info in recording.channels.values() if info.name != COMMANDS]
        latched = {info.name for info in topics if is_latched(recording.metadata(info.name))}
        for info in topics:
            server.advertise(Channel(info.name, info.type, "out", "", latched=info.name in latched))
        say(f"{recording.path} at {server.url}")
        while wait and not server.sessions:
            time.sleep(0.05)
        sent = _send_all(
            recording, server, pacer, (round(from_s * 1e9), None if until_s is None else round(until_s * 1e9)), latched
        )
        time.sleep(SETTLE_S)
        say(f"{sent:,} messages of {len(topics)} channels")


def _send_all(
    recording: Recording,
    server: RosbridgeServer,
    pacer: Pacer,
    span_ns: tuple[int, int | None],
    latched: set[str],
) -> int:
    from_ns, until_ns = span_ns
    sent = 0
    for recorded in recording.messages():
        if recorded.topic == COMMANDS or (recorded.time_ns < from_ns and recorded.topic not in latched):
            continue
        if until_ns is not None and recorded.time_ns > until_ns:
            break
        if recorded.time_ns >= from_ns:
            pacer.wait(recorded.time_ns)
        server.publish(recorded.topic, recorded.message, recorded.time_ns, latched=recorded.topic in latched)
        sent += 1
    return sent
