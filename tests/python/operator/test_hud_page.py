"""The head-up display in a real browser: whole labels, no part over another."""

import re
from unittest.mock import patch

import pytest

from browser import CHROMIUM, SOFTWARE_GL, shows, when

START_M = (-4.0, 0.0, -2.5)
SCREENS = [(1280, 720), (1366, 768), (1920, 1080), (2560, 1440)]
LARGE = "--blink-settings=defaultFontSize=32"  # a font of 200 %
HELD = [(844, 390), (390, 844), (1024, 768)]
OVERLAPS = """() => {
  const { station, telemetry, views } = globalThis.station;
  const all = { holds: ['heading', 'depth', 'position'], hold_targets: [1, 4.2, 0.3] };
  const why = 'depth, position hold ended: the sensor of kind dvl has no valid reading';
  Object.assign(telemetry.message, all, { hold_note: why });
  Object.defineProperty(telemetry, 'contact', { value: { name: 'port', time_s: 3.2 }, configurable: true });
  const over = document.querySelector('.view.is-large .over');
  over.hidden = false;
  over.textContent = 'Pictures over the acoustic modem, one in 12 s';
  telemetry.dispatchEvent(new Event('change'));
  const { left, top, width, height } = document.querySelector('.view.is-large').getBoundingClientRect();
  const drawn = Object.entries(views.largeView.hud.shown.boxes);
  const boxes = drawn.map(([name, [x, y, w, h]]) => [name, left + x, top + y, w, h]);
  const parts = '#all-stop, #unfold, #lease, .lamp, .stick, .is-large > .name, .is-large > .over, .is-large button,' +
    '.is-large select, :root:not(.is-hand-held) .view:not(.is-large)'; // on a phone that stands, sticks lie over them
  for (const element of document.querySelectorAll(parts)) {
    if (!element.checkVisibility() || element.className === 'swap') continue;
    const { x, y, width: w, height: h } = element.getBoundingClientRect();
    if (w > 0) boxes.push([element.id || element.className || element.textContent, x, y, w, h]);
  }
  delete telemetry.contact;
  const overlaps = boxes.flatMap(([a, ax, ay, aw, ah], k) =>
    boxes.slice(0, k).filter(([, x, y, w, h]) => Math.min(ax + aw, x + w) - Math.max(ax, x) > 0.5
      && Math.min(ay + ah, y + h) - Math.max(ay, y) > 0.5).map(([b]) => `${a} over ${b}`));
  const outside = boxes.slice(0, drawn.length).filter(([, x, y, w, h]) =>
    x < left - 0.5 || y < top - 0.5 || x + w > left + width + 0.5 || y + h > top + height + 0.5);
  return { drawn: drawn.map(([name]) => name).sort(), overlaps, outside: outside.map(([name]) => name) };
}"""
TAPES = """() => {
  const { station, views, telemetry } = globalThis.station;
  const { hud } = views.largeView;
  const { context: c } = hud;
  const drawn = [];
  c.fillText = (text, x, y, ...room) => {
    const { actualBoundingBoxLeft: left, actualBoundingBoxRight: right, actualBoundingBoxAscent: up,
      actualBoundingBoxDescent: down } = c.measureText(text);
    drawn.push([text, x - left, y - up, x + right, y + down]);
    CanvasRenderingContext2D.prototype.fillText.call(c, text, x, y, ...room);
  };
  const wrong = new Set();
  let labels = 0;
  for (let depth = 0; depth < 130; depth += depth < 14 ? 0.07 : 3.37) {
    Object.assign(telemetry.message, { depth, distance_to_seabed: 12.3 - depth > 0 ? 12.3 - depth : depth });
    drawn.length = 0;
    telemetry.dispatchEvent(new Event('change'));
    for (const part of ['left', 'right']) {
      const [x, y, w, h] = hud.shown.boxes[part];
      const inside = drawn.filter(([, l, t, r, b]) => r > x && l < x + w && b > y && t < y + h);
      labels += inside.length;
      for (const [text, l, t, r, b] of inside) {
        if (l < x - 1 || t < y - 1 || r > x + w + 1 || b > y + h + 1) wrong.add(`${part} at ${depth}: ${text} is cut`);
        for (const [other, ol, ot, or, ob] of inside)
          if (other !== text && Math.min(r, or) > Math.max(l, ol) && Math.min(b, ob) > Math.max(t, ot))
            wrong.add(`${part} at ${depth}: ${text} over ${other}`);
      }
    }
  }
  delete c.fillText;
  return [labels, [...wrong]];
}"""
SIGNALS = """async () => {
  const { telemetry } = globalThis.station;
  const quiet = { ...telemetry.message, alarms: [], hold_note: '', failsafe: '', failsafe_cause: '', collisions: 0 };
  const tell = (changes) => {
    telemetry.message = { ...telemetry.message, ...changes };
    telemetry.dispatchEvent(new Event('change'));
  };
  tell({ ...quiet, proximity_warning: false, range_warning: false });
  tell({ hold_note: 'heading, depth hold ended: the failsafe steers' });
  tell({ hold_note: 'altitude hold became depth hold: the sensor of kind dvl has no valid reading' });
  tell({ failsafe: 'return', failsafe_cause: 'thruster', alarms: ['thruster stern does not obey', 'battery low'] });
  await null; // until it is drawn
  const log = [...document.querySelectorAll('#alarm-log li')].map(({ lastChild }) => lastChild.textContent.trim());
  return [log, document.querySelector('#failsafe').textContent];
}"""
NORTH = """() => {
  const { chart } = globalThis.station;
  const c = chart.canvas.getContext('2d');
  let north = null;
  c.fillText = (text, x, y) => { if (text === 'N') north = [x, y]; };
  chart.draw();
  delete c.fillText;
  const { left, top } = chart.canvas.getBoundingClientRect();
  const [x, y] = [left + north[0], top + north[1]];
  const over = [...chart.tools.children].map((each) => each.getBoundingClientRect());
  const rows = new Set(over.map(({ top }) => top)).size;
  return [rows, over.some((box) => box.left < x + 10 && box.right > x - 10 && box.top < y + 40 && box.bottom > y - 8)];
}"""
HEARD = [  # newest first
    "Failsafe: the vehicle is returning by itself, because a thruster does not respond.",
    "battery low",
    "thruster stern does not obey",
    "altitude hold became depth hold: the sensor of kind dvl has no valid reading",
    "heading, depth hold ended: the failsafe steers",
]
DRAWN = ["camera", "contact", "heading", "holds", "ladder", "left", "note", "right"]
CLEAR = {"drawn": DRAWN, "overlaps": [], "outside": []}
BAR = """() => {
  const buttons = [...document.querySelectorAll('.topbar button')].filter((each) => each.checkVisibility());
  const places = () => buttons.map((each) => each.getBoundingClientRect().x);
  const { classList } = document.querySelector('#factor');
  classList.remove('is-late');
  const before = places();
  classList.add('is-late');
  const after = places();
  const words = [...buttons, ...document.querySelectorAll('.topbar .caption')].filter((each) => each.checkVisibility());
  return [
    words.filter((each) => each.scrollWidth > each.clientWidth + 1).map(({ textContent }) => textContent),
    buttons.filter((each, k) => before[k] !== after[k]).map(({ id }) => id),
  ];
}"""


def fit(look, size):
    """Resize a page; return when it has found its new layout."""
    look.set_viewport_size({"width": size[0], "height": size[1]})
    look.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))")


@pytest.fixture(scope="module")
def look(here, page):
    """A watcher's page beside a pilot who stays."""
    look = here.fly(viewport={"width": 1280, "height": 720})
    yield look
    look.context.close()


def enlarge_front(look) -> None:
    look.evaluate("station.views.enlarge('front')")
    when(look, "station.views.largeView.picture?.drawn > 0 && station.views.largeView.hud.shown?.boxes.left")


def test_nothing_lies_over_anything(look):
    for size in SCREENS:
        fit(look, size)
        enlarge_front(look)
        assert look.evaluate(OVERLAPS) == CLEAR, size


def test_nothing_lies_over_anything_in_hands(here, page):
    held = here.fly(viewport={"width": 844, "height": 390}, has_touch=True, is_mobile=True)
    here.give(page, held)
    held.wait_for_selector(".stick.left")
    found = {}
    for size in HELD:
        fit(held, size)
        enlarge_front(held)
        found[size] = held.evaluate(OVERLAPS)
    held.context.close()
    here.regain(page)
    assert found == dict.fromkeys(HELD, CLEAR)


def test_a_font_of_200_percent_leaves_bar_and_display_whole(here, page):
    browser = here.browser.browser_type.launch(executable_path=CHROMIUM, args=[SOFTWARE_GL, LARGE])
    with patch.object(here, "browser", browser):
        large = here.fly(viewport={"width": 1280, "height": 720})
    assert large.evaluate("getComputedStyle(document.documentElement).fontSize") == "32px"
    for size in SCREENS[::2]:
        fit(large, size)
        enlarge_front(large)
        assert large.evaluate(OVERLAPS) == CLEAR, size
        end = large.locator("#menu").bounding_box()
        assert large.evaluate(BAR)[0] == [] and end["x"] + end["width"] <= size[0], size
        assert large.evaluate("document.documentElement.scrollWidth") <= size[0], size
    large.context.close()
    browser.close()


def test_no_word_of_the_bar_is_cut_and_no_button_moves_when_steps_are_late(look):
    for width in (1280, 1401, 1513, 1801, 2001, 2560):
        fit(look, (width, 800))
        end = look.locator("#menu").bounding_box()
        assert look.evaluate(BAR) == [[], []] and end["x"] + end["width"] <= width, width


def test_the_chart_s_tools_are_one_row_and_not_over_the_arrow(look):
    fit(look, (1280, 720))
    look.evaluate("station.views.enlarge('chart')")
    when(look, "station.chart.frame.scale > 5")
    assert look.evaluate(NORTH) == [1, False]


def test_views_are_called_by_their_titles_and_alarms_are_told_as_they_come(look):
    when(look, "station.views.names.length > 2")
    titles = look.evaluate("[...document.querySelectorAll('.view .name')].map((each) => each.lastChild.textContent)")
    assert {"Front", "Down", "Chase"} <= set(titles)
    heard, shown = look.evaluate(SIGNALS)
    assert heard[: len(HEARD)] == HEARD
    assert "is returning by itself" in shown and "thruster stern does not obey" in shown


def test_the_tapes_labels_are_whole(page):
    for size in (SCREENS[0], SCREENS[2], HELD[0]):
        fit(page, size)
        enlarge_front(page)
        labels, wrong = page.evaluate(TAPES)
        assert labels > 1000 and not wrong, size
    fit(page, (1440, 1000))


def test_the_bed_lamp_follows_the_wire_and_the_contact_lamp_the_echoes(here, page):
    def place(*position_m: float) -> None:
        live = here.station.present().live
        live.command("place", vehicle="rov", position_world_m=position_m).result()

    place(-2.0, 0.0, -2.5)  # 2.5 m above the bed, 4.5 m before the box
    when(page, "station.telemetry.message.proximity_warning && station.telemetry.nearest_m > 2")
    lit = "['bed', 'contact'].map((name) => document.querySelector(`#lamp-${name}`).dataset.on).join()"
    when(page, f"{lit} === 'warn,off'")
    shows(page, "#panel", "> 10")
    row = page.locator("dl.values div", has_text="Port side").inner_text()
    assert re.sub(r"\s", "", row) == "Portside>10m"
    place(1.0, 0.0, -4.4)
    when(page, f"{lit} === 'warn,warn'")
    limit = "station.telemetry.message.proximity_warning"
    here.station.present().live.command("set_parameter", name="warnings.proximity_m", value=0.1).result()
    when(page, f"!{limit} && {lit} === 'off,warn'")
    here.station.present().live.command("reset_parameters", name="warnings.proximity_m").result()
    when(page, f"{lit} === 'warn,warn'")
    page.evaluate("station.station.description.warnings.as_published = true")  # as in `paper`: one red lamp
    when(page, f"{lit} === 'alarm,off'")
    assert re.findall(r"\w+", page.inner_text("#lamp-bed"))[0].title() == "Proximity"
    assert not page.is_visible("#lamp-contact")
    page.evaluate("station.station.description.warnings.as_published = false")
    when(page, f"{lit} === 'warn,warn'")
    place(*START_M)
