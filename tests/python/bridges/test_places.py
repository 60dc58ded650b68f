"""Half-open peers end in time, and no number of silent peers shuts out one that speaks."""

import socket
import time
from collections import Counter
from contextlib import ExitStack

import pytest

from uwsim.bridges.doors.places import HALF_OPEN_S, HalfOpen, Places

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from mavlink_station import Station
from uwsim.bridges.mavlink import MavlinkVehicle
from uwsim.bridges.mavlink.endpoint import DATAGRAMS_IN_SPAN, FORM, PEERS_MAX, Wire
from uwsim.live import LiveSimulator

ANSWER_S = 3.0  # the vehicle's heartbeat comes once a second
Packer = dialect.MAVLink


def heartbeat(system: int = 250) -> bytes:
    packer = Packer(None, srcSystem=system)
    return bytes(packer.heartbeat_encode(6, 8, 0, 0, 0).pack(packer))


HALF = heartbeat()[:-2]
FALSE = heartbeat()[:-1] + bytes([heartbeat()[-1] ^ 1])
UNKNOWN = b"\xfd\x01\0\0\0\xff\xbe\xff\xff\xff\0\0\0"
"""A message with a number that no dialect has, so that its checksum cannot be checked."""


def vehicle_at(live: LiveSimulator, kind: str) -> MavlinkVehicle:
    return MavlinkVehicle(live, FORM.parse(f"{kind}:127.0.0.1:0"), (), action=None)


def test_the_peer_that_came_first_goes_and_so_do_those_that_stay_half_open() -> None:
    now_s, ended = [0.0], []
    half_open: HalfOpen[str] = HalfOpen(ended.append, most=2, clock=lambda: now_s[0])
    for name in "abc":
        half_open.add(name)
        now_s[0] += 1.0
    assert ended == ["a"]
    half_open.discard("b")
    now_s[0] = 2.0 + HALF_OPEN_S
    half_open.add("d")
    half_open.sweep()
    assert ended == ["a", "c"] and "d" in half_open and len(half_open) == 1


def test_a_newcomer_gets_the_place_of_one_that_never_spoke_else_of_the_one_that_was_silent_longest() -> None:
    now_s, ended = [0.0], []
    places: Places[str] = Places(ended.append, most=3, silent_s=10.0, clock=lambda: now_s[0])
    notes = {"speaks": places.renew, "comes": places.admit}
    for did, name in (
        ("speaks", "a"), ("comes", "b"), ("comes", "c"), ("comes", "d"), ("speaks", "c"), ("speaks", "d"),
        ("comes", "e"), ("comes", "f"),
    ):  # fmt: skip
        notes[did](name)
        now_s[0] += 1.0
    assert ended == ["b", "a", "e"] and places.peers() == ["f", "c", "d"]
    now_s[0] = 14.5
    places.sweep()
    assert ended == ["b", "a", "e", "c"]


def test_silent_connections_take_no_place_from_a_ground_station_that_speaks() -> None:
    """Neither those that send nothing, nor those that begin a message, nor those that send a false one."""

    def parser() -> dialect.MAVLink:
        found = Packer(None)
        found.robust_parsing = True
        return found

    wire, spoken = Wire(FORM.parse("tcp:127.0.0.1:0"), parser), set[tuple[str, int]]()
    with ExitStack() as stack:
        stack.callback(wire.close)
        for sent in (heartbeat(), *[b"", HALF, FALSE, UNKNOWN] * PEERS_MAX):
            connection = stack.enter_context(socket.create_connection((wire.endpoint.host, wire.endpoint.port)))
            connection.sendall(sent)
            spoken |= {peer for peer, _ in wire.receive(0.1)}
        (speaker,) = spoken
        assert speaker in wire.peers and len(wire.peers) == PEERS_MAX


@pytest.mark.parametrize("kind", ["tcp", "udpin"])
def test_peers_that_fall_silent_make_room(live: LiveSimulator, kind: str) -> None:
    """Also if each of them has sent a valid message."""
    with vehicle_at(live, kind) as vehicle, ExitStack() as stack:
        for system in range(12):
            stranger = socket.socket(type=socket.SOCK_STREAM if kind == "tcp" else socket.SOCK_DGRAM)
            stack.enter_context(stranger).connect(("127.0.0.1", vehicle.endpoint.port))
            stranger.sendall(heartbeat(system + 1))
        time.sleep(0.2)
        scheme = "tcp" if kind == "tcp" else "udpout"
        station = Station(f"{scheme}:127.0.0.1:{vehicle.endpoint.port}")
        stack.callback(station.close)
        station.receive("HEARTBEAT", limit_s=ANSWER_S)
        assert len(vehicle._wire.peers) == PEERS_MAX


@pytest.mark.parametrize("sent", [b"\xfd", HALF, FALSE, UNKNOWN])
def test_a_datagram_without_a_valid_message_gets_no_telemetry(live: LiveSimulator, sent: bytes) -> None:
    with vehicle_at(live, "udpin") as vehicle, socket.socket(type=socket.SOCK_DGRAM) as stranger:
        stranger.settimeout(1.5)
        stranger.sendto(sent, ("127.0.0.1", vehicle.endpoint.port))
        with pytest.raises(TimeoutError):
            stranger.recv(1000)
        assert not vehicle._wire.peers
        stranger.sendto(heartbeat(), ("127.0.0.1", vehicle.endpoint.port))
        assert stranger.recv(1000)


def test_a_flood_of_datagrams_of_one_peer_is_read_in_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("uwsim.bridges.mavlink.endpoint.SPAN_S", ANSWER_S)
    wire = Wire(FORM.parse("udpin:127.0.0.1:0"), lambda: Packer(None))
    with socket.socket(type=socket.SOCK_DGRAM) as noisy, socket.socket(type=socket.SOCK_DGRAM) as quiet:
        for each, count in ((noisy, DATAGRAMS_IN_SPAN + 5), (quiet, 1)):
            for _ in range(count):
                each.sendto(heartbeat(), (wire.endpoint.host, wire.endpoint.port))
        received = Counter(port for (_, port), _ in wire.receive(ANSWER_S))
        assert received == {noisy.getsockname()[1]: DATAGRAMS_IN_SPAN, quiet.getsockname()[1]: 1}
    wire.close()
