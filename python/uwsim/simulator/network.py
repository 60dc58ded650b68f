"""Network: the messages exchanged by station and vehicles over a simulator's link."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from uwsim import _core
from uwsim.base.journal import Journal
from uwsim.base.named import did_you_mean
from uwsim.scenario import Scenario
from uwsim.scenario.build.station import link_spec
from uwsim.scenario.spec.link import ModemModel

STATION = "station"
PAYLOAD_BYTES_MAX = 1_000_000
REPEATS_MAX = 10


class Delivery(NamedTuple):
    """A delivered message. given_s: when it was submitted; arrived_s: when it arrived (simulated time)."""

    sender: str
    receiver: str
    topic: str
    payload: bytes
    given_s: float
    arrived_s: float


class Counts(NamedTuple):
    """Message counts for one topic and sender; `lost` counts messages sent but not received, by reason.

    replaced: superseded by a newer message while queued. refused: the queue was full. late: expired before it could be
    sent. bytes_sent, bytes_delivered: payload bytes. delay_s: mean time from `send` to arrival. resent: retransmissions
    after a missing acknowledgement, by all nodes along the route.
    """

    topic: str
    sender: str
    given: int
    replaced: int
    refused: int
    late: int
    sent: int
    delivered: int
    lost: Mapping[str, int]
    bytes_sent: int
    bytes_delivered: int
    delay_s: float
    resent: int


class Network:
    """The packets between the station and the vehicles, in simulated time; part of a simulator's state.

    modem: its parameters. nodes: the senders: "station", and the vehicles by name. A message is delivered whole with
    its last packet, or not at all; it may be sent several times, either unconditionally (`repeats`) or because it was
    not acknowledged (the modem's `retransmissions`). Topics that begin with `ranging/` are pings and fixes of a USBL
    that shares the modem; the topic `acknowledgement` counts acknowledgements.
    """

    def __init__(self, core: _core.Simulation, scenario: Scenario, modem: ModemModel, journal: Journal) -> None:
        self._core = core
        self._journal = journal
        self.modem = modem
        self.nodes = (STATION, *(vehicle.name for vehicle in scenario.vehicles))

    @staticmethod
    def of(core: _core.Simulation, scenario: Scenario, world: _core.World, journal: Journal) -> Network | None:
        """Return a scenario's network, or None if it has no link. Call after all vehicles have been added.

        Raises ScenarioError if the station's transducer is not under water.
        """
        if scenario.link is None:
            return None
        spec = link_spec(scenario.link, scenario.station, world)
        if spec is None:
            return None
        core.set_link(spec)
        return Network(core, scenario, scenario.link.modem, journal)

    def send(
        self,
        sender: str,
        receiver: str,
        topic: str,
        payload: bytes,
        *,
        priority: int = 0,
        lifetime_s: float | None = None,
        replaces: bool = False,
        repeats: int = 0,
    ) -> bool:
        """Queue a message at the sender; return False if the queue is full.

        priority: 0 is sent first. lifetime_s: a message that is still queued after this time is dropped. replaces:
        whether it replaces an older message on its topic whose transmission has not begun. repeats: number of
        additional copies, in case some are lost; only the first to arrive counts. Raises ValueError for an invalid
        argument.
        """
        if not isinstance(payload, bytes) or len(payload) > PAYLOAD_BYTES_MAX:
            raise ValueError(f"link: payload of topic '{topic}': must be at most {PAYLOAD_BYTES_MAX} bytes")
        if isinstance(priority, bool) or not isinstance(priority, int) or not 0 <= priority <= 255:
            raise ValueError(f"link: priority = {priority!r}: must be a whole number in [0, 255]")
        if lifetime_s is not None and not 0 < lifetime_s <= 1e9:
            raise ValueError(f"link: lifetime_s = {lifetime_s!r} s: must be in (0, 1e9]")
        if isinstance(repeats, bool) or not isinstance(repeats, int) or not 0 <= repeats <= REPEATS_MAX:
            raise ValueError(f"link: repeats = {repeats!r}: must be a whole number in [0, {REPEATS_MAX}]")
        source, target = self._node(sender), self._node(receiver)
        taken = self._core.link_send(
            source, target, self._core.link_topic(topic), payload, priority, lifetime_s or 0.0, replaces, repeats
        )
        self._journal.note(
            "link_send", sender=sender, receiver=receiver, topic=topic, payload=payload, priority=priority,
            lifetime_s=lifetime_s, replaces=replaces, repeats=repeats,
        )  # fmt: skip
        return bool(taken)

    def received(self, at: str, after_s: float = 0.0) -> list[Delivery]:
        """Return the messages that arrived at a node after a given time, oldest first.

        Only the latest 512 messages across all nodes are kept.
        """
        topics = self._core.link_topics()
        found = self._core.link_deliveries(self._node(at), max(round(1e9 * after_s), 0))
        return [
            Delivery(
                self.nodes[one.from_node], at, topics[one.topic], one.payload,
                1e-9 * one.given_ns, 1e-9 * one.arrived_ns,
            )
            for one in found
        ]  # fmt: skip

    def counts(self) -> list[Counts]:
        """Return message counts so far, by topic and sender."""
        found = []
        for index, topic in enumerate(self._core.link_topics()):
            for node, name in enumerate(self.nodes):
                one = self._core.link_counts(index, node)
                if one.given:
                    mean_s = one.delay_s / one.delivered if one.delivered else 0.0
                    found.append(
                        Counts(
                            topic, name, one.given, one.replaced, one.refused, one.late, one.sent, one.delivered,
                            one.lost, one.bytes_sent, one.bytes_delivered, mean_s, one.resent,
                        )
                    )  # fmt: skip
        return found

    def quality(self, sender: str, at: str) -> _core.LinkQuality:
        """Return the quality of a link as last measured: delay, SNR, closing speed, packets sent and lost."""
        return self._core.link_quality(self._node(sender), self._node(at))

    def reception(self, sender: str, receiver: str) -> _core.Reception:
        """Predict the reception of a packet sent now."""
        return self._core.link_reception(self._node(sender), self._node(receiver))

    def waiting(self, node: str) -> tuple[int, int]:
        """Return the numbers of messages and bytes queued at a node."""
        messages, size = self._core.link_waiting(self._node(node))
        return messages, size

    def silence_s(self, at: str, sender: str = STATION) -> float:
        """Return the time since a node last received an intact packet from a sender, or since the start."""
        heard_ns = self.quality(sender, at).heard_ns
        return 1e-9 * max(self._core.time_ns - heard_ns, 0)

    def cut_off(self, vehicle: str, is_cut_off: bool) -> None:
        """Block all packets to and from a vehicle, or unblock them. Called by faults."""
        self._core.link_cut_off(self._node(vehicle), is_cut_off)

    def fault_loss(self, vehicle: str) -> float:
        """Return the fraction of packets between a vehicle and the station that faults drop; 1 is a blackout."""
        return self._core.link_fault_loss(self._node(vehicle), self._node(STATION))

    @property
    def sending_s(self) -> float:
        """The total time so far during which some node was transmitting."""
        return self._core.link_sending_s()

    @property
    def next_arrival_ns(self) -> int:
        """The earliest simulated time at which, as far as is known, a message may arrive."""
        return self._core.link_next_arrival_ns()

    def _node(self, name: str) -> int:
        if name not in self.nodes:
            raise ValueError(f"link: node = {name!r}: must be one of {', '.join(self.nodes)}"
                             f"{did_you_mean(str(name), self.nodes)}")  # fmt: skip
        return self.nodes.index(name)
