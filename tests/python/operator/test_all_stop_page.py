"""All stop on the station's page: any page may trigger it, by key or button; the pilot releases it."""

import json

import pytest

from browser import desk, judge, shows, until, when
from client_socket import connect
from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator

AHEAD = {"position": {"x": 1.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}}

POINTER = [{"width": 1440, "height": 900}, {"width": 1024, "height": 768}, {"width": 400, "height": 800}]
TOUCH = [{"width": 1024, "height": 768}, {"width": 844, "height": 390}, {"width": 390, "height": 844}]
STATES = ("", "hover", "active", "focus-visible")
CONTRAST_MIN = 4.5  # WCAG 2.1, 1.4.3
CONTRASTS = """() => {
  const pen = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
  const over = (colour) => {
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b] = [...pen.getImageData(0, 0, 1, 1).data].map((byte) => byte / 255)
      .map((share) => (share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (button) => {
    const layers = [];
    for (let each = button; each; each = each.parentElement) layers.unshift(getComputedStyle(each).backgroundColor);
    const [ground, text] = [...layers, getComputedStyle(button).color].map(over).slice(-2);
    return (Math.max(ground, text) + 0.05) / (Math.min(ground, text) + 0.05);
  };
  const stop = document.querySelector('#all-stop');
  const { left, top, right, bottom } = stop.getBoundingClientRect();
  const isOnTop = document.elementFromPoint((left + right) / 2, (top + bottom) / 2) === stop;
  const isRead = (each) => each.checkVisibility() && each.textContent.trim();
  const buttons = [...document.querySelectorAll('button')].filter(isRead);
  const found = buttons.map((each) => [each.id || each.textContent, contrast(each)]);
  return { isOnTop, pressed: stop.getAttribute('aria-pressed'), found };
}"""


@pytest.mark.parametrize("is_touch", [False, True], ids=["pointer", "touch"])
def test_all_stop_and_each_button_can_be_read_in_every_theme_size_and_state(browser, tmp_path, is_touch):
    with desk(browser, tmp_path, "pool") as here:
        page = here.fly(has_touch=is_touch, is_mobile=is_touch)
        when(page, f"matchMedia('(pointer: coarse)').matches === {json.dumps(is_touch)}")
        inspector = page.context.new_cdp_session(page)
        inspector.send("DOM.enable")
        inspector.send("CSS.enable")
        root = inspector.send("DOM.getDocument")["root"]["nodeId"]
        wrong, seen = [], set()

        def force(state):
            for node in inspector.send("DOM.querySelectorAll", {"nodeId": root, "selector": "button"})["nodeIds"]:
                forced = {"nodeId": node, "forcedPseudoClasses": [state] if state else []}
                inspector.send("CSS.forcePseudoState", forced)

        def measure(*where):
            for theme in ("dark", "light", "night"):
                page.evaluate(f"document.documentElement.dataset.theme = '{theme}'")
                measured = page.evaluate(CONTRASTS)
                case = (measured["pressed"], theme, *where)
                wrong.extend((*case, *each) for each in measured["found"] if each[1] < CONTRAST_MIN)
                assert measured["isOnTop"] and "all-stop" in dict(measured["found"]), case
                seen.add(case)

        for is_set in (False, True):
            if is_set:
                page.keyboard.press("x")
                page.wait_for_selector("#all-stop[aria-pressed=true]")
            for state in STATES:
                force(state)
                for size in TOUCH if is_touch else POINTER:
                    page.set_viewport_size(size)
                    measure(state, *size.values(), "folded")
                    if page.is_visible("#unfold"):
                        page.click("#unfold")
                        measure(state, *size.values(), "unfolded")
                        page.click("#unfold")
        assert not wrong, "\n".join(map(str, wrong[:20]))
        assert len(seen) == 2 * len(STATES) * 3 * (6 if is_touch else 4)
        assert not here.complaints


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
