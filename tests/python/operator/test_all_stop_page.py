"""All stop on the station's page: any page may trigger it, by key or button; the pilot releases it."""

import json

from browser import judge, shows, until, when
from client_socket import connect

AHEAD = {"position": {"x": 1.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}}

POINTER = [(1440, 900), (400, 800)]
TOUCH = [(1024, 768), (390, 844)]
THEMES = ["dark", "light", "night"]
STATES = ["none", "hover", "active", "focus-visible"]
CONTRAST_MIN = 4.5  # WCAG 2.1, 1.4.3
FORCE = """(states) => {
  const force = (list) => {
    for (let k = list.cssRules.length - 1; k >= 0; k -= 1) {
      const rule = list.cssRules[k];
      const text = states.reduce((css, state) => css.replaceAll(`:${state}`, `.is-forced-${state}`), rule.cssText);
      if (!rule.selectorText) rule.cssRules && force(rule);
      else if (text !== rule.cssText) list.insertRule(text, k + 1);
    }
  };
  for (const sheet of document.styleSheets) force(sheet);
}"""
"""Gives each rule for a state of an element to a class, too, which any number of elements may have."""
CONTRASTS = """([themes, states]) => {
  const pen = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
  const over = (colour) => {
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b] = [...pen.getImageData(0, 0, 1, 1).data].map((byte) => byte / 255)
      .map((share) => (share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const known = new Map(); // since many buttons have the same colours, and each pixel takes a while to read
  const contrast = (button) => {
    const layers = [];
    for (let each = button; each; each = each.parentElement) layers.unshift(getComputedStyle(each).backgroundColor);
    const colours = layers.filter((colour, k) => k === 0 || colour !== 'rgba(0, 0, 0, 0)');
    colours.push(getComputedStyle(button).color);
    const key = colours.join();
    if (!known.has(key)) {
      const [ground, text] = colours.map(over).slice(-2);
      known.set(key, (Math.max(ground, text) + 0.05) / (Math.min(ground, text) + 0.05));
    }
    return known.get(key);
  };
  const stop = document.querySelector('#all-stop');
  const isRead = (each) => each.checkVisibility() && each.textContent.trim();
  const found = themes.flatMap((theme) => states.map((state) => {
    document.documentElement.dataset.theme = theme;
    const buttons = [...document.querySelectorAll('button')].filter(isRead);
    for (const each of buttons) each.classList.add(`is-forced-${state}`);
    const contrasts = buttons.map((each) => [each.id || each.textContent, contrast(each)]);
    for (const each of buttons) each.classList.remove(`is-forced-${state}`);
    const { left, top, right, bottom } = stop.getBoundingClientRect();
    const isOnTop = document.elementFromPoint((left + right) / 2, (top + bottom) / 2) === stop;
    return { theme, state, isOnTop, contrasts };
  }));
  return { pressed: stop.getAttribute('aria-pressed'), found };
}"""


def test_x_stops_what_another_client_drives_until_the_pilot_releases_it(here):
    with connect(here.url.replace("http", "ws", 1)) as other:
        other.send(json.dumps({"op": "publish", "topic": "/key", "msg": AHEAD}))
        until(lambda: here.effort("surge") == 1.0, "the other client's effort")
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
        here.leave(page)


def test_a_watcher_may_stop_and_not_release_even_while_a_dialog_is_open_and_a_lost_stop_is_sent_again(here, page):
    pilot, watcher = page, here.fly()
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
    pilot.keyboard.up("w")
    pilot.click("#end-stop")
    until(lambda: not here.rov.all_stopped, "the release of all stop")
    watcher.keyboard.press("Escape")
    watcher.click("#all-stop")
    until(lambda: here.rov.all_stopped, "all stop by the button")
    pilot.click("#end-stop")
    watcher.wait_for_selector("#all-stop[aria-pressed=false]")

    watcher.evaluate("station.station.bridge.close()")  # closed permanently, by the page itself
    watcher.evaluate("() => { station.panel.allStop.press(); }")
    when(watcher, "document.querySelector('#toast').textContent.includes('not connected')")
    watcher.evaluate(
        """() => {
          station.station.bridge.call = async (service, args) => { window.asked = [service, args.on]; return {}; };
          station.station.dispatchEvent(new Event('state'));
        }"""
    )
    assert watcher.evaluate("window.asked") == ["/station/all_stop", True]
    watcher.context.close()


def test_all_stop_and_each_button_can_be_read_in_every_theme_size_and_state(here, page):
    seen = set()

    def measure(page, *where) -> None:
        measured = page.evaluate(CONTRASTS, [THEMES, STATES])
        for found in measured["found"]:
            case = (measured["pressed"], found["theme"], found["state"], *where)
            contrasts = dict(found["contrasts"])
            assert found["isOnTop"] and "all-stop" in contrasts, case
            assert min(contrasts.values()) >= CONTRAST_MIN, (case, contrasts)
            seen.add(case)

    touched = here.fly(has_touch=True, is_mobile=True)
    for look, sizes, is_touch in ((page, POINTER, False), (touched, TOUCH, True)):
        when(look, f"station.station.isPilot && matchMedia('(pointer: coarse)').matches === {json.dumps(is_touch)}")
        look.evaluate(FORCE, STATES)
        for is_set in (False, True):
            if is_set:
                look.keyboard.press("x")
            look.wait_for_selector(f"#all-stop[aria-pressed={json.dumps(is_set)}]")
            for width, height in sizes:
                look.set_viewport_size({"width": width, "height": height})
                measure(look, is_touch, width, "folded")
                if look.is_visible("#unfold"):
                    look.click("#unfold")
                    measure(look, is_touch, width, "unfolded")
                    look.click("#unfold")
        look.evaluate("station.station.allStop('rov', false)")
        until(lambda: not here.rov.all_stopped, "the release of all stop")
        if look is page:
            here.give(page, touched)
    assert len(seen) == 2 * len(STATES) * len(THEMES) * (3 + 4)
