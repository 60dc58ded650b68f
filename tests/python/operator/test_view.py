"""`uwsim.view` over a simulator of one's own, which goes on afterwards, and `uwsim map view`, the page of one map."""

import http.client
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from urllib.request import urlopen

import cbor2
import numpy as np
import pytest
from websockets.sync.client import connect

import command_line
import uwsim
from browser import WAIT_S, judge, when
from uwsim.live import LiveSimulator
from uwsim.operator.map_view import MapViewer


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


def asked(viewer: MapViewer, path: str, **headers: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection(*viewer.url[7:-1].split(":"), timeout=WAIT_S)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, answer.read()
    connection.close()
    return found


def test_the_page_shows_each_voxel_where_it_is(browser, slope) -> None:
    with MapViewer(slope, "slope.bt") as viewer:
        page = browser.new_page(viewport={"width": 1000, "height": 700})
        complaints: list[str] = []
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(viewer.url)
        when(page, "globalThis.mapView?.voxels.pointCount > 0")
        assert page.evaluate("mapView.store.count") == 800
        rows = page.evaluate(
            "[...mapView.store.blocks].flatMap(({x, y, z, rows}) =>"
            " [...rows].map((bits, k) => [bits, 16 * x, 16 * y + (k & 15), 16 * z + (k >> 4)]))"
        )
        seen = {(x + bit, y, z) for bits, x, y, z in rows for bit in range(16) if bits >> bit & 1}
        assert seen == {tuple(key) for key in np.floor(slope.occupied_voxels()).astype(int).tolist()}
        assert page.inner_text("#name") == "slope.bt" and "800" in page.inner_text("#about")

        # The whole map is in the picture, from every side, and its east is to the right in the view from the south.
        for side in ("Above", "East", "North", "West", "South"):
            page.click(f"text={side}")
            where = page.evaluate(
                "mapView.picture(() => 0) ?? [[-20, 0, -15], [20, 20, -5]]"
                ".map((p) => mapView.controls.target.clone().fromArray(p).project(mapView.camera).toArray())"
            )
            assert np.all(np.abs(where) < 1.0), side
        assert where[1][0] > where[0][0]
        judge(page, "the page of a map")
        assert complaints == []
        page.close()


def test_a_large_map_comes_in_larger_cubes(slope) -> None:
    with MapViewer(slope, voxels_max=300) as viewer:
        _, about = asked(viewer, "/map/map.json")
        message = cbor2.loads(asked(viewer, "/map/voxels.cbor")[1])
    assert b'"cube_m": 2.0' in about and b'"occupied": 800' in about
    cells = np.frombuffer(message["cells"].value, np.uint16)
    assert len(cells) == 10 * 2 * 10  # the slope's columns are 2 x 2; each stays within one cube of height


def test_only_this_machine_s_pages_are_served(slope) -> None:
    with uwsim.view(slope, browser=False) as viewer:
        assert viewer.url.startswith("http://127.0.0.1:") and f'src="{viewer.url}"' in viewer._repr_html_()
        assert asked(viewer, "/")[0] == 200 and asked(viewer, "/../site/answers.py")[0] == 404
        assert asked(viewer, "/map/map.json", **{"Host": "rebound.example"})[0] == 403
        assert asked(viewer, "/map/map.json", **{"Sec-Fetch-Site": "cross-site"})[0] == 404
        with pytest.raises(Exception, match="503"):
            connect(viewer.url.replace("http", "ws"))


def test_the_command_serves_until_ctrl_c(slope, tmp_path) -> None:
    slope.write(tmp_path / "slope.bt")
    command = [*command_line.UWSIM, "map", "view", "--no-browser", str(tmp_path / "slope.bt")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        line = process.stdout.readline()
        assert line.startswith("the map is at http://127.0.0.1:") and line.endswith("; Ctrl-C ends it\n")
        process.send_signal(signal.SIGINT)
        assert process.wait(WAIT_S) == 0


def test_bad_maps_are_refused_in_one_line(tmp_path) -> None:
    (tmp_path / "broken.bt").write_bytes(b"# Octomap OcTree binary file\nid OcTree\n")
    uwsim.OccupancyMap(1.0).write(tmp_path / "empty.bt")
    for name, word in (("broken.bt", "broken.bt"), ("empty.bt", "'empty.bt': has no occupied voxels")):
        assert word in command_line.error_line(command_line.uwsim("map", "view", "--no-browser", tmp_path / name))
