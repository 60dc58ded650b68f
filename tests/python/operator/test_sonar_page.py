"""The sonar pictures as the pilot uses them, in a real browser: ranges, bearings, gain, palette, freeze, cursor."""

import math

import pytest

from browser import judge, shows, until, when

START_M = [-2.5, 0.0, -4.2]
FACE_M = 2.5  # east of the pool's middle: the near face of its box
EYE_M = 0.56  # the sonar's head, ahead of the vehicle's middle


def enlarge(page, name):
    page.evaluate("(name) => station.views.enlarge(name)", name)
    when(page, f"station.views.largeView.picture.drawn > 1 && station.views.sonarOf('{name}').shown")


def brightness(page, name):
    """Return the mean brightness of the large picture, 0..255."""
    return page.evaluate(f"""() => {{
      const {{ canvas }} = station.views.sonarOf('{name}');
      const {{ data }} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      return data.reduce((sum, value, k) => sum + (k % 4 < 3 ? value : 0), 0) / (0.75 * data.length);
    }}""")


def test_the_box_is_where_rings_and_cursor_say(here, page):
    name = "forward_looking"
    enlarge(page, name)
    screen = f"station.views.sonarOf('{name}')"
    while page.evaluate(f"{screen}.shown.shown_m") > 6:
        page.click(".view.is-large button[aria-label='Less range']")
    page.mouse.move(5, 5)
    drawn = page.evaluate("station.views.largeView.picture.drawn")
    when(page, f"station.views.largeView.picture.drawn > {drawn + 2}")
    strongest_m = page.evaluate(f"""() => {{
      const {{ canvas, shown }} = {screen};
      const ratio = canvas.width / canvas.clientWidth;
      const at = (range, bearing) => {{
        const [x, y] = shown.at(range, bearing);
        const {{ data }} = canvas.getContext('2d').getImageData(x * ratio, y * ratio, 1, 1);
        return data[0] + data[1] + data[2];
      }};
      const ranges = Array.from({{ length: 200 }}, (_, k) => 2.0 + 0.0145 * k);
      const levels = ranges.map((range) => at(range, 0.02) + at(range, -0.03) + at(range, 0.04));
      return ranges[levels.findIndex((level) => level > 0.95 * Math.max(...levels))];
    }}""")
    expected_m = (
        here.station.present().live.read(lambda sim: FACE_M - EYE_M - float(sim.rov.pose.position_world_m[0])).result()
    )
    assert strongest_m == pytest.approx(expected_m, abs=0.35)
    x, y = page.evaluate(f"{screen}.shown.at(4, 0.5)")
    box = page.locator(".view.is-large canvas.picture").bounding_box()
    page.mouse.move(box["x"] + x, box["y"] + y)
    shows(page, ".view.is-large .sonar-reading", "starboard")
    range_m, _, bearing, side = page.inner_text(".view.is-large .sonar-reading").replace(" m,", " m").split()
    assert (float(range_m), side) == (pytest.approx(4.0, abs=0.1), "starboard")
    assert float(bearing.removesuffix("°")) == pytest.approx(math.degrees(0.5), abs=1.5)
    judge(page, "sonar picture")


def test_gain_and_palette_change_the_picture_and_freeze_keeps_it(here, page):
    name = "forward_looking"
    enlarge(page, name)
    page.wait_for_timeout(300)
    before = brightness(page, name)
    for _ in range(3):
        page.click(".view.is-large button[aria-label='More gain']")
    until(lambda: brightness(page, name) > 1.2 * before, "a brighter picture")
    page.select_option(".view.is-large select[aria-label=Palette]", "grey")
    colours = f"""(() => {{
      const {{ canvas, shown }} = station.views.sonarOf('{name}');
      const ratio = canvas.width / canvas.clientWidth;
      const [x, y] = shown.at(shown.shown_m * 0.55, 0.07);
      return [...canvas.getContext('2d').getImageData(x * ratio, y * ratio, 1, 1).data];
    }})()"""
    until(lambda: len(set(page.evaluate(colours)[:3])) == 1, "a grey picture")
    page.click(".view.is-large button:text-is('Freeze')")
    kept = brightness(page, name)
    here.station.present().live.command("place", vehicle="rov", position_world_m=[5.0, 5.0, -1.0]).result()
    drawn = page.evaluate("station.views.largeView.picture.drawn")
    when(page, f"station.views.largeView.picture.drawn > {drawn} + 3")
    assert brightness(page, name) == kept
    page.click(".view.is-large button:text-is('Freeze')")
    until(lambda: abs(brightness(page, name) - kept) > 0.5, "another picture")
    page.click(".view.is-large button:text-is('Freeze')")
    page.evaluate("station.views.enlarge('front')")
    assert page.evaluate(f"station.views.sonarOf('{name}').tools.isFrozen") is False  # a small view is never old


@pytest.mark.parametrize("name", ["side_scan", "profiler", "fan"])
def test_all_sonars_have_ranges_and_a_cursor(page, name):
    page.evaluate("(name) => station.views.enlarge(name)", name)
    page.wait_for_timeout(1500)
    box = page.locator(".view.is-large canvas").first.bounding_box()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    shows(page, ".view.is-large .sonar-reading", "starboard")
    judge(page, name)
