"""A ROS 2 node of the default middleware (tests/fast_dds/fast_dds_peer.cpp), in a separate process."""

import json
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ros2_tools import until

BINARY = Path(__file__).parents[2] / "build/tests/fast_dds/fast_dds_peer"
SECONDS = 120  # after which it ends by itself


class FastDdsPeer:
    """The running process. lines: what it has printed so far."""

    def __init__(self, domain: int, *words: str) -> None:
        self.lines: list[dict[str, Any]] = []
        self.process = subprocess.Popen(
            [str(BINARY), str(domain), str(SECONDS), *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self._thread = threading.Thread(target=self._collect, daemon=True)
        self._thread.start()

    def messages(self, topic: str) -> list[dict[str, Any]]:
        """Return what it says of a topic's messages, in the order in which they came."""
        return [line for line in list(self.lines) if line.get("topic") == topic and "size" in line]

    def endpoints(self) -> dict[str, dict[str, Any]]:
        """Return the endpoints that it has found, by their names in DDS."""
        return {line["guid"]: line for line in list(self.lines) if "endpoint" in line}

    def wait_for(self, topic: str, count: int) -> list[dict[str, Any]]:
        """Wait for a number of messages."""
        return until(lambda: (found := self.messages(topic)) and len(found) >= count and found, f"{count} of {topic}")

    def _collect(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(json.loads(line))

    def close(self) -> None:
        """End it."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        try:
            self.process.wait(10.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._thread.join(5.0)


def sub(topic: str, type_name: str, reliability: str = "reliable", durability: str = "volatile") -> list[str]:
    """Return the words that make it subscribe, to a topic and type in ROS 2's spelling."""
    package, _, short = type_name.split("/")
    return ["sub", f"rt/{topic}", f"{package}::msg::dds_::{short}_", reliability, durability]


@contextmanager
def fast_dds_peer(domain: int, *words: str) -> Iterator[FastDdsPeer]:
    """Give a peer."""
    peer = FastDdsPeer(domain, *words)
    try:
        yield peer
    finally:
        peer.close()
