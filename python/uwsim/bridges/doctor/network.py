"""Checks this machine's interfaces, multicast, ports and buffers. Linux only, like the ROS packages."""

from __future__ import annotations

import fcntl
import socket
import struct
from pathlib import Path

from uwsim.bridges.doctor.finding import Finding
from uwsim.bridges.ros2.lossy_readers import ADVICE, default_buffer_bytes
from uwsim.bridges.ros2.settings import MULTICAST_GROUP, PARTICIPANTS_MAX, Ros2Settings, unicast_port

SIOCGIFFLAGS, SIOCGIFADDR = 0x8913, 0x8915
UP, LOOPBACK, MULTICAST = 0x1, 0x8, 0x1000
BUFFER_GOOD = 2 << 20  # receive buffer that a socket should have for point clouds and pictures, in bytes
ECHO_S = 1.0


def interfaces() -> dict[str, tuple[str, int]]:
    """Return the address and flags of each interface that is up and has an IPv4 address."""
    found = {}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, name in socket.if_nameindex():
            request = struct.pack("256s", name.encode()[:15])
            try:
                flags = struct.unpack_from("<H", fcntl.ioctl(probe, SIOCGIFFLAGS, request), 16)[0]
                address = socket.inet_ntoa(fcntl.ioctl(probe, SIOCGIFADDR, request)[20:24])
            except OSError:
                continue  # no IPv4 address
            if flags & UP:
                found[name] = address, flags
    return found


def network(settings: Ros2Settings) -> list[Finding]:
    """Return findings about the network that DDS uses."""
    there = interfaces()
    if settings.reach == "localhost":
        loopback = [name for name, (_, flags) in there.items() if flags & LOOPBACK]
        if "lo" not in loopback:
            return [Finding("interface", "no lo with 127.0.0.1", "wrong", "sudo ip link set lo up")]
        return [Finding("interface", "lo"), Finding("multicast", "not used with localhost"), buffers()]
    outward = {name: address for name, (address, flags) in there.items() if not flags & LOOPBACK}
    if not outward:
        return [Finding("interface", "none but loopback", "wrong", "connect a network, or --ros-reach localhost")]
    text = ", ".join(f"{name} {address}" for name, address in outward.items())
    return [Finding("interface", text), *(multicast(name, *there[name]) for name in outward), buffers()]


def multicast(name: str, address: str, flags: int) -> Finding:
    """Send a packet to the DDS multicast group on an interface and wait for it to come back."""
    what = f"multicast on {name}"
    if not flags & MULTICAST:
        advice = f"sudo ip link set {name} multicast on; or --ros-reach subnet --ros-peer HOST"
        return Finding(what, "the interface has none", "wrong", advice)
    ours = socket.inet_aton(address)
    try:
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
        ):
            receiver.bind((MULTICAST_GROUP, 0))
            receiver.settimeout(ECHO_S)
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(MULTICAST_GROUP) + ours)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, ours)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            sender.sendto(b"uwsim doctor", (MULTICAST_GROUP, receiver.getsockname()[1]))
            receiver.recv(64)
    except OSError as error:
        advice = "look at firewall and routes; or --ros-reach subnet --ros-peer HOST"
        return Finding(what, f"a packet did not come back ({error})", "wrong", advice)
    return Finding(what, "works on this machine")


def buffers() -> Finding:
    """Return a finding about the default size of socket receive buffers."""
    default = default_buffer_bytes()
    if default is None:
        return Finding("socket buffers", "unknown", "note", "clouds and pictures need net.core.rmem_default of 2 MB")
    found = f"{default / 1e3:.0f} kB"
    if default >= BUFFER_GOOD:
        return Finding("socket buffers", found)
    advice = f"for clouds and pictures: {ADVICE}"
    return Finding("socket buffers", found, "note", advice)


def udp_ports() -> set[int]:
    """Return the UDP ports in use on this machine."""
    found = set()
    for name in ("udp", "udp6"):
        try:
            lines = Path(f"/proc/net/{name}").read_text().splitlines()[1:]
        except OSError:
            continue
        found |= {int(line.split()[1].rpartition(":")[2], 16) for line in lines}
    return found


def participants_here(domain_id: int, ports: set[int]) -> int:
    """Return the number of a domain's participants on this machine, as inferred from the ports in use."""
    return sum(unicast_port(domain_id, number) in ports for number in range(PARTICIPANTS_MAX))
