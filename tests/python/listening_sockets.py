"""Find a program's listening sockets in /proc, and send them HTTP requests."""

import re
import socket
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

PATIENCE_S = 180.0
LISTENS = "0A"  # code of the LISTEN state in /proc/net/tcp
LOOPBACK = {"0100007F", "00000000000000000000000001000000"}  # 127.0.0.1 and ::1
Socket = tuple[str, str]
"""A protocol and an address."""
UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
    "Sec-WebSocket-Protocol": "foxglove.sdk.v1, foxglove.websocket.v1",
}
NOTHING = 0  # the connection closed without an HTTP response


def free_port(kind: int = socket.SOCK_STREAM) -> int:
    """Return a port of loopback that is free; kind: SOCK_DGRAM for UDP."""
    with socket.socket(type=kind) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def family(pid: int) -> Iterator[int]:
    """Yield the ids of a process and all its descendants."""
    yield pid
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in task.read_text().split():
            yield from family(int(child))


def sockets(pid: int) -> Iterator[tuple[str, str, int, str]]:
    """Yield the table, address in hexadecimal, port and state of each socket of a process and its descendants."""
    for member in family(pid):
        own = set()
        for link in Path(f"/proc/{member}/fd").iterdir():
            try:
                found = re.fullmatch(r"socket:\[(\d+)\]", str(link.readlink()))
            except FileNotFoundError:  # the socket has just been closed
                continue
            if found is not None:
                own.add(found[1])
        for table in ("tcp", "tcp6", "udp", "udp6"):
            for line in Path(f"/proc/{member}/net/{table}").read_text().splitlines()[1:]:
                fields = line.split()
                if fields[9] in own:
                    address, _, port = fields[1].rpartition(":")
                    yield table, address, int(port, 16), fields[3]


def listening(pid: int) -> set[int]:
    """Return the TCP ports on which a process and its descendants listen."""
    return {port for table, _, port, state in sockets(pid) if table.startswith("tcp") and state == LISTENS}


def receiving(pid: int) -> Counter[Socket]:
    """Return the number of sockets on which a process and its descendants listen or receive datagrams."""
    return Counter(
        (table[:3].upper(), "127.0.0.1" if address in LOOPBACK else "all addresses")
        for table, address, _, state in sockets(pid)
        if table.startswith("udp") or state == LISTENS
    )


def status(port: int, method: str = "GET", path: str = "/", body: bytes = b"", **fields: str) -> int:
    """Send one request; return the response's status, or NOTHING. fields: HTTP headers, with _ in place of -."""
    sent = {"Host": f"127.0.0.1:{port}"} | {name.replace("_", "-"): value for name, value in fields.items()}
    if body:
        sent["Content-Length"] = str(len(body))
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in sent.items()), "", ""]
    answer = b""
    try:
        with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as connection:
            connection.sendall("\r\n".join(lines).encode() + body)
            while b"\r\n" not in answer and (part := connection.recv(4096)):
                answer += part
    except ConnectionError:
        return NOTHING
    found = re.match(rb"HTTP/1\.[01] (\d{3})", answer)
    return int(found[1]) if found else NOTHING


def upgrade(port: int, path: str = "/", **fields: str) -> int:
    """Request a WebSocket upgrade; return the response's status, which is 101 if the upgrade is accepted."""
    return status(port, path=path, **{name.replace("-", "_"): value for name, value in UPGRADE.items()}, **fields)
