"""Protects the two sockets that rospy opens against requests from browser pages; see SECURITY.md."""

from __future__ import annotations

import importlib
import os
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from uwsim.bridges.doors.admission import Door
from uwsim.bridges.doors.places import HALF_OPEN_S, HalfOpen

HEADER_BYTES_MAX = 1 << 16  # limit on a connection's header; with a message definition, it takes a few kB
LOOPBACK = "127.0.0.1"


def guard_sockets() -> None:
    """Guard all sockets that rospy opens from now on. A second call does nothing."""
    tcpros: Any = importlib.import_module("rospy.impl.tcpros_base")
    if not hasattr(tcpros, "uwsim_guards"):
        tcpros.uwsim_guards = True
        _guard_xmlrpc(importlib.import_module("rosgraph.xmlrpc"))
        _guard_tcpros(tcpros)


def _guard_xmlrpc(xmlrpc: Any) -> None:
    """Refuse requests from browser pages to the XML-RPC server.

    The server would otherwise accept a POST from any page: with `publisherUpdate`, a page could make the node read
    commands from a server of its choice; with `shutdown`, it could end the node.
    """
    door = Door((), os.environ.get("ROS_HOSTNAME") or os.environ.get("ROS_IP") or LOOPBACK)

    class GuardedHandler(xmlrpc.SilenceableXMLRPCRequestHandler):  # type: ignore[misc]
        timeout = HALF_OPEN_S  # of each reading, so that silent connections end

        def do_POST(self) -> None:  # noqa: N802
            refusal = door.refusal(self.headers, names_matter=False)
            if refusal is None:
                super().do_POST()
            else:
                self.send_error(refusal[0], explain=refusal[1])

    xmlrpc.SilenceableXMLRPCRequestHandler = GuardedHandler


def _guard_tcpros(tcpros: Any) -> None:
    """Limit a connection's header in bytes and in time, and read each header on a separate thread; see HalfOpen.

    rospy reads a header before it accepts the next client, so a client that sends nothing would block all others. The
    first characters of an HTTP request, interpreted as the header length, would mean 1 GB.
    """
    read, refused = tcpros.read_ros_handshake_header, importlib.import_module("rosgraph.network").ROSHandshakeException

    def read_short(sock: Any, buffer: Any, buff_size: int) -> Any:
        timeout_s = sock.gettimeout()
        sock.settimeout(HALF_OPEN_S)
        begin = sock.recv(4, socket.MSG_PEEK)
        (size,) = struct.unpack("<I", begin.ljust(4, b"\0"))
        if size > HEADER_BYTES_MAX:
            raise refused(f"a header of {size} bytes: must be {HEADER_BYTES_MAX} at most")
        found = read(sock, buffer, buff_size)
        half_open.discard(sock)
        sock.settimeout(timeout_s)
        return found

    half_open: HalfOpen[socket.socket] = HalfOpen(_end)

    class ThreadedServer(tcpros.TCPServer):  # type: ignore[misc]
        def __init__(self, inbound_handler: Callable[[Any, Any], object], port: int = 0) -> None:
            def handle(sock: Any, address: Any) -> None:
                limit = threading.Timer(HALF_OPEN_S, half_open.sweep)  # also ends a header that comes in drops
                limit.daemon = True
                limit.start()
                try:
                    inbound_handler(sock, address)
                finally:
                    half_open.discard(sock)
                    limit.cancel()

            def begin(sock: Any, address: Any) -> None:
                half_open.add(sock)
                threading.Thread(target=handle, args=(sock, address), name="uwsim-tcpros", daemon=True).start()

            super().__init__(begin, port)

    tcpros.read_ros_handshake_header = read_short
    tcpros.TCPServer = ThreadedServer


def _end(sock: socket.socket) -> None:
    """Close a connection whose header is being read, which ends the reading."""
    with suppress(OSError):
        sock.shutdown(socket.SHUT_RDWR)
    sock.close()
