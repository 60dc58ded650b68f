"""A ROS 2 node that uses the default middleware (tests/fast_dds/fast_dds_peer.cpp), running in a separate process."""

import json
import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from waiting import until

BINARY = Path(__file__).parents[2] / "build/tests/fast_dds/fast_dds_peer"
SECONDS = 120  # after which the peer exits by itself


class FastDdsPeer:
    """A running peer process. lines: its output so far. on: a command that runs it elsewhere."""

    def __init__(self, domain: int, *words: str, on: Sequence[str] = ()) -> None:
        self.lines: list[dict[str, Any]] = []
        self.process = subprocess.Popen(
            [*on, str(BINARY), str(domain), str(SECONDS), *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self._thread = threading.Thread(target=self._collect, daemon=True)
        self._thread.start()

    def messages(self, topic: str) -> list[dict[str, Any]]:
        """Return the peer's output for messages on a topic, in order of arrival."""
        return [line for line in list(self.lines) if line.get("topic") == topic and "size" in line]

    def answers(self, service: str) -> list[dict[str, Any]]:
        """Return the responses of a service that the peer took for its own, in order of arrival."""
        return [line for line in list(self.lines) if line.get("service") == service]

    def endpoints(self) -> dict[str, dict[str, Any]]:
        """Return the endpoints that the peer has discovered, by DDS name."""
        return {line["guid"]: line for line in list(self.lines) if "endpoint" in line}

    def wait_for(self, topic: str, count: int) -> list[dict[str, Any]]:
        """Wait until `count` messages have arrived."""
        until(lambda: len(self.messages(topic)) >= count, f"{count} of {topic}")
        return self.messages(topic)

    def _collect(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(json.loads(line))

    def close(self) -> None:
        """Stop the process."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        try:
            self.process.wait(10.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._thread.join(5.0)


def sub(topic: str, type_name: str, reliability: str = "reliable", durability: str = "volatile") -> list[str]:
    """Return the peer's command-line arguments for subscribing to a topic; names are in ROS 2's spelling."""
    package, _, short = type_name.split("/")
    return ["sub", f"rt/{topic}", f"{package}::msg::dds_::{short}_", reliability, durability]


@contextmanager
def fast_dds_peer(domain: int, *words: str, on: Sequence[str] = ()) -> Iterator[FastDdsPeer]:
    """Run a peer for the duration of a test."""
    peer = FastDdsPeer(domain, *words, on=on)
    try:
        yield peer
    finally:
        peer.close()
