"""Address and port on the station's start screen join the simulator to the user's rosbridge, in a real browser."""

import json

from websockets.sync.client import connect

from browser import desk, shows, until, when
from uwsim.bridges import RosbridgeServer


def test_address_and_port_on_the_start_screen_join_the_users_rosbridge(browser, tmp_path):
    def fill(page, host, port):
        page.fill("#field-rosbridge_host", host)
        page.fill("#field-rosbridge_port", str(port))
        page.click("button[type=submit]")

    def refused(page, sentence):
        shows(page, "#wrong-rosbridge_host", sentence)
        page.wait_for_timeout(400)  # the check of the fields, which ends later, leaves it there
        assert sentence in page.inner_text("#wrong-rosbridge_host")
        assert page.is_visible("#start")  # nothing was started

    with desk(browser, tmp_path) as here, RosbridgeServer(None) as users:
        page = here.open()
        page.wait_for_selector("#field-rosbridge_host")
        with RosbridgeServer(None) as gone:
            port = gone.port
        fill(page, "127.0.0.1", port)
        refused(page, f"ws://127.0.0.1:{port}: connection refused: no server listens there")
        fill(page, "ws://127.0.0.1", here.url.rpartition(":")[2])  # its own address
        refused(page, "this is a uwsim station")

        fill(page, "localhost", users.port)
        page.wait_for_selector("#station:not([hidden])")
        shows(page, "#rosbridge", f"ROS localhost:{users.port}")
        with connect(users.url) as node:  # the user's, which knows nothing of the page
            say = lambda **operation: node.send(json.dumps(operation))  # noqa: E731
            say(op="subscribe", topic="/depthArray", type="std_msgs/String")
            assert len(json.loads(node.recv(30))["msg"]["data"].split("a")) == 513 + 1
            say(op="advertise", topic="/key", type="geometry_msgs/Pose")
            say(op="publish", topic="/key", msg={"position": {"x": 0.5}, "orientation": {"w": 1.0}})
            until(lambda: here.rov.released, "the release by the user's node")
            say(op="publish", topic="/key", msg={"position": {"x": 0.5}})
            until(lambda: here.effort("surge") == 0.5, "its effort")
            assert not page.evaluate("station.station.isPilot")
        port = users.port
        users.stop()
        sentence = f"Not connected to your rosbridge at ws://localhost:{port}: "
        shows(page, "#banner", sentence)
        banner = page.inner_text("#banner")
        assert banner.startswith(sentence) and banner.endswith("; trying again.")
        with RosbridgeServer(None, port=port):
            when(page, "document.querySelector('#banner').hidden")
        assert not here.complaints
