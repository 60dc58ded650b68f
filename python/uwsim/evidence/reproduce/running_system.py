"""A running system: the simulator behind rosbridge, the paper's chain of nodes, and a client's view of both."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

from uwsim.base.texts.json_text import json_object
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.nodes.chain import INSERTED, NODES
from uwsim.live import LiveSimulator
from uwsim.scenario import AnyScenario

NODES_PROGRAM = "from uwsim.cli import main; main()"
PATIENCE_S = 60.0
LISTEN_S = 4.0  # of simulated time
SIMULATOR = "/uwsim"
KEY_PUBLISHER = "key_publisher"
OWN_TOPICS = {  # topics that identify clients of rosbridge, which gives them no names
    "decodedDepth": "string_decoder", "scan": "scan_publisher", "laserPointCloud": "laser_to_cloud",
    "tf": "tf_broadcaster", INSERTED: "octomap", "rovParameters": "parameter_decoder", "key": KEY_PUBLISHER,
}  # fmt: skip
QUIET = ("clock", "rosout", INSERTED)


@dataclass(frozen=True)
class Link:
    """A transform: its frames and its rate in simulated time (0 if it is published only once)."""

    parent: str
    child: str
    rate_hz: float


@dataclass(frozen=True)
class Edge:
    """A topic that one node publishes and another subscribes to; subscriber: "" if none does."""

    publisher: str
    topic: str
    subscriber: str


class Client:
    """A minimal rosbridge client."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self.messages: list[dict[str, Any]] = []

    def say(self, op: str, **fields: Any) -> None:
        """Send an operation."""
        self._connection.send(json.dumps({"op": op, **fields}))

    def ask(self, service: str, **args: Any) -> dict[str, Any]:
        """Call a service and return its response; messages that arrive in the meantime are stored in `messages`."""
        self.say("call_service", service=service, args=args, id=service)
        deadline_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline_s:
            operation: dict[str, Any] = json_object(self._connection.recv(PATIENCE_S), "the system")
            if operation["op"] == "service_response":
                values: dict[str, Any] = operation["values"]
                return values
            self.messages.append(operation)
        raise TimeoutError(f"service '{service}': no answer")


@contextmanager
def running(map_file: Path, scenario: AnyScenario = "paper") -> Iterator[tuple[Client, Client]]:
    """Run a scenario, the nodes and a key publisher; yield a client of their server and one of the standard topics'."""
    with (
        LiveSimulator(scenario, paused=True) as live,
        RosbridgeServer(live, wire="published", origin="published") as server,
        RosbridgeServer(live, wire="standard") as standard,
        connect(server.url, max_queue=None) as first,
        connect(standard.url, max_queue=None) as second,
        connect(server.url) as keyboard,
    ):
        command = [sys.executable, "-c", NODES_PROGRAM, "ros", "nodes", "--url", server.url, "--out", str(map_file)]
        nodes = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            assert nodes.stdout is not None and nodes.stderr is not None
            if not nodes.stdout.readline():
                raise OSError(f"the nodes did not start: {nodes.stderr.read().strip()}")
            live.command("undock", vehicle="rov").result()
            keys = Client(keyboard)
            keys.say("advertise", topic="key", type="geometry_msgs/Pose")
            pose = {
                "position": {"x": 0.5, "y": 0.0, "z": -0.3},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0},
            }
            keys.say("publish", topic="key", msg=pose)
            keys.ask("/rosapi/nodes")  # answered when the server has the message
            yield Client(first), Client(second)
        finally:
            nodes.terminate()
            nodes.communicate()


def transforms(client: Client) -> list[Link]:
    """Let simulated time pass; return the transforms published on /tf and /tf_static."""
    client.messages.clear()
    for topic in ("/tf", "/tf_static"):
        client.say("subscribe", topic=topic, type="tf2_msgs/TFMessage", queue_length=1000)
    steps = round(LISTEN_S / 0.005)
    for _ in range(20):
        client.ask("/simulation/step", steps=steps // 20)
        time.sleep(0.02)  # lets the nodes, which are other processes, keep up
    counts: Counter[tuple[str, str]] = Counter()
    once: set[tuple[str, str]] = set()
    for operation in client.messages:
        for stamped in operation["msg"]["transforms"]:
            link = stamped["header"]["frame_id"], stamped["child_frame_id"]
            counts[link] += 1
            if operation["topic"] == "/tf_static":
                once.add(link)
    return [Link(*link, 0.0 if link in once else round(count / LISTEN_S, 1)) for link, count in counts.items()]


def connections(client: Client) -> list[Edge]:
    """Return the topics reported by rosapi; each client is named after the node whose topics it publishes."""
    details = {name: client.ask("/rosapi/node_details", node=name) for name in client.ask("/rosapi/nodes")["nodes"]}
    names = {
        node: next((OWN_TOPICS[t.strip("/")] for t in found["publishing"] if t.strip("/") in OWN_TOPICS), node)
        for node, found in details.items()
        if node != SIMULATOR
    } | {SIMULATOR: "simulator"}
    shown = {"simulator", KEY_PUBLISHER, *NODES}
    reading = {
        (topic, names[subscriber])
        for subscriber, reader in details.items()
        for topic in reader["subscribing"]
        if names[subscriber] in shown
    }
    found = []
    for publisher, writer in details.items():
        for topic in writer["publishing"]:
            if names[publisher] in shown and topic.strip("/") not in QUIET:
                readers = [name for read, name in sorted(reading) if read == topic and name != names[publisher]]
                found += [Edge(names[publisher], topic.strip("/"), reader) for reader in readers or [""]]
    return found
