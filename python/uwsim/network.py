"""Network: the messages that station and vehicles send each other over a simulator's link."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from uwsim import _core
from uwsim.did_you_mean import did_you_mean
from uwsim.journal import Journal
from uwsim.scenario import Scenario
from uwsim.scenario.build.link import link_spec
from uwsim.scenario.spec.modem import ModemModel

STATION = "station"
PAYLOAD_BYTES_MAX = 1_000_000
REPEATS_MAX = 10


class Delivery(NamedTuple):
    """A message that has arrived. given_s, arrived_s: simulated time."""

    sender: str
    receiver: str
    topic: str
    payload: bytes
    given_s: float
    arrived_s: float


class Counts(NamedTuple):
    """What happened to the messages of one topic and sender; `lost` of those that were sent, by reason.

    replaced: by newer ones while they waited. refused: there was no room. late: their lifetime was over before they
    could be sent. bytes_sent, bytes_delivered: of payloads. delay_s: mean, from `send` to the arrival.
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


class Network:
    """The packets between the station and the vehicles, in simulated time; part of a simulator's state.

    modem: its figures. nodes: who can send: "station", and the vehicles by name. A message arrives whole after its
    packets' travel, or not at all; there are no acknowledgements, but a message may be sent several times.
    Topics that begin with `ranging/` are pings and fixes of a USBL that shares the modem.
    """

    def __init__(self, core: _core.Simulation, scenario: Scenario, modem: ModemModel, journal: Journal) -> None:
        self._core = core
        self._journal = journal
        self.modem = modem
        self.nodes = (STATION, *(vehicle.name for vehicle in scenario.vehicles))

    @staticmethod
    def of(core: _core.Simulation, scenario: Scenario, journal: Journal) -> Network | None:
        """Return the network of a scenario, whose vehicles have all been added, or None where it has no link."""
        if scenario.link is None:
            return None
        spec = link_spec(scenario.link, scenario.station)
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
        """Give a message to the sender's queue now; return whether there was room.

        priority: 0 goes first. lifetime_s: after which it is not sent any more. replaces: it takes the place of an
        older one of its topic that still waits whole. repeats: how often it is sent again, since it may get lost; it
        arrives once, with the first copy that does. Raises ValueError.
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
        """Return what has arrived at a node after a time, oldest first; the newest 512 of all nodes are kept."""
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
        """Return what happened to all messages so far, by topic and sender."""
        found = []
        for index, topic in enumerate(self._core.link_topics()):
            for node, name in enumerate(self.nodes):
                one = self._core.link_counts(index, node)
                if one.given:
                    mean_s = one.delay_s / one.delivered if one.delivered else 0.0
                    found.append(
                        Counts(
                            topic, name, one.given, one.replaced, one.refused, one.late, one.sent, one.delivered,
                            one.lost, one.bytes_sent, one.bytes_delivered, mean_s,
                        )
                    )  # fmt: skip
        return found

    def quality(self, sender: str, at: str) -> _core.LinkQuality:
        """Return what a node last heard of another: delay, SNR, closing speed, packets and how many were lost."""
        return self._core.link_quality(self._node(sender), self._node(at))

    def reception(self, sender: str, receiver: str) -> _core.Reception:
        """Return how a packet that is sent now would arrive."""
        return self._core.link_reception(self._node(sender), self._node(receiver))

    def waiting(self, node: str) -> tuple[int, int]:
        """Return the messages and the bytes that wait at a node."""
        messages, size = self._core.link_waiting(self._node(node))
        return messages, size

    def silence_s(self, at: str, sender: str = STATION) -> float:
        """Return for how long a node has heard nothing whole from another, since the start if it never has."""
        heard_ns = self.quality(sender, at).heard_ns
        return 1e-9 * max(self._core.time_ns - heard_ns, 0)

    def cut_off(self, vehicle: str, is_cut_off: bool) -> None:
        """Let no packet to or from a vehicle be received from now on, or no longer: of a fault."""
        self._core.link_cut_off(self._node(vehicle), is_cut_off)

    def fault_loss(self, vehicle: str) -> float:
        """Return the share of the packets between a vehicle and the station that faults take now; 1 is a blackout."""
        return self._core.link_fault_loss(self._node(vehicle), self._node(STATION))

    @property
    def sending_s(self) -> float:
        """For how long somebody has sent so far."""
        return self._core.link_sending_s()

    @property
    def next_arrival_ns(self) -> int:
        """The earliest simulated time at which a message may arrive, as far as is known now."""
        return self._core.link_next_arrival_ns()

    def _node(self, name: str) -> int:
        if name not in self.nodes:
            raise ValueError(f"link: node = {name!r}: must be one of {', '.join(self.nodes)}"
                             f"{did_you_mean(str(name), self.nodes)}")  # fmt: skip
        return self.nodes.index(name)
