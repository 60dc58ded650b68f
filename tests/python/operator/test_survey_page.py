"""The start screen: its task Survey, scenes and planned lanes; the address and port of the user's rosbridge."""

import io
import json

import numpy as np
from PIL import Image
from websockets.sync.client import connect

from browser import desk, shows, until, when
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.operator.station.controls.plan import survey_lanes
from uwsim.scenario import load, packaged_scenarios

SCENES = "[...document.querySelector('#field-scenario').options]"


def test_a_lane_is_level_and_keeps_the_surveys_altitude_above_all_that_lies_below():
    with Simulator("lake") as sim:
        plan, survey = survey_lanes(sim), sim.scenario.survey
        ends = np.array(plan.points_world_m).reshape(-1, 2, 3)
        assert len(ends) > 3 and (ends[:, 0, 2] == ends[:, 1, 2]).all()
        for start, end in ends:
            places = np.linspace(start, end, 200)
            down = np.tile([0.0, 0.0, -1.0], (len(places), 1))
            below_m = sim.scene.cast(places, down, 200.0).ranges_m
            assert below_m.min() > survey.altitude_m - 0.3  # between two of the plan's samples


def test_a_survey_is_chosen_started_and_planned(browser, tmp_path):
    with desk(browser, tmp_path) as here:
        page = here.open(viewport={"width": 1440, "height": 1000})
        page.wait_for_selector("#field-scenario")
        page.click("[data-task=survey]")
        offered = page.evaluate(f"{SCENES}.filter(({{ disabled }}) => !disabled).map(({{ value }}) => value)")
        assert sorted(offered) == sorted(name for name in packaged_scenarios() if load(name).survey is not None)
        assert page.input_value("#field-tilt_deg") == "60"
        page.select_option("#field-scenario", "pool")
        when(page, "document.querySelector('.preview img')?.naturalWidth === 480")
        seen = page.request.get(here.url + "/preview/pool.jpg")
        assert Image.open(io.BytesIO(seen.body())).size == (480, 270)
        page.click("button[type=submit]")
        when(page, "station.views?.large === 'chart' && station.chart.points.length > 3")
        planned = np.array(page.evaluate("station.chart.points"))
        live = here.station.present().live
        origin_m = here.station.present().table.sources[0].origin_m
        wanted = live.read(survey_lanes).result()
        assert np.abs(planned - origin_m - wanted.points_world_m).max() < 1e-3
        shows(page, ".view.is-large .scene-note", "planned")
        assert not here.complaints


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
