"""The client-side WebSocket: one thread reads and writes, with or without TLS; closing it releases waiting threads."""

import threading
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed

from certificate import write_certificate
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.nodes.node import Node
from uwsim.bridges.nodes.websocket import WebSocket


def test_a_node_speaks_through_encryption(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    certfile, keyfile = write_certificate(tmp_path)
    monkeypatch.setenv("SSL_CERT_FILE", str(certfile))
    before = threading.active_count()
    with RosbridgeServer(None, certfile=certfile, keyfile=keyfile) as server:
        node = Node(f"wss://localhost:{server.port}", queue=10)
        assert [thread.name for thread in threading.enumerate()].count("uwsim-websocket") == 1
        assert node.ask("/rosapi/get_time")["result"]
        node.close()
    assert threading.active_count() == before


def test_closing_ends_a_wait_on_another_thread() -> None:
    with RosbridgeServer(None) as server:
        socket = WebSocket(server.url)
        errors: list[BaseException] = []

        def wait() -> None:
            try:
                socket.recv(60.0)
            except BaseException as error:
                errors.append(error)

        waiting = threading.Thread(target=wait)
        waiting.start()
        socket.close()
        waiting.join(10.0)
        assert [isinstance(error, ConnectionClosed) for error in errors] == [True]
        with pytest.raises(ConnectionClosed):
            socket.send("{}")
