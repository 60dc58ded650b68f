"""All stop on the station's page: any page may trigger it, by key or button; the pilot releases it."""

import json

from browser import desk, judge, shows, until, when
from client_socket import connect
from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator

AHEAD = {"position": {"x": 1.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}}


def test_x_stops_what_another_client_drives_until_the_pilot_releases_it(browser, tmp_path):
    with desk(browser, tmp_path, "pool") as here, connect(here.url.replace("http", "ws", 1)) as other:
        other.send(json.dumps({"op": "call_service", "service": "/release"}))
        other.send(json.dumps({"op": "publish", "topic": "/key", "msg": AHEAD}))
        until(lambda: here.rov.released and here.effort("surge") == 1.0, "the other client's effort")
        page = here.open()
        when(page, "globalThis.station?.telemetry.message")
        shows(page, "#lease", "A rosbridge client drives: take the controls")
        judge(page, "another client drives")
        assert page.is_hidden("#stopped")
        page.keyboard.press("x")
        until(lambda: here.rov.all_stopped and not here.rov.effort.any(), "all stop")
        page.click("#lease")
        page.wait_for_selector("#end-stop:not([disabled])")
        page.wait_for_selector("#all-stop[aria-pressed=true]")
        shows(page, "#stopped", "nothing moves the vehicle")
        assert page.is_hidden("#failsafe")
        judge(page, "all stop")
        page.screenshot(path=tmp_path / "stopped.png")

        other.send(json.dumps({"op": "publish", "topic": "/key", "msg": AHEAD}))
        while (status := json.loads(other.recv(timeout=60)))["op"] != "status":
            pass
        assert "has the controls" in status["msg"]
        page.keyboard.down("w")
        page.keyboard.press("x")  # a second press does not release it
        page.wait_for_timeout(500)
        assert here.rov.all_stopped and not here.rov.effort.any()

        page.click("#end-stop")
        until(lambda: not here.rov.all_stopped, "the release of all stop")
        page.wait_for_selector("#stopped", state="hidden")
        assert not here.rov.effort.any()  # a key still held must be pressed again
        page.keyboard.up("w")
        page.keyboard.down("w")
        until(lambda: here.effort("surge") == 0.5, "the pilot's effort")
        assert not here.complaints


def test_a_watcher_may_stop_and_not_release_even_while_a_dialog_is_open(browser, tmp_path):
    with desk(browser, tmp_path, "pool") as here:
        pilot = here.fly()
        when(pilot, "station.station.isPilot")
        watcher = here.fly()
        pilot.keyboard.down("w")
        until(lambda: here.effort("surge") == 0.5, "the pilot's effort")
        watcher.keyboard.press("?")
        watcher.wait_for_selector("#keys-dialog[open]")
        watcher.keyboard.press("x")
        until(lambda: here.rov.all_stopped, "all stop")
        watcher.wait_for_selector("#end-stop[disabled]", state="attached")
        assert watcher.evaluate("station.station.allStop('rov', false)")["success"] is False
        assert here.rov.all_stopped
        when(pilot, "!station.pilot.isHeld")
        pilot.click("#end-stop")
        until(lambda: not here.rov.all_stopped, "the release of all stop")
        watcher.keyboard.press("Escape")
        watcher.click("#all-stop")
        until(lambda: here.rov.all_stopped, "all stop by the button")


def test_a_stop_that_is_lost_is_sent_again(browser, tmp_path):
    with desk(browser, tmp_path, "pool") as here:
        page = here.fly()
        page.evaluate("station.station.bridge.close()")  # closed permanently, by the page itself
        page.evaluate("() => { station.panel.allStop.press(); }")
        when(page, "document.querySelector('#toast').textContent.includes('not connected')")
        page.evaluate(
            """() => {
              station.station.bridge.call = async (service, args) => { window.asked = [service, args.on]; return {}; };
              station.station.dispatchEvent(new Event('state'));
            }"""
        )
        assert page.evaluate("window.asked") == ["/station/all_stop", True]


def test_a_rosbridge_without_a_station_is_stopped_and_released(browser, tmp_path):
    with (
        desk(browser, tmp_path) as here,
        LiveSimulator("pool") as live,
        RosbridgeServer(live, origins=[here.url]) as other,
    ):
        page = here.open(f"/?rosbridge={other.url}")
        when(page, "globalThis.station?.telemetry.message")
        page.wait_for_selector("#station:not([hidden])")
        page.keyboard.press("x")
        until(lambda: live.rov.all_stopped, "all stop")
        page.click("#end-stop")
        until(lambda: not live.rov.all_stopped, "the release of all stop")
