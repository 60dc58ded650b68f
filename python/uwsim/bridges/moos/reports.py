"""Node reports that travel by sound: each community's own reaches the others only as far as the link carries it."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.moos.client import MoosClient, logger
from uwsim.bridges.moos.wire import Message
from uwsim.bridges.rare_log import RareLog
from uwsim.channels.channel import PANEL
from uwsim.live import LiveSimulator
from uwsim.simulator.network import STATION, Delivery
from uwsim.simulator.simulator import Simulator

OWN, RECEIVED = "NODE_REPORT_LOCAL", "NODE_REPORT"
"""The report of pNodeReporter on its own vehicle, and a community's reports on the others."""
TOPIC = "node_report"
"""The messages' name in the link's counts."""
REPORT_BYTES_MAX = 65_536
LOOK_S = 0.1


class NodeReports:
    """Carries each community's NODE_REPORT_LOCAL to all others as NODE_REPORT, over the simulator's link.

    The bytes on the air are the report's text. A newer report replaces one whose transmission has not begun. Use it as
    a context, after all communities have joined.
    """

    def __init__(self, live: LiveSimulator) -> None:
        self._live = live
        self._communities: dict[str, MoosClient] = {}
        self._rare = RareLog(logger)
        self._looked_s = 0.0

    def join(self, node: str, client: MoosClient) -> None:
        """Add a community. node: where its modem is, a vehicle's name or "station"."""
        self._communities[node] = client

    def joined_shore(self, address: Endpoint, name: str) -> MoosClient:
        """Return a client of the shoreside's MOOSDB, whose modem is the station's; it connects as a context."""

        def take(messages: list[Message]) -> None:
            for each in messages:
                self.send(STATION, each.value)

        def note(community: str, warp: float) -> None:
            logger.info("shoreside '%s' at %s: time warp %g", community, address, warp)

        client = MoosClient(address, name, (OWN,), take, note)
        self.join(STATION, client)
        return client

    def __enter__(self) -> NodeReports:
        self._looked_s = self._live.simulator.time_s
        self._subscription = self._live.every(LOOK_S, self._arrived, self._publish)
        return self

    def __exit__(self, *_: object) -> None:
        self._subscription.cancel()

    def send(self, node: str, report: float | bytes) -> None:
        """Send a community's own report to the others. Does not block. Raises RuntimeError."""
        if not isinstance(report, bytes) or len(report) > REPORT_BYTES_MAX:
            self._rare.warning(f"{OWN} of '{node}': must be a text of at most {REPORT_BYTES_MAX} bytes")
            return
        for other in self._communities:
            if other != node:
                self._live.command(
                    "link_send", sender=node, receiver=other, topic=TOPIC, payload=report, priority=PANEL,
                    replaces=True,
                ).add_done_callback(self._log_error)  # fmt: skip

    def _arrived(self, sim: Simulator) -> list[Delivery]:
        assert sim.link is not None
        since_s, self._looked_s = min(self._looked_s, sim.time_s), sim.time_s  # time may have jumped back
        return [got for node in self._communities for got in sim.link.received(node, since_s) if got.topic == TOPIC]

    def _publish(self, arrived: list[Delivery]) -> None:
        for got in arrived:
            self._communities[got.receiver].publish([(RECEIVED, got.payload.decode("utf-8", "replace"))])

    def _log_error(self, done: Future[Any]) -> None:
        error = None if done.cancelled() else done.exception()
        if error is not None:
            self._rare.warning(f"{OWN}: {error}")
