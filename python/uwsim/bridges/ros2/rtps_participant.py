"""A small RTPS participant that serves calls from peers using rmw_fastrtps or rmw_cyclonedds.

It runs alongside the participant of the Cyclone DDS library, which cannot write the related sample identity: the inline
QoS parameter with which rmw_fastrtps matches a response to its request. (rmw_cyclonedds uses a header in front of the
message.) This participant implements only what services need: discovery (RTPS 2.5, sections 8.5.3 and 8.5.4) and, for
each service, a reliable reader of requests and a reliable writer of responses.
"""

from __future__ import annotations

import logging
import os
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from uwsim.bridges.doors.datagrams import Address, Datagrams
from uwsim.bridges.ros2 import rtps
from uwsim.bridges.ros2.graph import PARTICIPANT_DATA, dds_name, endpoint_data
from uwsim.bridges.ros2.rtps_endpoints import HELD_MAX, HOLD_S, History, Peer, Response, RtpsServer, Track
from uwsim.bridges.ros2.settings import MULTICAST_GROUP, PARTICIPANTS_MAX, Ros2Settings, multicast_port, unicast_port
from uwsim.bridges.ros2.transport import Call
from uwsim.channels.ros.service_types import request_type, response_type

OURS, FAST_DDS, CYCLONE_DDS = b"\0\0", b"\x01\x0f", b"\x01\x10"  # vendors, section 9.3.1.3; ours is "unknown"
PARTICIPANT = b"\0\0\x01\xc1"  # entities, section 9.3.1.3
SPDP_WRITER, SPDP_READER = b"\0\x01\0\xc2", b"\0\x01\0\xc7"
PUBLICATIONS, SUBSCRIPTIONS = b"\0\0\x03\xc2", b"\0\0\x04\xc2"  # the writers that announce endpoints
READER_OF = {PUBLICATIONS: b"\0\0\x03\xc7", SUBSCRIPTIONS: b"\0\0\x04\xc7"}
PROTOCOL_VERSION, VENDOR, LEASE, BUILTIN_ENDPOINTS = 0x15, 0x16, 0x02, 0x58
TYPE_NAME, RELIABILITY, DURABILITY, USER_DATA = 0x07, 0x1A, 0x1D, 0x2C
RELIABLE = 2
BUILTINS = 0x3F  # announcer and detector of participants, publications, subscriptions
CDR_HEADER, CALL_HEADER = 4, 16  # bytes
ANNOUNCE_S, RETRY_S, LEASE_S = 1.0, 0.1, 20
PEERS_MAX, CLIENTS_MAX = 200, 1000


class RtpsParticipant:
    """An RTPS participant that serves calls. Call `start` after creating all servers. Raises OSError."""

    def __init__(self, settings: Ros2Settings) -> None:
        self._settings = settings
        self.prefix = OURS + os.urandom(10)
        self._host = "127.0.0.1" if settings.reach == "localhost" else _own_address()
        self._datagrams = Datagrams((self._host, 0))
        self._lock = threading.Lock()
        self._peers: dict[bytes, Peer] = {}
        self._servers: dict[str, RtpsServer] = {}  # by request topic
        self._responses: dict[str, bytes] = {}  # writers of responses, by response topic
        self._histories = {writer: History(writer, reader) for writer, reader in READER_OF.items()}
        self._count = 0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="uwsim-ros2-rtps", daemon=True)

    def server(self, service: str, service_type: str, put: Callable[[RtpsServer], object]) -> RtpsServer:
        """Return a new server of a service. put: called on the participant's thread when a call has arrived."""
        server = RtpsServer(len(self._servers) + 1, put)
        identity = f"serviceid={'.'.join(f'{byte:x}' for byte in self.prefix + server.reader)};"
        name, (package, group, short) = dds_name(service).removeprefix("rt/"), service_type.split("/")
        for writer, entity, topic, part, type_name in (
            (SUBSCRIPTIONS, server.reader, f"rq/{name}Request", "Request", request_type(service_type)),
            (PUBLICATIONS, server.history.writer, f"rr/{name}Reply", "Response", response_type(service_type)),
        ):
            hashed = identity.encode() + endpoint_data(type_name, self._settings.distro)
            found = [
                (rtps.ENDPOINT_GUID, self.prefix + entity),
                (rtps.PARTICIPANT_GUID, self.prefix + PARTICIPANT),
                (rtps.TOPIC_NAME, rtps.text(topic)),
                (TYPE_NAME, rtps.text(f"{package}::{group}::dds_::{short}_{part}_")),
                (RELIABILITY, struct.pack("<IiI", 2, 0, 0x1999_9999)),
                (DURABILITY, bytes(4)),
                (USER_DATA, struct.pack("<I", len(hashed)) + hashed),
            ]
            self._histories[writer].add(rtps.PL_CDR_LE + rtps.parameters(found))
        self._servers[f"rq/{name}Request"] = server
        self._responses[f"rr/{name}Reply"] = server.history.writer
        self._histories[server.history.writer] = server.history
        return server

    def guids(self) -> tuple[list[bytes], list[bytes]]:
        """Return the identifiers of all readers and all writers."""
        servers = self._servers.values()
        return [self.prefix + one.reader for one in servers], [self.prefix + one.history.writer for one in servers]

    def start(self) -> None:
        """Announce the participant and its endpoints, and receive calls."""
        self._thread.start()

    def close(self) -> None:
        """Stop, and notify the other participants, which would otherwise wait for its responses."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(2.0)
            gone = rtps.gone(SPDP_READER, SPDP_WRITER, 2, self.prefix + PARTICIPANT)
            for prefix, peer in self._peers.items():
                self._send(peer.discovery, prefix, gone)
        self._datagrams.close()

    def _run(self) -> None:
        next_s = retry_s = 0.0
        while not self._stopping.is_set():
            if time.monotonic() >= next_s:
                next_s = time.monotonic() + ANNOUNCE_S
                self._announce()
            if time.monotonic() >= retry_s:
                retry_s = time.monotonic() + RETRY_S
                self._retry()
            self._datagrams.wait(RETRY_S)
            for packet, (host, _) in self._datagrams.received():
                try:
                    found = rtps.read(packet, self.prefix)
                    with self._lock:
                        for vendor, prefix, submessage in found:
                            if vendor in (FAST_DDS, CYCLONE_DDS):
                                self._receive(vendor, prefix, host, submessage)
                except ValueError as error:
                    logging.getLogger("uwsim.ros2").debug("%s", error)

    # Discovery

    def _announce(self) -> None:
        """Announce the participant to all possible addresses, and repeat unacknowledged heartbeats."""
        for address in self._places():
            self._send(address, b"", self._participant_data())
        with self._lock:
            for prefix, peer in list(self._peers.items()):
                if time.monotonic() - peer.heard_s > LEASE_S:
                    del self._peers[prefix]
                for writer, base in peer.awaited.items():
                    if base <= self._histories[writer].last:
                        self._send_to(prefix, peer, writer, self._heartbeat(self._histories[writer]))

    def _retry(self) -> None:
        """Send heartbeats to the readers of held responses, and send the responses that are ready or overdue."""
        with self._lock:
            for prefix, peer in self._peers.items():
                for history in {one.history.writer: one.history for one in peer.held}.values():
                    self._send(peer.address, prefix, self._heartbeat(history))
                self._release(prefix, peer)

    def _places(self) -> Iterator[Address]:
        domain, peers = self._settings.domain_id, self._settings.peers
        if self._settings.reach == "subnet":
            yield MULTICAST_GROUP, multicast_port(domain)
        for host in (*peers, "127.0.0.1") if self._settings.reach == "localhost" else peers:
            for participant in range(PARTICIPANTS_MAX):
                yield host, unicast_port(domain, participant)

    def _participant_data(self) -> bytes:
        locator = struct.pack("<iI12x", 1, self._datagrams.port) + socket.inet_aton(self._host)
        found = [
            (PROTOCOL_VERSION, b"\x02\x02"),
            (VENDOR, OURS),
            (rtps.PARTICIPANT_GUID, self.prefix + PARTICIPANT),
            (rtps.DEFAULT_UNICAST, locator),
            (rtps.METATRAFFIC_UNICAST, locator),
            (LEASE, struct.pack("<iI", LEASE_S, 0)),
            (BUILTIN_ENDPOINTS, struct.pack("<I", BUILTINS)),
            (USER_DATA, struct.pack("<I", len(PARTICIPANT_DATA)) + PARTICIPANT_DATA),
        ]
        return rtps.data(SPDP_READER, SPDP_WRITER, 1, rtps.PL_CDR_LE + rtps.parameters(found))[0]

    def _meet(self, vendor: bytes, prefix: bytes, host: str, payload: bytes) -> None:
        """Handle a participant's announcement. If it is new, exchange announcements and lists of endpoints with it."""
        if prefix in self._peers:
            self._peers[prefix].heard_s = time.monotonic()
            return
        order = _order_of(payload)
        found = dict(rtps.read_parameters(payload[4:], order)[0])
        ports = []
        for name in (rtps.METATRAFFIC_UNICAST, rtps.DEFAULT_UNICAST):
            if len(found.get(name, b"")) != 24:
                return  # the announcement has no address, or the participant is leaving
            ports.append(int(struct.unpack_from(f"{order}I", found[name], 4)[0]))
        if len(self._peers) >= PEERS_MAX:
            return
        peer = self._peers[prefix] = Peer(vendor, host, *ports)
        self._send(peer.discovery, prefix, self._participant_data())
        for writer in READER_OF:
            history = self._histories[writer]
            for _, submessages in history.samples:
                self._send(peer.discovery, prefix, *submessages)
            peer.awaited[writer] = 1
            self._send(peer.discovery, prefix, self._heartbeat(history))
            # a peer that was lost for a while would otherwise not send its endpoints again
            self._send(peer.discovery, prefix, self._acknowledgement(peer, READER_OF[writer], writer, [], more=True))

    # Samples

    def _receive(self, vendor: bytes, prefix: bytes, host: str, found: rtps.Submessage) -> None:
        if isinstance(found, rtps.Data) and found.writer == SPDP_WRITER:
            self._meet(vendor, prefix, host, found.payload)
        peer = self._peers.get(prefix)
        if peer is None or found.writer == SPDP_WRITER:
            return
        if isinstance(found, rtps.Missing):
            self._resend(prefix, peer, found)
        elif isinstance(found, rtps.Data):
            self._receive_data(prefix, peer, found)
        elif reader := READER_OF.get(found.writer) or self._reader_for(peer, found):
            track = peer.tracks.setdefault(found.writer, Track())
            if isinstance(found, rtps.Gap):
                for number in found.numbers:
                    track.add(number)
            else:
                track.skip_to(found.first)
                wanted = track.missing(found.last)
                if wanted or not found.is_final:
                    answer = self._acknowledgement(peer, reader, found.writer, wanted)
                    self._send_to(prefix, peer, found.writer, answer)

    def _reader_for(self, peer: Peer, found: rtps.Gap | rtps.Heartbeat) -> bytes | None:
        server = peer.clients.get(found.writer)
        return None if server is None else server.reader

    def _receive_data(self, prefix: bytes, peer: Peer, found: rtps.Data) -> None:
        """Handle a sample, which is an announcement of an endpoint or a request."""
        server = peer.clients.get(found.writer)
        if found.writer not in READER_OF and server is None:
            return  # its writer has not been announced yet: it will be sent again
        if not peer.tracks.setdefault(found.writer, Track()).add(found.number):
            return
        if found.writer in READER_OF:
            self._learn(prefix, peer, found)
        elif not found.payload:
            return
        elif server is not None and peer.vendor == CYCLONE_DDS:
            start = CDR_HEADER + CALL_HEADER
            if len(found.payload) >= start:
                order = "<" if found.payload[1] & 1 else ">"
                identity = struct.pack("<Qq", *struct.unpack(f"{order}Qq", found.payload[CDR_HEADER:start]))
                request = found.payload[:CDR_HEADER] + found.payload[start:]
                server.receive(Call(request, partial(self._respond, prefix, server.history, identity)))
        elif server is not None:
            client = next((found.qos[name] for name in rtps.RELATED_IDENTITIES if name in found.qos), bytes(16))[:16]
            client = client if any(client) else prefix + found.writer
            identity = client + struct.pack("<iI", found.number >> 32, found.number & 0xFFFF_FFFF)
            server.receive(Call(found.payload, partial(self._respond, prefix, server.history, identity)))

    def _learn(self, prefix: bytes, peer: Peer, found: rtps.Data) -> None:
        """Register an endpoint that a participant has announced, if it writes requests or reads responses.

        Fast DDS would send a request that came before its writer's announcement again after 3 s, if it were not asked,
        and let a new reader acknowledge a heartbeat after 70 ms.
        """
        order = _order_of(found.payload)
        known = dict(rtps.read_parameters(found.payload[4:], order)[0]) if found.payload else {}
        entity = known.get(rtps.ENDPOINT_GUID, found.qos.get(rtps.KEY_HASH, bytes(16)))[12:]
        topic = known.get(rtps.TOPIC_NAME, b"")[4:].split(b"\0")[0].decode(errors="replace")
        if rtps.STATUS_INFO in found.qos:  # it has been deleted
            peer.remove_reader(entity)
        elif found.writer == PUBLICATIONS and topic in self._servers and len(peer.clients) < CLIENTS_MAX:
            server = peer.clients[entity] = self._servers[topic]
            first = peer.tracks.setdefault(entity, Track()).base
            self._send(peer.address, prefix, self._acknowledgement(peer, server.reader, entity, [first]))
        elif found.writer == SUBSCRIPTIONS and topic in self._responses:
            kind = known.get(RELIABILITY, b"")[:4]
            if int.from_bytes(kind, "little" if order == "<" else "big") == RELIABLE:
                peer.add_reader(entity, self._responses[topic])
                self._send(peer.address, prefix, self._heartbeat(self._histories[self._responses[topic]]))

    def _respond(self, prefix: bytes, history: History, identity: bytes, response: memoryview) -> bool:
        """Send a response as soon as the client can receive it. Called on a service's thread."""
        with self._lock:
            peer = self._peers.get(prefix)
            if peer is None or len(peer.held) >= HELD_MAX:
                return False
            if peer.vendor == CYCLONE_DDS:
                payload, qos = bytes(response[:CDR_HEADER]) + identity + bytes(response[CDR_HEADER:]), b""
            else:
                payload = bytes(response)
                qos = rtps.parameters([(name, identity) for name in rtps.RELATED_IDENTITIES])
            peer.held.append(Response(history, payload, qos, time.monotonic() + HOLD_S))
            self._release(prefix, peer)
        return True

    def _release(self, prefix: bytes, peer: Peer) -> None:
        """Send the held responses whose readers are in step or whose deadline has passed."""
        held, peer.held = peer.held, []
        for one in held:
            if not peer.is_ready(one.history.writer) and time.monotonic() < one.deadline_s:
                peer.held.append(one)
                continue
            peer.awaited.setdefault(one.history.writer, 1)
            for submessage in one.history.add(one.payload, one.qos):
                self._send(peer.address, prefix, submessage)
            self._send(peer.address, prefix, self._heartbeat(one.history))

    def _resend(self, prefix: bytes, peer: Peer, found: rtps.Missing) -> None:
        history = self._histories.get(found.writer)
        if history is None:
            return
        peer.acknowledge(found.reader, history.writer, found.base)
        for number, submessages in history.samples:
            if number in found.numbers:
                for submessage in submessages:
                    self._send_to(prefix, peer, found.writer, submessage)
        if found.numbers or found.base <= history.last:
            self._send_to(prefix, peer, found.writer, self._heartbeat(history))
        self._release(prefix, peer)

    def _heartbeat(self, history: History) -> bytes:
        self._count += 1
        return history.heartbeat(self._count)

    def _acknowledgement(
        self, peer: Peer, reader: bytes, writer: bytes, wanted: Sequence[int], more: bool = False
    ) -> bytes:
        self._count += 1
        base = peer.tracks.setdefault(writer, Track()).base
        return rtps.missing(reader, writer, base, wanted, self._count, more)

    def _send_to(self, prefix: bytes, peer: Peer, writer: bytes, submessage: bytes) -> None:
        self._send(peer.discovery if writer in READER_OF else peer.address, prefix, submessage)

    def _send(self, address: Address, prefix: bytes, submessage: bytes) -> None:
        receiver = rtps.to_participant(prefix) if prefix else b""
        self._datagrams.send(rtps.header(self.prefix, OURS) + receiver + submessage, address)


def _order_of(payload: bytes) -> str:
    return "<" if payload[1:2] == b"\x03" else ">"


def _own_address() -> str:
    """Return this host's address on the network that reaches the multicast group."""
    with Datagrams(to=(MULTICAST_GROUP, 1)) as probe:
        return probe.host
