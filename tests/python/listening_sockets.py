"""Find a program's listening sockets in /proc, and send them HTTP requests."""

import re
import socket
from collections.abc import Iterator
from pathlib import Path

PATIENCE_S = 60.0
LISTENS = "0A"  # code of the LISTEN state in /proc/net/tcp
UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
    "Sec-WebSocket-Protocol": "foxglove.sdk.v1, foxglove.websocket.v1",
}
NOTHING = 0  # the connection closed without an HTTP response


def family(pid: int) -> Iterator[int]:
    """Yield the ids of a process and all its descendants."""
    yield pid
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in task.read_text().split():
            yield from family(int(child))


def listening(pid: int) -> set[int]:
    """Return the TCP ports on which a process and its descendants listen."""
    ports = set()
    for member in family(pid):
        own = set()
        for link in Path(f"/proc/{member}/fd").iterdir():
            try:
                found = re.fullmatch(r"socket:\[(\d+)\]", str(link.readlink()))
            except FileNotFoundError:  # the socket has just been closed
                continue
            if found is not None:
                own.add(found[1])
        for table in ("tcp", "tcp6"):
            for line in Path(f"/proc/{member}/net/{table}").read_text().splitlines()[1:]:
                fields = line.split()
                if fields[3] == LISTENS and fields[9] in own:
                    ports.add(int(fields[1].rpartition(":")[2], 16))
    return ports


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
