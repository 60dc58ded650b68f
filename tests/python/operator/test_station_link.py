"""The station over a modem: it shows the pictures, map and panel that arrived; true ones need permission."""

from __future__ import annotations

import io
import json

from PIL import Image

from browser import desk, when
from ros2_tools import until
from station_pages import get, page, serving


def test_a_page_gets_thumbnails_a_map_ashore_and_no_full_picture_without_the_truth(tmp_path):
    with serving(tmp_path, truth=False) as (station, server), page(server) as ada:
        ada.call("take_control")
        assert ada.call("start", scenario="lake", link="s2cm_hs", seed=3, speed=4)["success"]
        said = ada.call("describe")
        views = {view["name"]: view for view in said["views"]}
        front = views["front"]
        assert front["link"] == {"modem": "s2cm_hs", "period_s": 2.0, "large_only": True}
        assert "aboard_topic" not in front and "link" not in views["station"]
        assert get(server, "/snapshot/front.png")[0] != 200, "none has come"
        ada.subscribe("/station/view/front")
        ada.subscribe(said["vehicles"][0]["map_changes"])
        ada.subscribe(said["vehicles"][0]["scan"])
        picture = ada.message("/station/view/front")
        assert Image.open(io.BytesIO(bytes(picture["data"]))).width == 96
        assert len(ada.message("/ping")["ranges"]) == 65
        sim = station.present().live.simulator
        sent = {one.topic for one in sim.link.counts() if one.sender == "rov"}
        assert sent <= {"ranging/usbl", "telemetry", "placed_ping", "camera/front/image_raw/compressed"}
        status, png, _ = get(server, "/snapshot/front.png")
        assert status == 200 and Image.open(io.BytesIO(png)).width == 96
        assert "depth_m" in json.loads(Image.open(io.BytesIO(png)).text["uwsim"])
        offered = {topic.name for topic in station.present().topics()}
        assert not {name for name in offered if "aboard" in name}


def test_a_slow_modem_has_no_room_for_pictures_and_says_so(tmp_path):
    with serving(tmp_path) as (station, server), page(server) as ada:
        ada.call("take_control")
        assert ada.call("start", scenario="pool", link="micromodem", seed=3)["success"]
        views = {view["name"]: view for view in ada.call("describe")["views"]}
        assert views["front"]["link"] == {"modem": "micromodem", "period_s": None, "large_only": True}
        ada.subscribe("/telemetry")
        ada.message("/telemetry")  # over the link; a note needs no picture
        said = ada.call("notes", action="add", vehicle="rov", category="leak", view="front")
        assert said["success"] and said["notes"][0]["picture"] == ""
        assert station.present().carrier.rates.keys() == {"telemetry"}


def test_over_the_ideal_link_pictures_come_whole_and_late_and_small_ones_less_often(tmp_path):
    with serving(tmp_path, truth=False) as (station, server), page(server) as ada:
        ada.call("take_control")
        assert ada.call("start", scenario="pool", link="ideal_acoustic", seed=3)["success"]
        said = ada.call("describe")
        views = {view["name"]: view for view in said["views"]}
        assert not views["front"]["link"]["large_only"] and "aboard_topic" not in views["front"]
        assert ada.call("command", name="release", vehicle="rov")["message"] == "Sent over ideal_acoustic"
        live = station.present().live
        camera = live.simulator.rov.cameras["front"].mount
        for topic in ("/station/view/front", "/station/small/down"):
            ada.subscribe(topic)
            assert Image.open(io.BytesIO(bytes(ada.message(topic)["data"]))).width == camera.width
        until(lambda: _sent(live, "front") > 10)
        assert 0 < _sent(live, "down") <= 1 + 0.5e-9 * live.time_ns, "one in 2 s at most"
        live.command("inject_fault", kind="link", name="cut").result()
        before = _arrived(live)
        until(lambda: _sent(live, "front") > 20)
        assert _arrived(live) <= before + 1, "one that was on its way"


def _counts(live, camera):
    topic = f"camera/{camera}/image_raw/compressed"
    return next(one for one in live.read(lambda sim: sim.link.counts()).result() if one.topic == topic)


def _sent(live, camera):
    return _counts(live, camera).sent


def _arrived(live):
    return _counts(live, "front").delivered


def test_the_operator_reads_how_often_pictures_come_and_may_see_what_the_vehicle_sees(browser, tmp_path):
    with desk(browser, tmp_path, "pool", link="s2cm_hs") as here:
        look = here.open()
        look.wait_for_selector("#station:not([hidden])")
        when(look, "station.views.picture('front').drawn > 0")
        when(look, "document.querySelector('.is-large .over').textContent === 'over s2cm_hs: 1 picture in 2 s'")
        assert look.evaluate("station.views.picture('front').canvas.width") == 96
        look.click("text=Show what the vehicle sees")
        when(look, "station.views.picture('front').canvas.width > 96")
        look.wait_for_selector(".is-large .over", state="hidden")
        assert not here.complaints
