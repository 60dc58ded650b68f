"""`uwsim.view`: the station's page over a simulator of one's own, which goes on afterwards."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from urllib.request import urlopen

import pytest

import uwsim
from browser import when
from uwsim.live import LiveSimulator


def test_a_simulator_is_viewed_and_goes_on_afterwards() -> None:
    sim = uwsim.Simulator("pool", seed=3)
    sim.rov.undock()
    sim.advance(1.0)
    with uwsim.view(sim, paused=True, browser=False) as viewer:
        assert viewer.live.simulator is sim
        viewer.rov.set_effort(surge=0.5)
        viewer.live.step(200)
        with urlopen(viewer.url) as page:
            assert "uwsim" in page.read().decode()
            assert "frame-ancestors http://localhost:* http://127.0.0.1:*" in page.headers["Content-Security-Policy"]
        assert viewer.url in repr(viewer) and f'src="{viewer.url}"' in viewer._repr_html_()
        assert viewer.url.startswith("http://127.0.0.1:")
    assert sim.time_s == pytest.approx(2.0)
    sim.advance(1.0)
    assert sim.time_s == pytest.approx(3.0) and sim.rov.velocity.linear_body_m_s[0] > 0.1


def test_a_live_simulator_keeps_running() -> None:
    with LiveSimulator("pool", paused=True) as live:
        viewer = uwsim.view(live, browser=False)
        viewer.close()
        assert live.running
        live.step(1)


@contextmanager
def notebook(body: str) -> Iterator[str]:
    """Serve a page of this machine on another port, as Jupyter does."""

    class Notebook(BaseHTTPRequestHandler):
        def do_GET(self) -> None:  # the name that http.server calls
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!DOCTYPE html>" + body.encode())

        def log_message(self, *_: object) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Notebook) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        thread.join()


def test_a_notebook_s_frame_shows_the_scene(browser) -> None:
    with uwsim.view("pool", browser=False) as viewer:
        complaints: list[str] = []
        with notebook(viewer._repr_html_()) as url:
            page = browser.new_page(viewport={"width": 1000, "height": 700})
            page.on("console", lambda message: message.type == "error" and complaints.append(message.text))
            page.goto(url)
            frame = page.wait_for_selector("iframe").content_frame()
            frame.wait_for_selector("#station:not([hidden])", timeout=60_000)
            when(frame, "station.telemetry.message && station.station.state.pilot")
            assert frame.evaluate("station.views.large") == "scene", "the 3D view is the large one"
            page.close()
        assert complaints == []
