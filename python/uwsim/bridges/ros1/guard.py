"""Protects the two sockets that rospy opens against requests from browser pages; see SECURITY.md."""

from __future__ import annotations

import importlib
import os
import socket
import struct
import threading
from collections.abc import Callable
from typing import Any

from uwsim.bridges.admission import Door

HEADER_BYTES_MAX = 1 << 16  # limit on a connection's header; with a message definition, it takes a few kB
HEADER_S = 10.0  # time limit for each part of the header
HEADERS_MAX = 64  # headers read at a time; further connections are closed
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
        def do_POST(self) -> None:  # noqa: N802
            refusal = door.refusal(self.headers, names_matter=False)
            if refusal is None:
                super().do_POST()
            else:
                self.send_error(refusal[0], explain=refusal[1])

    xmlrpc.SilenceableXMLRPCRequestHandler = GuardedHandler


def _guard_tcpros(tcpros: Any) -> None:
    """Limit a connection's header in bytes and in time, and read each header on a separate thread.

    rospy reads a header before it accepts the next client, so a client that sends nothing would block all others. The
    first characters of an HTTP request, interpreted as the header length, would mean 1 GB.
    """
    read, refused = tcpros.read_ros_handshake_header, importlib.import_module("rosgraph.network").ROSHandshakeException

    def read_short(sock: Any, buffer: Any, buff_size: int) -> Any:
        timeout_s = sock.gettimeout()
        sock.settimeout(HEADER_S)
        begin = sock.recv(4, socket.MSG_PEEK)
        (size,) = struct.unpack("<I", begin.ljust(4, b"\0"))
        if size > HEADER_BYTES_MAX:
            raise refused(f"a header of {size} bytes: must be {HEADER_BYTES_MAX} at most")
        found = read(sock, buffer, buff_size)
        sock.settimeout(timeout_s)
        return found

    waiting = threading.BoundedSemaphore(HEADERS_MAX)

    class ThreadedServer(tcpros.TCPServer):  # type: ignore[misc]
        def __init__(self, inbound_handler: Callable[[Any, Any], object], port: int = 0) -> None:
            def handle(sock: Any, address: Any) -> None:
                try:
                    inbound_handler(sock, address)
                finally:
                    waiting.release()

            def begin(sock: Any, address: Any) -> None:
                if waiting.acquire(blocking=False):
                    threading.Thread(target=handle, args=(sock, address), name="uwsim-tcpros", daemon=True).start()
                else:
                    sock.close()

            super().__init__(begin, port)

    tcpros.read_ros_handshake_header = read_short
    tcpros.TCPServer = ThreadedServer
