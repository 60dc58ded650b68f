"""The rosbridge client: one thread reads and writes, with or without TLS; closing it releases waiting threads."""

import threading
from pathlib import Path

import pytest

from certificate import write_certificate
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge.client import Client
from waiting import until


def test_a_client_speaks_through_encryption(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    certfile, keyfile = write_certificate(tmp_path)
    monkeypatch.setenv("SSL_CERT_FILE", str(certfile))
    before = threading.active_count()
    with (
        RosbridgeServer(None, certfile=certfile, keyfile=keyfile) as server,
        Client(f"wss://localhost:{server.port}", keeps=False) as client,
    ):
        assert [thread.name for thread in threading.enumerate()].count("uwsim-rosbridge-client") == 1
        assert client.ask("/rosapi/get_time")["result"]
    assert threading.active_count() == before


def test_closing_ends_a_wait_on_another_thread_and_what_follows() -> None:
    asked, answers = threading.Event(), []
    with RosbridgeServer(None) as server, Client(server.url) as silent, Client(server.url, keeps=False) as client:
        silent.serve("busy", "std_srvs/srv/Trigger", lambda arguments, respond: asked.set())
        until(lambda: "/busy" in client.ask("/rosapi/services")["values"]["services"])
        waiting = threading.Thread(target=lambda: answers.append(client.ask("/busy", patience_s=60.0)))
        waiting.start()
        assert asked.wait(10.0)
        client.close()
        waiting.join(10.0)
        assert [*answers, client.ask("/busy")] == [{}, {}]
